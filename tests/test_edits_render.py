"""From a designer's edits to a drive, through the command line: exactly what was asked for, and silence elsewhere."""

import csv
import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile
import wavinfo
from numpy.typing import NDArray

from blastline import run
from blastline.export import read_timeline
from blastline.model import Event, Timeline
from commands import RATE_HZ, Ended, blastline, write_film

SHOTS_S = (1.0, 2.5, 4.0, 4.1)
LENGTH_S = 7.0
FRAMES = round(LENGTH_S * RATE_HZ)
GUARD, FADE_IN = RATE_HZ // 1000, 5 * RATE_HZ // 1000

Row = dict[str, str]


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_film(tmp_path_factory.mktemp("film") / "film.wav", length_s=LENGTH_S, shots_s=SHOTS_S)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory, film: Path) -> Path:
    """Return a folder whose timeline has exactly the film's four shots, the last two in one window."""
    folder = tmp_path_factory.mktemp("result") / "out"
    rows = "".join(f"{round(shot_s * RATE_HZ)}\n" for shot_s in SHOTS_S)
    (folder.parent / "first.csv").write_text(f"onset_sample\n{rows}")
    ended = blastline("render", film, "-o", folder, "--timeline", folder.parent / "first.csv", "--no-report")
    assert ended.code == 0, ended
    assert blastline("export", folder / "timeline.json", "--format", "audacity", "-o", folder).code == 0
    return folder


def edited(result: Path, folder: Path, edit: Callable[[list[Row]], object]) -> Path:
    """Return a copy of the result's table, edited, with the original timeline beside it."""
    with (result / "timeline.csv").open(newline="") as text:
        rows = list(csv.DictReader(text))
    columns = list(rows[0])
    edit(rows)
    (folder / "timeline.json").write_bytes((result / "timeline.json").read_bytes())
    with (folder / "edited.csv").open("w", newline="") as text:
        table = csv.DictWriter(text, columns)
        table.writeheader()
        table.writerows(rows)
    return folder / "edited.csv"


def rendered(film: Path, file: Path, *more: str | Path) -> tuple[Ended, Timeline, NDArray[np.int32]]:
    """Render an edited timeline and return how that ended, the new timeline and the drive."""
    out = file.parent / "out"
    ended = blastline("render", film, "-o", out, "--timeline", file, "--no-report", "--overwrite", *more)
    assert ended.code == 0, ended
    return ended, read_timeline(out / "timeline.json"), soundfile.read(out / "drive.wav", dtype="int32")[0]


def by_id(timeline: Timeline) -> Mapping[str, Event]:
    """Return the events of a timeline by id."""
    return {event.id: event for event in timeline.events}


def felt_db(event: Event) -> float:
    """Return the level of what an event lets feel, against direct conversion."""
    assert event.drive is not None
    return event.drive.perceived_gain_db


def moving(drive: NDArray[np.int32], windows: list[tuple[int, int]]) -> None:
    """Assert that the drive is exactly 0 outside windows and moves in each."""
    outside = np.ones(drive.size, bool)
    for start, stop in windows:
        outside[start:stop] = False
        assert np.any(drive[start:stop])
    assert not np.any(drive[outside])


def test_moved_deleted_and_added_is_what_the_drive_does(tmp_path: Path, film: Path, result: Path) -> None:
    def edit(rows: list[Row]) -> None:
        rows[0]["onset_s"] = "1.1"
        del rows[1]
        rows.append({"onset_s": "5.5"})

    ended, after, drive = rendered(film, edited(result, tmp_path, edit))
    assert "edits: edited.csv: 2 kept, 1 moved, 1 added, 1 deleted" in ended.err
    before, found = by_id(read_timeline(result / "timeline.json")), by_id(after)
    assert list(found) == ["shot-0001", "shot-0003", "shot-0004", "shot-0005"]
    assert [(e.onset_sample, e.origin) for e in found.values()][::3] == [(52_800, "added"), (264_000, "added")]
    for name in ("shot-0003", "shot-0004"):
        assert found[name] == before[name]
    for name, onset in (("shot-0001", 52_800), ("shot-0005", 264_000)):
        assert found[name].window.start == onset - GUARD - FADE_IN
        assert found[name].blast.start == onset
    windows = sorted({(e.window.start, e.window.stop) for e in found.values()})
    moving(drive, windows)
    assert not np.any(drive[: 52_800 - GUARD - FADE_IN])
    assert not np.any(drive[round(2.4 * RATE_HZ) : round(3.9 * RATE_HZ)])
    deleted = [r for r in after.rejections if r.reason == "deleted by hand"]
    assert [r.at_sample for r in deleted] == [before["shot-0002"].onset_sample]


def test_a_shot_with_another_id_is_the_same_shot_and_drives_the_same(tmp_path: Path, film: Path, result: Path) -> None:
    names = ["door", "shot-0002", "last but one", "shot-0077"]

    def edit(rows: list[Row]) -> None:
        for row, name in zip(rows, names, strict=True):
            row["id"] = name

    ended, after, drive = rendered(film, edited(result, tmp_path, edit))
    assert "edits: edited.csv: 4 kept\n" in ended.err
    before = read_timeline(result / "timeline.json")
    assert after.events == tuple(
        msgspec.structs.replace(event, id=name) for event, name in zip(before.events, names, strict=True)
    )
    assert [r for r in after.rejections if r.reason == "deleted by hand"] == []
    assert np.array_equal(drive, soundfile.read(result / "drive.wav", dtype="int32")[0])


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


def test_a_found_shot_that_is_moved_says_so(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    for event in plain["events"]:
        event["origin"] = "found"
    plain["events"][0]["onset_sample"] = 52_800
    file = tmp_path / "edited.json"
    file.write_text(json.dumps(plain))
    ended, after, _ = rendered(film, file)
    assert "edits: edited.json: 3 kept, 1 moved" in ended.err
    assert [event.origin for event in after.events] == ["moved", "found", "found", "found"]


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


@pytest.mark.parametrize("name", ["timeline.json", "timeline.csv", "timeline.audacity.txt"])
def test_what_was_not_edited_is_rendered_to_the_bit(tmp_path: Path, film: Path, result: Path, name: str) -> None:
    file = tmp_path / name
    file.write_bytes((result / name).read_bytes())
    before = read_timeline(result / "timeline.json")
    given: list[list[str | Path]] = [["--original", result / "timeline.json"], []]
    for more in given:
        _, after, _ = rendered(film, file, *more)
        events = list(after.events)
        if name.endswith(".txt") and not more:  # alone, a label track has no more than two decimals of confidence
            events = (
                list(before.events) if [e.onset_sample for e in events] == [48_000, 120_000, 192_000, 196_800] else []
            )
        assert events == list(before.events)
        assert (tmp_path / "out" / "drive.wav").read_bytes() == (result / "drive.wav").read_bytes()


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


def test_a_result_is_rendered_again_by_its_folder_as_by_its_timeline(tmp_path: Path, film: Path, result: Path) -> None:
    made = []
    for given in (result, result / "timeline.json"):
        out = tmp_path / given.name
        ended = blastline("render", film, "-o", out, "--timeline", given, "--no-report")
        assert (ended.code, "edits: timeline.json: 4 kept" in ended.err) == (0, True)
        made.append((read_timeline(out / "timeline.json"), (out / "drive.wav").read_bytes()))
    assert made[0] == made[1]
    labels = tmp_path / "labels.txt"
    labels.write_bytes((result / "timeline.audacity.txt").read_bytes())
    assert "4 kept" in rendered(film, labels, "--original", result)[0].err


def test_a_folder_without_a_timeline_is_told_by_the_file_that_is_missing(tmp_path: Path, film: Path) -> None:
    (tmp_path / "empty").mkdir()
    ended = blastline("render", film, "-o", tmp_path / "out", "--timeline", tmp_path / "empty")
    assert ended.complaint.startswith(f"{tmp_path / 'empty' / 'timeline.json'}: no such file; expected ")


def test_a_json_without_its_original_says_what_it_cannot_tell(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    plain["events"][1]["gain_db"] = -12.0
    (tmp_path / "alone.json").write_text(json.dumps(plain))
    ended, after, _ = rendered(film, tmp_path / "alone.json")
    assert "if gains, ends or confidences were changed, they hold as they stand and count as kept" in ended.err
    assert after.events[1].gain_db == -12.0


def test_a_json_that_is_named_as_its_own_original_keeps_its_edits(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    plain["events"][0]["onset_sample"] = 52_800
    file = tmp_path / "timeline.json"
    file.write_text(json.dumps(plain))
    ended, after, _ = rendered(film, file, "--original", tmp_path / "." / "timeline.json")
    assert "3 kept, 1 moved" in ended.err
    assert after.events[0].onset_sample == 52_800
    (tmp_path / "linked.json").symlink_to(file)
    assert "3 kept, 1 moved" in rendered(film, file, "--original", tmp_path / "linked.json")[0].err


def test_an_end_that_cannot_be_is_told_as_it_stands(tmp_path: Path, film: Path, result: Path) -> None:
    (tmp_path / "edited.csv").write_text("onset_s,window_start_s\n2.5,2.6\n")
    ended = blastline("render", film, "-o", tmp_path / "out", "--timeline", tmp_path / "edited.csv")
    assert ended.complaint.endswith("window_start_s = 2.6: expected at most 2.5, the onset")


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


def test_reapers_milliseconds_leave_untouched_onsets_exact(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    first = plain["events"][0]
    first["onset_sample"] += 17
    first["onset_s"] = first["onset_sample"] / RATE_HZ
    first["blast"]["start_sample"] += 17
    first["peak_dbfs"] = -50.0  # as if other rules had measured it
    original = tmp_path / "timeline.json"
    original.write_text(json.dumps(plain))
    file = tmp_path / "regions.csv"
    rows = "".join(
        f"R{n},{e['id']} 1.00,{e['onset_s']:.3f},{e['window']['stop_sample'] / RATE_HZ:.3f},\n"
        for n, e in enumerate(plain["events"], start=1)
    )
    file.write_text(f"#,Name,Start,End,Length\n{rows}")
    ended, after, _ = rendered(film, file)
    assert "edits: regions.csv: 4 kept" in ended.err
    assert [e.onset_sample for e in after.events] == [48_017, 120_000, 192_000, 196_800]
    assert after.events[0].peak_dbfs == -50.0


@pytest.mark.parametrize("name", ["audacity", "reaper"])
def test_without_its_original_no_shot_is_said_to_be_kept_or_moved(
    tmp_path: Path, film: Path, result: Path, name: str
) -> None:
    """A label tells where its shot is, and not where it was: "4 kept" would be a guess, and wrong of the second."""
    assert blastline("export", result, "--format", name, "-o", tmp_path / "cues").code == 0
    (file,) = (tmp_path / "cues").iterdir()
    moved = file.read_text().replace("2.500000000", "2.600000000")
    assert moved != file.read_text()
    alone = tmp_path / file.name
    alone.write_text(moved)
    ended, after, _ = rendered(film, alone)
    assert f"edits: {file.name}: 4 as given\n" in ended.err
    assert after.edits is not None
    assert (after.edits.kept, after.edits.moved, after.edits.as_given) == (0, 0, 4)
    assert f"edits: {file.name}: 3 kept, 1 moved\n" in rendered(film, alone, "--original", result)[0].err


def test_a_row_that_tells_where_its_onset_was_is_kept_or_moved_without_an_original(
    tmp_path: Path, film: Path, result: Path
) -> None:
    file = edited(result, tmp_path, lambda rows: rows[1].update(onset_s="2.6", onset_sample="", origin="found"))
    (tmp_path / "timeline.json").unlink()
    rows = file.read_text().replace(",added,", ",found,")
    file.write_text(rows)
    assert "edits: edited.csv: 3 kept, 1 moved\n" in rendered(film, file)[0].err


def test_no_events_are_a_silent_drive_and_said(tmp_path: Path, film: Path, result: Path) -> None:
    ended, after, drive = rendered(film, edited(result, tmp_path, lambda rows: rows.clear()))
    assert after.events == ()
    assert drive.size == FRAMES
    assert not np.any(drive)
    assert "edits: edited.csv: 4 deleted" in ended.err
    assert "note: no events: the drive is silent" in ended.err
    (tmp_path / "labels.txt").write_bytes(b"")
    assert rendered(film, tmp_path / "labels.txt")[1].events == ()


def test_the_edited_result_passes_its_checks_again_and_shows_in_its_report(
    tmp_path: Path, film: Path, result: Path
) -> None:
    file = edited(result, tmp_path, lambda rows: rows[0].update(onset_s="1.1"))
    out = tmp_path / "out"
    assert blastline("render", film, "-o", out, "--timeline", file).code == 0
    page = (out / "report.html").read_text()
    assert "Edited by hand" in page
    assert "edited.csv: 3 kept, 1 moved" in page
    assert blastline("check", out, "--audio", film, "--quiet") == Ended(0, "", "")
    late = np.roll(soundfile.read(out / "drive.wav", dtype="int32")[0], 480)
    soundfile.write(tmp_path / "late.wav", late, RATE_HZ, subtype="PCM_24")
    assert blastline("check", out, "--audio", film, "--drive", tmp_path / "late.wav").code == 1


def test_an_edited_result_can_be_edited_again_in_its_place(tmp_path: Path, film: Path, result: Path) -> None:
    out = tmp_path / "out"
    file = edited(result, tmp_path, lambda rows: rows[0].update(onset_s="1.1"))
    first = rendered(film, file)[1]
    again = blastline("render", film, "-o", out, "--timeline", out / "timeline.csv", "--no-report", "--overwrite")
    assert again.code == 0
    assert "edits: timeline.csv: 4 kept" in again.err
    assert read_timeline(out / "timeline.json").events == first.events


def test_an_event_where_nothing_is_heard_is_rendered_and_not_held_against_the_drive(tmp_path: Path) -> None:
    film = tmp_path / "film.wav"
    samples = 1e-2 * np.random.default_rng(3).standard_normal(4 * RATE_HZ)
    samples[: 2 * RATE_HZ] = 0.0
    soundfile.write(film, samples, RATE_HZ, subtype="PCM_24")
    file = tmp_path / "edited.csv"
    file.write_text("onset_s\n0\n1.0\n2.5\n3.999\n")
    _, after, drive = rendered(film, file)
    assert [event.onset_sample for event in after.events] == [0, 48_000, 120_000, 191_952]
    assert not np.any(drive[: 2 * RATE_HZ])
    told = [check for check in after.checks if check.name in ("felt_lag", "drive_lag")]
    assert [(check.passed, check.limit) for check in told] == [(True, None)] * 4


def test_an_edit_in_a_column_that_is_not_read_is_told(tmp_path: Path, film: Path, result: Path) -> None:
    def edit(rows: list[Row]) -> None:
        rows[0]["timecode"], rows[1]["drive_model"] = "00:00:01.100", "filter"
        rows[2].update(timecode="00:00:04.005", onset_s="4.005")  # moved, and its timecode with it

    ended, after, _ = rendered(film, edited(result, tmp_path, edit))
    assert "edits: edited.csv: 3 kept, 1 moved" in ended.err
    notes = [
        "not used: the timecode of shot-0001, which was edited; onset_s or onset_sample moves a shot",
        "not used: the drive_model of shot-0002, which was edited; --drive chooses it, for all shots",
    ]
    assert [line for line in ended.err.splitlines() if "not used" in line] == [f"note: {note}" for note in notes]
    assert after.edits is not None
    assert list(after.edits.notes) == notes


def test_an_edit_in_a_key_that_is_not_read_is_told(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    plain["events"][0]["timecode"] = "00:00:01.100"
    plain["events"][1]["drive"]["model"] = "filter"
    (tmp_path / "edited.json").write_text(json.dumps(plain))
    ended, _, _ = rendered(film, tmp_path / "edited.json", "--original", result / "timeline.json")
    assert [line for line in ended.err.splitlines() if "not used" in line] == [
        "note: not used: the timecode of shot-0001, which was edited; onset_s or onset_sample moves a shot",
        "note: not used: the drive.model of shot-0002, which was edited; --drive chooses it, for all shots",
    ]


def test_columns_that_are_not_read_are_others_where_the_options_were(tmp_path: Path, film: Path, result: Path) -> None:
    def edit(rows: list[Row]) -> None:
        for row in rows:
            row["timecode"], row["drive_model"] = f"01:{row['timecode'][3:]}", "filter"

    assert "not used" not in rendered(film, edited(result, tmp_path, edit))[0].err


def test_a_gain_makes_the_drive_stronger_or_softer(tmp_path: Path, film: Path, result: Path) -> None:
    def edit(rows: list[Row]) -> None:
        rows[0]["gain_db"], rows[3]["gain_db"] = "-12", "-6"

    usual = rendered(film, edited(result, tmp_path, lambda rows: None), "--drive", "direct")[2]
    ended, after, drive = rendered(film, edited(result, tmp_path, edit), "--drive", "direct")
    assert "edits: edited.csv: 2 kept, 2 changed" in ended.err
    assert [event.gain_db for event in after.events] == [-12.0, 0.0, 0.0, -6.0]
    steps = 1 << 8  # of 24 bits, in 32
    for event, stop in zip(after.events, (None, None, 196_752, None), strict=True):
        where = slice(event.onset_sample, stop or event.window.stop)
        expected = 10.0 ** (event.gain_db / 20.0) * usual[where]
        assert np.max(np.abs(drive[where] - expected)) <= 1.5 * steps


@pytest.mark.parametrize("drive", ["auto", "constrained"])
def test_shots_of_one_window_with_gains_of_their_own_pass_their_checks(
    tmp_path: Path, film: Path, result: Path, drive: str
) -> None:
    def edit(rows: list[Row]) -> None:
        rows[2]["gain_db"], rows[3]["gain_db"] = "3", "-9"

    before = by_id(rendered(film, edited(result, tmp_path, lambda rows: None), "--drive", drive)[1])
    _, after, _ = rendered(film, edited(result, tmp_path, edit), "--drive", drive)
    assert all(check.passed for check in after.checks)
    gained = {event.id: felt_db(event) - felt_db(before[event.id]) for event in after.events}
    assert gained["shot-0001"] == gained["shot-0002"] == 0.0
    assert 1.5 < gained["shot-0003"] <= 3.1
    assert gained["shot-0004"] == pytest.approx(-9.0, abs=1.0)


def test_detection_is_not_asked(tmp_path: Path, film: Path, result: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("detection was asked")

    for name in ("find_shots", "load_verifier"):
        monkeypatch.setattr(run.listening, name, never)
    rendered(film, edited(result, tmp_path, lambda rows: None))


@pytest.mark.parametrize(
    ("edit", "complaint"),
    [
        (lambda r: r[1].update(onset_s="7.5"), "line 3: onset at sample 360000, 7.5 s: expected a time in the film"),
        (
            lambda r: r[1].update(onset_sample="336000"),
            "line 3: onset at sample 336000, 7 s: expected a time in the film",
        ),
        (lambda r: r[1].update(window_stop_s="7.1"), "line 3: window ends at sample 340800, 7.1 s: expected a time in"),
        (lambda r: r[1].update(id="shot-0001"), "line 3: id = 'shot-0001': line 2 has it too; expected each once"),
        (lambda r: r[1].update(onset_s="-1"), "line 3: onset_s = '-1': expected a time from 0"),
        (lambda r: r[1].update(onset_s="3", onset_sample="5"), "line 3: onset_sample = 5 and onset_s = 3 contradict"),
    ],
)
def test_edits_that_cannot_be_rendered_are_one_line_and_nothing_is_written(
    tmp_path: Path, film: Path, result: Path, edit: Callable[[list[Row]], object], complaint: str
) -> None:
    file = edited(result, tmp_path, edit)
    out = tmp_path / "out"
    line = blastline("render", film, "-o", out, "--timeline", file, "--quiet").complaint
    assert line.startswith(f"{file}: {complaint}")
    assert not out.exists()


def test_another_film_is_refused_by_both_names(tmp_path: Path, film: Path, result: Path) -> None:
    file = edited(result, tmp_path, lambda rows: None)
    other = write_film(tmp_path / "recut.wav", length_s=6.0, shots_s=SHOTS_S)
    line = blastline("render", other, "-o", tmp_path / "out", "--timeline", file, "--quiet").complaint
    assert line.startswith(f"{tmp_path / 'timeline.json'}: is of film.wav (sha256 ")
    assert f"{FRAMES} frames at 48000 Hz), but the film is recut.wav (sha256 " in line
    assert "blastline conform" in line
    soundfile.write(tmp_path / "slow.wav", np.zeros(44_100), 44_100)
    line = blastline("render", tmp_path / "slow.wav", "-o", tmp_path / "out", "--timeline", file, "--quiet").complaint
    assert "is of film.wav" in line
    assert "44100 Hz" in line
    assert not (tmp_path / "out").exists()


def test_another_sound_stream_is_refused(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    plain["source"]["stream"] = 1
    file = tmp_path / "edited.json"
    file.write_text(json.dumps(plain))
    line = blastline("render", film, "-o", tmp_path / "out", "--timeline", file, "--quiet").complaint
    assert line == f"{file}: is of sound stream 1 of film.wav, not 0; give --stream 1"


def test_an_original_without_an_edited_timeline_is_refused(tmp_path: Path, film: Path, result: Path) -> None:
    line = blastline("render", film, "-o", tmp_path / "out", "--original", result / "timeline.json").complaint
    assert line.endswith("there is no edited timeline; give one with --timeline")


def test_an_original_of_another_film_is_refused(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    plain["source"]["sha256"] = "ab" * 32
    file = tmp_path / "edited.json"
    file.write_text(json.dumps(plain))
    line = blastline("render", film, "-o", tmp_path / "out", "--timeline", file, "--original", result / "timeline.json")
    assert re.search(r"edited.json: is of film.wav .*, but its original .* of film.wav .*--original", line.complaint)


def test_a_rejection_that_is_added_back_is_no_rejection_any_more(tmp_path: Path, film: Path, result: Path) -> None:
    without = edited(result, tmp_path, lambda rows: rows.pop(1))
    after = rendered(film, without)[1]
    assert [rejection.reason for rejection in after.rejections] == ["deleted by hand"]
    out = tmp_path / "out"
    again = tmp_path / "again.csv"
    again.write_text("id,onset_s\n" + "".join(f"{e.id},{e.onset_s}\n" for e in after.events) + ",2.501\n")
    ended, regained, _ = rendered(film, again, "--original", out / "timeline.json")
    assert "3 kept, 1 added" in ended.err
    assert regained.rejections == ()
    assert [(e.id, e.onset_sample, e.confidence) for e in regained.events if e.onset_s == 2.501] == [
        ("shot-0005", 120_048, 1.0)
    ]
