"""What goes on as loud as it begins is a cut to another scene; what falls in some time may be a shot."""

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect import find_shots, verifier_of
from blastline.detect.rounds import before_a_round
from blastline.detect.steady import goes_on
from blastline.detect.tracks import Grid, pieces
from blastline.model import Clip
from blastline.ruleset import load_rules

RATE_HZ = 48_000
GRID = Grid(RATE_HZ)
ONSET = RATE_HZ
RULES = load_rules("standard")
LEAST_DB = RULES.tier.verify.least_fall_db
_ASKED = (
    "report_from",
    "round_threshold",
    "even_threshold",
    "even_networks_threshold",
    "company_threshold",
    "burst_threshold",
)
_FROM = ("look_from", "row_from", "gate_from")
CREDULOUS = msgspec.structs.replace(
    RULES.tier, verify=msgspec.structs.replace(RULES.tier.verify, **dict.fromkeys((*_ASKED, *_FROM), 0.0))
)
"""Standard's rules, but that anything is believed of what comes as fast as a gun fires."""

Samples = NDArray[np.float64]


def noise(seconds: float, *, seed: int, pink: bool = False) -> Samples:
    count = round(seconds * RATE_HZ)
    sound = np.random.default_rng(seed).standard_normal(count)
    if pink:
        spectrum = np.fft.rfft(sound) / np.sqrt(np.maximum(np.arange(count // 2 + 1), 1.0))
        sound = np.fft.irfft(spectrum, count)
    return np.asarray(sound / np.std(sound))


def cut(step_db: float, *, seed: int, pink: bool = False) -> Samples:
    """Return three seconds of noise that is louder from the first second on."""
    film = 0.1 * noise(3.0, seed=seed, pink=pink)
    film[:ONSET] *= 10.0 ** (-step_db / 20.0)
    return np.asarray(film, np.float64)


def shot(decay_s: float, *, seed: int, over_db: float = 30.0) -> Samples:
    """Return noise that dies away over three seconds of softer noise."""
    film = 0.1 * 10.0 ** (-over_db / 20.0) * noise(3.0, seed=seed)
    since_s = np.arange(2 * RATE_HZ) / RATE_HZ
    film[ONSET:] += 0.1 * noise(2.0, seed=seed + 1) * np.exp(-since_s / decay_s)
    return np.asarray(film, np.float64)


def is_steady(film: Samples, onset: int = ONSET) -> bool:
    blocks = [Clip(film[:, None].astype(np.float32), RATE_HZ, 0)]
    bands = np.concatenate([piece.bands.copy() for piece in pieces(blocks, RATE_HZ)])
    return bool(goes_on(bands, np.array([onset], np.intp), GRID, LEAST_DB)[0])


@pytest.mark.parametrize("step_db", [8.0, 12.0, 20.0, 40.0])
@pytest.mark.parametrize("pink", [False, True])
@pytest.mark.parametrize("gain", [1e-4, 1.0, 8.0])
def test_a_cut_to_louder_sound_goes_on_at_any_level(step_db: float, pink: bool, gain: float) -> None:
    assert all(is_steady(gain * cut(step_db, seed=seed, pink=pink)) for seed in range(6))


@pytest.mark.parametrize("decay_s", [0.01, 0.1, 0.4, 1.0])
@pytest.mark.parametrize("over_db", [8.0, 20.0, 40.0])
def test_what_dies_away_does_not_go_on(decay_s: float, over_db: float) -> None:
    assert not any(is_steady(shot(decay_s, seed=seed, over_db=over_db)) for seed in range(0, 12, 2))


def test_a_rest_between_rounds_is_a_fall() -> None:
    film = 0.001 * noise(3.0, seed=1)
    for number in range(18):
        at = ONSET + number * RATE_HZ // 10
        film[at : at + 2_400] += 0.1 * noise(0.05, seed=number)
    assert not is_steady(film)


def test_what_the_film_ends_before_does_not_go_on_and_what_it_begins_with_may() -> None:
    film = cut(20.0, seed=3)
    assert not is_steady(film[: ONSET + RATE_HZ // 2])
    assert is_steady(film[ONSET:], 0)


def test_before_the_film_and_after_it_is_silence() -> None:
    level = np.ones((600, 8), np.float32)  # 2 ms each
    assert goes_on(level, np.array([0, 100 * GRID.hop]), GRID, LEAST_DB).tolist() == [True, False]
    level[:50] = 0.0
    onsets = np.array([50 * GRID.hop])
    assert goes_on(level, onsets, GRID, LEAST_DB).tolist() == [True]
    assert goes_on(level[:540], onsets, GRID, LEAST_DB).tolist() == [False]


def test_a_bang_on_the_cut_is_kept() -> None:
    film = cut(20.0, seed=5)
    film[ONSET : ONSET + RATE_HZ // 20] *= 2.0
    assert not is_steady(film)


def test_rounds_of_even_fire_that_hardly_fall_are_followed() -> None:
    """A minigun in a hall: its rounds are judged as a row."""
    film = 0.001 * noise(4.0, seed=6)
    onsets = [ONSET + number * RATE_HZ // 12 for number in range(24)]
    film[ONSET : ONSET + 2 * RATE_HZ] += 0.05 * noise(2.0, seed=7)
    for at in onsets:
        film[at : at + 4_000] += 0.07 * noise(0.1, seed=at)[:4_000] * np.exp(-np.arange(4_000) / 900.0)
    blocks = [Clip(film.astype(np.float32)[:, None], RATE_HZ, 0)]
    found = find_shots(blocks, rate_hz=RATE_HZ, tier=CREDULOUS, verifier=verifier_of(CREDULOUS))
    assert is_steady(film)
    assert found.shots[0].onset == pytest.approx(ONSET, abs=480)
    assert len(found.shots) >= 20


@pytest.mark.parametrize("softer_db", [4.0, 5.0, 8.0])
@pytest.mark.parametrize("begun_s", [0.0, 64.496])  # a second, and 40 ms, before the first core ends
def test_the_first_round_may_be_softer_than_its_row(softer_db: float, begun_s: float) -> None:
    """A hall fills with the sound of a burst: only the rounds after the first are as loud as one another."""
    film = 0.001 * noise(4.0, seed=6)
    film[ONSET : ONSET + 2 * RATE_HZ] += 0.05 * noise(2.0, seed=7)
    for number in range(24):
        at = ONSET + number * RATE_HZ // 12
        gain = 0.1 * 10.0 ** (-softer_db / 20.0 if number == 0 else 0.0)
        film[at : at + 4_000] += gain * noise(0.1, seed=at)[:4_000] * np.exp(-np.arange(4_000) / 900.0)
    assert is_steady(film)
    film = np.append(0.001 * noise(70.0, seed=8)[: round(begun_s * RATE_HZ)], film)
    blocks = [Clip(film.astype(np.float32)[:, None], RATE_HZ, 0)]
    found = find_shots(blocks, rate_hz=RATE_HZ, tier=CREDULOUS, verifier=verifier_of(CREDULOUS))
    nearest = min(abs(shot.onset - ONSET - round(begun_s * RATE_HZ)) for shot in found.shots)
    assert nearest <= 480


def test_a_likely_round_follows_as_fast_as_a_gun_fires() -> None:
    gap = round(RULES.tier.bursts.longest_gap_ms * RATE_HZ / 1000.0)
    onsets = np.array([0, 1_000, gap, gap + 1, 2 * gap + 2_000])
    for likely, expected in (
        ([False, False, True, False, False], [True, True, False, False, False]),
        ([False, False, False, True, False], [False, True, False, False, False]),
        ([True, True, False, False, True], 5 * [False]),
    ):
        told = before_a_round(onsets, np.array(likely), rate_hz=RATE_HZ, rules=RULES.tier.bursts)
        assert told.tolist() == expected


def test_where_nothing_rises_nothing_goes_on() -> None:
    assert not is_steady(0.1 * noise(3.0, seed=4))
    assert not goes_on(np.zeros((0, 8), np.float32), np.array([5], np.intp), GRID, LEAST_DB).any()
    assert not is_steady(np.zeros(3 * RATE_HZ))


@pytest.mark.parametrize("rising", [1, 4, 12])
@pytest.mark.parametrize("beside", [0, 4, 40])
@pytest.mark.parametrize(("falls_by_db", "steady"), [(LEAST_DB - 1.0, True), (LEAST_DB + 1.0, False)])
def test_bands_in_which_nothing_rises_have_no_say(rising: int, beside: int, falls_by_db: float, steady: bool) -> None:
    """A tone rises by 30 dB beside a louder bed that stays as it is, and falls somewhat in half a second."""
    hops = 3 * RATE_HZ // GRID.hop
    since_s = (np.arange(hops) * GRID.hop - ONSET) / RATE_HZ
    level_db = np.full((hops, rising + beside), -20.0)
    level_db[:, :rising] = np.select([since_s < 0.0, since_s < 0.5], [-60.0, -30.0], -30.0 - falls_by_db)[:, None]
    bands = (10.0 ** (level_db / 10.0)).astype(np.float32)
    assert goes_on(bands, np.array([ONSET], np.intp), GRID, LEAST_DB).tolist() == [steady]


def test_scenes_that_begin_with_loud_rain_shake_no_seat_and_the_shots_in_them_do() -> None:
    film = np.concatenate([cut(20.0, seed=seed) for seed in range(4)])
    at = 2 * 3 * RATE_HZ + 2 * RATE_HZ  # a second after the third cut
    since_s = np.arange(RATE_HZ) / RATE_HZ
    blast = (1.0 - since_s / 1e-3) * np.exp(-since_s / 1e-3) + 0.5 * noise(1.0, seed=9) * np.exp(-since_s / 0.05)
    film[at : at + RATE_HZ] += 4.0 * blast
    blocks = [Clip((film / 8.0).astype(np.float32)[:, None], RATE_HZ, 0)]
    found = find_shots(blocks, rate_hz=RATE_HZ, tier=RULES.tier, verifier=verifier_of(RULES.tier))
    assert [shot.onset for shot in found.shots] == [pytest.approx(at, abs=48)]
    cuts = [each.at_sample for each in found.rejections if "another scene" in each.reason]
    assert cuts == [pytest.approx((3 * number + 1) * RATE_HZ, abs=240) for number in range(4)]
