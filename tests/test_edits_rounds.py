"""Round after round of editing: what was taken out stays out, what was cut stays cut, through the command line."""

import csv
import json
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline.export import read_timeline
from blastline.model import Event
from commands import RATE_HZ, blastline, write_film

SHOTS_S = (1.0, 1.1, 1.2, 2.5)
"""Three shots in one window, which the decay of each alone would fill, and one by itself."""

Row = dict[str, str]
Edit = Callable[[list[Row]], object]


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_film(tmp_path_factory.mktemp("film") / "film.wav", length_s=4.0, shots_s=SHOTS_S)


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory, film: Path) -> Path:
    """Return a folder whose timeline has exactly the film's shots."""
    folder = tmp_path_factory.mktemp("result")
    (folder / "first.csv").write_text("onset_s\n" + "".join(f"{shot_s}\n" for shot_s in SHOTS_S))
    rendered(film, folder / "first.csv", folder / "out")
    events = read_timeline(folder / "out" / "timeline.json").events
    assert events[0].window == events[1].window == events[2].window
    assert events[0].window.stop > at(1.3)
    return folder / "out"


def at(time_s: float) -> int:
    return round(time_s * RATE_HZ)


def rendered(film: Path, file: Path, out: Path, *more: str | Path) -> str:
    ended = blastline("render", film, "-o", out, "--timeline", file, "--quality", "draft", "--no-report", *more)
    assert ended.code == 0, ended
    return ended.err


def edited(film: Path, before: Path, out: Path, edit: Edit) -> Path:
    """Edit the table of a result, render again, and return the new result."""
    with (before / "timeline.csv").open(newline="") as text:
        rows = list(csv.DictReader(text))
    columns = list(rows[0])
    edit(rows)
    with out.with_suffix(".csv").open("w", newline="") as text:
        table = csv.DictWriter(text, columns)
        table.writeheader()
        table.writerows(rows)
    rendered(film, out.with_suffix(".csv"), out, "--original", before / "timeline.json")
    return out


def drive_of(folder: Path) -> NDArray[np.int32]:
    return np.asarray(soundfile.read(folder / "drive.wav", dtype="int32")[0])


def events_of(folder: Path) -> Mapping[str, Event]:
    return {event.id: event for event in read_timeline(folder / "timeline.json").events}


def row_of(rows: list[Row], identity: str) -> Row:
    return next(row for row in rows if row["id"] == identity)


def moved(identity: str, onset_s: float) -> Edit:
    return lambda rows: row_of(rows, identity).update(onset_s=f"{onset_s:.9f}", onset_sample="")


def ends(identity: str, stop_s: float) -> Edit:
    return lambda rows: row_of(rows, identity).update(window_stop_s=f"{stop_s:.9f}", window_stop_sample="")


def deleted(identity: str) -> Edit:
    return lambda rows: rows.remove(row_of(rows, identity))


def added(onset_s: float) -> Edit:
    return lambda rows: rows.append({"onset_s": f"{onset_s:.9f}"})


def both(*edits: Edit) -> Edit:
    return lambda rows: [edit(rows) for edit in edits]


@pytest.mark.parametrize(
    "touch",
    [moved("shot-0001", 0.99), moved("shot-0001", 1.02), ends("shot-0001", 1.05), deleted("shot-0002"), added(1.05)],
    ids=["moved back", "moved on", "changed", "deleted", "added"],
)
def test_what_was_deleted_stays_deleted_in_the_next_round(tmp_path: Path, film: Path, first: Path, touch: Edit) -> None:
    """The last of the window is gone; whatever is done to the others, nothing plays in its place again."""
    one = edited(film, first, tmp_path / "one", deleted("shot-0003"))
    assert not np.any(drive_of(one)[at(1.2) : at(2.4)])
    two = edited(film, one, tmp_path / "two", touch)
    assert not np.any(drive_of(two)[at(1.2) : at(2.4)])
    assert events_of(two)["shot-0004"] == events_of(first)["shot-0004"]
    deletions = [r.at_sample for r in read_timeline(two / "timeline.json").rejections if r.reason == "deleted by hand"]
    assert at(1.2) in deletions


def test_what_was_deleted_stays_silent_though_its_neighbour_is_moved(tmp_path: Path, film: Path, first: Path) -> None:
    """Nothing else of its window is left to end what is measured anew as the decay of the shot that was moved."""
    one = edited(film, first, tmp_path / "one", both(deleted("shot-0002"), deleted("shot-0003")))
    two = edited(film, one, tmp_path / "two", moved("shot-0001", SHOTS_S[0] - 0.01))
    assert np.any(drive_of(two)[at(SHOTS_S[0]) : at(SHOTS_S[1])])
    assert not np.any(drive_of(two)[at(SHOTS_S[1]) : at(2.4)])


def test_an_end_that_was_set_holds_in_the_next_round(tmp_path: Path, film: Path, first: Path) -> None:
    one = edited(film, first, tmp_path / "one", ends("shot-0003", 1.25))
    assert not np.any(drive_of(one)[at(1.25) : at(2.4)])
    for name, touch in (
        ("moved", moved("shot-0001", 0.99)),
        ("deleted", deleted("shot-0001")),
        ("added", added(1.05)),
    ):
        two = edited(film, one, tmp_path / name, touch)
        assert events_of(two)["shot-0003"].window.stop == at(1.25), name
        assert not np.any(drive_of(two)[at(1.25) : at(2.4)]), name


def test_a_start_that_was_set_holds_in_the_next_round(tmp_path: Path, film: Path, first: Path) -> None:
    """But for a shot that is moved to the very place of the one that it was set for: its window is planned anew."""

    def earlier(rows: list[Row]) -> None:
        rows[0].update(window_start_s="0.9", window_start_sample="")

    one = edited(film, first, tmp_path / "one", earlier)
    assert events_of(one)["shot-0001"].window.start == at(0.9)
    two = edited(film, one, tmp_path / "two", deleted("shot-0003"))
    assert events_of(two)["shot-0001"].window.start == at(0.9)
    instead = edited(film, one, tmp_path / "instead", both(deleted("shot-0001"), moved("shot-0002", 1.0)))
    assert events_of(instead)["shot-0002"].onset_sample == at(1.0)
    assert events_of(instead)["shot-0002"].window.start == events_of(first)["shot-0001"].window.start


def test_the_place_that_a_shot_has_left_is_silent(tmp_path: Path, film: Path, first: Path) -> None:
    """The window of the shots before it ends there; the moved one plays where it was put."""
    one = edited(film, first, tmp_path / "one", moved("shot-0003", 3.2))
    drive = drive_of(one)
    assert not np.any(drive[at(1.2) : at(2.4)])
    assert np.any(drive[at(1.1) : at(1.19)])
    assert events_of(one)["shot-0003"].onset_sample == at(3.2)


def test_a_shot_that_is_nudged_has_left_no_place(tmp_path: Path, film: Path, first: Path) -> None:
    """By less than the rounds of a burst can follow each other it is the same bang."""
    one = edited(film, first, tmp_path / "one", moved("shot-0003", 1.21))
    assert np.all([np.any(drive_of(one)[at(t) : at(t + 0.01)]) for t in np.arange(1.0, 1.3, 0.01)])


@pytest.mark.parametrize("put", [added(1.05), moved("shot-0004", 1.05)], ids=["added", "moved in"])
def test_what_is_put_before_a_deletion_ends_there(tmp_path: Path, film: Path, first: Path, put: Edit) -> None:
    one = edited(film, first, tmp_path / "one", both(deleted("shot-0002"), deleted("shot-0003"), put))
    drive = drive_of(one)
    assert np.any(drive[at(1.05) : at(1.09)])
    assert not np.any(drive[at(1.1) : at(2.4)])


@pytest.mark.parametrize("by_s", [-0.02, 0.02, 0.045, 0.15])
def test_a_label_that_is_dragged_within_a_burst_ends_no_other_shot(
    tmp_path: Path, film: Path, first: Path, by_s: float
) -> None:
    """Every label of a burst ends with the window that they share; only the last one's end is that window's."""
    assert blastline("export", first / "timeline.json", "--format", "audacity", "-o", tmp_path).code == 0
    labels = [line.split("\t") for line in (tmp_path / "timeline.audacity.txt").read_text().splitlines()]
    labels[1][:2] = [f"{float(time_s) + by_s:.6f}" for time_s in labels[1][:2]]
    file = tmp_path / "labels.txt"
    file.write_text("".join("\t".join(label) + "\n" for label in labels))
    rendered(film, file, tmp_path / "out", "--original", first / "timeline.json")
    before, after = events_of(first), events_of(tmp_path / "out")
    assert after["shot-0002"].onset_sample == at(1.1 + by_s)
    assert after["shot-0003"].window.stop == before["shot-0003"].window.stop


def test_the_last_label_of_a_burst_takes_the_windows_end_along(tmp_path: Path, film: Path, first: Path) -> None:
    before = events_of(first)["shot-0003"]
    stop_s = before.window.stop / RATE_HZ - 0.05
    file = tmp_path / "labels.txt"
    file.write_text(f"1.0\t1.0\tshot-0001\n1.1\t1.1\tshot-0002\n1.15\t{stop_s:.9f}\tshot-0003\n2.5\t2.5\tshot-0004\n")
    rendered(film, file, tmp_path / "out", "--original", first / "timeline.json")
    assert events_of(tmp_path / "out")["shot-0003"].window.stop == before.window.stop - at(0.05)


def test_a_shot_that_is_put_back_plays_again(tmp_path: Path, film: Path, first: Path) -> None:
    one = edited(film, first, tmp_path / "one", deleted("shot-0003"))
    two = edited(film, one, tmp_path / "two", added(1.2))
    assert read_timeline(two / "timeline.json").rejections == ()
    assert np.any(drive_of(two)[at(1.2) : at(1.25)])


def test_a_shot_moved_earlier_has_the_decay_of_its_new_place(tmp_path: Path, film: Path, first: Path) -> None:
    """What sounds where it was before is what it sounds like now; only other shots' places are out of bounds."""
    one = edited(film, first, tmp_path / "one", moved("shot-0004", 2.44))
    assert np.any(drive_of(one)[at(2.5) : at(2.55)])


@pytest.mark.parametrize(("gone", "said"), [(1, True), (2, False), (3, False), (None, False)])
def test_a_json_without_its_original_says_that_deletions_cannot_be_told(
    tmp_path: Path, film: Path, first: Path, gone: int | None, said: bool
) -> None:
    """A gap in a burst's numbers tells of one all the same, but the last of a burst leaves none."""
    plain = json.loads((first / "timeline.json").read_text())
    assert [event["shot_in_burst"] for event in plain["events"]] == [1, 2, 3, None]
    plain["events"] = [event for index, event in enumerate(plain["events"]) if index != gone]
    (tmp_path / "alone.json").write_text(json.dumps(plain))
    told = rendered(film, tmp_path / "alone.json", tmp_path / "out")
    assert "what was deleted cannot be known, and is still felt" in told
    assert ("missing in its burst: shot 1.2; give the original" in told) == said


@pytest.mark.parametrize(("onset_s", "said"), [(1.1, False), (1.12, False), (0.9, True), (1.3, True), (3.1, True)])
def test_an_event_that_says_no_more_than_its_onset_may_be_a_missing_one_only_where_that_would_be(
    tmp_path: Path, film: Path, first: Path, onset_s: float, said: bool
) -> None:
    plain = json.loads((first / "timeline.json").read_text())
    plain["events"][1] = {"onset_s": onset_s}
    (tmp_path / "alone.json").write_text(json.dumps(plain))
    told = rendered(film, tmp_path / "alone.json", tmp_path / "out")
    assert ("missing in its burst: shot 1.2; give the original" in told) == said


@pytest.mark.parametrize(("last", "more"), [(13, ""), (14, " and more"), (1_000_000_000, " and more")])
def test_ten_shots_that_are_missing_in_a_burst_are_named_and_it_says_whether_there_are_more(
    tmp_path: Path, film: Path, first: Path, last: int, more: str
) -> None:
    plain = json.loads((first / "timeline.json").read_text())
    plain["events"][2]["shot_in_burst"] = last
    (tmp_path / "alone.json").write_text(json.dumps(plain))
    told = rendered(film, tmp_path / "alone.json", tmp_path / "out")
    named = ", ".join(f"1.{number}" for number in range(3, 13))
    assert f"missing in its burst: shot {named}{more}; give the original" in told
