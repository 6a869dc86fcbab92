"""A shot's parts: where its decay ends and why, and how peaks are held."""

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from blastline.detect.bursts import drop_claimed_reflections
from blastline.detect.segment import peak_dbfs, running_peak, segment
from blastline.model import Shot, Span
from blastline.ruleset import SegmentRules, load_rules
from blastline.units import db_from_gain, gain_from_db

RATE_HZ = 48_000
ONSET = RATE_HZ // 2
RULES = load_rules("standard").tier.segment


def decaying(fall_db_per_s: float, *, seconds: float = 2.0, seed: int = 0) -> NDArray[np.float64]:
    """Return noise that begins at once and falls steadily."""
    time_s = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    noise = np.random.default_rng(seed).standard_normal(time_s.size)
    return np.asarray(0.1 * noise * 10.0 ** (-fall_db_per_s * time_s / 20.0), np.float64)


def measured(film: NDArray[np.float64], rules: SegmentRules = RULES) -> Shot:
    """Return the shot on the onset of a film."""
    return segment(
        film.astype(np.float32),
        ONSET,
        film_start=0,
        film_stop=film.size,
        confidence=1.0,
        rate_hz=RATE_HZ,
        rules=rules,
    )


def segmented(*sounds: tuple[float, NDArray[np.float64]], constant: float = 0.0) -> Shot:
    """Return the first of some sounds, given with their begin in ms after it, over faint noise beside zero."""
    film = constant + 1e-5 * np.random.default_rng(9).standard_normal(3 * RATE_HZ)
    for at_ms, sound in sounds:
        start = ONSET + round(at_ms * RATE_HZ / 1000.0)
        film[start : start + sound.size] += sound[: film.size - start]
    return measured(film)


def ended(shot: Shot) -> tuple[float, str]:
    """Return how long a shot's decay is, in ms, and what ended it."""
    assert shot.evidence is not None
    return len(shot.span) * 1000.0 / RATE_HZ, shot.evidence.decay_end


@pytest.mark.parametrize("width", range(1, 10))
def test_a_running_peak_is_the_largest_of_each_sample_and_those_after_it(width: int) -> None:
    values = np.random.default_rng(width).uniform(0.0, 1.0, 50)
    ahead = [values[at : at + width].max() for at in range(values.size)]
    np.testing.assert_array_equal(running_peak(values, width), ahead)


@pytest.mark.parametrize("next_ms", [600.0, 730.0, 900.0])
@pytest.mark.parametrize("gain", [0.01, 1.0, -1.0])
def test_the_decay_ends_and_says_so_where_another_sound_begins(next_ms: float, gain: float) -> None:
    one, other = gain * decaying(25.0), gain * decaying(25.0, seed=1)
    alone_ms, reason = ended(segmented((0.0, one)))
    assert alone_ms > next_ms + 100.0
    assert reason != "next sound"
    length_ms, reason = ended(segmented((0.0, one), (next_ms, other)))
    assert reason == "next sound"
    assert length_ms == pytest.approx(next_ms, abs=25.0)  # in whole grains of that length


def beside(kind: str) -> NDArray[np.float64]:
    """Return three seconds of what no seat plays: above the band of vibration or below it."""
    time_s, rng = np.arange(3 * RATE_HZ) / RATE_HZ, np.random.default_rng(4)
    if kind == "rain":
        hiss = butter(6, 4_000.0, "high", fs=RATE_HZ, output="sos")
        return np.asarray(0.2 * sosfilt(hiss, rng.normal(size=time_s.size)))
    return {
        "pilot tone": 0.1 * np.sin(2.0 * np.pi * 19_500.0 * time_s),
        "swell": 0.05 * np.sin(2.0 * np.pi * 1.0 * time_s),
    }[kind]


@pytest.mark.parametrize("kind", ["rain", "pilot tone", "swell"])
def test_what_cannot_be_felt_neither_shortens_nor_lengthens_what_is(kind: str) -> None:
    """A boom under rain is the boom that it is without: its window would be a stump."""
    time_s = np.arange(RATE_HZ) / RATE_HZ
    boom = 0.5 * np.sin(2.0 * np.pi * 70.0 * time_s) * np.exp(-time_s / 0.1) + 0.5 * decaying(1000.0, seconds=1.0)
    film = 1e-5 * np.random.default_rng(9).standard_normal(3 * RATE_HZ)
    film[ONSET : ONSET + boom.size] += boom
    alone_ms, _ = ended(measured(film))
    assert 250.0 < alone_ms < 450.0
    assert ended(measured(film + beside(kind)))[0] == pytest.approx(alone_ms, abs=50.0)


def test_what_begins_while_the_shot_is_still_loud_does_not_end_it() -> None:
    length_ms, _ = ended(segmented((0.0, decaying(25.0)), (250.0, decaying(25.0, seed=1))))
    assert length_ms > 1000.0


@pytest.mark.parametrize("constant", [-0.3, 0.05])
def test_a_constant_is_no_sound(constant: float) -> None:
    sounds = (0.0, decaying(60.0)), (90.0, 0.4 * decaying(60.0))
    still, beside = segmented(*sounds), segmented(*sounds, constant=constant)
    assert still.reflections
    assert (beside.blast, beside.span) == (still.blast, still.span)
    assert [each.start for each in beside.reflections] == [each.start for each in still.reflections]
    assert (beside.peak_dbfs, beside.snr_db) == pytest.approx((still.peak_dbfs, still.snr_db), abs=0.02)


@pytest.mark.parametrize("constant", [-0.3, 0.0, 0.05])
@pytest.mark.parametrize("level_dbfs", [-60.0, -46.0, -40.0, -26.0, -20.0])
@pytest.mark.parametrize("peak", [-0.9, 0.6])
def test_a_shot_stands_out_by_its_peak_over_the_root_mean_square_of_what_is_before_it(
    peak: float, level_dbfs: float, constant: float
) -> None:
    film = gain_from_db(level_dbfs) * np.random.default_rng(6).standard_normal(2 * ONSET)
    film[ONSET] = peak
    shot = measured(film + constant)
    assert shot.snr_db == pytest.approx(db_from_gain(abs(peak)) - level_dbfs, abs=0.5)
    assert shot.peak_dbfs == pytest.approx(db_from_gain(abs(peak)), abs=0.1)


@pytest.mark.parametrize("constant", [-0.25, 0.0, 0.125])
@pytest.mark.parametrize("polarity", [-1.0, 1.0])
def test_a_peak_is_as_high_below_zero_as_above_and_however_it_is_asked_for(polarity: float, constant: float) -> None:
    film = np.full(2 * ONSET, constant)
    film[ONSET : ONSET + 48] += 0.5 * polarity
    film[ONSET + 48 : ONSET + 200] -= 0.15 * polarity
    found = peak_dbfs(film.astype(np.float32), ONSET, RATE_HZ)
    assert found == measured(film).peak_dbfs == pytest.approx(db_from_gain(0.5), abs=1e-5)


def cracking(*, decay_ms: float = 2.0, seed: int = 0) -> NDArray[np.float64]:
    """Return a short blast: noise that dies away within some milliseconds."""
    return decaying(20.0 / np.log(10.0) * 1000.0 / decay_ms, seconds=0.1, seed=seed)


@pytest.mark.parametrize("delay_ms", [6.0, 8.0, 40.0, 120.0])
@pytest.mark.parametrize("gain", [0.35, 0.7])
def test_a_blast_ends_before_its_echo_which_is_no_louder_than_what_is_there(delay_ms: float, gain: float) -> None:
    shot = segmented((0.0, cracking(decay_ms=6.0)), (delay_ms, gain * cracking(decay_ms=6.0)))
    assert shot.evidence is not None
    assert shot.evidence.echo_room_db is not None
    assert any(abs(each.delay_ms - delay_ms) < 0.5 for each in shot.reflections)
    assert all(shot.blast.stop <= each.start for each in shot.reflections)
    assert all(each.level_db <= shot.evidence.echo_room_db for each in shot.reflections)


def test_a_louder_copy_is_another_shot_and_no_echo() -> None:
    copies = [segmented((0.0, cracking()), (90.0, gain * cracking())).reflections for gain in (0.5, 2.0)]
    assert [any(abs(each.delay_ms - 90.0) < 0.5 for each in found) for found in copies] == [True, False]


def test_a_blast_is_over_where_it_is_no_louder_than_what_was_there_before() -> None:
    noise = np.random.default_rng(5).standard_normal(3 * RATE_HZ)
    lengths = []
    for level in (0.0, 0.01, 0.05):
        lengths.append(len(segmented((0.0, cracking(decay_ms=8.0)), (-500.0, level * noise)).blast))
    assert lengths == sorted(lengths, reverse=True)
    assert lengths[-1] < 0.8 * lengths[0]


def test_a_tick_does_not_end_a_decay() -> None:
    sound = decaying(25.0)
    alone = ended(segmented((0.0, sound)))
    sound[705 * RATE_HZ // 1000 : 715 * RATE_HZ // 1000] *= 10.0
    assert ended(segmented((0.0, sound))) == alone


def settled(*shots: Shot) -> Shot:
    """Return the first of some shots with the reflections that are left to it."""
    return drop_claimed_reflections(shots, rate_hz=RATE_HZ, rules=load_rules("standard").tier.bursts)[0]


@pytest.mark.parametrize("gain", [0.01, 1.0, -1.0])
def test_a_shot_lasts_until_its_last_reflection_is_over_though_its_decay_ended_sooner(gain: float) -> None:
    echoes_ms, crack = (60.0, 170.0, 330.0), gain * cracking()
    shot = segmented((0.0, crack), *((at_ms, 0.4 * crack) for at_ms in echoes_ms))
    assert len(shot.span) < round(echoes_ms[1] * RATE_HZ / 1000.0)
    kept = settled(shot)
    np.testing.assert_allclose([each.delay_ms for each in kept.reflections[-3:]], echoes_ms, atol=0.1)
    assert kept.span.stop == kept.reflections[-1].stop
    assert ended(kept)[1] == "last reflection"


def test_what_a_later_shot_claims_does_not_make_the_first_one_last() -> None:
    first = segmented((0.0, cracking()), (330.0, 0.9 * cracking()))
    later = msgspec.structs.replace(first, onset=first.reflections[-1].start, reflections=())
    kept = settled(first, later)
    assert all(each.delay_ms < 80.0 for each in kept.reflections)
    assert kept.span == first.span
    assert ended(kept) == ended(first)


@pytest.mark.parametrize(("gain", "heard"), [(0.25, True), (0.14, False)])
def test_after_the_decay_only_what_is_as_strong_as_what_was_before_is_a_reflection(gain: float, heard: bool) -> None:
    hum = 0.01 * np.random.default_rng(3).standard_normal(2 * RATE_HZ)
    shot = segmented((-400.0, hum), (0.0, cracking()), (330.0, gain * cracking()))
    assert any(abs(each.delay_ms - 330.0) < 0.1 for each in shot.reflections)
    kept = settled(shot)
    assert any(abs(each.delay_ms - 330.0) < 0.1 for each in kept.reflections) == heard
    assert kept.span.stop == (kept.reflections[-1].stop if heard else shot.span.stop)


def test_an_earlier_shot_drowns_no_reflection() -> None:
    shot = segmented((-100.0, 2.0 * cracking(seed=5)), (0.0, cracking()), (330.0, 0.1 * cracking()))
    assert any(abs(each.delay_ms - 330.0) < 0.1 for each in settled(shot).reflections)


@pytest.mark.parametrize("longest_blast_ms", [5e-324, 0.01, 0.02])
def test_a_blast_lasts_for_a_sample_at_least_however_short_its_rule_is(longest_blast_ms: float) -> None:
    rules = msgspec.structs.replace(RULES, longest_blast_ms=longest_blast_ms)
    shot = measured(np.concatenate([np.zeros(ONSET), decaying(60.0)]), rules)
    assert len(shot.blast) == 1
    assert all(len(Span(each.start, each.stop)) == 1 for each in shot.reflections)
