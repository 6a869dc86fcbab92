"""What the command says it understood of edits, what it could not use, and what it refuses."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile

from commands import blastline, write_film
from edited_films import FRAMES, SHOTS_S, Row, edited, edited_film, first_result, rendered


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return edited_film(tmp_path_factory.mktemp("film"))


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory, film: Path) -> Path:
    return first_result(tmp_path_factory.mktemp("result"), film)


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


def test_a_folder_without_a_timeline_is_told_by_the_file_that_is_missing(tmp_path: Path, film: Path) -> None:
    (tmp_path / "empty").mkdir()
    ended = blastline("render", film, "-o", tmp_path / "out", "--timeline", tmp_path / "empty")
    assert ended.complaint.startswith(f"{tmp_path / 'empty' / 'timeline.json'}: no such file; expected ")


def test_a_json_without_its_original_says_what_it_cannot_tell(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    plain["events"][1]["gain_db"] = -12.0
    (tmp_path / "alone.json").write_text(json.dumps(plain))
    ended, after, _ = rendered(film, tmp_path / "alone.json")
    assert "nothing to compare the timeline with (--original), which matters only if it was edited: " in ended.err
    assert "changed gains, ends and confidences hold as they stand, and count as kept" in ended.err
    assert after.events[1].gain_db == -12.0


def test_a_json_that_is_named_as_its_own_original_keeps_its_edits(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    plain["events"][0]["onset_sample"] = 52_800
    file = tmp_path / "timeline.json"
    file.write_text(json.dumps(plain))
    ended, after, _ = rendered(film, file, "--original", tmp_path / "." / "timeline.json")
    assert "3 kept, 1 moved" in ended.err
    assert after.events[0].onset_sample == 52_800
    assert "note: not used: --original, which is the edited file itself\n" in ended.err
    (tmp_path / "linked.json").symlink_to(file)
    assert "3 kept, 1 moved" in rendered(film, file, "--original", tmp_path / "linked.json")[0].err


def test_an_end_that_cannot_be_is_told_as_it_stands(tmp_path: Path, film: Path, result: Path) -> None:
    (tmp_path / "edited.csv").write_text("onset_s,window_start_s\n2.5,2.6\n")
    ended = blastline("render", film, "-o", tmp_path / "out", "--timeline", tmp_path / "edited.csv")
    assert ended.complaint.endswith("window_start_s = 2.6: expected at most 2.5, the onset")


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


@pytest.mark.parametrize("name", ["audacity", "reaper"])
def test_a_gain_comes_back_with_its_marker_without_the_original(
    tmp_path: Path, film: Path, result: Path, name: str
) -> None:
    """A shot that was muted must not shake the seat again because a tool knows nothing of gains."""
    gains_db = (-60.0, 2.25, 0.0, -1 / 3)

    def regain(rows: list[Row]) -> None:
        for row, gain_db in zip(rows, gains_db, strict=True):
            row["gain_db"] = repr(gain_db)

    file = edited(result, tmp_path, regain)
    _, before, muted = rendered(film, file)
    assert [event.gain_db for event in before.events] == list(gains_db)
    assert blastline("export", tmp_path / "out", "--format", name, "-o", tmp_path / "cues").code == 0
    (markers,) = (tmp_path / "cues").iterdir()
    _, after, drive = rendered(film, markers)
    assert [event.gain_db for event in after.events] == list(gains_db)
    own = slice(before.events[0].window.start, before.events[0].window.stop)
    assert np.max(np.abs(drive[own])) <= 2 * np.max(np.abs(muted[own]))
    again = tmp_path / "again" / markers.name
    again.parent.mkdir()
    again.write_text(markers.read_text().replace("gain -60 dB", "gain -6 dB loud enough"))
    ended, after, _ = rendered(film, again, "--original", tmp_path / "out")
    assert f"edits: {markers.name}: 3 kept, 1 changed\n" in ended.err
    assert [event.gain_db for event in after.events] == [-6.0, *gains_db[1:]]


@pytest.mark.parametrize(
    "typed",
    [
        "gain -60dB",
        "gain -60 dB.",
        "Gain  -60 dB",
        "gain \u221260 dB",
        "gain -\u00a060 dB",
        "gain -60,0 dB",
        "quiet gain -60 DB",
    ],
)
def test_a_gain_may_be_typed_as_people_write_it(tmp_path: Path, film: Path, typed: str) -> None:
    (tmp_path / "labels.txt").write_text(f"1.0\t1.0\tshot-0001 0.99 -6.0 dBFS direct {typed}\n", encoding="utf-8")
    assert [event.gain_db for event in rendered(film, tmp_path / "labels.txt")[1].events] == [-60.0]


def test_labels_that_are_ids_alone_are_as_given_without_their_original(tmp_path: Path, film: Path) -> None:
    """Somebody has taken the confidence away, or written another name behind the id: it is no new shot by that."""
    (tmp_path / "labels.txt").write_text("1.0\t1.0\tshot-0001\n2.5\t2.5\tshot-0002 door?\n4.0\t4.0\tboom\n")
    ended, after, _ = rendered(film, tmp_path / "labels.txt")
    assert "edits: labels.txt: 1 added, 2 as given\n" in ended.err
    assert [event.origin for event in after.events] == ["found", "found", "added"]


def test_a_row_that_tells_where_its_onset_was_is_kept_or_moved_without_an_original(
    tmp_path: Path, film: Path, result: Path
) -> None:
    file = edited(result, tmp_path, lambda rows: rows[1].update(onset_s="2.6", onset_sample="", origin="found"))
    (tmp_path / "timeline.json").unlink()
    rows = file.read_text().replace(",added,", ",found,")
    file.write_text(rows)
    assert "edits: edited.csv: 3 kept, 1 moved\n" in rendered(film, file)[0].err


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


@pytest.mark.parametrize("frame_rate", [None, "25"])
@pytest.mark.parametrize(
    ("away_s", "told"),
    [(None, False), (0.0, False), (0.5, True), (-2.5, True)],
)
def test_a_timecode_that_contradicts_where_its_row_was_moved_is_told(
    tmp_path: Path, film: Path, result: Path, frame_rate: str | None, away_s: float | None, told: bool
) -> None:
    """Of a row that is moved, the old timecode says nothing, and one typed with the new time agrees to a frame."""

    def timecode(at_s: float) -> str:
        return f"00:00:{at_s:06.3f}" if frame_rate is None else f"00:00:{int(at_s):02}:{int(at_s % 1.0 * 25):02}"

    def edit(rows: list[Row]) -> None:
        rows[2].update(onset_s="4.007")
        if away_s is not None:
            rows[2].update(timecode=timecode(4.007 + away_s))

    counted = ("--frame-rate", frame_rate) if frame_rate else ()
    first = rendered(film, edited(result, tmp_path, lambda rows: None), *counted)[1]
    assert first.source.frame_rate == frame_rate
    (tmp_path / "again").mkdir()
    err = rendered(film, edited(tmp_path / "out", tmp_path / "again", edit), *counted)[0].err
    assert "3 kept, 1 moved" in err
    note = "note: not used: the timecode of shot-0003, which was edited; onset_s or onset_sample moves a shot"
    assert [line for line in err.splitlines() if "the timecode of" in line] == ([note] if told else [])


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


def with_reflection(event: dict[str, Any], *, level_db: float) -> dict[str, Any]:
    onset = event["onset_sample"]
    echo = {"start_sample": onset + 4_800, "stop_sample": onset + 5_280, "delay_ms": 100.0, "level_db": level_db}
    return event | {"reflections": [echo]}


@pytest.mark.parametrize("left", [1, 2])
@pytest.mark.parametrize("level_db", [-9.0, -3.0])
def test_an_edit_of_reflections_is_told_and_no_other_is(
    tmp_path: Path, film: Path, result: Path, left: int, level_db: float
) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    events = [with_reflection(event, level_db=-9.0) for event in plain["events"]]
    (tmp_path / "original.json").write_text(json.dumps(plain | {"events": events}))
    edits = [with_reflection(events[0], level_db=level_db), *events[1:left]]
    (tmp_path / "edited.json").write_text(json.dumps(plain | {"events": edits}))
    told = rendered(film, tmp_path / "edited.json", "--original", tmp_path / "original.json")[0].err
    assert ("not used: the reflections of shot-0001, which was edited" in told) == (level_db != -9.0)


@pytest.mark.parametrize("moved", [False, True])
def test_an_edit_of_what_is_planned_or_measured_is_told(
    tmp_path: Path, film: Path, result: Path, *, moved: bool
) -> None:
    """A shot that was moved is measured where it is now; its fades nobody moves."""
    plain = json.loads((result / "timeline.json").read_text())
    event = plain["events"][1]
    event["window"]["fade_out_samples"] //= 2
    event["blast"]["stop_sample"] += 100
    if moved:
        event.update(onset_sample=event["onset_sample"] + 960, onset_s=None)
    plain["level_db"], plain["source"]["start_timecode"] = 3.0, "01:00:00:00"
    (tmp_path / "edited.json").write_text(json.dumps(plain))
    told = rendered(film, tmp_path / "edited.json", "--original", result / "timeline.json")[0].err
    notes = [line.removeprefix("note: not used: ") for line in told.splitlines() if "not used" in line]
    of_film = ["level_db, which was edited; --level sets it"]
    of_film += ["source.start_timecode, which was edited; --start-timecode sets it"]
    of_shot = [
        "the window.fade_out_samples of shot-0002, which was edited; the rules' [windows] have it, for all shots"
    ]
    of_shot += [] if moved else ["the blast.stop_sample of shot-0002, which was edited; it is measured in the film"]
    assert notes == of_film + of_shot


def test_a_shot_may_be_moved_together_with_the_start_of_its_blast(tmp_path: Path, film: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    onset = plain["events"][1]["onset_sample"] + 9_600
    plain["events"][1].update(onset_sample=onset, onset_s=None)
    plain["events"][1]["blast"]["start_sample"] = onset
    (tmp_path / "edited.json").write_text(json.dumps(plain))
    ended, after, _ = rendered(film, tmp_path / "edited.json", "--original", result / "timeline.json")
    assert "edits: edited.json: 3 kept, 1 moved\n" in ended.err
    assert after.events[1].onset_sample == onset == after.events[1].blast.start


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"gain_db": 0.0', '"gain_db": -3.0, "gain_db": 0.0', "gain_db of 'shot-0001' is there twice, as -3.0 and 0.0"),
        ('"events":', '"events": [], "events":', "events is there twice, as [] and [{"),
        ('"gain_db": 0.0', '"gain_db": 1e400', "1e400: too large for a number"),
    ],
)
def test_what_json_leaves_open_is_refused(
    tmp_path: Path, film: Path, result: Path, old: str, new: str, complaint: str
) -> None:
    text = (result / "timeline.json").read_text()
    assert old in text
    (tmp_path / "edited.json").write_text(text.replace(old, new, 1))
    asked = ("render", film, "-o", tmp_path / "out", "--timeline", tmp_path / "edited.json")
    assert complaint in blastline(*asked).complaint


@pytest.mark.parametrize("edit", [{"onset_s": 2.75}, {"onset_sample": 132_000}])
def test_a_timeline_that_was_edited_is_made_whole_by_render(tmp_path: Path, result: Path, edit: Row) -> None:
    plain = json.loads((result / "timeline.json").read_text())
    plain["events"][1].update(edit)
    (tmp_path / "timeline.json").write_text(json.dumps(plain))
    told = blastline("export", tmp_path, "--format", "csv", "-o", tmp_path / "out").complaint
    assert "events[1].onset_s = " in told
    assert told.endswith("; of an edited timeline `blastline render FILM --timeline FILE` makes a whole one")


def test_columns_that_are_not_read_are_others_where_the_options_were(tmp_path: Path, film: Path, result: Path) -> None:
    def edit(rows: list[Row]) -> None:
        for row in rows:
            row["timecode"], row["drive_model"] = f"01:{row['timecode'][3:]}", "filter"

    assert "not used" not in rendered(film, edited(result, tmp_path, edit))[0].err


@pytest.mark.parametrize(
    ("edit", "complaint"),
    [
        (lambda r: r[1].update(onset_s="7.5"), "line 3: onset_s = '7.5': expected a time in the film"),
        (
            lambda r: r[1].update(onset_s="6.99999", onset_sample=""),  # nearer to the sample behind the last one
            "line 3: onset_s = '6.99999': expected a time in the film, which has 336000 frames, 7 s; its last sample "
            "is 335999, at 6.99997917 s",
        ),
        (lambda r: r[1].update(onset_sample="336000"), "line 3: onset_sample = '336000': expected a time in the film"),
        (lambda r: r[1].update(window_stop_s="7.1"), "line 3: window_stop_s = '7.1': expected a time in the film"),
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
