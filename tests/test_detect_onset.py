"""The detector's parts: the same whatever the blocks are, and right to the sample where physics says so."""

from collections.abc import Iterator
from functools import partial

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import firwin, kaiserord

from blastline.detect.bandshape import band_levels
from blastline.detect.bursts import drop_claimed_reflections, group_bursts, suppress_non_maxima, without_echoes
from blastline.detect.candidates import _onsets, describe_candidates, let_all_pass
from blastline.detect.chunks import chunks
from blastline.detect.onset import _low_pass, refine_onsets
from blastline.detect.pace import automatic
from blastline.detect.scan import candidate_steps, rise_ratios
from blastline.detect.segment import segment
from blastline.detect.sparse import bands_near
from blastline.detect.tracks import BANDS, Grid, pieces
from blastline.model import Clip, Reflection, Shot, Span
from blastline.ruleset import ScanRules, load_rules

RATE_HZ = 48_000
TIER = load_rules("standard").tier
PACE = automatic(TIER.bursts)


def blast(rate_hz: int = RATE_HZ, *, rise_ms: float = 0.1, positive_ms: float = 1.0) -> NDArray[np.float64]:
    """Return a Friedlander blast with a straight rise, peak 1, its onset at index 0."""
    rise = max(1, round(rise_ms * rate_hz / 1000.0))
    time_ms = np.arange(round(0.02 * rate_hz)) * 1000.0 / rate_hz
    decay = (1.0 - time_ms / positive_ms) * np.exp(-time_ms / positive_ms)
    return np.concatenate([np.arange(1, rise) / rise, decay])


def film(rate_hz: int = RATE_HZ, seconds: float = 1.0, noise: float = 1e-4, seed: int = 0) -> NDArray[np.float32]:
    rng = np.random.default_rng(seed)
    return (noise * rng.standard_normal(round(seconds * rate_hz))).astype(np.float32)


def clips(samples: NDArray[np.float32], size: int, rate_hz: int = RATE_HZ) -> list[Clip]:
    return [Clip(samples[at : at + size, None], rate_hz, at) for at in range(0, samples.shape[0], size)]


@pytest.mark.parametrize("size", [1, 7, 4096])
def test_tracks_do_not_depend_on_the_block_size(size: int) -> None:
    samples = film(seconds=0.3 if size == 1 else 2.5)
    whole = list(pieces(clips(samples, samples.shape[0]), RATE_HZ))
    parts = list(pieces(clips(samples, size), RATE_HZ))
    assert len(whole) == len(parts) > 0
    for one, other in zip(whole, parts, strict=True):
        for track in ("samples", "peak", "slope", "bands"):
            np.testing.assert_array_equal(getattr(one, track), getattr(other, track))


def test_a_readers_reused_block_is_not_kept() -> None:
    samples = film(seconds=1.5)
    reused = np.empty((1000, 1), np.float32)

    def blocks() -> Iterator[Clip]:
        for at in range(0, samples.shape[0], 1000):
            reused[:, 0] = samples[at : at + 1000]
            yield Clip(reused, RATE_HZ, at)

    kept = np.concatenate([p.samples[: p.frames] for p in pieces(blocks(), RATE_HZ)])
    np.testing.assert_array_equal(kept, samples)


@pytest.mark.parametrize("rate_hz", [8_000, 22_050, 44_100, 48_000, 192_000])
@pytest.mark.parametrize(("frequency_hz", "band"), [(550.0, 1), (1200.0, 2), (2200.0, 3)])
def test_a_tone_sounds_in_its_own_band(rate_hz: int, frequency_hz: float, band: int) -> None:
    time = np.arange(2 * rate_hz) / rate_hz
    tone = (0.5 * np.sin(2 * np.pi * frequency_hz * time)).astype(np.float32)
    bands = next(iter(pieces(clips(tone, tone.shape[0], rate_hz), rate_hz))).bands[5:-5].mean(axis=0)
    assert bands.shape == (BANDS,)
    assert int(np.argmax(bands)) == band


@pytest.mark.parametrize("rate_hz", [44_100, 48_000, 96_000, 192_000])
def test_what_no_film_of_44_kilohertz_can_hold_is_filtered_out_and_all_else_passes(rate_hz: int) -> None:
    """By Kaiser's formulas, for 40 dB."""
    taps = _low_pass(rate_hz)
    frequencies_hz = np.linspace(0.0, rate_hz / 2.0, 2001)
    gain = np.abs(np.exp(-2j * np.pi * np.outer(frequencies_hz, np.arange(taps.size)) / rate_hz) @ taps)
    np.testing.assert_allclose(gain[frequencies_hz <= 18_000.0], 1.0, atol=0.011)
    assert np.all(gain[frequencies_hz >= 20_000.0] <= 0.011)  # which they reach but for a tenth


@pytest.mark.parametrize("rate_hz", [36_000, 40_000, 44_100, 48_000, 88_200, 96_000, 192_000])
def test_the_low_pass_is_the_shortest_odd_one_that_scipy_designs_by_the_same_formulas(rate_hz: int) -> None:
    if rate_hz <= 40_000:
        assert _low_pass(rate_hz).tolist() == [1.0]  # all is in band
        return
    count, beta = kaiserord(40.0, 2.0 * (20_000.0 - 18_000.0) / rate_hz)
    wanted = firwin(count | 1, 19_000.0, window=("kaiser", beta), fs=rate_hz)
    np.testing.assert_allclose(_low_pass(rate_hz), wanted, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("offset", [0.1, -0.03])
def test_no_track_hears_a_constant(offset: float) -> None:
    samples = film(seconds=2.5, noise=1e-3)
    shot = 0.3 * blast(rise_ms=0.3)
    samples[60_000 : 60_000 + shot.shape[0]] += shot.astype(np.float32)
    plain, shifted = (list(pieces(clips(each, 48_000), RATE_HZ)) for each in (samples, samples + np.float32(offset)))
    for one, other in zip(plain, shifted, strict=True):
        for track in ("peak", "slope"):
            np.testing.assert_allclose(getattr(one, track), getattr(other, track), atol=1e-7)
        np.testing.assert_allclose(np.sqrt(one.bands), np.sqrt(other.bands), atol=1e-6)


def test_rises_compare_with_the_past_alone() -> None:
    track = np.array([1, 1, 1, 8, 8, 2, 2, 2, 2, 2, 2, 16], np.float32)
    ratio = rise_ratios(track, 4, 1e-3)
    assert ratio[3] == 8.0  # over the ones before
    assert ratio[4] == 8.0  # the step right before is left out: a rise may straddle two
    assert ratio[6] == 2.0 / 8.0
    assert ratio[11] == 8.0  # the eights have left the history by then
    for at in range(len(track)):
        past = track[max(0, at - 5) : max(0, at - 1)]
        assert ratio[at] == pytest.approx(track[at] / max([*past.tolist(), 1e-3]))


@pytest.mark.parametrize("rate_hz", [8_000, 44_100, 48_000, 96_000])
@pytest.mark.parametrize("rise_ms", [0.05, 0.5, 2.0])
def test_the_onset_is_the_first_sample_of_the_rise(rate_hz: int, rise_ms: float) -> None:
    errors_ms = []
    for seed in range(12):
        samples = film(rate_hz, seed=seed)
        at = round(0.5 * rate_hz) + 7 * seed
        shot = 0.5 * blast(rate_hz, rise_ms=rise_ms, positive_ms=2.0)
        samples[at : at + shot.shape[0]] += shot.astype(np.float32)
        grid = Grid(rate_hz)
        chunk = next(chunks(pieces(clips(samples, samples.shape[0], rate_hz), rate_hz)))
        steps = candidate_steps(
            chunk.peak, chunk.slope, chunk.bands, grid=grid, rules=TIER.scan, pace=automatic(TIER.bursts)
        )
        onsets = refine_onsets(chunk.samples, steps * grid.step, rate_hz=rate_hz, rules=TIER.onset)
        errors_ms.append(np.min(np.abs(onsets - at)) * 1000.0 / rate_hz)
    # one sample of an 8 kHz film lasts 0.125 ms
    assert max(errors_ms) <= max(0.1, 1100.0 / rate_hz)


@pytest.mark.parametrize("rate_hz", [44_100, 48_000, 96_000])
@pytest.mark.parametrize("rise_ms", [1.0, 2.0, 3.0])
def test_a_slow_rise_begins_where_it_leaves_zero_not_where_it_stands_out(rate_hz: int, rise_ms: float) -> None:
    rise = 0.5 * blast(rate_hz, rise_ms=rise_ms, positive_ms=2.0).astype(np.float32)
    for seed in range(6):
        samples, at = film(rate_hz, seed=seed), rate_hz // 2 + 7 * seed
        samples[at : at + rise.size] += rise
        (onset,) = refine_onsets(samples, np.array([at + rate_hz // 500]), rate_hz=rate_hz, rules=TIER.onset)
        assert abs(onset - at) <= 0.03e-3 * rate_hz


def test_a_delay_delays_the_onset_and_gain_and_polarity_do_not() -> None:
    samples = film(noise=1e-3)
    shot = 0.3 * blast(rise_ms=0.3)
    samples[20_000 : 20_000 + shot.shape[0]] += shot.astype(np.float32)
    (onset,) = refine_onsets(samples, np.array([20_030]), rate_hz=RATE_HZ, rules=TIER.onset)
    for n in (1, 13, 47, 48):
        later = np.concatenate([np.zeros(n, np.float32), samples])
        (moved,) = refine_onsets(later, np.array([20_030 // 48 * 48]), rate_hz=RATE_HZ, rules=TIER.onset)
        assert moved == onset + n
    for gain in (-1.0, 2.0, 0.125):
        changed = (gain * samples).astype(np.float32)
        assert refine_onsets(changed, np.array([20_030]), rate_hz=RATE_HZ, rules=TIER.onset)[0] == onset


@pytest.mark.parametrize("smear_db", [-40.0, -30.0])
def test_what_a_codec_smears_before_a_shot_is_not_its_onset(smear_db: float) -> None:
    """A transform codec spreads its error over a block: up to 5 ms of noise before the attack, far beneath it."""
    samples = film(noise=1e-5)
    shot = 0.5 * blast(rise_ms=0.05)
    samples[20_000 : 20_000 + shot.shape[0]] += shot.astype(np.float32)
    smear = 0.5 * 10.0 ** (smear_db / 20.0) * np.random.default_rng(1).uniform(-1.0, 1.0, 240)
    samples[19_760:20_000] += smear.astype(np.float32)
    (onset,) = refine_onsets(samples, np.array([20_030]), rate_hz=RATE_HZ, rules=TIER.onset)
    assert abs(onset - 20_000) <= 5


@pytest.mark.parametrize("tone_hz", [30.0, 60.0, 120.0])
def test_an_engine_as_loud_as_the_shot_moves_no_onset(tone_hz: float) -> None:
    for seed in range(12):
        rng = np.random.default_rng(seed)
        engine = 0.3 * np.sin(2.0 * np.pi * tone_hz * np.arange(RATE_HZ) / RATE_HZ + rng.uniform(0.0, 6.28))
        samples = film(noise=3e-3, seed=seed) + engine.astype(np.float32)
        shot = rng.choice([-0.3, 0.3]) * blast(positive_ms=0.5)
        samples[20_000 : 20_000 + shot.shape[0]] += shot.astype(np.float32)
        guess = 20_000 + int(rng.integers(-30, 30))
        (onset,) = refine_onsets(samples, np.array([guess]), rate_hz=RATE_HZ, rules=TIER.onset)
        assert abs(onset - 20_000) <= 10


@pytest.mark.parametrize("place", [24_000, 24_001, 24_047])
def test_a_step_is_a_candidate_wherever_it_lies_on_the_grid(place: int) -> None:
    samples = film(noise=1e-5)
    samples[place:] += np.float32(0.3)
    chunk = next(chunks(pieces(clips(samples, samples.shape[0]), RATE_HZ)))
    steps = candidate_steps(
        chunk.peak, chunk.slope, chunk.bands, grid=Grid(RATE_HZ), rules=TIER.scan, pace=automatic(TIER.bursts)
    )
    onsets = refine_onsets(chunk.samples, steps * 48, rate_hz=RATE_HZ, rules=TIER.onset)
    assert np.abs(onsets - place).min() <= 1


def steps_of(samples: NDArray[np.float32], rules: ScanRules = TIER.scan) -> list[int]:
    chunk = next(chunks(pieces(clips(samples, samples.shape[0]), RATE_HZ)))
    steps = candidate_steps(chunk.peak, chunk.slope, chunk.bands, grid=Grid(RATE_HZ), rules=rules, pace=PACE)
    return [int(step) for step in steps]


def mastered() -> NDArray[np.float32]:
    """Return shots over steps, knocks and what is hardly heard, 20 to 100 dB under them, after silence."""
    rng = np.random.default_rng(4)
    samples = np.zeros(6 * RATE_HZ)
    samples[RATE_HZ:] += 1e-4 * rng.standard_normal(5 * RATE_HZ)
    for place in rng.integers(RATE_HZ // 2, 5 * RATE_HZ, 60).tolist():
        knock = 10.0 ** (rng.uniform(-80.0, -6.0) / 20.0) * blast(rise_ms=0.1)
        samples[place : place + knock.shape[0]] += knock
    return samples.astype(np.float32)


@pytest.mark.parametrize("gain_db", [-20.0, 6.0])
def test_a_film_that_is_mastered_lower_or_higher_has_the_same_candidates(gain_db: float) -> None:
    samples = mastered()
    steps = steps_of(samples)
    assert len(steps) > 20
    assert steps_of((10.0 ** (gain_db / 20.0) * samples).astype(np.float32)) == steps


def test_what_is_far_beneath_the_sounds_around_it_is_silence_and_elsewhere_is_not() -> None:
    faint_db, far_s = 6.0 - TIER.scan.range_db, 3
    assert 0.5 * 10.0 ** (faint_db / 20.0) > 10.0 ** (TIER.scan.floor_dbfs / 20.0)
    for loud in (False, True):
        samples = np.zeros(6 * RATE_HZ)
        for at_s in (1.0, 1.0 + far_s):
            knock = 0.5 * 10.0 ** ((faint_db - 12.0) / 20.0) * blast(rise_ms=0.1)
            samples[round(at_s * RATE_HZ) :][: knock.shape[0]] += knock
        if loud:
            shot = 0.5 * blast(rise_ms=0.1)
            samples[round(1.5 * RATE_HZ) :][: shot.shape[0]] += shot
        near = [any(abs(step - at_ms) <= 2 for step in steps_of(samples.astype(np.float32))) for at_ms in (1000, 4000)]
        assert near == [not loud, True]


@pytest.mark.parametrize("offset", [0.02, -0.2])
def test_a_constant_offset_moves_no_onset(offset: float) -> None:
    samples = film(noise=1e-3)
    shot = 0.3 * blast(rise_ms=0.3)
    samples[20_000 : 20_000 + shot.shape[0]] += shot.astype(np.float32)
    plain, shifted = (
        refine_onsets(each, np.array([20_030]), rate_hz=RATE_HZ, rules=TIER.onset)
        for each in (samples, samples + np.float32(offset))
    )
    assert abs(plain[0] - shifted[0]) <= 1


def test_a_shot_on_the_first_sample_is_a_candidate_with_onset_zero() -> None:
    samples = film()
    shot = 0.5 * blast()
    samples[: shot.shape[0]] += shot.astype(np.float32)
    chunk = next(chunks(pieces(clips(samples, samples.shape[0]), RATE_HZ)))
    steps = candidate_steps(
        chunk.peak, chunk.slope, chunk.bands, grid=Grid(RATE_HZ), rules=TIER.scan, pace=automatic(TIER.bursts)
    )
    onsets = refine_onsets(chunk.samples, steps * 48, rate_hz=RATE_HZ, rules=TIER.onset)
    assert 0 in onsets


def shot_with_echoes(delays_ms: list[float], gains: list[float]) -> tuple[NDArray[np.float32], int]:
    samples = film(seconds=2.0).astype(np.float64)
    direct = 0.6 * blast(positive_ms=0.8)
    at = 48_000
    for delay_ms, gain in zip([0.0, *delays_ms], [1.0, *gains], strict=True):
        start = at + round(delay_ms * 48)
        samples[start : start + direct.shape[0]] += gain * direct
    return samples.astype(np.float32), at


def test_reflections_are_found_at_their_delay_and_level() -> None:
    samples, at = shot_with_echoes([17.5, 60.0, 175.0], [0.5, -0.4, 0.25])
    shot = segment(samples, at, film_start=0, film_stop=96_000, confidence=1.0, rate_hz=RATE_HZ, rules=TIER.segment)
    assert [r.delay_ms for r in shot.reflections] == pytest.approx([17.5, 60.0, 175.0], abs=0.05)
    levels = [20 * np.log10(g) for g in (0.5, 0.4, 0.25)]
    assert [r.level_db for r in shot.reflections] == pytest.approx(levels, abs=0.5)
    assert shot.blast.start == at == shot.onset
    assert 1.0 <= len(shot.blast) / 48 <= 6.0
    assert shot.span.start == at
    assert shot.span.stop > at + 60 * 48


def test_a_shot_at_the_end_of_what_is_known_stays_inside() -> None:
    samples, at = shot_with_echoes([], [])
    for left in (1, 2, 100):
        stop = at + left
        shot = segment(samples, at, film_start=0, film_stop=stop, confidence=1.0, rate_hz=RATE_HZ, rules=TIER.segment)
        assert at < shot.span.stop <= stop
        assert at < shot.blast.stop <= stop
        assert shot.reflections == ()


def shots_at(*times_ms: float, confidence: float = 0.9) -> list[Shot]:
    found = []
    for ms in times_ms:
        at = round(ms * 48)
        found.append(
            Shot(
                onset=at,
                confidence=confidence,
                peak_dbfs=0.0,
                snr_db=20.0,
                blast=Span(at, at + 10),
                reflections=(),
                span=Span(at, at + 10),
            )
        )
    return found


def test_bursts_are_runs_of_shots_in_the_rhythm_of_automatic_fire() -> None:
    shots = shots_at(0, 1000, 1100, 1200, 1300, 3000, 3050, 5000, 5060, 5120)
    grouped = group_bursts(shots, rate_hz=RATE_HZ, rules=TIER.bursts)
    assert [s.burst for s in grouped] == [None, 1, 1, 1, 1, None, None, 2, 2, 2]
    assert [s.shot_in_burst for s in grouped] == [None, 1, 2, 3, 4, None, None, 1, 2, 3]


def test_the_next_shot_of_a_burst_is_no_reflection() -> None:
    first, second = shots_at(1000, 1085)
    echoes = tuple(Reflection(48 * ms, 48 * ms + 10, ms - 1000.0, -6.0) for ms in (1030, 1084, 1200))
    parted = drop_claimed_reflections(
        [msgspec.structs.replace(first, reflections=echoes), second], rate_hz=RATE_HZ, rules=TIER.bursts
    )
    assert [echo.delay_ms for echo in parted[0].reflections] == [30.0, 200.0]


def test_a_weaker_copy_is_an_echo_and_a_round_as_loud_is_not() -> None:
    first, later = shots_at(1_000, 1_090)
    repeated = Reflection(later.onset + 20, later.onset + 100, 90.4, -6.0)
    heard = msgspec.structs.replace(first, peak_dbfs=-6.0, reflections=(repeated,))

    def kept(peak_dbfs: float, level_db: float = -6.0, late: int = 0) -> list[int]:
        there = msgspec.structs.replace(
            heard, reflections=(msgspec.structs.replace(repeated, start=repeated.start + late, level_db=level_db),)
        )
        shots, echoes = without_echoes(
            [there, msgspec.structs.replace(later, peak_dbfs=peak_dbfs)], rate_hz=RATE_HZ, rules=TIER.bursts
        )
        assert len(shots) + len(echoes) == 2
        return [shot.onset for shot in shots]

    assert kept(-12.0) == kept(-12.0, late=-40) == [first.onset]  # a little later, or sooner, than the copy
    assert kept(-7.0) == [first.onset, later.onset]  # as loud: the gun fired again
    assert kept(-12.0, level_db=-1.0) == [first.onset, later.onset]  # likeness says as loud
    assert kept(-12.0, late=960) == [first.onset, later.onset]  # no copy is there


def test_an_echo_in_a_film_is_no_shot_of_its_own() -> None:
    """Where the verdict takes a clear copy for a shot, the waveform says whose it is."""
    samples, at = shot_with_echoes([180.0], [0.4])
    first, second = (
        segment(
            samples,
            onset,
            film_start=0,
            film_stop=samples.shape[0],
            confidence=0.99,
            rate_hz=RATE_HZ,
            rules=TIER.segment,
        )
        for onset in (at, at + 180 * 48)
    )
    shots, echoes = without_echoes([first, second], rate_hz=RATE_HZ, rules=TIER.bursts)
    assert [shot.onset for shot in shots] == [at]
    assert [echo.at_sample for echo in echoes] == [at + 180 * 48]


def test_what_two_shots_claim_is_the_later_ones_echo() -> None:
    shots = shots_at(1_000, 1_090, 1_180)
    heard = [
        msgspec.structs.replace(
            shot,
            reflections=tuple(
                Reflection(shot.onset + round(48 * ms), shot.onset + round(48 * (ms + 2.0)), ms, -12.0) for ms in delays
            ),
        )
        for shot, delays in zip(shots, ([21.0, 111.2, 201.0, 300.0], [21.0, 110.5], [21.0]), strict=True)
    ]
    parted = drop_claimed_reflections(heard, rate_hz=RATE_HZ, rules=TIER.bursts)
    assert [[echo.delay_ms for echo in shot.reflections] for shot in parted] == [[21.0, 300.0], [21.0], [21.0]]


def test_of_two_shots_nearer_than_any_gun_the_surer_stays() -> None:
    kept, dropped = suppress_non_maxima(
        [*shots_at(0, confidence=0.6), *shots_at(20, confidence=0.9), *shots_at(60)],
        rate_hz=RATE_HZ,
        rules=TIER.bursts,
        sure={"mains": TIER.verify.threshold},
    )
    assert [s.onset for s in kept] == [20 * 48, 60 * 48]
    assert [r.at_sample for r in dropped] == [0]
    assert dropped[0].evidence["probability"] == 0.6


def test_bands_looked_up_near_a_place_are_those_of_the_scan() -> None:
    samples = film(seconds=4.0, noise=0.1)
    samples[96_000:] *= np.float32(4.0)
    grid = Grid(RATE_HZ)
    scanned = np.concatenate([piece.bands for piece in pieces(clips(samples, 5_000), RATE_HZ)])
    whole = np.concatenate([piece.samples for piece in pieces(clips(samples, 5_000), RATE_HZ, with_bands=False)])
    places = np.array([20_000, 120_000])
    sparse = bands_near(whole, places, grid)
    assert sparse.shape == scanned.shape
    for place in places // grid.hop:
        near = slice(place - 7, place + 17)
        np.testing.assert_allclose(np.sqrt(sparse[near]), np.sqrt(scanned[near]), rtol=1e-2, atol=1e-6)
    ours, theirs = (band_levels(bands, places, grid)[:, -1] for bands in (sparse, scanned))
    attack = slice(3, 8)  # the segments whose frames are all there
    np.testing.assert_allclose(ours[:, attack], theirs[:, attack], atol=0.02)
    np.testing.assert_allclose(ours, theirs, atol=2.0)  # of noise, a mean of an eighth as many frames


def test_a_film_without_scanned_bands_has_the_same_other_tracks() -> None:
    samples = film(seconds=2.5)
    with_bands, without = (list(pieces(clips(samples, 7_000), RATE_HZ, with_bands=asked)) for asked in (True, False))
    for one, other in zip(with_bands, without, strict=True):
        assert other.bands.shape == (0, BANDS)
        for track in ("samples", "peak", "slope"):
            np.testing.assert_array_equal(getattr(one, track), getattr(other, track))


def test_where_the_scan_guessed_an_onset_leaves_hardly_a_trace() -> None:
    rng = np.random.default_rng(0)
    onsets = RATE_HZ // 2 + RATE_HZ * np.arange(40)
    film = 1e-4 * rng.standard_normal(41 * RATE_HZ)
    time = np.arange(4800)
    for onset in onsets.tolist():
        rise = np.minimum(1.0, (time + 1) / rng.integers(1, 40))
        film[onset : onset + 4800] += 0.5 * rise * rng.standard_normal(4800) * np.exp(-time / 400)
    samples = film.astype(np.float32)
    there = refine_onsets(samples, onsets, rate_hz=RATE_HZ, rules=TIER.onset)
    for late in (-96, -48, 96):
        again = refine_onsets(samples, onsets + late, rate_hz=RATE_HZ, rules=TIER.onset)
        assert np.mean(again == there) >= 0.95
        assert np.max(np.abs(again - there)) <= 4


def lingering(onsets: list[int], *, decay_ms: float = 80.0, seed: int = 3) -> NDArray[np.float32]:
    """Return rounds of noise that die away so slowly that each next one rises but a little over what is left."""
    rng = np.random.default_rng(seed)
    samples = 1e-4 * rng.standard_normal(onsets[-1] + 2 * RATE_HZ)
    for onset in onsets:
        t = np.arange(samples.size - onset) / RATE_HZ
        samples[onset:] += 0.2 * rng.standard_normal(t.size) * np.exp(-t * 1000.0 / decay_ms)
    return samples.astype(np.float32)


def heard(onsets: list[int], steps: list[int]) -> list[bool]:
    return [any(abs(48 * step - onset) <= 96 for step in steps) for onset in onsets]


@pytest.mark.parametrize("gap_ms", [57, 65, 72])
def test_rounds_of_fast_fire_are_candidates_however_long_they_linger(gap_ms: int) -> None:
    found, towering = 0, 0
    onsets = [48_000 + number * gap_ms * 48 for number in range(12)]
    for seed in range(6):
        samples = lingering(onsets, seed=seed)
        found += sum(heard(onsets, steps_of(samples)))
        towering += sum(heard(onsets, steps_of(samples, msgspec.structs.replace(TIER.scan, row_jump_db=None))))
    assert found >= 0.8 * 72
    assert towering <= 0.6 * 72, "few of them tower over the one before"


def test_small_rises_that_keep_no_pace_are_no_candidates() -> None:
    gaps_ms = [50, 72, 41, 95, 55, 120, 38, 77, 140, 60, 100]
    onsets = [48_000, *(48_000 + 48 * at_ms for at_ms in np.cumsum(gaps_ms).tolist())]
    samples = lingering(onsets)
    assert steps_of(samples) == steps_of(samples, msgspec.structs.replace(TIER.scan, row_jump_db=None))


def rifle(blast_at: int, *, early_ms: int, crack_peak: float) -> NDArray[np.float32]:
    """Return 3 s of faint noise with the blast of a rifle and, so much earlier, the crack of its bullet.

    A crack is an N-wave of .3 ms; it rises out of silence, so that the blast after it rises less.
    """
    samples = 3e-4 * np.random.default_rng(early_ms).standard_normal(3 * RATE_HZ)
    crack_at = blast_at - 48 * early_ms
    samples[crack_at : crack_at + 15] += crack_peak * np.linspace(1.0, -1.0, 15)
    t = np.arange(RATE_HZ) / RATE_HZ
    rng = np.random.default_rng(1)
    samples[blast_at : blast_at + t.size] += 0.25 * (1.0 - t / 0.001) * np.exp(-t / 0.001)
    samples[blast_at : blast_at + t.size] += 0.15 * rng.standard_normal(t.size) * np.exp(-t / 0.05)
    return samples.astype(np.float32)


@pytest.mark.parametrize("early_ms", [5, 7, 8, 9, 10, 11, 12, 13, 16])
@pytest.mark.parametrize("crack_peak", [0.1, 0.35])
def test_the_blast_after_the_crack_of_its_bullet_has_its_own_onset(early_ms: int, crack_peak: float) -> None:
    blast_at = 96_000
    film = rifle(blast_at, early_ms=early_ms, crack_peak=crack_peak)
    crack_at = blast_at - 48 * early_ms
    chunk = next(chunks(pieces(clips(film, film.shape[0]), RATE_HZ)))
    found = describe_candidates(chunk, Grid(RATE_HZ), TIER, gate=let_all_pass, screen=let_all_pass).onsets
    for at in (crack_at, blast_at):
        assert np.abs(found - at).min() <= 10, at


def test_of_a_films_first_two_places_the_second_has_its_own_onset_as_later_ones_have() -> None:
    """The crack is so loud that the blast alone would have the crack's onset."""
    samples, crack_at = rifle(96_000, early_ms=5, crack_peak=0.6), 96_000 - 48 * 5
    pair = np.array([crack_at, 96_000]) + 24
    assert np.ptp(refine_onsets(samples, pair, rate_hz=RATE_HZ, rules=TIER.onset)) == 0
    find = partial(_onsets, samples, rate_hz=RATE_HZ, rules=TIER.onset)
    alone = find(pair, np.array([0, 1]))
    np.testing.assert_array_equal(find(np.array([20_000, *pair]), np.array([1, 2])), alone)
    np.testing.assert_allclose(alone, [crack_at, 96_000], atol=10)
