"""How sure each mix has to be of a shot, and by which shots of a burst the others are judged."""

from collections.abc import Sequence

import msgspec
import pytest

from blastline.detect.company import in_company
from blastline.model import HeardIn, Shot, Span
from blastline.ruleset import load_rules

RATE_HZ = 48_000
TIER = load_rules("standard").tier
VERIFY, BURSTS, CHANNELS = TIER.verify, TIER.bursts, TIER.channels
FAST_MS = (BURSTS.shortest_gap_ms + BURSTS.longest_gap_ms) / 2
HAIR = 1e-6


def shot(at_ms: float, confidence: float, peak_dbfs: float = -6.0, heard_in: HeardIn = "mains") -> Shot:
    onset = round(at_ms * RATE_HZ / 1000)
    span = Span(onset, onset + 480)
    return Shot(onset, confidence, peak_dbfs, snr_db=20.0, blast=span, reflections=(), span=span, heard_in=heard_in)


def believed_ms(*shots: Shot) -> list[float]:
    kept, _ = in_company(shots, rate_hz=RATE_HZ, tier=TIER)
    return [each.onset * 1000 / RATE_HZ for each in kept]


def sure(*numbers: int) -> list[Shot]:
    """Return sure rounds of a burst, by their numbers in it."""
    return [shot(20_000 + n * FAST_MS, VERIFY.threshold) for n in numbers]


@pytest.mark.parametrize("heard_in", ["mains", "sides"])
@pytest.mark.parametrize("company", ["alone", "beside a sure shot", "in a burst", "after a sure shot"])
def test_a_candidate_is_believed_from_the_threshold_of_its_own_mix_on(heard_in: HeardIn, company: str) -> None:
    least, others = {
        "alone": ((VERIFY.threshold, CHANNELS.sides_threshold), []),
        "beside a sure shot": ((VERIFY.company_threshold, CHANNELS.sides_company_threshold), [shot(15_000, 0.99)]),
        "in a burst": ((VERIFY.round_threshold, CHANNELS.sides_company_threshold), sure(-2, -1)),
        "after a sure shot": ((VERIFY.pair_threshold, CHANNELS.sides_company_threshold), sure(-1)),
    }[company]
    own = least[heard_in == "sides"]
    assert len(set(least)) == 2
    for confidence, more in ((own - HAIR, 0), (own, 1)):
        found = believed_ms(*others, shot(20_000, confidence, heard_in=heard_in))
        assert len(found) == len(others) + more


@pytest.mark.parametrize("odd", [0, 1, 2])
@pytest.mark.parametrize("off_db", [-20.0, -6.0, 6.0, 20.0])
def test_one_round_that_is_louder_or_softer_costs_a_burst_none_of_the_others(odd: int, off_db: float) -> None:
    """It may be a second gun, or a ricochet."""
    rounds = [shot(20_000 + n * FAST_MS, VERIFY.round_threshold, -8.0) for n in (3, 4)]
    burst = sure(0, 1, 2)
    assert len(believed_ms(*burst, *rounds)) == 5
    burst[odd] = msgspec.structs.replace(burst[odd], peak_dbfs=burst[odd].peak_dbfs + off_db)
    assert len(believed_ms(*burst, *rounds)) == 5


def doublet(confidences: Sequence[float]) -> list[Shot]:
    """Return two candidates nearer to each other than a gun fires."""
    return [shot(20_000 + n * (BURSTS.shortest_gap_ms - 5.0), each) for n, each in enumerate(confidences)]


@pytest.mark.parametrize("likely", [(0.5, 0.6), (0.6, 0.5)])
@pytest.mark.parametrize(("gap_ms", "number"), [(BURSTS.longest_gap_ms, 4), (BURSTS.longest_gap_ms + 1.0, 0)])
def test_of_two_nearer_than_a_gun_fires_the_surer_is_the_round_of_a_run_whichever_comes_first(
    likely: tuple[float, float], gap_ms: float, number: int
) -> None:
    two = doublet(likely)
    surer_ms = max(two, key=lambda each: each.confidence).onset * 1000 / RATE_HZ
    around = [shot(at_ms, VERIFY.burst_threshold) for at_ms in (20_000 - FAST_MS, surer_ms + gap_ms)]
    assert min(likely) >= VERIFY.burst_threshold
    assert len(believed_ms(*two, *around)) == number


def test_a_run_has_no_gap_that_is_too_long_forwards_or_backwards() -> None:
    """The surer of two that are too near each other may be too far from the round before."""
    longest, likely = BURSTS.longest_gap_ms, VERIFY.burst_threshold
    at_ms = [0.0, longest - 10.0, longest + 20.0, 2.0 * longest + 20.0]
    for turned in (False, True):
        places = [20_000 + (at_ms[-1] - at if turned else at) for at in at_ms]
        shots = [shot(at, likely + 0.1 * (n == 2)) for n, at in enumerate(places)]
        assert believed_ms(*sorted(shots, key=lambda each: each.onset)) == []
