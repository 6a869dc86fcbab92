"""Ends that somebody has set, and windows of which a shot is gone."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import wavinfo

from blastline.export import read_timeline
from commands import RATE_HZ, blastline
from edited_films import FADE_IN, FRAMES, GUARD, Row, by_id, edited, edited_film, first_result, moving, rendered


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return edited_film(tmp_path_factory.mktemp("film"))


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory, film: Path) -> Path:
    return first_result(tmp_path_factory.mktemp("result"), film)


@pytest.mark.parametrize("stop_ms", [8, 16, 30, 41, 70])
def test_a_window_cut_shorter_than_a_fade_keeps_the_attack(
    tmp_path: Path, film: Path, result: Path, stop_ms: int
) -> None:
    """The fade-out takes half of what follows the onset, so the drive passes its checks, of which exit code 0 tells."""

    def edit(rows: list[Row]) -> None:
        for row in rows:
            stop = int(row["onset_sample"]) + stop_ms * RATE_HZ // 1000
            row["window_stop_sample"], row["window_stop_s"] = str(stop), ""

    ended, after, _ = rendered(film, edited(result, tmp_path, edit))
    assert re.search(r"checks: (\d+) of \1 passed", ended.err), ended
    for event in after.events:
        room = stop_ms * RATE_HZ // 1000
        assert event.window.stop - event.onset_sample == room
        assert event.window.fade_out_samples <= room // 2
        assert event.drive is not None
        assert event.drive.fidelity > 0.9


def test_a_window_that_is_rounded_to_just_past_the_end_ends_with_the_film(
    tmp_path: Path, film: Path, result: Path
) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    for event in plain["events"][2:]:
        event["window"]["stop_sample"] = FRAMES + RATE_HZ // 1000 - 1
    file = tmp_path / "edited.json"
    file.write_text(json.dumps(plain))
    _, after, drive = rendered(film, file)
    assert [event.window.stop for event in after.events[2:]] == [FRAMES, FRAMES]
    moving(drive, sorted({(event.window.start, event.window.stop) for event in after.events}))


def test_a_shot_that_is_deleted_leaves_the_window_that_it_shared(tmp_path: Path, film: Path, result: Path) -> None:
    before = by_id(read_timeline(result / "timeline.json"))
    assert before["shot-0003"].window == before["shot-0004"].window
    _, after, drive = rendered(film, edited(result, tmp_path, lambda rows: rows.pop(2)))
    assert by_id(after)["shot-0004"].window.start == 196_800 - GUARD - FADE_IN
    assert not np.any(drive[round(3.9 * RATE_HZ) : 196_800 - GUARD - FADE_IN])


def test_the_last_shot_of_a_window_is_gone_where_it_is_deleted(tmp_path: Path, film: Path, result: Path) -> None:
    """What is measured as the decay of the shot before holds the one that was deleted."""
    before = by_id(read_timeline(result / "timeline.json"))
    assert before["shot-0003"].window.stop > 196_800
    ended, after, drive = rendered(film, edited(result, tmp_path, lambda rows: rows.pop(3)))
    assert "3 kept, 1 deleted" in ended.err
    assert by_id(after)["shot-0003"].window.stop == 196_800
    assert np.any(drive[192_000:196_000])
    assert not np.any(drive[196_800:])
    assert by_id(after)["shot-0001"].window == before["shot-0001"].window


def test_a_shot_in_the_middle_of_a_window_is_gone_where_it_is_deleted(tmp_path: Path, film: Path) -> None:
    onsets = (192_000, 194_400, 196_800)
    (tmp_path / "three.csv").write_text("onset_sample\n" + "".join(f"{onset}\n" for onset in onsets))
    three = tmp_path / "three"
    asked = ("render", film, "-o", three, "--timeline", tmp_path / "three.csv", "--no-report")
    assert blastline(*asked).code == 0
    (tmp_path / "edit").mkdir()
    _, after, drive = rendered(film, edited(three, tmp_path / "edit", lambda rows: rows.pop(1)))
    assert [event.onset_sample for event in after.events] == [192_000, 196_800]
    assert not np.any(drive[194_400 : 196_800 - GUARD - FADE_IN])
    assert np.any(drive[192_000:194_000])
    assert np.any(drive[196_800:198_000])


def test_an_end_that_is_set_of_a_bursts_last_shot_is_the_windows(tmp_path: Path, film: Path, result: Path) -> None:
    def shorter(rows: list[Row]) -> None:
        rows[3]["window_stop_s"] = "4.2"
        rows[3]["window_stop_sample"] = ""

    ended, after, drive = rendered(film, edited(result, tmp_path, shorter))
    assert "3 kept, 1 changed" in ended.err
    found = by_id(after)
    assert found["shot-0003"].window == found["shot-0004"].window
    assert found["shot-0004"].window.stop == round(4.2 * RATE_HZ)
    assert not np.any(drive[round(4.2 * RATE_HZ) :])


def test_a_shot_that_is_dragged_with_its_end_ends_no_later_one(tmp_path: Path, film: Path, result: Path) -> None:
    """A label that is dragged takes its end along: over the next shot, which was left alone, that decides nothing."""
    labels = ("1.0\t1.0\tshot-0001", "2.5\t2.5\tshot-0002", "4.02\t4.15\tshot-0003", "4.1\t4.1\tshot-0004")
    (tmp_path / "labels.txt").write_text("".join(f"{label}\n" for label in labels))
    _, after, drive = rendered(film, tmp_path / "labels.txt", "--original", result / "timeline.json")
    assert by_id(after)["shot-0003"].onset_sample == round(4.02 * RATE_HZ)
    assert by_id(after)["shot-0004"].window.stop > round(4.2 * RATE_HZ)
    assert np.any(drive[round(4.16 * RATE_HZ) : round(4.2 * RATE_HZ)])


def test_what_is_deleted_within_a_shot_leaves_it_whole(tmp_path: Path, film: Path) -> None:
    """Two marks of one bang: without the second the first has its decay, not 20 ms."""
    (tmp_path / "two.csv").write_text("onset_sample\n192000\n192960\n")
    two = tmp_path / "two"
    assert blastline("render", film, "-o", two, "--timeline", tmp_path / "two.csv", "--no-report").code == 0
    (tmp_path / "edit").mkdir()
    _, after, _ = rendered(film, edited(two, tmp_path / "edit", lambda rows: rows.pop(1)))
    assert after.events[0].window.stop > 196_800


def test_a_marker_of_the_drive_lasts_to_the_end_that_was_set(tmp_path: Path, film: Path, result: Path) -> None:
    file = edited(result, tmp_path, lambda rows: rows[0].update(window_stop_s="1.7", window_stop_sample=""))
    _, after, _ = rendered(film, file)
    cues = wavinfo.WavInfoReader(str(tmp_path / "out" / "drive.wav")).cues
    assert cues is not None
    lengths = [cues.range(cue.name) for cue in cues.cues]
    last_two = [196_800 - 192_000, after.events[3].window.stop - 196_800]
    assert lengths == [33_600, after.events[1].window.stop - 120_000, *last_two]


def test_the_end_of_a_label_is_the_end_of_its_window(tmp_path: Path, film: Path, result: Path) -> None:
    lines = (result / "timeline.audacity.txt").read_text().splitlines(keepends=True)
    lines[0] = "1.000000\t1.150000\tshot-0001 1.00\n"
    lines.append("5.500000\t5.700000\tanother\n")
    file = tmp_path / "labels.txt"
    file.write_text("".join(lines))
    ended, after, drive = rendered(film, file, "--original", result / "timeline.json")
    assert "edits: labels.txt: 3 kept, 1 changed, 1 added" in ended.err
    found = by_id(after)
    assert (found["shot-0001"].window.stop, found["shot-0005"].window.stop) == (55_200, 273_600)
    assert not np.any(drive[55_200:110_000])
    assert np.any(drive[270_000:273_600])


@pytest.mark.parametrize(
    ("shot", "end", "at_s", "told"),
    [
        (3, "start", 4.09, "the start that was set of shot-0004: the shared window begins with its first shot"),
        (2, "stop", 4.105, "the end that was set of shot-0003: the shared window ends with a later shot"),
    ],
)
def test_an_end_amid_the_other_shots_of_a_window_is_told_and_changes_nothing(
    tmp_path: Path, film: Path, result: Path, shot: int, end: str, at_s: float, told: str
) -> None:
    def edit(rows: list[Row]) -> None:
        rows[shot][f"window_{end}_s"], rows[shot][f"window_{end}_sample"] = str(at_s), ""

    before = by_id(read_timeline(result / "timeline.json"))
    ended, after, _ = rendered(film, edited(result, tmp_path, edit))
    assert f"note: not used: {told}\n" in ended.err
    assert "edits: edited.csv: 4 kept\n" in ended.err
    assert {event.window for event in after.events[2:]} == {before["shot-0003"].window}


def _in_table(result: Path, end_s: str) -> str:
    lines = (result / "timeline.csv").read_text().splitlines(keepends=True)
    names, cells = lines[0].rstrip().split(","), lines[3].rstrip().split(",")
    cells[names.index("window_stop_s")], cells[names.index("window_stop_sample")] = end_s, ""
    return "".join([*lines[:3], f"{','.join(cells)}\n", *lines[4:]])


def _in_labels(result: Path, end_s: str) -> str:
    lines = (result / "timeline.audacity.txt").read_text().splitlines(keepends=True)
    start, _, text = lines[2].split("\t")
    return "".join([*lines[:2], f"{start}\t{end_s}\t{text}", *lines[3:]])


def _in_regions(result: Path, end_s: str) -> str:
    lines = (result / "timeline.reaper.csv").read_text().splitlines(keepends=True)
    kind, name, start, *_ = lines[3].split(",")
    return "".join([*lines[:3], f"{kind},{name},{start},0:00:0{end_s},\n", *lines[4:]])


def _in_document(result: Path, end_s: str) -> str:
    plain = json.loads((result / "timeline.json").read_text())
    plain["events"][2]["window"]["stop_sample"] = round(float(end_s) * RATE_HZ)
    return json.dumps(plain)


@pytest.mark.parametrize("with_original", [True, False])
@pytest.mark.parametrize(
    ("edit", "name"),
    [(_in_table, "x.csv"), (_in_labels, "x.txt"), (_in_regions, "x.csv"), (_in_document, "x.json")],
)
def test_an_end_before_a_bursts_next_shot_is_a_rest_in_every_format(
    tmp_path: Path, film: Path, result: Path, edit: Callable[[Path, str], str], name: str, *, with_original: bool
) -> None:
    """At the end that was set the drive is over until the next shot fades in; one behind that is told and not used."""
    whole = by_id(read_timeline(result / "timeline.json"))["shot-0003"].window
    original = ("--original", result) if with_original else ()
    file = tmp_path / name
    file.write_text(edit(result, "4.050"))
    ended, after, drive = rendered(film, file, *original)
    assert "not used" not in ended.err
    first, second = (by_id(after)[f"shot-000{number}"].window for number in (3, 4))
    assert (first.start, first.stop) == (whole.start, round(4.05 * RATE_HZ))
    assert (second.start, second.stop) == (196_800 - GUARD - FADE_IN, whole.stop)
    assert not np.any(drive[first.stop : second.start])
    file.write_text(edit(result, "4.105"))
    ended, after, _ = rendered(film, file, *original)
    assert "not used: the end that was set of shot-0003: the shared window ends with a later shot\n" in ended.err
    assert {(event.window.start, event.window.stop) for event in after.events[2:]} == {(whole.start, whole.stop)}


def _row_added(result: Path, onset_s: str, end_s: str) -> str:
    text = (result / "timeline.csv").read_text()
    names = text.splitlines()[0].split(",")
    cells = {"onset_s": onset_s, "window_stop_s": end_s}
    return text + ",".join(cells.get(name, "") for name in names) + "\n"


def _label_added(result: Path, onset_s: str, end_s: str) -> str:
    return (result / "timeline.audacity.txt").read_text() + f"{onset_s}\t{end_s}\tmissed\n"


def _region_added(result: Path, onset_s: str, end_s: str) -> str:
    return (result / "timeline.reaper.csv").read_text() + f"R9,missed,0:00:0{onset_s},0:00:0{end_s},\n"


def _event_added(result: Path, onset_s: str, end_s: str) -> str:
    plain = json.loads((result / "timeline.json").read_text())
    window = {"stop_sample": round(float(end_s) * RATE_HZ)}
    plain["events"].append({"onset_sample": round(float(onset_s) * RATE_HZ), "window": window})
    return json.dumps(plain)


@pytest.mark.parametrize("with_original", [True, False])
@pytest.mark.parametrize(
    ("edit", "name"),
    [(_row_added, "x.csv"), (_label_added, "x.txt"), (_region_added, "x.csv"), (_event_added, "x.json")],
)
@pytest.mark.parametrize(
    ("at_s", "end_s", "windows_s"),
    [
        pytest.param("4.040", "4.070", [(3.994, 4.07), (3.994, 4.07), (4.094, 4.365)], id="a rest before the next"),
        pytest.param("4.040", "4.120", [(3.994, 4.365)] * 3, id="amid a later shot"),
        pytest.param("4.150", "4.200", [(3.994, 4.2)] * 3, id="the last"),
        pytest.param("4.150", "4.500", [(3.994, 4.5)] * 3, id="beyond the window"),
        pytest.param("2.560", "2.600", [(2.494, 2.6)] * 2, id="the last after a single one"),
    ],
)
def test_a_shot_that_is_added_with_an_end_parts_or_ends_the_window_it_is_in(
    tmp_path: Path,
    film: Path,
    result: Path,
    edit: Callable[[Path, str, str], str],
    name: str,
    at_s: str,
    end_s: str,
    windows_s: list[tuple[float, float]],
    *,
    with_original: bool,
) -> None:
    file = tmp_path / name
    file.write_text(edit(result, at_s, end_s))
    ended, after, _ = rendered(film, file, *(("--original", result) if with_original else ()))
    near = [event for event in after.events if windows_s[0][0] <= event.onset_s < windows_s[-1][1]]
    assert [(event.window.start, event.window.stop) for event in near] == [
        (round(start_s * RATE_HZ), round(stop_s * RATE_HZ)) for start_s, stop_s in windows_s
    ]
    assert ("not used" in ended.err) == (end_s == "4.120")


@pytest.mark.parametrize(("shot", "end", "at_s"), [(3, "stop", 4.2), (2, "start", 3.9), (2, "start", 3.998)])
def test_an_outer_end_of_a_shared_window_needs_no_original(
    tmp_path: Path, film: Path, result: Path, shot: int, end: str, at_s: float
) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    plain["events"][shot]["window"][f"{end}_sample"] = round(at_s * RATE_HZ)
    (tmp_path / "alone.json").write_text(json.dumps(plain))
    ended, after, _ = rendered(film, tmp_path / "alone.json")
    assert "not used" not in ended.err
    assert [getattr(event.window, end) for event in after.events[2:]] == [round(at_s * RATE_HZ)] * 2


def test_ends_of_a_window_of_ones_own_are_used_and_nothing_is_told(tmp_path: Path, film: Path, result: Path) -> None:
    def edit(rows: list[Row]) -> None:
        rows[0].update(window_start_s="0.9", window_start_sample="", window_stop_s="1.2", window_stop_sample="")
        rows[2].update(window_start_s="3.9", window_start_sample="")

    ended, after, _ = rendered(film, edited(result, tmp_path, edit))
    assert "not used" not in ended.err
    windows = [event.window for event in after.events]
    assert (windows[0].start, windows[0].stop) == (round(0.9 * RATE_HZ), round(1.2 * RATE_HZ))
    assert windows[2].start == windows[3].start == round(3.9 * RATE_HZ)
