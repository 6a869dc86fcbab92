"""Which options a run has otherwise than a timeline was made with, told from what that says of itself."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import msgspec
import pytest

from blastline.model import ActuatorRef, Timeline
from blastline.progress import no_progress
from blastline.run.edit_settings import other_settings, settings_of
from blastline.run.options import RenderOptions, Setup, set_up
from timelines import timeline

USUAL = set_up(RenderOptions(), no_progress)
OTHERS = {
    "phase": (RenderOptions(phase="zero"), "--phase zero (there causal)"),
    "background": (RenderOptions(background="direct"), "--background direct (there mute)"),
    "level": (RenderOptions(level_db=-3.5), "--level -3.5 (there 0)"),
    "quality": (RenderOptions(quality="draft"), "--quality draft (there standard)"),
}


def made_by(setup: Setup, *, drive: bool = True) -> Timeline:
    """Return a timeline that was made with a run's options."""
    return msgspec.structs.replace(
        timeline(),
        quality=setup.rules.quality,
        rules_digest=setup.rules.digest,
        actuator=setup.actuator if drive else None,
        phase=setup.options.phase,
        background=setup.options.background,
        level_db=setup.rules.tier.render.level_db,
    )


def told(there: Mapping[str, Any] | Timeline, setup: Setup = USUAL) -> list[str]:
    return list(other_settings(settings_of(there) if isinstance(there, Timeline) else there, setup))


@pytest.mark.parametrize("name", OTHERS)
def test_one_option_that_differs_is_the_one_that_is_told(name: str) -> None:
    options, line = OTHERS[name]
    other = set_up(options, no_progress)
    assert told(made_by(USUAL), USUAL) == told(made_by(other), other) == []
    assert told(made_by(USUAL), other) == [line]
    option, now, _, was = line.split()
    assert told(made_by(other), USUAL) == [f"{option} {was[:-1]} (there {now})"]


def test_all_that_differ_are_told_in_one_order() -> None:
    other = set_up(RenderOptions(phase="zero", background="direct", level_db=2.0, quality="reference"), no_progress)
    assert [each.split()[0] for each in told(made_by(USUAL), other)] == [
        "--phase",
        "--background",
        "--level",
        "--quality",
    ]


def test_what_a_timeline_does_not_say_is_nothing_else() -> None:
    unusual = set_up(RenderOptions(phase="zero", background="direct", level_db=2.0, quality="draft"), no_progress)
    nothing: list[dict[str, Any]] = [{}, dict.fromkeys(settings_of(timeline())), {"actuator": {"name": "mine"}}]
    for there in nothing:
        assert told(there, unusual) == []


@pytest.mark.parametrize("name", ["phase", "background", "level"])
def test_without_a_drive_only_what_was_asked_of_an_earlier_one_tells(name: str) -> None:
    """A timeline that was found or conformed says the usual of a drive that it does not have."""
    options, _ = OTHERS[name]
    other = set_up(options, no_progress)
    assert told(made_by(USUAL, drive=False), other) == []
    assert len(told(made_by(other, drive=False), USUAL)) == 1
    assert told(made_by(other, drive=False), other) == []


def test_rules_are_told_by_their_digest_but_for_those_of_another_quality() -> None:
    there = msgspec.structs.replace(made_by(USUAL), rules_digest="ef" * 32)
    assert told(there) == ["--rules (there others)"]
    assert told(msgspec.structs.replace(there, quality="draft")) == ["--quality standard (there draft)"]


def test_a_seat_is_told_by_its_digest_and_by_its_name_where_that_tells() -> None:
    name, digest = USUAL.actuator.name, USUAL.actuator.digest
    for actuator, line in (
        (ActuatorRef(name, digest), None),
        (ActuatorRef("mine", digest), None),  # the same under another name
        (ActuatorRef("mine", "ef" * 32), f"--actuator {name} (there mine)"),
        (ActuatorRef(name, "ef" * 32), f"--actuator {name} (there another profile of that name)"),
    ):
        found = told(msgspec.structs.replace(made_by(USUAL), actuator=actuator))
        assert found == ([] if line is None else [line])


@pytest.mark.parametrize("junk", [["mine"], "mine", 7, True])
def test_what_is_no_seat_tells_of_none(junk: object) -> None:
    assert told({**settings_of(made_by(USUAL)), "actuator": junk}) == []


def test_what_a_file_says_stays_on_one_line() -> None:
    there = {**settings_of(made_by(USUAL)), "phase": "zero\nand more", "level_db": [1.5], "quality": "be\x07st"}
    lines = told(there)
    assert [each.split()[0] for each in lines] == ["--phase", "--level", "--quality"]
    assert all(each.isprintable() for each in lines)
    seat = {**settings_of(made_by(USUAL)), "actuator": {"name": "two\nlines", "digest": "ef" * 32}}
    [line] = told(seat)
    assert line.isprintable()


def test_the_level_of_the_rules_counts_where_none_is_asked_for() -> None:
    tier = USUAL.rules.tier
    louder = msgspec.structs.replace(tier, render=msgspec.structs.replace(tier.render, level_db=4.0))
    by_rules = replace(USUAL, rules=replace(USUAL.rules, tier=louder))
    assert told(made_by(USUAL), by_rules) == ["--level 4 (there 0)"]
    assert told(made_by(by_rules), by_rules) == []
