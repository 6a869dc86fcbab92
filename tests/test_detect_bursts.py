"""Shots near each other: which of them stay, and whose an echo is that two of them claim."""

import msgspec
import numpy as np
import pytest

from blastline.detect.bursts import drop_claimed_reflections, suppress_non_maxima, without_echoes
from blastline.model import Reflection, Rejection, Shot, Span
from blastline.ruleset import load_rules

RATE_HZ = 48_000
RULES = load_rules("standard").tier.bursts
GAP = round(RULES.shortest_gap_ms * RATE_HZ / 1000.0)


def sample(at_ms: float) -> int:
    return round(at_ms * RATE_HZ / 1000.0)


def shot(at_ms: float, *, confidence: float = 0.9, echoes_at_ms: tuple[float, ...] = ()) -> Shot:
    at = sample(at_ms)
    echoes = tuple(Reflection(sample(ms), sample(ms + 2.0), ms - at_ms, -12.0) for ms in echoes_at_ms)
    span = Span(at, max([at + 9, *(echo.stop for echo in echoes)]))
    return Shot(at, confidence, peak_dbfs=0.0, snr_db=20.0, blast=Span(at, at + 9), reflections=echoes, span=span)


def apart(*shots: Shot, sure: float = 1.0) -> tuple[list[int], list[Rejection]]:
    kept, dropped = suppress_non_maxima(shots, rate_hz=RATE_HZ, rules=RULES, sure={"mains": sure})
    return [each.onset for each in kept], list(dropped)


def test_only_a_shot_that_stays_costs_another_its_place() -> None:
    kept, dropped = apart(shot(0, confidence=0.90), shot(30, confidence=0.95), shot(60, confidence=0.97))
    assert kept == [sample(0), sample(60)]
    assert [each.at_sample for each in dropped] == [sample(30)]


def test_of_two_as_sure_the_earlier_stays() -> None:
    kept, dropped = apart(shot(20), shot(0))
    assert kept == [sample(0)]
    assert [each.at_sample for each in dropped] == [sample(20)]


@pytest.mark.parametrize("later_ms", [4.0, 12.0, 19.0])
def test_a_shot_begins_where_it_is_sure_and_not_with_its_loudest_stage(later_ms: float) -> None:
    begin, stage = shot(100, confidence=0.95), shot(100 + later_ms, confidence=0.97)
    assert apart(begin, stage, sure=0.84)[0] == [begin.onset]
    assert apart(begin, stage, sure=0.96)[0] == [stage.onset]
    assert apart(msgspec.structs.replace(begin, confidence=0.93), stage, sure=0.84)[0] == [stage.onset]
    another = shot(130, confidence=0.98)  # too late for a stage
    assert apart(begin, another, sure=0.84)[0] == [another.onset]
    assert apart(begin, stage, msgspec.structs.replace(another, confidence=0.9), sure=0.84)[0] == [begin.onset]


def test_shots_as_near_as_a_gun_fires_both_stay() -> None:
    first = shot(100)
    for gap, stay in ((GAP, 2), (GAP - 1, 1)):
        assert len(apart(first, msgspec.structs.replace(first, onset=first.onset + gap))[0]) == stay


@pytest.mark.parametrize("seed", range(8))
def test_what_stays_is_apart_and_what_goes_is_near_to_something_as_sure_that_stays(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shots = [shot(ms, confidence=round(rng.uniform(0.5, 1.0), 1)) for ms in rng.uniform(0.0, 2000.0, 60).tolist()]
    sure = {each.onset: each.confidence for each in shots}
    kept, dropped = apart(*shots)
    assert min(np.diff(kept)) >= GAP
    assert sorted([*kept, *(each.at_sample for each in dropped)]) == sorted(sure)
    assert [each.at_sample for each in dropped] == sorted(each.at_sample for each in dropped)
    for each in dropped:
        near = [onset for onset in kept if abs(onset - each.at_sample) < GAP]
        assert max(sure[onset] for onset in near) >= each.evidence["probability"] == sure[each.at_sample]
    assert apart(*rng.permutation(np.array(shots, object)).tolist()) == (kept, dropped)


@pytest.mark.parametrize(("beside_ms", "left"), [(0.0, []), (0.9, []), (-0.9, []), (1.5, [101.5]), (-1.5, [98.5])])
def test_an_echo_that_two_shots_claim_is_the_later_ones_alone(beside_ms: float, left: list[float]) -> None:
    """It sounds too late after the later shot to be a round of its own, so that alone does not part them."""
    later = shot(50, echoes_at_ms=(100,))
    assert RULES.shortest_gap_ms < 50.0
    first, second = drop_claimed_reflections(
        [shot(0, echoes_at_ms=(20, 100.0 + beside_ms)), later], rate_hz=RATE_HZ, rules=RULES
    )
    assert [echo.delay_ms for echo in first.reflections] == [20, *left]
    assert second == later


@pytest.mark.parametrize(
    ("beside", "is_echo"),
    [(d, abs(d) <= RATE_HZ // 1000) for d in (-49, -48, -47, -20, -1, 0, 1, 20, 47, 48, 49)],
)
def test_a_softer_sound_within_a_millisecond_of_an_echo_is_that_echo(beside: int, is_echo: bool) -> None:
    first = shot(0, echoes_at_ms=(300,))
    soft = msgspec.structs.replace(shot(0), onset=first.reflections[0].start + beside, peak_dbfs=-12.0)
    kept, echoes = without_echoes([first, soft], rate_hz=RATE_HZ, rules=RULES)
    assert kept == ((first,) if is_echo else (first, soft))
    assert [each.at_sample for each in echoes] == ([soft.onset] if is_echo else [])


@pytest.mark.parametrize("seed", range(12))
def test_each_echo_is_left_to_the_shots_as_when_all_are_compared_with_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    onsets_ms = np.sort(rng.integers(0, rng.choice([400, 4000]), 60)).tolist()
    shots = [shot(at, echoes_at_ms=tuple(at + rng.integers(-30, 300, rng.integers(0, 7)))) for at in onsets_ms]
    asked = [msgspec.structs.replace(each, reflections=_inside(each.reflections)) for each in shots]
    claimed: list[int] = []
    expected = []
    for each in reversed(asked):
        later = [other.onset for other in asked if other.onset > each.onset]
        own = [
            echo.start
            for echo in each.reflections
            if not any(onset - GAP // 2 < echo.start < onset + GAP for onset in later)
            and not any(abs(echo.start - other) <= sample(1.0) for other in claimed)
        ]
        claimed += own
        expected.append(own)
    left = drop_claimed_reflections(asked, rate_hz=RATE_HZ, rules=RULES)
    assert [[echo.start for echo in each.reflections] for each in left] == expected[::-1]


def test_each_echo_of_a_film_of_nothing_but_fire_is_one_shots() -> None:
    fired = [shot(100.0 * n, echoes_at_ms=tuple(100.0 * n + d for d in (55, 155, 255, 355))) for n in range(2000)]
    left = drop_claimed_reflections(fired, rate_hz=RATE_HZ, rules=RULES)
    assert all(len(each.reflections) == 1 for each in left[:-3])


def _inside(echoes: tuple[Reflection, ...]) -> tuple[Reflection, ...]:
    return tuple(echo for echo in echoes if echo.start >= 0)
