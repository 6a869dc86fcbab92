"""Shots: the formulas of their waves, exact onsets, and echoes where geometry puts them."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from blastline.synth import random_shot
from blastline.synth.chance import generator
from blastline.synth.colour import CLEAN, air, draw_colour, record
from blastline.synth.echoes import with_acoustics
from blastline.synth.images import SPEED_OF_SOUND_M_S, Axis, image_echoes
from blastline.synth.layouts import LOUDSPEAKERS_DEG, sound_gains
from blastline.synth.rooms import ENVIRONMENTS, Acoustics, Environment, draw_acoustics, tail_noise
from blastline.synth.scene import Layout
from blastline.synth.shots import fire, fire_apart
from blastline.synth.tone import compress, highpass, lowpass, peak, tilt
from blastline.synth.voices import draw_voice
from blastline.synth.waves import friedlander, n_wave
from blastline.synth.weapons import WEAPONS, WeaponName

RATE_HZ = 48_000


def test_the_impulses_of_friedlanders_wave() -> None:
    wave = friedlander(1_000_000, positive_ms=2.0)
    positive = wave[wave > 0.0].sum() / 1e6
    negative = wave[wave < 0.0].sum() / 1e6
    assert positive == pytest.approx(0.002 / math.e, rel=1e-3)
    assert negative == pytest.approx(-0.002 / math.e, rel=5e-3)
    assert np.flatnonzero(wave <= 0.0)[0] == 2_000


def test_a_rise_lengthens_the_front_and_leaves_the_rest() -> None:
    sharp = friedlander(RATE_HZ, positive_ms=1.0)
    soft = friedlander(RATE_HZ, positive_ms=1.0, rise_ms=1.0)
    assert np.array_equal(soft[47:], sharp)
    assert np.all(np.diff(soft[:48]) > 0.0)
    assert soft[0] > 0.0


def test_the_n_wave_falls_straight_from_plus_to_minus_one() -> None:
    wave = n_wave(RATE_HZ, length_ms=0.5, rise_ms=0.0)
    assert (wave[0], wave[-1], len(wave)) == (1.0, -1.0, 24)
    assert np.diff(wave) == pytest.approx(-2.0 / 23)


@pytest.mark.parametrize("seed", range(6))
def test_a_shot_is_zero_before_its_start_and_sounds_at_its_onset(seed: int) -> None:
    for number in range(6):
        samples, onset, truth = random_shot(generator(seed, number), RATE_HZ)
        assert np.isfinite(samples).all()
        assert onset == truth.onset_sample == truth.blast.start
        assert not np.any(samples[: truth.start_sample])
        assert np.any(samples[onset : onset + 4])
        assert peak(samples[onset : onset + RATE_HZ // 20]) == pytest.approx(1.0)
        assert all(truth.start_sample <= at < onset for at in truth.accept_samples)


def test_the_first_sample_of_a_lone_shot_is_its_onset() -> None:
    voice = draw_voice(generator(1), "pistol", environment="field", distance_m=5.0, clean=True)
    samples, truth = fire(generator(2), RATE_HZ, voice)
    assert truth.onset_sample == 0
    assert samples[0] != 0.0


@pytest.mark.parametrize(("weapon", "environment"), list(itertools.product(WEAPONS, ENVIRONMENTS)))
def test_every_weapon_in_every_place(weapon: WeaponName, environment: Environment) -> None:
    voice = draw_voice(generator(3, weapon, environment), weapon, environment=environment)
    samples, truth = fire(generator(4), RATE_HZ, voice)
    assert (truth.weapon, truth.environment) == (weapon, environment)
    assert len(truth.blast) > 0
    assert 0.02 < len(samples) / RATE_HZ < 12.0


def test_shots_of_one_voice_share_their_echoes_and_differ_otherwise() -> None:
    voice = draw_voice(generator(5), "smg", environment="street")
    (one, first), (two, second) = (fire(generator(6, number), RATE_HZ, voice) for number in (0, 1))
    assert {echo.delay_ms for echo in first.reflections} & {echo.delay_ms for echo in second.reflections}
    count = min(len(one), len(two))
    assert not np.allclose(one[:count], two[:count])


def test_the_sample_rate_changes_neither_the_voice_nor_its_times() -> None:
    for rate_hz in (44_100, 96_000):
        voice = draw_voice(generator(7), "rifle", environment="street", distance_m=30.0)
        _, here = fire(generator(8), RATE_HZ, voice)
        _, there = fire(generator(8), rate_hz, voice)
        assert there.onset_s == pytest.approx(here.onset_s, abs=1.0 / 44_100)
        assert there.rise_ms == here.rise_ms
        delays = [[echo.delay_ms for echo in truth.reflections[:3]] for truth in (here, there)]
        assert delays[0] == pytest.approx(delays[1], abs=0.03)


def test_the_ground_answers_after_the_detour_and_as_weakly_as_it_is_long() -> None:
    source, listener, far = 1.2, 1.8, 10.0
    axes = (Axis(None, 0.0, far, 0.0), Axis(None, 0.0, 0.0, 0.0), Axis(None, source, listener, 0.8))
    direct, (echo,) = image_echoes(axes, order=0, corner_hz=20_000.0)
    bounce = math.hypot(far, source + listener)
    assert direct == pytest.approx(math.hypot(far, source - listener))
    assert echo.delay_s == pytest.approx((bounce - direct) / SPEED_OF_SOUND_M_S)
    assert echo.gain == pytest.approx(0.8 * direct / bounce)


def test_two_walls_answer_at_the_images_of_the_source() -> None:
    width, at = 10.0, 4.0
    axes = (Axis(width, at, at, 0.9), Axis(None, 0.0, 6.0, 0.0), Axis(None, 0.0, 0.0, 0.0))
    _, echoes = image_echoes(axes, order=1, corner_hz=20_000.0)
    # the near wall, the far wall, and both in turn
    for across, hits in ((2 * at, 1), (2 * (width - at), 1), (2 * width, 2)):
        path = math.hypot(across, 6.0)
        found = [echo for echo in echoes if echo.delay_s == pytest.approx((path - 6.0) / SPEED_OF_SOUND_M_S)]
        assert found
        assert found[0].gain == pytest.approx(6.0 / path * 0.9**hits)


def test_echoes_come_out_where_and_as_strong_as_the_truth_says() -> None:
    axes = (Axis(None, 0.0, 6.0, 0.0), Axis(20.0, 8.0, 8.0, 0.7), Axis(None, 0.0, 0.0, 0.0))
    direct_m, echoes = image_echoes(axes, order=1, corner_hz=30_000.0)
    click = np.array([1.0])
    heard, listed = with_acoustics(generator(9), click, Acoustics(direct_m, echoes, None), rate_hz=RATE_HZ)
    assert [echo.delay for echo in listed] == [round(echo.delay_s * RATE_HZ) for echo in echoes]
    for echo in listed:
        alone = [other for other in listed if other.delay == echo.delay]
        assert heard[echo.delay] == pytest.approx(sum(other.gain for other in alone))
    assert np.count_nonzero(heard) == 1 + len({echo.delay for echo in listed})


@pytest.mark.parametrize("environment", ENVIRONMENTS)
def test_a_tail_holds_its_energy_and_dies_at_its_rate(environment: Environment) -> None:
    for seed in range(3):
        acoustics = draw_acoustics(generator(10, environment, seed), environment)
        assert acoustics.tail is not None
        noise = tail_noise(generator(11), RATE_HZ, acoustics.tail)
        assert 10.0 * math.log10(np.sum(noise**2)) == pytest.approx(acoustics.tail.level_db, abs=1e-6)
        # Schroeder's backward integral from -5 to -25 dB: between the two reverberation times
        decay_db = 10.0 * np.log10(np.cumsum(noise[::-1] ** 2)[::-1] / np.sum(noise**2))
        early, late = np.searchsorted(-decay_db, [5.0, 25.0])
        time_s = 3.0 * (late - early) / RATE_HZ
        slowest = max(acoustics.tail.low_s, acoustics.tail.high_s)
        fastest = min(acoustics.tail.low_s, acoustics.tail.high_s)
        assert 0.75 * fastest < time_s < 1.25 * slowest + 1.5 * acoustics.tail.growth_s


def test_air_and_recording_are_causal() -> None:
    sound = np.zeros(4_000)
    sound[1_000:1_400] = friedlander(RATE_HZ, positive_ms=1.0)[:400]
    for seed in range(30):
        heard = record(air(sound, 10.0 * seed + 1.0, rate_hz=RATE_HZ), draw_colour(generator(seed)), rate_hz=RATE_HZ)
        assert not np.any(heard[:1_000])
        assert np.any(heard[1_000:1_004])
        assert np.isfinite(heard).all()
    assert not np.any(record(np.zeros(10), CLEAN, rate_hz=RATE_HZ))


def test_far_air_takes_the_treble() -> None:
    click = np.zeros(4_096)
    click[0] = 1.0
    spectra = [np.abs(np.fft.rfft(air(click, far, rate_hz=RATE_HZ))) for far in (1.0, 100.0, 1_500.0)]
    at_5_khz = [spectrum[round(5_000 / RATE_HZ * 4_096)] for spectrum in spectra]
    assert at_5_khz[0] > 0.8
    assert at_5_khz[0] > 1.5 * at_5_khz[1] > 2.25 * at_5_khz[2]


def test_filters_meet_their_corners() -> None:
    click = np.zeros(RATE_HZ)
    click[0] = 1.0
    low, high, tilted = (
        np.abs(np.fft.rfft(samples))
        for samples in (
            lowpass(click, 1_000.0, rate_hz=RATE_HZ),
            highpass(click, 1_000.0, rate_hz=RATE_HZ),
            tilt(click, 12.0, pivot_hz=1_000.0, rate_hz=RATE_HZ),
        )
    )
    assert low[1_000] == pytest.approx(math.sqrt(0.5), abs=1e-3)
    assert high[1_000] == pytest.approx(math.sqrt(0.5), abs=1e-3)
    assert low[0] == pytest.approx(1.0, abs=1e-3)
    levels_db = 20.0 * np.log10(tilted[[10, 1_000, 20_000]])
    assert levels_db == pytest.approx([-6.0, 0.0, 6.0], abs=0.2)


def test_the_compressor_holds_a_steady_tone_at_its_ratio() -> None:
    tone = np.full(48_000, 0.5)
    squashed = compress(tone, threshold=0.125, ratio=2.0, release_ms=50.0, rate_hz=RATE_HZ)
    assert squashed == pytest.approx(0.25)
    burst = np.concatenate([tone[:100], np.full(48_000, 0.01)])
    released = compress(burst, threshold=0.125, ratio=2.0, release_ms=50.0, rate_hz=RATE_HZ)
    assert released[101] < 0.006
    assert released[-1] == pytest.approx(0.01)


@pytest.mark.parametrize("seed", range(4))
def test_a_blast_ends_with_the_last_sample_of_it_that_is_within_20_db_of_its_peak(seed: int) -> None:
    voice = draw_voice(generator(seed, "blast"), "pistol", environment="field")
    fired = fire_apart(generator(seed, "fired"), 48_000, replace(voice, roars=(), second_pulse=None))
    blast, direct = len(fired.truth.blast), np.abs(fired.parts.direct)
    assert direct[blast - 1] >= 0.1 * direct.max() > direct[blast:].max()


@pytest.mark.parametrize("layout", ["stereo", "5.1", "7.1"])
@pytest.mark.parametrize("azimuth_deg", [-170.0, -100.0, -45.0, -30.0, -12.0, 0.0, 30.0, 70.0, 110.0])
def test_a_sound_is_panned_to_where_it_comes_from_as_far_as_there_are_loudspeakers(
    layout: Layout, azimuth_deg: float
) -> None:
    gains, there = sound_gains(np.random.default_rng(1), layout, azimuth_deg), LOUDSPEAKERS_DEG[layout]
    mains = gains[list(there)]
    assert np.all(gains >= 0.0)
    assert np.mean(mains) == pytest.approx(1.0)
    assert np.sum(gains) == pytest.approx(np.sum(mains)), "the LFE has none"
    if layout == "5.1" and abs(azimuth_deg) > 110.0:  # half a circle and more lies between the surrounds
        return
    toward = np.angle(np.sum(mains * np.exp(1j * np.radians(list(there.values())))), deg=True)
    assert toward == pytest.approx(np.clip(azimuth_deg, -30.0, 30.0) if layout == "stereo" else azimuth_deg, abs=1e-6)
