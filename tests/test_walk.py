"""The parts of one result together, as a user walks them: render, formats, edits, a new cut, and the drive of that."""

import csv
import re
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import msgspec
import numpy as np
import pytest
import soundfile

from blastline import run
from blastline.cli.options import Formats
from blastline.export import FORMATS, HAPTIC_FORMATS, export_timeline, read_timeline
from blastline.export.edits import match, read_edits
from blastline.model import Span, Timeline, Window
from commands import RATE_HZ, blastline, write_film
from timelines import SHOT, timeline

ALL = {**FORMATS, **HAPTIC_FORMATS}
SHOTS_S = (1.0, 3.0, 3.1, 3.2, 8.0)
LENGTH_S = 10.0
DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_film(tmp_path_factory.mktemp("film") / "film.wav", length_s=LENGTH_S, shots_s=SHOTS_S)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory, film: Path) -> Path:
    """Return a folder with a render of exactly these shots, three of them a burst, in every format."""
    folder = tmp_path_factory.mktemp("result")
    (folder / "first.csv").write_text("onset_sample\n" + "".join(f"{round(s * RATE_HZ)}\n" for s in SHOTS_S))
    ended = blastline(
        *("render", film, "-o", folder / "out", "--timeline", folder / "first.csv", "--format", ",".join(ALL)),
        *("--frame-rate", "25", "--start-timecode", "10:00:00:00"),
    )
    assert ended.code == 0, ended
    return folder / "out"


def test_formats_have_the_same_names_everywhere() -> None:
    listed = [line.split()[0] for line in blastline("formats").out.splitlines() if not line.startswith(" ")]
    assert listed == list(ALL)
    said = get_args(Formats)[1].help
    assert re.findall(r"\w+", re.sub(r"Timeline files to write:|from the drive:|`blastline.*", "", said)) == list(ALL)
    table = re.findall(r"^\| `(\w+)` \| ([^|]*) \|", (DOCS / "formats.md").read_text(), re.MULTILINE)
    assert [name for name, _ in table] == list(ALL)
    assert [row.name for row in run.export_rows()] == list(ALL)
    for row, (_, files) in zip(run.export_rows(), table, strict=True):
        assert set(re.findall(r"`([^`]+)`", files)) == set(row.files)


def test_the_report_links_every_file_of_every_format(result: Path) -> None:
    page = (result / "report.html").read_text()
    linked = set(re.findall(r'href="(timeline\.[^"]+)"', page))
    assert linked == {file.name for file in result.iterdir()} - {"drive.wav", "report.html"}
    assert "timeline.reel-01.haptic" in linked


def burst() -> Timeline:
    """Return a timeline with a burst in one window, a shot with a gain, a moved one and an added one."""
    shared = Window(47_712, 90_000, 240, 1920)
    events = [
        msgspec.structs.replace(
            SHOT,
            id=f"shot-{number:04}",
            onset_sample=onset,
            onset_s=onset / RATE_HZ,
            blast=Span(onset, onset + 100),
            reflections=(),
            window=shared if number <= 4 else Window(onset - 288, onset + 20_000, 240, 1920),
            burst=1 if number <= 4 else None,
            shot_in_burst=number if number <= 4 else None,
            gain_db=-6.25 if number == 5 else 0.0,
            origin="moved" if number == 6 else "added" if number == 7 else "found",
            confidence=0.98765,
        )
        for number, onset in enumerate((48_000, 52_801, 57_599, 62_400, 200_001, 300_007, 400_013), start=1)
    ]
    whole = timeline(*events)
    return msgspec.structs.replace(whole, source=msgspec.structs.replace(whole.source, frames=500_000))


@pytest.mark.parametrize("name", ["json", "csv", "audacity", "reaper"])
def test_what_a_writer_wrote_its_reader_understands_whole(tmp_path: Path, name: str) -> None:
    before = burst()
    [file] = export_timeline(before, tmp_path, formats=[name])
    wishes = match(read_edits(file), {e.id: e for e in before.events}, rate_hz=RATE_HZ).wishes
    assert [wish.was for wish in wishes] == list(before.events)
    for wish, event in zip(wishes, before.events, strict=True):
        assert (wish.unmoved, wish.changed, wish.onset, wish.window) == (True, False, event.onset_sample, event.window)
        assert (wish.origin, wish.gain_db, wish.confidence) == (event.origin, event.gain_db, event.confidence)
    alone = match(read_edits(file), None, rate_hz=RATE_HZ).wishes
    assert [(wish.id, wish.onset) for wish in alone] == [(e.id, e.onset_sample) for e in before.events]


@pytest.mark.parametrize("decimals", [9, 3])
def test_a_region_that_ends_at_the_next_shot_has_no_end_of_its_own(tmp_path: Path, decimals: int) -> None:
    before = burst()
    [file] = export_timeline(before, tmp_path, formats=["reaper"])
    with file.open(newline="") as text:
        header, *rows = list(csv.reader(text))
    for row in rows:
        row[2:4] = [f"0:00:{float(time[5:]):0{decimals + 3}.{decimals}f}" for time in row[2:4]]
    del rows[2]
    for cell in (2, 3):  # the last of the burst is dragged by 12 ms, as a whole
        rows[2][cell] = f"0:00:{float(rows[2][cell][5:]) + 0.012:0{decimals + 3}.{decimals}f}"
    rows[0][3] = rows[1][2]
    with file.open("w", newline="") as text:
        csv.writer(text).writerows([header, *rows])
    wanted = match(read_edits(file), {e.id: e for e in before.events}, rate_hz=RATE_HZ)
    assert [event.id for event in wanted.deleted] == ["shot-0003"]
    first, second, moved, *others = wanted.wishes
    assert [(wish.start, wish.stop, wish.changed) for wish in (first, second)] == [(None, None, False)] * 2
    assert (moved.id, moved.origin) == ("shot-0004", "moved")
    assert abs(moved.onset - 62_400 - 576) <= 24
    assert all(wish.unmoved and not wish.changed for wish in others)


def in_reaper(result: Path, folder: Path) -> Path:
    """Move, delete, add and shorten regions as REAPER writes them, in milliseconds."""
    with (result / "timeline.reaper.csv").open(newline="") as text:
        header, *rows = list(csv.reader(text))
    times = [[float(cell[5:]) for cell in row[2:4]] for row in rows]
    times[0] = [1.2, 1.5]
    times[4][1] = 8.1
    made = [[*row[:2], f"0:{a:06.3f}", f"0:{b:06.3f}", ""] for row, (a, b) in zip(rows, times, strict=True)]
    del made[2]
    made.append(["R9", "one more", "0:06.000", "0:06.250", ""])
    with (folder / "edited.csv").open("w", newline="") as text:
        csv.writer(text).writerows([header, *made])
    return folder / "edited.csv"


def in_audacity(result: Path, folder: Path) -> Path:
    """The same with labels, in microseconds."""
    rows = [line.split("\t") for line in (result / "timeline.audacity.txt").read_text().splitlines()]
    rows[0][:2] = ["1.200000", "1.500000"]
    rows[4][1] = "8.100000"
    del rows[2]
    rows.append(["6.000000", "6.250000", ""])
    (folder / "labels.txt").write_text("".join("\t".join(row) + "\n" for row in rows))
    return folder / "labels.txt"


def in_a_spreadsheet(result: Path, folder: Path) -> Path:
    """The same with a table."""
    with (result / "timeline.csv").open(newline="") as text:
        rows = list(csv.DictReader(text))
    columns = list(rows[0])
    rows[0] |= {"onset_s": "1.2", "window_stop_s": "1.5"}
    rows[4]["window_stop_s"] = "8.1"
    del rows[2]
    rows.append({"onset_s": "6.0", "window_stop_s": "6.25"})
    with (folder / "edited.csv").open("w", newline="") as text:
        table = csv.DictWriter(text, columns)
        table.writeheader()
        table.writerows(rows)
    return folder / "edited.csv"


@pytest.mark.parametrize("edit", [in_reaper, in_audacity, in_a_spreadsheet])
def test_the_same_edits_in_any_tool_are_the_same_result(
    tmp_path: Path, film: Path, result: Path, edit: Callable[[Path, Path], Path]
) -> None:
    file = edit(result, tmp_path)
    original = result / "timeline.json"
    ended = blastline(
        *("render", film, "-o", tmp_path / "out", "--timeline", file, "--original", original, "--no-report"),
        *("--format", "json,resolve,hjif"),
    )
    assert ended.code == 0, ended
    assert f"edits: {file.name}: 2 kept, 1 moved, 1 changed, 1 added, 1 deleted" in ended.err
    made = read_timeline(tmp_path / "out" / "timeline.json")
    ends = {event.id: (event.onset_sample, event.window.stop) for event in made.events}
    before = {event.id: event for event in read_timeline(original).events}
    assert ends["shot-0001"] == (57_600, 72_000)
    assert ends["shot-0005"] == (before["shot-0005"].onset_sample, 388_800)
    assert ends["shot-0006"] == (288_000, 300_000)
    assert ends["shot-0002"] == (before["shot-0002"].onset_sample, before["shot-0003"].onset_sample)
    assert (made.source.start_timecode, made.source.frame_rate) == ("10:00:00:00", "25")  # as it was said at first
    assert {event.timecode[:8] for event in made.events} >= {"10:00:01", "10:00:08"}
    assert blastline("check", tmp_path / "out", "--audio", film, "--quiet").code == 0


def test_a_timecode_that_is_said_anew_holds(tmp_path: Path, film: Path, result: Path) -> None:
    ended = blastline(
        *("render", film, "-o", tmp_path / "out", "--timeline", result / "timeline.json", "--no-report"),
        *("--start-timecode", "02:00:00:00"),
    )
    assert ended.code == 0, ended
    source = read_timeline(tmp_path / "out" / "timeline.json").source
    assert (source.start_timecode, source.frame_rate) == ("02:00:00:00", "25")


def test_a_new_cut_is_conformed_rendered_and_checked_in_one_go(tmp_path: Path, film: Path, result: Path) -> None:
    samples, rate_hz = soundfile.read(film)
    new = tmp_path / "new.wav"
    soundfile.write(new, np.concatenate([samples[round(1.7 * rate_hz) :], np.zeros(rate_hz)]), rate_hz)
    edited = blastline(
        *("render", film, "-o", tmp_path / "old", "--timeline", in_reaper(result, tmp_path), "--no-report"),
        *("--original", result / "timeline.json"),
    )
    assert edited.code == 0, edited
    cut = tmp_path / "conformed"
    ended = blastline("conform", tmp_path / "old" / "timeline.json", "--from", film, "--to", new, "-o", cut)
    assert ended.code == 0, ended
    placed = read_timeline(cut / "timeline.json")
    assert "4 of 5 shots placed, 1 not" in ended.out
    assert (placed.actuator, placed.edits, placed.checks) == (None, None, ())
    assert all(event.drive is None for event in placed.events)
    refused = blastline("export", cut / "timeline.json", "--format", "json,hjif", "-o", tmp_path / "none")
    assert "has no drive and names no actuator" in refused.complaint
    assert not (tmp_path / "none").exists()
    tables = blastline("export", cut / "timeline.json", "--format", "csv,reaper,audacity,midi", "-o", cut)
    assert tables.code == 0, tables
    drives = []
    for name in ("timeline.json", "timeline.csv", "timeline.reaper.csv", "timeline.audacity.txt"):
        out = tmp_path / name
        rendered = blastline("render", new, "-o", out, "--timeline", cut / name, "--no-report", "--format", "json,ahap")
        assert rendered.code == 0, rendered
        assert f"edits: {name}: 4 kept" in rendered.err
        made = read_timeline(out / "timeline.json")
        told = [(e.id, e.onset_sample, e.window, e.origin, e.gain_db) for e in made.events]
        assert told == [(e.id, e.onset_sample, e.window, e.origin, e.gain_db) for e in placed.events]
        assert blastline("check", out, "--audio", new, "--quiet").code == 0
        drives.append((out / "drive.wav").read_bytes())
    assert len(set(drives)) == 1
