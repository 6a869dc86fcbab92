"""Rounds of even fire that are softer than the one before: each is where an echo might be, but comes when it is due."""

from collections.abc import Sequence

import pytest

from blastline.detect.bursts import without_echoes
from blastline.model import EvenRow, Reflection, Shot, ShotEvidence, Span
from blastline.ruleset import load_rules

RATE_HZ = 48_000
RULES = load_rules("standard").tier.bursts
GAP_MS, ROUNDS = 90.0, 8
SOFTER_DB = RULES.echo_drop_db + 1.0
OFF_BEAT_MS = 2.0 * RULES.unevenness * GAP_MS


def sound(at_ms: float, peak_dbfs: float = -6.0, row: EvenRow | None = "fire") -> Shot:
    """Return a shot that answers to itself wherever another one may be."""
    at = round(at_ms * RATE_HZ / 1000.0)
    part = Span(at, at + 9)
    delays = [round(ms * RATE_HZ / 1000.0) for ms in range(20, 500)]
    heard = tuple(Reflection(at + d, at + d + 9, d * 1000.0 / RATE_HZ, -RULES.echo_drop_db) for d in delays)
    known = ShotEvidence(0.9, 1, None, "fallen", even_row=row)
    return Shot(at, 0.9, peak_dbfs=peak_dbfs, snr_db=30.0, blast=part, reflections=heard, span=part, evidence=known)


def burst(soft: Sequence[int] = (), row: EvenRow | None = "fire") -> list[Shot]:
    """Return even fire with some rounds softer."""
    return [sound(GAP_MS * n, -6.0 - SOFTER_DB * (n in soft), row) for n in range(ROUNDS)]


def kept(shots: Sequence[Shot]) -> list[int]:
    found, dropped = without_echoes(shots, rate_hz=RATE_HZ, rules=RULES)
    assert len(found) + len(dropped) == len(shots)
    return [each.onset for each in found]


@pytest.mark.parametrize(
    "soft", [(1,), (4,), (ROUNDS - 1,), (3, 4), (1, 2), (ROUNDS - 2, ROUNDS - 1), range(1, ROUNDS)]
)
def test_a_softer_round_that_comes_when_it_is_due_is_no_echo(soft: Sequence[int]) -> None:
    assert kept(burst(soft)) == [each.onset for each in burst()]


@pytest.mark.parametrize("rounds", [3, 4, ROUNDS])
def test_nor_where_the_burst_is_too_short_or_uneven_to_be_heard_as_a_row(rounds: int) -> None:
    for soft in range(1, rounds):
        shots = burst((soft,), row=None)[:rounds]
        assert kept(shots) == [each.onset for each in shots]


def test_what_is_soft_from_the_first_repetition_on_and_no_row_of_fire_is_a_flutter_echo() -> None:
    assert kept(burst(range(1, ROUNDS), row=None)[:6]) == [0]


@pytest.mark.parametrize("late_ms", [GAP_MS - OFF_BEAT_MS, GAP_MS + OFF_BEAT_MS, 1.5 * GAP_MS, 2.5 * GAP_MS])
def test_what_is_soft_and_late_or_early_after_the_last_round_is_an_echo(late_ms: float) -> None:
    last_ms = GAP_MS * (ROUNDS - 1)
    for row in ("fire", None):
        assert kept([*burst(), sound(last_ms + late_ms, -6.0 - SOFTER_DB, row)]) == [each.onset for each in burst()]


@pytest.mark.parametrize("delay_ms", [36.0, GAP_MS / 2.0, 54.0, GAP_MS + 20.0, 1.5 * GAP_MS, 2.5 * GAP_MS])
def test_the_echoes_of_even_fire_are_as_even_and_still_echoes(delay_ms: float) -> None:
    for row in ("fire", None):
        echoes = [sound(GAP_MS * n + delay_ms, -6.0 - SOFTER_DB, row) for n in range(ROUNDS)]
        assert kept([*burst(row=row), *echoes]) == [each.onset for each in burst()]
