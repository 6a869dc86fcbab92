"""From a designer's edits to a drive, through the command line: exactly what was asked for, and silence elsewhere."""

import json
from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile

from blastline import run
from blastline.export import read_timeline
from blastline.model import Decision
from commands import RATE_HZ, Ended, blastline
from edited_films import (
    FADE_IN,
    FRAMES,
    GUARD,
    Row,
    by_id,
    edited,
    edited_film,
    felt_db,
    first_result,
    moving,
    rendered,
)


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return edited_film(tmp_path_factory.mktemp("film"))


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory, film: Path) -> Path:
    return first_result(tmp_path_factory.mktemp("result"), film)


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


def test_how_closely_a_shot_was_looked_at_is_kept_until_it_is_moved(tmp_path: Path, film: Path, result: Path) -> None:
    before = read_timeline(result / "timeline.json")
    told = Decision("verifier", "looked at twice", "as somebody else decided", {"probability": 0.5})
    events = tuple(msgspec.structs.replace(event, decisions=(told,)) for event in before.events)
    moved = msgspec.structs.replace(events[0], onset_sample=52_800, onset_s=1.1)
    file, original = tmp_path / "edited.json", tmp_path / "original.json"
    file.write_bytes(msgspec.json.encode(msgspec.structs.replace(before, events=(moved, *events[1:]))))
    original.write_bytes(msgspec.json.encode(msgspec.structs.replace(before, events=events)))
    ended, after, _ = rendered(film, file, "--original", original)
    assert "3 kept, 1 moved" in ended.err
    assert [event.decisions for event in after.events[1:]] == [(told,)] * 3
    assert told not in after.events[0].decisions


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


def test_no_events_are_a_silent_drive_and_said(tmp_path: Path, film: Path, result: Path) -> None:
    ended, after, drive = rendered(film, edited(result, tmp_path, lambda rows: rows.clear()))
    assert after.events == ()
    assert drive.size == FRAMES
    assert not np.any(drive)
    assert "edits: edited.csv: 4 deleted" in ended.err
    assert "warning: edited.csv: no events: the drive is silent" in ended.err
    (tmp_path / "labels.txt").write_bytes(b"")
    ended, after, _ = rendered(film, tmp_path / "labels.txt", "--quiet")
    assert after.events == ()
    assert ended.err == "warning: labels.txt: no events: the drive is silent\n"


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

    for name in ("find_shots", "verifier_of"):
        monkeypatch.setattr(run.listening, name, never)
    rendered(film, edited(result, tmp_path, lambda rows: None))


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


@pytest.mark.parametrize("added_s", [0.4, 3.2, 5.5])
def test_a_rejection_stays_whatever_is_added_before_or_behind_it(
    tmp_path: Path, film: Path, result: Path, added_s: float
) -> None:
    after = rendered(film, edited(result, tmp_path, lambda rows: rows.pop(1)))[1]
    assert [(each.at_sample, each.reason) for each in after.rejections] == [(120_000, "deleted by hand")]
    again = edited(tmp_path / "out", tmp_path, lambda rows: rows.append({"onset_s": str(added_s)}))
    ended, later, _ = rendered(film, again)
    assert "3 kept, 1 added" in ended.err
    assert later.rejections == after.rejections
