"""Films at other rates than 48 kHz: heard at that one, and found in their own samples."""

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect import Detection, audio_around, find_shots, shot_at, verifier_of
from blastline.detect.onset import refine_onsets
from blastline.detect.rate import LISTENING_HZ, in_film, resampled
from blastline.model import Channels, Clip, Reflection, Rejection, Shot, Span
from blastline.ruleset import load_rules
from blastline.synth import Scene, Truth, render_scene, truth_of

Samples = NDArray[np.float32]

RULES = load_rules("standard")
VERIFIER = verifier_of(RULES.tier)
CLEAR = 0.9
RATES_HZ = (8_000, 11_025, 22_050, 32_000, 44_099, 44_100, 47_952, 88_200, 96_000, 192_000, 384_000)
SCENE = {
    "schema": 1,
    "rate_hz": LISTENING_HZ,
    "duration_s": 14.0,
    "seed": 23,
    "beds": [{"kind": "dialogue", "level_dbfs": -36.0}, {"kind": "ambience", "level_dbfs": -52.0}],
    "shots": [
        {"at_s": 1.5, "weapon": "shotgun", "environment": "field", "distance_m": 20.0, "peak_dbfs": -3.0},
        {"at_s": 4.0, "weapon": "pistol", "environment": "street", "distance_m": 8.0, "peak_dbfs": -6.0},
        {
            "at_s": 6.5,
            "weapon": "smg",
            "environment": "field",
            "distance_m": 12.0,
            "peak_dbfs": -4.0,
            "burst": {"shots": 4, "rpm": 700.0},
        },
        {"at_s": 11.0, "weapon": "rifle", "environment": "street", "distance_m": 15.0, "peak_dbfs": -3.0},
    ],
    "negatives": [{"at_s": 9.5, "kind": "door", "peak_dbfs": -10.0}],
}


HELD_HZ = 18_000.0


@pytest.fixture(scope="module")
def film() -> tuple[Samples, Truth]:
    """Return a film whose sound every rate from 44.1 kHz on holds: what one cannot hold, no law can ask for."""
    from scipy.signal import firwin

    audio = render_scene(msgspec.convert(SCENE, Scene))
    low_pass = firwin(257, HELD_HZ, fs=LISTENING_HZ)
    return np.convolve(audio.read(0, audio.frames)[:, 0], low_pass, "same").astype(np.float32), truth_of(audio)


def at_rate(samples: Samples, rate_hz: int) -> Samples:
    """Return a 48 kHz film at another rate, made otherwise than the detector does it."""
    from scipy.signal import resample_poly

    shared = np.gcd(rate_hz, LISTENING_HZ)
    made = resample_poly(samples, rate_hz // shared, LISTENING_HZ // shared, window=("kaiser", 12.0))
    return np.asarray(made, np.float32)


def clips(samples: Samples, rate_hz: int, size: int = 65_536, sides: Samples | None = None) -> list[Clip]:
    return [
        Clip(samples[at : at + size, None], rate_hz, at, None if sides is None else sides[at : at + size])
        for at in range(0, samples.shape[0], size)
    ]


def find(samples: Samples, rate_hz: int, size: int = 65_536) -> Detection:
    return find_shots(clips(samples, rate_hz, size), rate_hz=rate_hz, tier=RULES.tier, verifier=VERIFIER)


def heard(samples: Samples, rate_hz: int, size: int = 65_536) -> Samples:
    made = [clip.heard for clip in resampled(clips(samples, rate_hz, size), rate_hz)]
    return np.concatenate([np.zeros(0, np.float32), *made])


def clear(found: Detection) -> list[Shot]:
    """Return the shots that no small change of their features could turn down."""
    return [shot for shot in found.shots if shot.confidence > CLEAR]


def test_a_film_at_the_listening_rate_is_heard_and_found_as_it_is() -> None:
    given = clips(np.ones(1000, np.float32), LISTENING_HZ, 300)
    assert all(one is other for one, other in zip(resampled(given, LISTENING_HZ), given, strict=True))
    shot = Shot(7, 0.5, -3.0, 9.0, Span(7, 8), (Reflection(10, 11, 3.0 / 48.0, -9.0),), Span(7, 99))
    rejection = Rejection(5, "why", {})
    assert in_film([shot], [rejection], LISTENING_HZ) == ([shot], [rejection])


@pytest.mark.parametrize("rate_hz", [22_050, 44_100, 96_000])
@pytest.mark.parametrize("size", [1, 7, 4_096])
def test_the_block_size_changes_no_sample(rate_hz: int, size: int) -> None:
    mains, sides = np.random.default_rng(5).uniform(-0.5, 0.5, (2, 20_000)).astype(np.float32)
    whole, pieces = (list(resampled(clips(mains, rate_hz, n, sides), rate_hz)) for n in (mains.size, size))
    for column in ("heard", "sides"):
        one, other = (np.concatenate([getattr(clip, column) for clip in some]) for some in (whole, pieces))
        assert np.array_equal(one, other)
    starts = np.cumsum([0, *(clip.samples.shape[0] for clip in pieces)])
    assert [clip.start for clip in pieces] == starts[:-1].tolist()


def test_the_block_size_changes_nothing_found(film: tuple[Samples, Truth]) -> None:
    samples = at_rate(film[0], 44_100)
    assert find(samples, 44_100, 1_001) == find(samples, 44_100, samples.shape[0])


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_a_tone_is_the_same_tone_at_the_same_time(rate_hz: int) -> None:
    time_s = np.arange(rate_hz) / rate_hz
    made = heard(np.sin(2.0 * np.pi * 1_000.0 * time_s).astype(np.float32), rate_hz)
    expected = np.sin(2.0 * np.pi * 1_000.0 * np.arange(made.shape[0]) / LISTENING_HZ)
    inside = slice(LISTENING_HZ // 10, -LISTENING_HZ // 10)
    np.testing.assert_allclose(made[inside], expected[inside], rtol=0.0, atol=1e-4)


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_nothing_sounds_above_what_either_rate_holds(rate_hz: int) -> None:
    noise = np.random.default_rng(1).standard_normal(2 * rate_hz).astype(np.float32) * 0.1
    made = heard(noise, rate_hz).astype(np.float64)
    power = np.abs(np.fft.rfft(made * np.hanning(made.size))) ** 2
    hz = np.fft.rfftfreq(made.size, 1.0 / LISTENING_HZ)
    # the filter falls between 0.91 and 1 of half the lower rate; beyond, noise of full band is 100 dB down
    beyond = hz > 0.51 * rate_hz
    if beyond.any():
        assert power[beyond].max() < 1e-10 * power[hz < 0.4 * rate_hz].mean()


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_a_constant_is_silence_from_the_first_sample_to_the_last(rate_hz: int) -> None:
    assert not heard(np.full(rate_hz // 10, 0.3, np.float32), rate_hz).any()
    noise = np.random.default_rng(2).uniform(-0.1, 0.1, rate_hz // 10).astype(np.float32)
    np.testing.assert_allclose(heard(noise + np.float32(0.3), rate_hz), heard(noise, rate_hz), rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_a_film_rests_at_its_last_level(rate_hz: int) -> None:
    noise = np.random.default_rng(3).uniform(-0.1, 0.1, rate_hz // 10).astype(np.float32)
    cut, held = heard(noise, rate_hz), heard(np.pad(noise, (0, rate_hz // 10), mode="edge"), rate_hz)
    np.testing.assert_allclose(cut, held[: cut.shape[0]], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("rate_hz", RATES_HZ)
@pytest.mark.parametrize("frames", [1, 2, 3, 5, 146, 147, 148, 4_801, 44_100])
def test_every_place_lies_in_the_film_and_reaches_its_ends(rate_hz: int, frames: int) -> None:
    count = heard(np.linspace(0.0, 0.1, frames, dtype=np.float32), rate_hz).shape[0]
    step = rate_hz / LISTENING_HZ
    assert frames - count * step < max(1.0, step)
    if frames >= step:
        last = Shot(count - 1, 0.5, -3.0, 9.0, Span(count - 1, count), (), Span(count - 1, count))
        ((shot,), _) = in_film([last], [], rate_hz)
        assert frames - 1 - 2.0 * max(1.0, step) <= shot.onset < shot.blast.stop == shot.span.stop <= frames


def test_what_follows_in_one_order_follows_in_it_in_the_film() -> None:
    for rate_hz in RATES_HZ:
        for onset in range(200, 360):
            blast, echo = Span(onset, onset + 100), Reflection(onset + 100, onset + 200, 100 / 48.0, -6.0)
            given = Shot(onset, 0.5, -3.0, 9.0, blast, (echo,), Span(onset, onset + 4_800))
            ((shot,), _) = in_film([given], [], rate_hz)
            (moved,) = shot.reflections
            assert shot.onset == shot.blast.start == shot.span.start
            assert shot.blast.stop == moved.start < moved.stop < shot.span.stop
            assert shot.onset / rate_hz == pytest.approx(onset / LISTENING_HZ, abs=0.5001 / rate_hz)
            assert moved.delay_ms == pytest.approx((moved.start - shot.onset) * 1000.0 / rate_hz, abs=1000.0 / rate_hz)


@pytest.mark.parametrize("rate_hz", [44_100, 96_000])
def test_a_resampled_film_holds_the_same_shots(film: tuple[Samples, Truth], rate_hz: int) -> None:
    plain, there = find(film[0], LISTENING_HZ), find(at_rate(film[0], rate_hz), rate_hz)
    assert len(clear(plain)) >= 6
    assert len(there.shots) == len(plain.shots)
    for one, other in zip(plain.shots, there.shots, strict=True):
        ms = 1000.0 / rate_hz
        assert other.onset * ms == pytest.approx(one.onset / 48.0, abs=0.1)
        assert other.confidence == pytest.approx(one.confidence, abs=0.1)
        assert other.peak_dbfs == pytest.approx(one.peak_dbfs, abs=0.5)
        assert (other.burst, other.shot_in_burst) == (one.burst, one.shot_in_burst)


@pytest.mark.parametrize("rate_hz", [44_100, 96_000])
def test_what_a_film_of_44_khz_cannot_hold_moves_no_onset(rate_hz: int) -> None:
    """In two stages of nearly one likelihood, clipped: what of it lies beyond 20 kHz would choose between them."""
    from scipy.signal import resample

    rng = np.random.default_rng(4)
    at, time = 4800 + 9600 * np.arange(300), np.arange(4800)
    film = 3e-4 * rng.standard_normal(at[-1] + 9600)
    for onset in at.tolist():
        film[onset : onset + 4800] += rng.standard_normal(4800) * np.exp(-time / 700)
        first = onset - rng.integers(60, 400)
        film[first:onset] += 10.0 ** rng.uniform(-1.6, -0.8) * rng.standard_normal(onset - first)
    samples = np.clip(film, -0.7, 0.7).astype(np.float32)
    steep = resample(samples, samples.size * rate_hz // LISTENING_HZ).astype(np.float32)
    again = heard(steep, rate_hz)
    here, there = (refine_onsets(each, at, rate_hz=LISTENING_HZ, rules=RULES.tier.onset) for each in (samples, again))
    assert np.abs(here - at).min() <= 2 < 60 <= np.abs(here - at).max()
    assert np.abs(there - here).max() <= 0.1 * LISTENING_HZ / 1000.0


@pytest.mark.parametrize(("rate_hz", "delay"), [(44_100, 147), (44_100, 29_400), (96_000, 2), (96_000, 96_002)])
def test_a_delay_by_whole_samples_of_both_rates_delays_all_there_is(
    film: tuple[Samples, Truth], rate_hz: int, delay: int
) -> None:
    samples = at_rate(film[0], rate_hz)
    first = clear(find(samples, rate_hz))
    later = {shot.onset: shot for shot in find(np.concatenate([np.zeros(delay, np.float32), samples]), rate_hz).shots}
    assert len(first) >= 6
    for shot in first:
        moved = later[shot.onset + delay]
        assert moved.span.stop - delay == shot.span.stop
        assert moved.blast.stop - delay == shot.blast.stop
        assert [r.delay_ms for r in moved.reflections] == [r.delay_ms for r in shot.reflections]


@pytest.mark.parametrize(("rate_hz", "delay"), [(44_100, 1), (44_100, 1_001), (96_000, 1), (96_000, 96_001)])
def test_any_delay_delays_single_shots_to_the_nearest_sample_that_is_heard(
    film: tuple[Samples, Truth], rate_hz: int, delay: int
) -> None:
    samples = at_rate(film[0], rate_hz)
    single = [shot for shot in clear(find(samples, rate_hz)) if shot.burst is None]
    later = find(np.concatenate([np.zeros(delay, np.float32), samples]), rate_hz).shots
    assert len(single) >= 3
    for shot in single:
        moved = min(later, key=lambda each: abs(each.onset - delay - shot.onset))
        assert abs(moved.onset - delay - shot.onset) <= rate_hz / LISTENING_HZ + 1.0


@pytest.mark.parametrize("rate_hz", [44_100, 96_000])
def test_films_that_begin_with_a_shot_or_end_inside_one(film: tuple[Samples, Truth], rate_hz: int) -> None:
    samples, ms = at_rate(film[0], rate_hz), rate_hz / 1000.0
    first, last = (round(film[1].shots[index].onset_sample / 48.0 * ms) for index in (0, -1))
    assert find(samples[first:], rate_hz).shots[0].onset <= 0.1 * ms
    for after_ms in (5.0, 60.0):
        frames = last + round(after_ms * ms)
        for shot in find(samples[:frames], rate_hz).shots:
            assert shot.onset < shot.blast.stop <= shot.span.stop <= frames


@pytest.mark.parametrize("rate_hz", [44_100, LISTENING_HZ, 96_000])
def test_a_shot_given_where_it_was_found_is_segmented_as_it_was(film: tuple[Samples, Truth], rate_hz: int) -> None:
    samples = at_rate(film[0], rate_hz)
    ms = rate_hz / 1000.0
    for shot in clear(find(samples, rate_hz)):
        for by in (0, 1):  # what is given by hand stays where it was given
            onset = shot.onset + by
            around = audio_around(onset, frames=samples.shape[0], rate_hz=rate_hz, tier=RULES.tier)
            audio = Clip(samples[around.start : around.stop, None], rate_hz, around.start)
            given = shot_at(onset, audio, confidence=shot.confidence, tier=RULES.tier)
            assert given.onset == given.blast.start == given.span.start == onset
            assert len(given.blast) == pytest.approx(len(shot.blast), abs=0.05 * ms)
            assert len(given.span) == pytest.approx(len(shot.span), abs=0.05 * ms)
            # the wave is the same, but heard half a sample beside, where it need not be as high
            assert given.peak_dbfs == pytest.approx(shot.peak_dbfs, abs=1.0)


@pytest.mark.parametrize("rate_hz", RATES_HZ)
@pytest.mark.parametrize("frames", [1, 2, 9, 5_000])
def test_a_shot_given_at_either_end_of_a_film_stays_in_it(rate_hz: int, frames: int) -> None:
    samples = np.random.default_rng(4).uniform(-0.1, 0.1, (frames, 1)).astype(np.float32)
    for onset in {0, frames - 1}:
        around = audio_around(onset, frames=frames, rate_hz=rate_hz, tier=RULES.tier)
        audio = Clip(samples[around.start : around.stop], rate_hz, around.start)
        shot = shot_at(onset, audio, confidence=1.0, tier=RULES.tier)
        assert shot.onset == onset < shot.blast.stop <= frames
        assert onset < shot.span.stop <= frames


def test_sides_and_azimuths_are_heard_in_the_film_s_own_samples(film: tuple[Samples, Truth]) -> None:
    shots = film[0]
    voice = 0.2 * np.random.default_rng(8).standard_normal(shots.shape[0])
    played = np.stack([0.8 * shots, 0.2 * shots, voice], axis=1).astype(np.float32)

    def find_in(played: Samples, rate_hz: int) -> tuple[tuple[Shot, ...], int]:
        def read(span: Span) -> Samples:
            asked.append(len(span))
            return played[span.start : span.stop]

        asked: list[int] = []
        blocks = clips(played.sum(axis=1), rate_hz, sides=played[:, :2].sum(axis=1))
        channels = Channels((-30.0, 30.0, 0.0), 2, read)
        found = find_shots(blocks, rate_hz=rate_hz, tier=RULES.tier, verifier=VERIFIER, channels=channels)
        return found.shots, max(asked)

    plain, around = find_in(played, LISTENING_HZ)
    fine, twice = find_in(np.stack([at_rate(column, 96_000) for column in played.T], axis=1), 96_000)
    assert {shot.heard_in for shot in plain} == {"mains", "sides"}
    assert twice == 2 * around
    for one in plain:
        other = min(fine, key=lambda each: abs(each.onset - 2 * one.onset))
        assert abs(other.onset - 2 * one.onset) <= 9
        assert other.heard_in == one.heard_in
        assert other.azimuth_deg == pytest.approx(one.azimuth_deg, abs=3.0)
