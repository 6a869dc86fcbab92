"""Reflections: found where physics put them, nowhere else, and the same however loud, late or sampled the film is."""

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.reflections import BandAnswer, _background, discrete_reflections
from blastline.detect.segment import segment
from blastline.model import Shot
from blastline.ruleset import load_rules
from blastline.units import gain_from_db

RATE_HZ = 48_000
ONSET_S = 0.5
RULES = load_rules("standard").tier.segment


def blast(rate_hz: int, *, positive_ms: float = 0.8) -> NDArray[np.float64]:
    time_ms = np.arange(round(0.03 * rate_hz)) * 1000.0 / rate_hz
    return np.asarray((1.0 - time_ms / positive_ms) * np.exp(-time_ms / positive_ms), np.float64)


def film(
    echoes: dict[float, float],
    *,
    rate_hz: int = RATE_HZ,
    noise_db: float = -45.0,
    tail_db: float | None = None,
    corner_hz: float | None = None,
    seed: int = 0,
) -> NDArray[np.float64]:
    """Return a shot at half a second with echoes as {delay in ms: level in dB}, over noise, and a tail."""
    from scipy.signal import butter, fftconvolve, sosfilt

    rng = np.random.default_rng(seed)
    direct = blast(rate_hz)
    samples = gain_from_db(noise_db) * rng.standard_normal(round(2.2 * rate_hz))
    at = round(ONSET_S * rate_hz)
    samples[at : at + direct.size] += direct
    dull = direct if corner_hz is None else sosfilt(butter(1, corner_hz, fs=rate_hz, output="sos"), direct)
    for delay_ms, level_db in echoes.items():
        start = at + round(delay_ms * rate_hz / 1000.0)
        samples[start : start + direct.size] += gain_from_db(level_db) * dull
    if tail_db is not None:
        time_s = np.arange(rate_hz) / rate_hz
        tail = rng.standard_normal(rate_hz) * np.exp(-time_s / 0.15)
        tail *= gain_from_db(tail_db) / np.sqrt(np.sum(tail**2))
        late = fftconvolve(direct, tail)[:rate_hz]
        samples[at + rate_hz // 100 :][: late.size] += late
    return np.asarray(0.5 * samples, np.float64)


def segmented(samples: NDArray[np.float64], *, rate_hz: int = RATE_HZ, onset: int | None = None) -> Shot:
    return segment(
        samples.astype(np.float32),
        round(ONSET_S * rate_hz) if onset is None else onset,
        film_start=0,
        film_stop=samples.shape[0],
        confidence=1.0,
        rate_hz=rate_hz,
        rules=RULES,
    )


def delays_ms(shot: Shot) -> list[float]:
    return [echo.delay_ms for echo in shot.reflections]


@pytest.mark.parametrize("delay_ms", [8.5, 17.0, 43.0, 160.0, 480.0])
@pytest.mark.parametrize("level_db", [-3.0, -12.0])
@pytest.mark.parametrize("tail_db", [None, -12.0])
def test_an_echo_is_found_where_it_is_and_as_strong(delay_ms: float, level_db: float, tail_db: float | None) -> None:
    shot = segmented(film({delay_ms: level_db}, tail_db=tail_db))
    near = [echo for echo in shot.reflections if abs(echo.delay_ms - delay_ms) < 0.3]
    assert len(near) == 1
    # an echo within the 12 ms that are taken for the blast hides a part of itself
    assert near[0].level_db == pytest.approx(level_db, abs=1.5 if delay_ms > RULES.longest_blast_ms else 2.5)
    assert len(shot.reflections) == 1


def test_a_dull_echo_is_found_hardly_later() -> None:
    shot = segmented(film({60.0: -6.0}, corner_hz=1_500.0))
    assert delays_ms(shot) == pytest.approx([60.0], abs=0.5)


def test_echoes_near_each_other_are_two() -> None:
    shot = segmented(film({30.0: -6.0, 36.0: -8.0, 90.0: -10.0}, tail_db=-15.0))
    assert delays_ms(shot) == pytest.approx([30.0, 36.0, 90.0], abs=0.2)


@pytest.mark.parametrize("seed", range(12))
def test_a_blast_in_the_open_has_no_echo(seed: int) -> None:
    noise_db = (-60.0, -45.0, -32.0)[seed % 3]
    assert segmented(film({}, noise_db=noise_db, seed=seed)).reflections == ()


@pytest.mark.parametrize("seed", range(6))
def test_a_tail_of_overlapping_echoes_holds_no_discrete_one(seed: int) -> None:
    assert len(segmented(film({}, tail_db=-6.0, seed=seed)).reflections) <= 1


@pytest.mark.parametrize("gain", [0.1, 10.0, -1.0])
def test_a_gain_changes_nothing(gain: float) -> None:
    samples = film({20.0: -6.0, 75.0: -9.0}, tail_db=-12.0)
    one, other = segmented(samples), segmented(gain * samples)
    assert delays_ms(other) == delays_ms(one)
    assert other.blast == one.blast
    levels = [[echo.level_db for echo in shot.reflections] for shot in (one, other)]
    assert levels[1] == pytest.approx(levels[0], abs=1e-3)


@pytest.mark.parametrize("later", [1, 777, 30_001])
def test_a_delayed_film_delays_all(later: int) -> None:
    samples = film({20.0: -6.0, 75.0: -9.0}, tail_db=-12.0)
    one = segmented(samples)
    other = segmented(np.concatenate([np.zeros(later), samples]), onset=one.onset + later)
    assert delays_ms(other) == delays_ms(one)
    assert other.blast.stop == one.blast.stop + later


@pytest.mark.parametrize("rate_hz", [44_100, 96_000])
def test_the_sample_rate_moves_no_echo(rate_hz: int) -> None:
    shot = segmented(film({12.0: -6.0, 75.0: -9.0}, rate_hz=rate_hz), rate_hz=rate_hz)
    assert delays_ms(shot) == pytest.approx([12.0, 75.0], abs=0.15)


def test_what_was_there_before_the_shot_is_no_echo_of_it() -> None:
    """A motor's knocks, alike and as sharp as the blast itself, go on through the shot."""
    samples = film({})
    knock = 0.1 * blast(RATE_HZ)
    for at in range(0, samples.size - knock.size, round(0.0137 * RATE_HZ)):
        samples[at : at + knock.size] += knock
    assert segmented(samples).reflections == ()


def test_the_blast_is_over_where_it_has_fallen_where_it_drowns_and_where_an_echo_begins() -> None:
    free = segmented(film({}, noise_db=-70.0))
    drowned = segmented(film({}, noise_db=-14.0))
    cut = segmented(film({4.5: -3.0}, noise_db=-70.0))
    time_ms = np.arange(1_000) * 1000.0 / RATE_HZ
    fallen_ms = time_ms[np.flatnonzero(np.abs(blast(RATE_HZ))[:1_000] >= gain_from_db(-RULES.blast_decay_db))[-1]]
    assert len(free.blast) * 1000.0 / RATE_HZ == pytest.approx(fallen_ms, abs=1.0)
    assert len(drowned.blast) < len(free.blast)
    assert len(cut.blast) * 1000.0 / RATE_HZ <= 4.6


def test_what_is_louder_than_the_blast_is_no_echo_of_it() -> None:
    assert segmented(film({100.0: 9.0})).reflections == ()


def test_a_shot_that_ends_with_the_film_has_the_echoes_that_are_left() -> None:
    samples = film({20.0: -6.0, 300.0: -6.0})
    onset = round(ONSET_S * RATE_HZ)
    for left_ms, heard in ((1.0, 0), (60.0, 1), (450.0, 2)):
        shot = segmented(samples[: onset + round(left_ms * 48)])
        assert len(shot.reflections) == heard


@pytest.mark.parametrize("left", range(760, 780))
@pytest.mark.parametrize("quiet", [0, 7, 9_568, 9_600])
def test_a_shot_may_end_with_the_film_at_any_sample(left: int, quiet: int) -> None:
    """The earliest echo would begin 768 samples before the end: what is left then may be too short for any answer."""
    noise = 1e-4 * np.random.default_rng(0).standard_normal(quiet + left)
    noise[quiet:] += np.resize(blast(RATE_HZ), left)
    lags, gains = discrete_reflections(noise[quiet:], noise[:quiet], rate_hz=RATE_HZ, rules=RULES)
    assert lags.shape == gains.shape
    assert np.all(lags <= left)
    assert segmented(noise, onset=quiet).span.stop == noise.size


def held_up(samples: NDArray[np.float64], late_ms: float) -> NDArray[np.float64]:
    """Return a shot whose sound from 13 ms on comes so much later, over noise of -30 dB all the while."""
    noise = 0.5 * gain_from_db(-30.0) * np.random.default_rng([7, 1]).standard_normal(round(late_ms * 48))
    cut = round(ONSET_S * RATE_HZ) + 13 * 48
    return np.concatenate([samples[:cut], noise, samples[cut:]])


def test_a_late_echo_has_to_be_clearer_than_an_early_one() -> None:
    """The same echo in the same noise: early it is taken, late only where it is 2 dB stronger."""

    def taken(level_db: float, late_ms: float) -> bool:
        shot = segmented(held_up(film({25.0: level_db}, noise_db=-30.0, seed=1), late_ms))
        return any(abs(delay_ms - 25.0 - late_ms) < 0.3 for delay_ms in delays_ms(shot))

    assert taken(-23.3, late_ms=0.0)
    assert not taken(-23.3, late_ms=425.0)
    assert taken(-21.3, late_ms=425.0)


def test_clearness_weighs_chance_against_how_rare_so_late_an_echo_is() -> None:
    """Noise exceeds z with exp(-pi z^2 / 4), and echoes thin out as 1 / lag from 30 ms on."""
    lags_ms, z = np.array([5.0, 29.0, 60.0, 120.0, 480.0]), 4.5
    answer, places = np.ones(500 * 48), np.round(lags_ms * 48).astype(np.intp)
    answer[places] = z
    clear = BandAnswer(answer, np.ones(200 * 48), grain=48).clearness(places, lags_ms)
    chance = np.exp(-0.25 * np.pi * np.square(clear))
    np.testing.assert_allclose(chance / chance[0], np.maximum(lags_ms / 30.0, 1.0), rtol=1e-6)
    assert (clear >= RULES.reflection_prominence).tolist() == [True, True, True, True, False]


def test_rules_decide_from_what_level_on_an_echo_counts() -> None:
    strict = msgspec.structs.replace(RULES, reflection_level_db=-8.0)
    samples = film({30.0: -5.0, 90.0: -12.0}).astype(np.float32)
    shot = segment(
        samples,
        round(ONSET_S * RATE_HZ),
        film_start=0,
        film_stop=samples.size,
        confidence=1.0,
        rate_hz=RATE_HZ,
        rules=strict,
    )
    assert delays_ms(shot) == pytest.approx([30.0], abs=0.1)


@pytest.mark.parametrize("longest_ms", [200.0, 1200.0])
def test_an_echo_is_found_as_late_as_asked_for_however_short_windows_are(longest_ms: float) -> None:
    rules = msgspec.structs.replace(RULES, latest_reflection_ms=1_000.0, longest_ms=longest_ms)
    film = np.zeros(2 * RATE_HZ, np.float32)
    blast = np.exp(-np.arange(480) / 40.0) * np.random.default_rng(6).standard_normal(480)
    for at, gain in ((RATE_HZ // 2, 0.5), (RATE_HZ // 2 + 28_800, 0.2)):
        film[at : at + 480] += (gain * blast).astype(np.float32)
    film += np.random.default_rng(7).normal(0.0, 1e-4, film.size).astype(np.float32)
    shot = segment(film, RATE_HZ // 2, film_start=0, film_stop=film.size, confidence=1.0, rate_hz=RATE_HZ, rules=rules)
    assert shot.reflections[-1].delay_ms == pytest.approx(600.0, abs=0.5)


@pytest.mark.parametrize("lag_ms", [4.5, 6.0, 8.0, 10.0, 13.0, 60.0])
@pytest.mark.parametrize(("true_db", "within_db"), [(-6.0, 1.5), (-12.0, 1.0), (-20.0, 1.0)])
def test_a_reflection_has_its_level_at_any_lag(lag_ms: float, true_db: float, within_db: float) -> None:
    """Also where it lies in the template, and where the whitening takes part of it for the sound's own colour."""
    found_db = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        wave, before = 1e-4 * rng.standard_normal(33_600), 1e-4 * rng.standard_normal(9_600)
        t = np.arange(2_400) / RATE_HZ
        blast = (1.0 - t / 1e-3) * np.exp(-t / 1e-3) + 0.5 * rng.standard_normal(t.size) * np.exp(-t / 1.5e-3)
        late = round(lag_ms * RATE_HZ / 1000.0)
        wave[: t.size] += blast
        wave[late : late + t.size] += 10.0 ** (true_db / 20.0) * blast
        lags, gains = discrete_reflections(wave, before, rate_hz=RATE_HZ, rules=RULES)
        found_db += [20.0 * np.log10(gain) for lag, gain in zip(lags, gains, strict=True) if abs(lag - late) <= 5]
    assert len(found_db) == 8
    assert np.mean(found_db) == pytest.approx(true_db, abs=within_db)


def test_an_echo_is_found_to_the_sample_between_the_values_of_the_answer() -> None:
    rng = np.random.default_rng(3)
    shot = 0.5 * rng.standard_normal(RATE_HZ) * np.exp(-np.arange(RATE_HZ) / 100)
    before, noise = 1e-5 * rng.standard_normal(RATE_HZ // 5), 1e-5 * rng.standard_normal(RATE_HZ)
    errors = []
    for lag in range(2400, 2424):
        wave = shot + noise
        wave[lag:] += 0.4 * shot[:-lag]
        lags, _ = discrete_reflections(wave, before, rate_hz=RATE_HZ, rules=RULES)
        errors.append(np.min(np.abs(lags - lag)))
    assert max(errors) <= 1
    assert np.mean(errors) <= 0.5


@pytest.mark.parametrize("count", [1, 7, 48, 51])
def test_what_answers_before_a_shot_is_known_by_the_quantile_of_its_peaks(count: int) -> None:
    """One knock among many milliseconds hides no echo."""
    answer = np.random.default_rng(count).exponential(size=(count, 5)) ** 3
    assert _background(np.append([99.0], answer.ravel()), 5) == pytest.approx(np.quantile(answer.max(axis=1), 0.95))
