import math
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from blastline.model import DriveChoice, DriveModel, SceneEvidence
from blastline.ruleset import SceneRules, load_rules
from blastline.scene import choose

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
