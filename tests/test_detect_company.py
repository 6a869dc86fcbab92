"""Which candidates are believed, alone and in company."""

from collections.abc import Sequence

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect import company
from blastline.detect.backdrop import LEVELS
from blastline.detect.company import in_company, worth_segmenting
from blastline.detect.fire import ScoredCandidates, even_rows
from blastline.detect.rounds import in_a_run
from blastline.detect.verify import Verdicts, log_odds_in
from blastline.model import EvenRow, Shot, ShotEvidence, Span
from blastline.ruleset import load_rules

RATE_HZ = 48_000
TIER = load_rules("standard").tier
VERIFY, BURSTS = TIER.verify, TIER.bursts
FAST_MS = (BURSTS.shortest_gap_ms + BURSTS.longest_gap_ms) / 2


def shot(at_ms: float, confidence: float, peak_dbfs: float = -6.0) -> Shot:
    onset = round(at_ms * RATE_HZ / 1000)
    span = Span(onset, onset + 480)
    return Shot(onset, confidence, peak_dbfs=peak_dbfs, snr_db=20.0, blast=span, reflections=(), span=span)


def in_row(one: Shot, row: EvenRow | None) -> Shot:
    """Return a shot of which is known whether it belongs to even fire."""
    return msgspec.structs.replace(one, evidence=ShotEvidence(0.5, 2, None, "background", even_row=row))


def believed_ms(*shots: Shot) -> list[float]:
    kept, refused = in_company(shots, rate_hz=RATE_HZ, tier=TIER)
    assert sorted([s.onset for s in kept] + [r.at_sample for r in refused]) == sorted(s.onset for s in shots)
    return [s.onset * 1000 / RATE_HZ for s in kept]


def scored(
    onsets: NDArray[np.intp], probability: NDArray[np.float64], by_screen: NDArray[np.float64] | None = None
) -> ScoredCandidates:
    """Return candidates of which screen and networks think alike, or the screen otherwise."""
    by_screen = probability if by_screen is None else by_screen
    return ScoredCandidates(
        onsets,
        np.zeros(onsets.size),
        log_odds_in(Verdicts(probability, by_screen, np.full(onsets.size, 2))),
        np.zeros((onsets.size, LEVELS), np.int16),
    )


def pair(confidence: float = VERIFY.company_threshold) -> tuple[Shot, Shot]:
    """Return two shots of a burst, the first one sure."""
    return shot(20_000, VERIFY.threshold), shot(20_000 + FAST_MS, confidence)


def test_an_unsure_shot_needs_the_company_of_a_sure_one() -> None:
    reach_ms = 1000.0 * VERIFY.company_s
    unsure = [shot(at_ms, VERIFY.company_threshold) for at_ms in (20_000 - reach_ms, 20_000 + reach_ms)]
    far = shot(20_001 + reach_ms, VERIFY.company_threshold)
    assert believed_ms(*unsure, far) == []
    assert believed_ms(far, shot(20_000, VERIFY.threshold), *unsure) == [
        20_000 - reach_ms,
        20_000,
        20_000 + reach_ms,
    ]


def test_of_an_unsure_shot_the_reason_tells_whether_company_would_have_helped() -> None:
    likely, unlikely = shot(0, VERIFY.company_threshold), shot(60_000, VERIFY.company_threshold - 0.01)
    kept, refused = in_company([likely, unlikely], rate_hz=RATE_HZ, tier=TIER)
    assert kept == ()
    assert [each.reason for each in refused] == ["alone, and not sure enough for that", "does not sound like a shot"]


def test_a_run_that_only_the_sides_hear_has_to_be_as_sure_as_their_company() -> None:
    own = TIER.channels.sides_company_threshold
    for probability, number in (((VERIFY.burst_threshold + own) / 2, 0), (own, 3)):
        run_ = [shot(20_000 + n * FAST_MS, probability) for n in range(3)]
        assert len(believed_ms(*(msgspec.structs.replace(each, heard_in="sides") for each in run_))) == number


@pytest.mark.parametrize("inside", [1, 2, 3])
def test_a_slow_row_that_the_end_of_a_core_cuts_is_segmented_on_both_sides(inside: int) -> None:
    onsets = np.array([20_000 + 600 * n for n in range(4)]) * (RATE_HZ // 1000)
    every = scored(onsets, np.full(4, (VERIFY.round_threshold + VERIFY.company_threshold) / 2))
    end = int(onsets[inside - 1]) + 300 * RATE_HZ // 1000
    for core in (Span(0, end), Span(end, 100 * RATE_HZ)):
        mine = (onsets >= core.start) & (onsets < core.stop)
        here = scored(onsets[mine], np.full(mine.sum(), (VERIFY.round_threshold + VERIFY.company_threshold) / 2))
        assert worth_segmenting(here, [None] * int(mine.sum()), rate_hz=RATE_HZ, tier=TIER, core=core).all()
    far = worth_segmenting(every, [None] * 4, rate_hz=RATE_HZ, tier=TIER, core=Span(0, 100 * RATE_HZ))
    assert not far.any(), "the others are rounds of no burst"


def test_two_shots_of_a_burst_take_its_rounds_along_before_and_after_them() -> None:
    reach = (BURSTS.most_unsure - 2) // 2
    numbers = [n for n in range(-reach, reach + 1) if n not in (0, 1)]
    rounds = [shot(20_000 + n * FAST_MS, VERIFY.round_threshold) for n in numbers]
    assert believed_ms(*rounds) == []
    assert believed_ms(*rounds, shot(20_000, VERIFY.threshold)) == [20_000]
    assert len(believed_ms(*rounds, *pair())) == len(rounds) + 2


def test_doublets_nearer_than_a_gun_fires_are_no_two_shots() -> None:
    doublet = shot(20_000 + BURSTS.shortest_gap_ms / 2, VERIFY.threshold)
    after = shot(20_000 + FAST_MS, VERIFY.round_threshold)
    assert len(believed_ms(shot(20_000, VERIFY.threshold), doublet, after)) == 2


def test_what_is_softer_is_no_round_but_perhaps_an_echo() -> None:
    at_ms = 20_000 + 2 * FAST_MS
    assert len(believed_ms(*pair(), shot(at_ms, VERIFY.round_threshold, -6.0 - BURSTS.echo_drop_db + 0.1))) == 3
    assert len(believed_ms(*pair(), shot(at_ms, VERIFY.round_threshold, -6.0 - BURSTS.echo_drop_db))) == 2
    assert len(believed_ms(*pair(), shot(at_ms, VERIFY.company_threshold, -40.0))) == 3


def test_a_gap_that_is_too_long_for_a_gun_ends_the_rounds() -> None:
    late_ms = 20_000 + 2 * FAST_MS + BURSTS.longest_gap_ms + 1
    after = [shot(at_ms, VERIFY.round_threshold) for at_ms in (20_000 + 2 * FAST_MS, late_ms)]
    assert believed_ms(*pair(), *after) == [20_000, 20_000 + FAST_MS, 20_000 + 2 * FAST_MS]


def test_what_reaches_less_than_a_round_is_never_believed() -> None:
    assert len(believed_ms(*pair(), shot(20_000 + 2 * FAST_MS, VERIFY.round_threshold - 0.01))) == 2


@pytest.mark.parametrize(
    ("gap_ms", "softer_db", "number"),
    [
        (BURSTS.shortest_gap_ms - 1.0, 0.0, 1),
        (BURSTS.shortest_gap_ms, 0.0, 2),
        (60.0, BURSTS.echo_drop_db - 0.1, 2),
        (60.0, BURSTS.echo_drop_db, 1),
        (VERIFY.pair_ms, -20.0, 2),
        (VERIFY.pair_ms + 1.0, 0.0, 1),
    ],
)
@pytest.mark.parametrize("sooner", [False, True])
def test_a_sure_shot_is_one_of_two_where_the_other_is_near_and_as_loud(
    gap_ms: float, softer_db: float, number: int, *, sooner: bool
) -> None:
    first = shot(20_000, VERIFY.threshold)
    other_ms = 20_000 - gap_ms if sooner else 20_000 + gap_ms
    other = shot(other_ms, VERIFY.pair_threshold, first.peak_dbfs - softer_db)
    assert len(believed_ms(first, other)) == number


def test_the_other_of_two_shots_is_near_one_that_is_sure_by_itself_and_brings_no_other() -> None:
    gap_ms = 0.7 * VERIFY.pair_ms
    first, *others = (shot(20_000 + n * gap_ms, VERIFY.pair_threshold) for n in range(4))
    sure_ = shot(20_000 + gap_ms, VERIFY.threshold)
    assert believed_ms(first, sure_, *others[1:]) == [20_000 + n * gap_ms for n in range(3)]
    company = shot(20_000 + gap_ms, VERIFY.company_threshold)
    assert believed_ms(shot(15_000, VERIFY.threshold), first, company, *others[1:]) == [15_000, 20_000 + gap_ms]


@pytest.mark.parametrize("first_inside", [False, True])
def test_two_shots_that_the_end_of_a_core_parts_are_both_segmented(*, first_inside: bool) -> None:
    gap = round(0.9 * VERIFY.pair_ms * RATE_HZ / 1000)
    other = scored(np.array([1_000_000]), np.array([VERIFY.pair_threshold + 0.01]))
    for edge, worth in ((1_000_000 + gap, True), (1_000_000 + 10 * RATE_HZ, False)):
        core = Span(0, edge) if first_inside else Span(2_000_000 - edge, 100 * RATE_HZ)
        told = worth_segmenting(other, [None], rate_hz=RATE_HZ, tier=TIER, core=core)
        assert told.tolist() == [worth]


@pytest.mark.parametrize("gap_ms", [BURSTS.shortest_gap_ms, FAST_MS, BURSTS.longest_gap_ms])
def test_likely_shots_as_fast_as_a_gun_fires_are_sure_together(gap_ms: float) -> None:
    run = [shot(20_000 + n * gap_ms, VERIFY.burst_threshold) for n in range(BURSTS.fewest_shots)]
    assert len(believed_ms(*run)) == BURSTS.fewest_shots
    assert believed_ms(*run[1:]) == []
    assert believed_ms(*run[1:], shot(20_000, VERIFY.burst_threshold - 0.01)) == []


def test_slower_than_any_gun_is_no_run() -> None:
    gap_ms = BURSTS.longest_gap_ms + 1
    assert believed_ms(*[shot(20_000 + n * gap_ms, VERIFY.burst_threshold) for n in range(20)]) == []


def test_doublets_nearer_than_a_gun_fires_count_once_in_a_run() -> None:
    near_ms = BURSTS.shortest_gap_ms / 2
    places_ms = [20_000 + n * FAST_MS + more for n in range(BURSTS.fewest_shots - 1) for more in (0.0, near_ms)]
    assert believed_ms(*[shot(at_ms, VERIFY.burst_threshold) for at_ms in places_ms]) == []


@pytest.mark.parametrize("likelier", [0, 1])
def test_of_doublets_in_a_run_the_likelier_ones_are_its_rounds(likelier: int) -> None:
    places_ms = [n * FAST_MS + late for n in range(5) for late in (0.0, BURSTS.shortest_gap_ms / 2)]
    onsets = np.array([round(at_ms * RATE_HZ / 1000) for at_ms in places_ms], np.intp)
    is_likelier = np.arange(onsets.size) % 2 == likelier
    found = in_a_run(onsets, np.where(is_likelier, 0.9, 0.8), np.full(onsets.size, 0.7), rate_hz=RATE_HZ, rules=BURSTS)
    assert found.tolist() == is_likelier.tolist()


def test_order_changes_nothing_and_a_delay_delays() -> None:
    rng = np.random.default_rng(5)
    places_ms = np.sort(rng.uniform(0, 60_000, 300))
    shots = [shot(at_ms, p) for at_ms, p in zip(places_ms.tolist(), rng.random(300).tolist(), strict=True)]
    kept = believed_ms(*shots)
    assert 50 < len(kept) < 300
    assert believed_ms(*(shots[n] for n in rng.permutation(300))) == kept
    later = believed_ms(*(shot(s.onset * 1000 / RATE_HZ + 250, s.confidence) for s in shots))
    np.testing.assert_allclose(np.array(later), np.array(kept) + 250, atol=1e-9)


def test_nothing_is_believed_of_nothing() -> None:
    assert believed_ms() == []


@pytest.mark.parametrize("seed", range(20))
def test_what_is_not_worth_segmenting_is_never_believed(seed: int) -> None:
    """Parting a film in cores, and leaving out there what is no round of a burst, changes nothing."""
    rng = np.random.default_rng(seed)
    rows_ms = [start + np.arange(6) * FAST_MS for start in rng.uniform(0, 60_000, 20)]
    places_ms = np.unique(np.round(np.concatenate([rng.uniform(0, 60_000, 200), *rows_ms])))
    told = np.array([None, None, None, "fire", "no fire"], object)
    probability, row = rng.random(places_ms.size) ** 3, rng.choice(told, places_ms.size)
    shots = [
        in_row(shot(*each), said)
        for *each, said in zip(places_ms.tolist(), probability.tolist(), row.tolist(), strict=True)
    ]
    onsets = np.array([s.onset for s in shots], np.intp)
    worth = np.zeros(onsets.size, bool)
    for start in range(0, 60 * RATE_HZ + 1, 20 * RATE_HZ):
        inside = np.flatnonzero((onsets >= start) & (onsets < start + 20 * RATE_HZ))
        core, rows = Span(start, start + 20 * RATE_HZ), row[inside].tolist()
        worth[inside] = worth_segmenting(
            scored(onsets[inside], probability[inside]), rows, rate_hz=RATE_HZ, tier=TIER, core=core
        )
    assert np.sum(~worth & (probability >= VERIFY.round_threshold)) > 0
    assert believed_ms(*shots) == believed_ms(*(s for s, kept in zip(shots, worth, strict=True) if kept))


def test_beyond_a_film_no_row_is_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where sounds lie close that takes longer than all else that a whole film tells of them."""
    onsets = np.arange(200) * RATE_HZ // 3
    unlikely, asked = scored(onsets, np.full(onsets.size, VERIFY.round_threshold)), list[int]()

    def none_at(onsets: NDArray[np.intp], *_: object, **__: object) -> list[NDArray[np.intp]]:
        asked.append(onsets.size)
        return []

    monkeypatch.setattr(company, "rows_at", none_at)
    for core, expected in ((None, []), (Span(0, 100 * RATE_HZ), [onsets.size])):
        worth_segmenting(unlikely, [None] * onsets.size, rate_hz=RATE_HZ, tier=TIER, core=core)
        assert asked == expected


@pytest.mark.parametrize("by_screen", [VERIFY.round_threshold, 0.999])
def test_a_round_at_the_edge_of_a_core_may_belong_to_a_burst_beyond_it(by_screen: float) -> None:
    """The networks alone may find it less likely: a round of a burst is what all together take for one."""
    core = Span(0, 20 * RATE_HZ)
    edges_ms = (0.0, BURSTS.longest_gap_ms, 10_000.0, 20_000.0 - BURSTS.longest_gap_ms, 19_999.0)
    onsets = np.array([round(at_ms * RATE_HZ / 1000) for at_ms in edges_ms], np.intp)
    probability = np.full(onsets.size, VERIFY.round_threshold)
    candidates = scored(onsets, probability, np.full(onsets.size, by_screen))
    worth = worth_segmenting(candidates, [None] * onsets.size, rate_hz=RATE_HZ, tier=TIER, core=core)
    assert worth.tolist() == [True, True, False, True, True]


def test_rounds_of_fire_are_believed_vouch_for_nothing_and_take_their_own_along() -> None:
    fire = [in_row(shot(20_000 + n * FAST_MS, VERIFY.round_threshold), "fire") for n in range(4)]
    last_ms = 20_000 + 3 * FAST_MS + BURSTS.longest_gap_ms
    assert len(believed_ms(*fire)) == 4
    assert len(believed_ms(*fire, shot(last_ms + 1, VERIFY.burst_threshold))) == 4
    assert len(believed_ms(*fire, shot(last_ms, VERIFY.round_threshold))) == 5


def test_of_a_row_that_is_no_fire_only_what_is_sure_by_itself_is_left() -> None:
    """Two sure ones would take the others along as rounds of a burst, and a burst is sure of what is likely."""
    sounds = [*pair(VERIFY.threshold), *(shot(20_000 + n * FAST_MS, VERIFY.burst_threshold) for n in range(2, 8))]
    assert len(believed_ms(*sounds)) == 8
    kept, refused = in_company([in_row(each, "no fire") for each in sounds], rate_hz=RATE_HZ, tier=TIER)
    assert [each.onset for each in kept] == [each.onset for each in sounds[:2]]
    assert {each.reason for each in refused} == {
        "one of a row as even as automatic fire that does not sound like a gun"
    }


@pytest.mark.parametrize("row", [None, "fire", "sustained fire"])
def test_an_even_run_beyond_a_magazine_is_a_machine_unless_half_of_it_is_sure_or_sustained_fire(
    row: EvenRow | None,
) -> None:
    likely, sure = VERIFY.burst_threshold, VERIFY.threshold
    most, half = BURSTS.most_unsure, (BURSTS.most_unsure + 2) // 2

    def run(*confidences: float) -> list[Shot]:
        return [in_row(shot(20_000 + n * FAST_MS, each), row) for n, each in enumerate(confidences)]

    assert len(believed_ms(*run(*[likely] * most))) == most
    kept, refused = in_company(run(*[likely] * most, sure), rate_hz=RATE_HZ, tier=TIER)
    why = {each.reason for each in refused}
    if row != "sustained fire":
        assert (kept, why) == ((), {"one of a row that goes on as no gun does, as of a machine"})
    else:
        assert (len(kept), why) == (most + 1, set())
    assert len(believed_ms(*run(*[likely, sure] * half))) == 2 * half


@pytest.mark.parametrize("every", [3, 5, 9])
def test_a_machine_that_pauses_now_and_then_is_a_machine(every: int) -> None:
    """Its usual gap is that of most, and not their mean, which none of them is near."""
    gaps_ms = np.where(np.arange(2 * BURSTS.most_unsure) % every, FAST_MS / 2, 0.95 * BURSTS.longest_gap_ms)
    places_ms = 20_000 + np.cumsum(gaps_ms)
    assert believed_ms(*[shot(at_ms, VERIFY.burst_threshold) for at_ms in places_ms.tolist()]) == []


def test_rows_that_are_fire_each_do_not_make_sustained_fire() -> None:
    """Two of them with a gap between that is no multiple of the pace: a machine that stumbles."""
    half = BURSTS.most_unsure // 2 + 2
    places = [20_000 + n * FAST_MS for n in range(half)]
    places += [places[-1] + BURSTS.longest_gap_ms - 1.0 + n * FAST_MS for n in range(half)]
    assert believed_ms(*[in_row(shot(at_ms, VERIFY.burst_threshold), "fire") for at_ms in places]) == []


@pytest.mark.parametrize(("row", "is_kept"), [("fire", False), ("sustained fire", True)])
def test_sustained_fire_is_no_loop(row: EvenRow, is_kept: bool) -> None:
    """A designer copies one sample: it comes again after the same time, each time after the same."""

    def known(at_ms: float) -> Shot:
        evidence = ShotEvidence(0.5, 2, None, "background", backdrop=5, sound=(20,) * LEVELS, even_row=row)
        return msgspec.structs.replace(shot(at_ms, VERIFY.burst_threshold), evidence=evidence)

    count = BURSTS.most_unsure
    assert (len(believed_ms(*[known(20_000 + n * 100.0) for n in range(count)])) == count) == is_kept


def test_several_guns_may_fire_for_long() -> None:
    rng = np.random.default_rng(3)
    places_ms = 20_000 + np.cumsum(rng.uniform(BURSTS.shortest_gap_ms + 1, BURSTS.longest_gap_ms - 1, 60))
    assert len(believed_ms(*[shot(at_ms, VERIFY.burst_threshold) for at_ms in places_ms.tolist()])) == 60


def test_a_long_slow_row_is_the_same_fire_wherever_a_core_cuts_it() -> None:
    """Its surest sounds may lie on one side alone, and the others far from there: they are rounds of it as well."""
    onsets = np.array([20_000 + 700 * n for n in range(12)]) * (RATE_HZ // 1000)
    probability = np.array([0.999] * 6 + [(VERIFY.round_threshold + VERIFY.company_threshold) / 2] * 6)
    for mirrored in (probability, probability[::-1]):
        every = scored(onsets, mirrored)
        assert even_rows(every, rate_hz=RATE_HZ, tier=TIER) == ["fire"] * 12
        for end in (onsets[1:] + onsets[:-1]) // 2:
            for core in (Span(0, int(end)), Span(int(end), 60 * RATE_HZ)):
                inside = (onsets >= core.start) & (onsets < core.stop)
                here = scored(onsets[inside], mirrored[inside])
                rows = even_rows(here, rate_hz=RATE_HZ, tier=TIER)
                assert worth_segmenting(here, rows, rate_hz=RATE_HZ, tier=TIER, core=core).all()


def test_fire_is_worth_segmenting_however_unlikely_each_of_its_rounds() -> None:
    onsets = np.array([s.onset for s in pair()], np.intp)
    core, probability = Span(0, 40 * RATE_HZ), np.zeros(2)
    assert worth_segmenting(
        scored(onsets, probability), ["fire", None], rate_hz=RATE_HZ, tier=TIER, core=core
    ).tolist() == [
        True,
        False,
    ]


def row(*confidences: float, gap_ms: float = 500.0, uneven: float = 0.0) -> list[Shot]:
    """Return sounds at one pace, every other gap longer by a share."""
    gaps_ms = [gap_ms * (1.0 + uneven * (n % 2)) for n in range(len(confidences))]
    return [shot(20_000 + sum(gaps_ms[:n]), each) for n, each in enumerate(confidences)]


SURE, UNSURE = VERIFY.threshold, VERIFY.company_threshold


@pytest.mark.parametrize("gap_ms", [TIER.rows.shortest_gap_ms, 500.0, TIER.rows.longest_gap_ms])
def test_a_sure_step_takes_no_even_row_of_steps_along(gap_ms: float) -> None:
    steps = row(UNSURE, SURE, UNSURE, UNSURE, UNSURE, gap_ms=gap_ms)
    kept, refused = in_company(steps, rate_hz=RATE_HZ, tier=TIER)
    assert kept == ()
    assert {each.reason for each in refused} == {"one of an even row, as of steps or blows"}
    assert len(refused) == 5


def test_who_fires_evenly_is_believed_where_most_shots_are_sure() -> None:
    assert len(believed_ms(*row(SURE, UNSURE, SURE, UNSURE))) == 4
    assert len(believed_ms(*row(*[SURE] * 20))) == 20


def test_only_an_even_row_of_some_length_and_pace_is_one() -> None:
    assert len(believed_ms(*row(UNSURE, SURE, UNSURE))) == 3
    assert len(believed_ms(*row(UNSURE, SURE, UNSURE, UNSURE, uneven=1.5 * TIER.rows.unevenness))) == 4
    assert len(believed_ms(*row(UNSURE, SURE, UNSURE, UNSURE, gap_ms=TIER.rows.longest_gap_ms + 1))) == 4
    assert len(believed_ms(*row(UNSURE, SURE, UNSURE, UNSURE, gap_ms=TIER.rows.shortest_gap_ms - 1))) == 4


def test_a_row_ends_where_its_pace_does() -> None:
    late = [shot(20_000 + 5 * 500 + 800 * n, confidence) for n, confidence in ((1, UNSURE), (2, SURE))]
    assert believed_ms(*row(UNSURE, SURE, UNSURE, UNSURE, UNSURE, UNSURE), *late) == [s.onset / 48 for s in late]


def test_a_refused_row_vouches_for_nobody() -> None:
    near = shot(23_000, UNSURE)
    assert len(believed_ms(shot(20_500, SURE), near)) == 2
    assert believed_ms(*row(UNSURE, SURE, UNSURE, UNSURE), near) == []
    assert believed_ms(*row(UNSURE, SURE, UNSURE, UNSURE), near, shot(24_100, SURE)) == [23_000, 24_100]


BED = 0x2_5A5A_1234_ABCD
"""What a loop has before a sound, and what may be there instead, as bits."""
ELSEWHERE = (
    0x1_C3A5_9E07_6B21,
    0x3_0F3C_72D8_1E94,
    0x0_E11B_A4C6_5D37,
    0x2_8C79_04F3_B61A,
    0x1_57E0_CB92_3F48,
    0x3_4A16_8F5D_E0A3,
)


SOUND = tuple(range(0, -LEVELS, -1))


def at(
    at_ms: float, confidence: float, backdrop: int | None, peak_dbfs: float = -6.0, sound: tuple[int, ...] = SOUND
) -> Shot:
    evidence = ShotEvidence(0.5, 2, None, "background", backdrop, sound)
    return msgspec.structs.replace(shot(at_ms, confidence, peak_dbfs), evidence=evidence)


def turning(*turns: int, confidence: float = UNSURE, first_ms: float = 20_777, every_ms: float = 2000.0) -> list[Shot]:
    """Return a sound that comes in some turns of a loop, the bed of which is covered by something else each time."""
    return [at(first_ms + n * every_ms, confidence, ELSEWHERE[n]) for n in turns]


def loop(count: int, every_ms: float = 2000.0, backdrops: Sequence[int | None] = (BED,) * 9) -> list[Shot]:
    """Return a sound that comes again after the same time."""
    return [at(20_000 + n * every_ms, UNSURE, backdrop) for n, backdrop in zip(range(count), backdrops, strict=False)]


SURE_SHOT = shot(20_111, SURE)  # in whose company the others would be believed
TURNS = TIER.rows.fewest_turns


@pytest.mark.parametrize("every_ms", [TIER.rows.longest_gap_ms, 2000.0, 1000.0 * TIER.rows.longest_loop_s])
def test_what_comes_again_and_again_with_the_same_before_it_is_a_loop(every_ms: float) -> None:
    kept, refused = in_company([SURE_SHOT, *loop(TURNS, every_ms)], rate_hz=RATE_HZ, tier=TIER)
    assert [each.onset for each in kept] == [SURE_SHOT.onset]
    assert {each.reason for each in refused} == {"one of a loop: it comes again with all that is around it, and again"}


def test_who_fires_like_clockwork_makes_no_loop() -> None:
    """Shots of a test scene may come every two seconds to the sample, as loud as each other; the wind does not."""
    for backdrops in (ELSEWHERE, (None,) * 6, (BED, BED, *ELSEWHERE)):
        assert len(believed_ms(SURE_SHOT, *loop(5, 2000.0, backdrops))) == 6
    later = [each if n else at(20_003.0, UNSURE, BED) for n, each in enumerate(loop(TURNS))]
    assert len(believed_ms(SURE_SHOT, *later)) == TURNS + 1


def test_a_backdrop_is_the_same_up_to_some_bits() -> None:
    few = [BED ^ (1 << TIER.rows.backdrop_bits * n) - 1 for n in range(3)]
    more = [BED ^ (1 << (TIER.rows.backdrop_bits + 1) * n) - 1 for n in range(3)]
    assert believed_ms(SURE_SHOT, *loop(3, 2000.0, few)) == [20_111]
    assert len(believed_ms(SURE_SHOT, *loop(3, 2000.0, more))) == 4


def test_several_guns_over_a_loop_are_none_of_it() -> None:
    """A bed may turn, and a tester fire a gun in each turn: what comes again is another sound each time."""
    step = 2 * round(TIER.rows.loop_sound_db) + 1
    guns = [at(20_777 + n * 2000.0, UNSURE, BED, sound=tuple(each - step * n for each in SOUND)) for n in range(5)]
    assert len(believed_ms(SURE_SHOT, *guns)) == 6
    assert believed_ms(SURE_SHOT, *loop(6), *guns) == [20_111, *(each.onset * 1000 / RATE_HZ for each in guns)]


def test_a_slow_row_that_is_fire_is_no_row_of_steps() -> None:
    gap_ms = TIER.rows.shortest_gap_ms + 1.0
    row = [shot(20_000 + n * gap_ms, UNSURE) for n in range(TIER.rows.fewest)]
    assert believed_ms(shot(15_000, SURE), *row) == [15_000]
    fire = [in_row(each, "fire") for each in row]
    assert len(believed_ms(*fire)) == len(fire)


def test_what_is_not_worth_segmenting_makes_no_loop() -> None:
    """Whether a faint candidate was segmented depends on where a film's cores lie; what is believed must not."""
    faint = [at(20_000 + n * 2000.0, VERIFY.company_threshold - 0.01, BED) for n in (1, 2)]
    turns = [at(20_000 + n * 2000.0, UNSURE, BED) for n in (0, 3)]
    assert believed_ms(*turns, SURE_SHOT, *faint) == believed_ms(*turns, SURE_SHOT) == [20_000, 20_111, 26_000]


def test_other_sounds_between_hide_no_loop() -> None:
    others = [shot(at_ms, SURE) for at_ms in (19_011.0, 22_203.0, 25_017.0, 30_911.0, 34_501.0, 39_007.0)]
    assert believed_ms(*loop(6), *others) == [each.onset * 1000 / RATE_HZ for each in others]


def test_a_loop_that_is_known_takes_along_what_else_turns_with_it() -> None:
    """Where other sounds cover the bed, or it is missed in a turn, a sound tells of no loop; another one does."""
    for others in (turning(0, 2, 3), turning(0, 1, confidence=SURE) + turning(3)):
        assert len(believed_ms(SURE_SHOT, *others)) == 1 + len(others)
        assert believed_ms(SURE_SHOT, *loop(6), *others) == [20_111]


def test_what_is_sure_in_each_turn_or_comes_too_seldom_too_late_or_louder_is_not_of_the_loop() -> None:
    late = turning(0, 2) + turning(3, first_ms=20_780)
    louder = [*turning(0, 2), at(20_777 + 6000.0, UNSURE, None, -6.0 + 2.0 * TIER.rows.loop_level_db)]
    for others in (turning(0, 2, 3, confidence=SURE), turning(0, 2), late, louder):
        assert len(believed_ms(SURE_SHOT, *loop(6), *others)) == 1 + len(others)
