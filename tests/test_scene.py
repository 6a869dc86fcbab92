"""What a scene requires: the cheapest model that is good enough, and decisions that follow from their evidence."""

import math
import re
from typing import get_args

import msgspec
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from blastline.detect.segment import segment
from blastline.model import (
    DecayEnd,
    DriveChoice,
    DriveModel,
    EvenRow,
    Reflection,
    SceneEvidence,
    Shot,
    ShotEvidence,
    Span,
)
from blastline.report.choice import reasons
from blastline.ruleset import SceneRules, load_rules
from blastline.scene import choose, decisions
from timelines import SHOT

RULES = SceneRules("test", 1, direct_level_db=1.0, direct_fidelity=0.9)


def evidence(level_db: float, fidelity: float, peak: float) -> SceneEvidence:
    return SceneEvidence(direct_level_db=level_db, direct_fidelity=fidelity, filter_peak=peak)


@pytest.mark.parametrize(
    ("found", "model"),
    [
        (evidence(0.0, 1.0, 9.0), "direct"),
        (evidence(-1.0, 0.9, 9.0), "direct"),
        (evidence(1.0, 0.9, 9.0), "direct"),
        (evidence(-1.1, 0.9, 1.0), "filter"),
        (evidence(1.1, 0.9, 1.0), "filter"),
        (evidence(0.0, 0.89, 1.0), "filter"),
        (evidence(-12.0, 0.7, 1.001), "constrained"),
        (evidence(0.0, -1.0, 9.0), "constrained"),
    ],
)
def test_cheapest_model_that_is_good_enough(found: SceneEvidence, model: str) -> None:
    assert choose(found, RULES, "auto")[0] == model


def test_reason_says_the_figures() -> None:
    _, reason = choose(evidence(-12.34, 0.712, 4.2), RULES, "auto")
    assert all(figure in reason for figure in ("-12.3 dB", "0.712", "4.2 of the limit"))


@given(st.floats(0.0, 2.0) | st.integers(1, 2**20).map(lambda steps: 1.0 + steps * 2.0**-52) | st.floats(1.0, 1e30))
@example(1.0 + 2.0**-52)
@example(1.0)
@example(math.inf)
def test_the_peak_that_a_reason_gives_is_too_much_where_it_says_so(peak: float) -> None:
    _, reason = choose(evidence(-12.0, 0.7, peak), RULES, "auto")
    said = re.search(r"peak is (\S+) of the limit", reason)
    assert said is not None
    assert (float(said[1]) > 1.0) == reason.endswith("which is too much") == (peak > 1.0)


@given(st.floats(-240, 240), st.floats(-1, 1), st.floats(0, 1e30), st.sampled_from(get_args(DriveChoice)))
def test_every_scene_has_a_model_and_a_reason(
    level_db: float, fidelity: float, peak: float, choice: DriveChoice
) -> None:
    model, reason = choose(evidence(level_db, fidelity, peak), RULES, choice)
    assert model in get_args(DriveModel)
    assert reason
    if choice != "auto":
        assert (model, reason) == (choice, "asked for")


def test_silence_needs_no_compensation() -> None:
    assert choose(evidence(0.0, 1.0, 0.0), load_rules("standard").scenes, "auto")[0] == "direct"


def test_a_stronger_scene_never_gets_a_lesser_model() -> None:
    order = ["direct", "filter", "constrained"]
    found = [choose(evidence(-5.0, 0.8, 0.1 * math.pow(1.3, step)), RULES, "auto")[0] for step in range(20)]
    assert [order.index(model) for model in found] == sorted(order.index(model) for model in found)


TIER = load_rules("standard").tier
RATE_HZ = 48_000
ECHOES = st.lists(
    st.builds(Reflection, st.just(2000), st.just(2100), st.floats(4.0, 500.0), st.floats(-20.0, 0.0)), max_size=3
)
HEARD = st.builds(
    ShotEvidence,
    st.none() | st.floats(0.0, 1.0),
    st.integers(1, 2),
    st.floats(-200.0, 40.0),
    st.sampled_from(get_args(DecayEnd)),
    even_row=st.none() | st.sampled_from(get_args(EvenRow)),
)


def shot_of(measured: ShotEvidence | None, echoes: list[Reflection]) -> Shot:
    return Shot(1000, 0.97, -3.0, 30.0, Span(1000, 1100), tuple(echoes), Span(1000, 25_000), evidence=measured)


@given(HEARD, ECHOES)
def test_every_decision_is_a_function_of_its_evidence(measured: ShotEvidence, echoes: list[Reflection]) -> None:
    shot = shot_of(measured, echoes)
    made = decisions(shot, TIER, rate_hz=RATE_HZ)
    elsewhere = msgspec.structs.replace(shot, onset=90, peak_dbfs=-30.0, burst=3, span=Span(90, 24_090))
    assert decisions(elsewhere, TIER, rate_hz=RATE_HZ) == made
    expected = [] if measured.screen is None else ["verifier"]
    assert [each.about for each in made] == [*expected, "reflections", "window"]
    assert all(each.choice and each.reason and each.evidence for each in made)


def test_a_round_that_is_believed_with_its_row_says_so() -> None:
    measured = ShotEvidence(0.02, 2, None, "fallen", even_row="fire")
    for row, told in (("fire", True), ("no fire", False), (None, False)):
        (verdict, *_) = decisions(shot_of(msgspec.structs.replace(measured, even_row=row), []), TIER, rate_hz=RATE_HZ)
        assert ("its even row" in verdict.reason) is told


def test_of_an_event_that_nobody_listened_to_nothing_is_said() -> None:
    assert decisions(shot_of(None, []), TIER, rate_hz=RATE_HZ) == ()


def test_more_doubt_never_asks_fewer_networks() -> None:
    said = [
        decisions(shot_of(ShotEvidence(0.5, n, 0.0, "fallen"), []), TIER, rate_hz=RATE_HZ)[0].choice for n in (1, 2, 3)
    ]
    assert said == ["one network", "2 networks", "3 networks"]


def heard_in(wave: np.ndarray) -> Shot:
    return segment(
        wave.astype(np.float32),
        9600,
        film_start=0,
        film_stop=len(wave),
        confidence=1.0,
        rate_hz=RATE_HZ,
        rules=TIER.segment,
    )


def bang(seed: int, *, decay_s: float, echo_db: float | None = None, noise: float = 1e-4) -> np.ndarray:
    """Return two and a half seconds with a noisy bang at 0.2 s, and a copy of its blast 60 ms later."""
    random = np.random.default_rng(seed)
    time_s = np.arange(2 * RATE_HZ) / RATE_HZ
    blast = (1.0 - time_s / 1e-3) * np.exp(-time_s / 1e-3)
    wave = noise * random.normal(size=int(2.5 * RATE_HZ))
    wave[9600 : 9600 + len(blast)] += 0.5 * blast + 0.02 * np.exp(-time_s / decay_s) * random.normal(size=len(blast))
    if echo_db is not None:
        wave[9600 + 2880 : 9600 + 2880 + 960] += 0.5 * 10.0 ** (echo_db / 20.0) * blast[:960]
    return wave


@pytest.mark.parametrize("echo_db", [-3.0, -10.0, -16.0, -30.0, None])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_no_reflection_is_louder_than_there_is_room_for(seed: int, echo_db: float | None) -> None:
    shot = heard_in(bang(seed, decay_s=0.002, echo_db=echo_db))
    least_db = TIER.segment.reflection_level_db
    assert shot.evidence is not None
    assert shot.evidence.echo_room_db is not None
    assert least_db is not None
    room_db = shot.evidence.echo_room_db
    assert all(echo.level_db <= room_db + 1e-6 for echo in shot.reflections)
    looked_for = decisions(shot, TIER, rate_hz=RATE_HZ)[0].choice
    if echo_db is not None and echo_db >= -16.0:
        assert looked_for == "segmented"
    else:
        assert shot.reflections == ()
        assert (looked_for == "none looked for") == (room_db < least_db)


@pytest.mark.parametrize(
    ("wave", "ended"),
    [
        (bang(1, decay_s=0.05), "fallen"),
        (bang(1, decay_s=0.05, noise=0.004), "background"),
        (bang(1, decay_s=30.0), "longest"),
        (bang(1, decay_s=0.04) + np.roll(bang(2, decay_s=0.04), int(0.11 * RATE_HZ)), "next sound"),
    ],
)
def test_the_decay_says_what_ended_it(wave: np.ndarray, ended: str) -> None:
    shot = heard_in(wave)
    assert shot.evidence is not None
    assert shot.evidence.decay_end == ended


def test_the_report_gives_every_reason() -> None:
    event = msgspec.structs.replace(
        SHOT, decisions=decisions(shot_of(ShotEvidence(0.9, 1, -30.0, "fallen"), []), TIER, rate_hz=RATE_HZ)
    )
    page = reasons(event)
    assert page.count("<p") == 4
    assert all(each.about.capitalize() in page for each in event.decisions)
    assert event.drive is not None
    assert event.drive.reason in page


def test_a_tier_without_a_level_looks_for_no_reflections() -> None:
    tier = msgspec.structs.replace(TIER, segment=msgspec.structs.replace(TIER.segment, reflection_level_db=None))
    wave = bang(1, decay_s=0.002, echo_db=-3.0).astype(np.float32)
    shot = segment(wave, 9600, film_start=0, film_stop=len(wave), confidence=1.0, rate_hz=RATE_HZ, rules=tier.segment)
    assert heard_in(wave).reflections
    assert shot.reflections == ()
    assert shot.evidence is not None
    assert shot.evidence.echo_room_db is None
    assert decisions(shot, tier, rate_hz=RATE_HZ)[0].choice == "none looked for"


@pytest.mark.parametrize(("copies", "told"), [(1, "what copies it is a later shot"), (3, "are later shots")])
def test_what_copies_a_shot_but_is_a_later_one_is_no_reflection_and_told_by_its_number(copies: int, told: str) -> None:
    measured = ShotEvidence(0.9, 1, 12.0, "last reflection", copies=copies)
    said = next(each for each in decisions(shot_of(measured, []), TIER, rate_hz=RATE_HZ) if each.about == "reflections")
    assert (said.choice, told in said.reason) == ("none", True)


@pytest.mark.parametrize(("looks", "room_db"), [(False, None), (True, -80.0)])
def test_a_reflection_that_was_found_as_a_sound_is_told_where_none_was_looked_for(
    looks: bool, room_db: float | None
) -> None:
    segment_rules = TIER.segment if looks else msgspec.structs.replace(TIER.segment, reflection_level_db=None)
    tier = msgspec.structs.replace(TIER, segment=segment_rules)
    echo = Reflection(20_000, 20_100, 400.0, -9.0)
    measured = ShotEvidence(0.9, 1, room_db, "last reflection", copies=1)
    told = next(
        each for each in decisions(shot_of(measured, [echo]), tier, rate_hz=RATE_HZ) if each.about == "reflections"
    )
    assert told.choice == "segmented"
    assert "found as a sound of its own" in told.reason
    assert (told.evidence["reflections"], told.evidence["level_db"], told.evidence["delay_ms"]) == (1.0, -9.0, 400.0)
