"""What editing tools write is read as it is meant, and what cannot be used is refused in one line with its place."""

import codecs
import json
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
from hypothesis import given

from blastline.errors import TimelineError
from blastline.export import export_timeline, read_timeline
from blastline.export.edits import EditedFile, Point, match, read_edits
from blastline.export.edits.document import read_document
from blastline.model import Timeline, encode
from timelines import BURST_SHOT, RATE_HZ, SHOT, any_timeline, timeline

READ = "an edited timeline: timeline.json, timeline.csv, Audacity labels or REAPER's CSV"
TABLE = "id,onset_sample,onset_s,confidence\nshot-0001,48001,,0.5\nshot-0002,96000,,\n"
LABELS = "1.000021\t1.500000\tshot-0001 0.97\n2.000000\t2.083333\tshot-0002 0.50\n"
REAPER = "#,Name,Start,End,Length\nR1,shot-0001 0.97,0:01.000,0:01.500,0:00.500\nM1,bang,0:02.250,,\n"


def read(tmp_path: Path, content: str | bytes, name: str = "edited.csv") -> EditedFile:
    """Return what is read from a file of this content."""
    file = tmp_path / name
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_edits(file)


def samples(edited: EditedFile) -> list[int]:
    """Return the onsets at 48 kHz as the file has them."""
    return [edit.onset.nearest(RATE_HZ) for edit in edited.edits]


def refusal(tmp_path: Path, content: str | bytes, name: str = "edited.csv") -> str:
    """Return the line with which a file is refused, after its name."""
    with pytest.raises(TimelineError) as raised:
        match(read(tmp_path, content, name), None, rate_hz=RATE_HZ)
    line = str(raised.value)
    assert "\n" not in line
    assert line.startswith(f"{tmp_path / name}: ")
    return line.removeprefix(f"{tmp_path / name}: ")


@pytest.mark.parametrize(
    "spoilt",
    [
        TABLE.encode(),
        codecs.BOM_UTF8 + TABLE.encode(),
        TABLE.encode("utf-16"),
        codecs.BOM_UTF16_BE + TABLE.encode("utf-16-be"),
        TABLE.encode("utf-16-le"),
        TABLE.replace("\n", "\r\n").encode(),
        TABLE.replace(",", ";").encode(),
        TABLE.replace(",", ";").replace(".", ",").encode(),
        b"sep=;\r\n" + TABLE.replace(",", ";").replace(".", ",").encode(),
        TABLE.replace(",", "\t").encode(),
        b"sep=\t\r\n" + TABLE.replace(",", "\t").replace(".", ",").encode(),
        TABLE.replace("48001,", "48001.0,").encode(),
        TABLE.replace("48001,", "48001.000,").encode(),
        (TABLE + "\n,,,\n\n").encode(),
        TABLE.replace("id,", "ID, ").replace("shot-0001,", "shot-0001 , ").lower().encode(),
        TABLE.replace("shot-0001", '"shot-0001"').encode(),
    ],
)
def test_a_table_is_the_same_whatever_program_saved_it(tmp_path: Path, spoilt: bytes) -> None:
    edited = read(tmp_path, spoilt)
    assert samples(edited) == [48_001, 96_000]
    assert [edit.id for edit in edited.edits] == ["shot-0001", "shot-0002"]
    assert [edit.confidence for edit in edited.edits] == [pytest.approx(0.5), None]


def test_a_letter_of_the_western_alphabet_is_no_obstacle(tmp_path: Path) -> None:
    edited = read(tmp_path, "id,onset_s\nStra\u00dfe,1.5\n".encode("cp1252"))
    assert [edit.id for edit in edited.edits] == ["Stra\u00dfe"]


@pytest.mark.parametrize(("name", "text"), [("c.csv", TABLE), ("c.txt", TABLE), ("r.txt", REAPER), ("r.csv", REAPER)])
def test_a_table_is_known_by_its_header(tmp_path: Path, name: str, text: str) -> None:
    assert len(read(tmp_path, text, name).edits) == 2


@pytest.mark.parametrize("suffix", ["csv", "tsv", "txt", "json", "xml", ""])
@pytest.mark.parametrize("text", [TABLE, LABELS, REAPER, encode(timeline()).decode()])
def test_a_file_is_told_by_its_contents_whatever_it_is_called(tmp_path: Path, text: str, suffix: str) -> None:
    here, there = read(tmp_path, text, "edited.txt"), read(tmp_path, text, f"edited.{suffix}")
    assert len(there.edits) == 2
    assert replace(there, path=here.path) == here


@pytest.mark.parametrize("suffix", ["csv", "json"])
@pytest.mark.parametrize("name", ["resolve", "fcp7", "fcpxml", "otio", "webvtt", "avid"])
def test_a_file_that_is_not_read_is_called_by_what_it_is_whatever_its_name(
    tmp_path: Path, name: str, suffix: str
) -> None:
    (file,) = export_timeline(timeline(SHOT, BURST_SHOT), tmp_path, formats=[name])
    content = file.read_bytes()
    assert refusal(tmp_path, content, f"edited.{suffix}") == refusal(tmp_path, content, "edited.txt")


def test_columns_that_nobody_knows_are_left_aside_and_said(tmp_path: Path) -> None:
    assert read(tmp_path, "onset_s,comment,who\n1.0,loud,me\n").notes == ("not used: column comment, who",)
    assert read(tmp_path, "onset_s,,\n1.0,,\n").notes == ()  # as a spreadsheet saves columns that were emptied


def test_keys_that_nobody_knows_are_left_aside_and_said(tmp_path: Path) -> None:
    plain = json.loads(encode(timeline()))
    plain["events"][0] |= {"gain_dB": -6, "window_stop_s": 1.5, "a\nb": 1}
    plain["events"][0]["window"]["stop_s"] = 1.5
    plain["events"][1] = {"onset_s": 2.0, "gain_dB": 3, "window": None}
    assert read(tmp_path, json.dumps(plain), "e.json").notes == (
        "not used: key gain_dB, window_stop_s, 'a\\nb', window.stop_s",
    )
    plain["events"] = [{"onset_s": 1.0, f"mine {number}": 0} for number in range(12)]
    [note] = read(tmp_path, json.dumps(plain), "e.json").notes
    assert note.endswith("mine 9 and 2 more")


@given(any_timeline())
def test_no_key_of_a_timeline_is_unknown(drawn: Timeline) -> None:
    assert read_document(encode(drawn).decode(), Path("timeline.json"), expected=READ).notes == ()


def test_labels_are_points_and_ranges_with_frequencies_left_aside(tmp_path: Path) -> None:
    text = LABELS + "\\\t6928.456055\t6928.456055\n2.250000\t2.250000\tbang\n2,400000\t2,400000\n"
    edited = read(tmp_path, text.replace("\n", "\r\n"), "labels.txt")
    assert samples(edited) == [48_001, 96_000, 108_000, 115_200]
    assert [edit.text for edit in edited.edits] == ["shot-0001 0.97", "shot-0002 0.50", "bang", ""]
    assert [edit.window_stop for edit in edited.edits[1:]] == [
        Point(seconds=Fraction("2.083333"), step_s=Fraction(1, 10**6)),
        None,
        None,
    ]


@pytest.mark.parametrize(
    ("start", "stop", "onset"),
    [
        ("1.500", "2.500", 72_000),
        ("0:01.500", "0:02.500", 72_000),
        ("0:00:01.500", "0:00:02.500", 72_000),
        ("1:00:01.500", "1:00:02.500", 172_872_000),
        ("72000", "120000", 72_000),
    ],
)
def test_reapers_ruler_may_show_seconds_clock_or_samples(tmp_path: Path, start: str, stop: str, onset: int) -> None:
    text = f"#,Name,Start,End,Length,Color\nM1,one,{start},,,\nR2,two,{start},{stop},1,FF0000\n"
    edited = read(tmp_path, text)
    assert samples(edited) == [onset, onset]
    assert [edit.window_stop and edit.window_stop.nearest(RATE_HZ) for edit in edited.edits] == [None, onset + 48_000]


def test_a_marker_and_a_region_of_one_name_are_one_event(tmp_path: Path) -> None:
    text = "#,Name,Start,End,Length\nM1,shot-0001 0.9,1.006,,\nR1,shot-0001 0.9,1.000,1.500,0.500\nR2,x,2.0,3.0,1.0\n"
    first, second = read(tmp_path, text).edits
    assert first.window_start is not None
    assert first.window_stop is not None
    ends = (first.onset, first.window_start, first.window_stop)
    assert [point.nearest(1000) for point in ends] == [1006, 1000, 1500]
    assert second.window_start is None


def test_four_times_the_markers_are_four_times_the_work(tmp_path: Path) -> None:
    """Not sixteen times: 10,000 of them would take longer to read than their film to render."""
    calls = [calls_to_read(tmp_path, count) for count in (200, 800)]
    assert calls[1] < 5 * calls[0]


def calls_to_read(folder: Path, count: int) -> int:
    """Return how many calls it takes to read so many markers, each with a region of its name."""
    lines = [f"M{n},shot-{n:05} 0.9,{n}.000,,\nR{n},shot-{n:05} 0.9,{n}.000,{n}.500,0.500" for n in range(count)]
    file = folder / "regions.csv"
    file.write_text("\n".join(["#,Name,Start,End,Length", *lines]), encoding="utf-8")
    calls = 0

    def counted(_frame: FrameType, event: str, _arg: object) -> None:
        nonlocal calls
        calls += event == "call"

    before = sys.getprofile()
    sys.setprofile(counted)
    try:
        edited = read_edits(file)
    finally:
        sys.setprofile(before)
    assert len(edited.edits) == count
    return calls


def test_an_event_of_a_document_needs_no_more_than_its_onset(tmp_path: Path) -> None:
    plain = json.loads(encode(timeline()))
    plain["events"] += [{"onset_sample": 100_000}, {"onset_s": 2.25, "id": "mine"}]
    edited = read(tmp_path, json.dumps(plain), "edited.json")
    assert samples(edited) == [48_001, 96_000, 100_000, 108_000]
    assert [edit.id for edit in edited.edits] == ["shot-0001", "shot-0002", None, "mine"]
    wanted = match(edited, None, rate_hz=RATE_HZ)
    assert [wish.unmoved for wish in wanted.wishes] == [True, True, False, False]
    assert [wish.id for wish in wanted.wishes] == ["shot-0001", "shot-0002", "shot-0003", "mine"]


def test_a_document_tells_by_its_blasts_what_was_moved(tmp_path: Path) -> None:
    plain = json.loads(encode(timeline()))
    plain["events"][0]["onset_s"] = 1.25
    plain["events"][1]["onset_sample"] = 100_000
    wanted = match(read(tmp_path, json.dumps(plain), "edited.json"), None, rate_hz=RATE_HZ)
    assert [(wish.onset, wish.origin) for wish in wanted.wishes] == [(60_000, "moved"), (100_000, "moved")]


def test_nothing_is_an_empty_label_track_or_a_table_without_rows(tmp_path: Path) -> None:
    assert read(tmp_path, "", "labels.txt").edits == ()
    assert read(tmp_path, "id,onset_s\n").edits == ()
    assert read(tmp_path, "#,Name,Start,End,Length\n").edits == ()


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "line 1: no header; expected onset_sample or onset_s, as timeline.csv has, or #,Name,Start,End,Length"),
        ("a,b\n1,2\n", "line 1: not a header of a timeline; expected onset_sample or onset_s"),
        (
            "id,onset\nx,1\n",
            "line 1: no column onset_sample or onset_s; expected one of them or both, found: id, onset",
        ),
        ("onset_s,id,id\n1,a,b\n", "line 1: two columns are called 'id'; expected each once"),
        ("id,onset_s\na,1\nb,-0.5\n", "line 3: onset_s = '-0.5': expected a time from 0, the first frame of the track"),
        ("onset_sample\n-1\n", "line 2: onset_sample = '-1': expected a sample from 0"),
        (
            "onset_sample\n1.5\n",
            "line 2: onset_sample = '1.5': expected a whole number of samples, with all its digits",
        ),
        ("onset_sample\n1.2E+08\n", "line 2: onset_sample = '1.2E+08': expected a whole number of samples"),
        ("id,onset_s\na,soon\n", "line 2: onset_s = 'soon': expected a number of seconds"),
        (
            "id,onset_s\na,01:00:19:18\n",
            "line 2: onset_s = '01:00:19:18': expected a number of seconds from the film's first sample, "
            "such as 19.75, and no timecode",
        ),
        ('id,onset_s\na,"1,5"\n', "line 2: onset_s = '1,5': expected a number"),
        ("id;onset_s\na;1.234,5\n", "line 2: onset_s = '1.234,5': expected a number"),
        ("id;onset_sample\na;48.000\n", "line 2: onset_sample = '48.000': expected a whole number of samples, without"),
        ("id,onset_sample\na,48.000\n", "line 2: onset_sample = '48.000': expected a whole number of samples, without"),
        ("onset_s\nnan\n", "line 2: onset_s = 'nan': expected a number"),
        ("onset_s\n1e999999999\n", "line 2: onset_s = '1e999999999': expected a number"),
        ("onset_s\n1_0\n", "line 2: onset_s = '1_0': expected a number"),
        ("id,onset_s\na,\n", "line 2: no onset; expected a time in onset_sample or onset_s"),
        (
            "id,onset_s,timecode\na,,01:00:19:18\n",
            "line 2: no onset; expected a time in onset_sample or onset_s; timecode is not read",
        ),
        ("id,onset_s\na,1,5\n", "line 2: 3 cells; expected 2, as many as the header has columns"),
        ('id,onset_s\n"a,1\n', "line 2: not a row of a table"),
        ("id,onset_s\na,1\nb,2\na,3\n", "line 4: id = 'a': line 2 has it too; expected each once"),
        ("id,onset_s\na,1\nb,1\n", "line 3: onset_s = '1', sample 48000: line 2 has it too; expected each once"),
        ("onset_s\n2.5\n2.500001\n", "line 3: onset_s = '2.500001', sample 120000: line 2 has it too; expected each"),
        ("onset_sample\n48000\n48000\n", "line 3: onset_sample = 48000: line 2 has it too; expected each once"),
        ("onset_s,confidence\n1,1.5\n", "line 2: confidence = 1.5: expected 0 to 1"),
        ("onset_s,confidence\n1,high\n", "line 2: confidence = 'high': expected a number"),
        ("onset_s,gain_db\n1,99\n", "line 2: gain_db = 99: expected -60 to 24 dB"),
        ("onset_s,origin\n1,me\n", "line 2: origin = 'me': expected one of: found, moved, added"),
        (
            "id,onset_sample,onset_s\na,48000,1.5\n",
            "line 2: onset_sample = 48000 and onset_s = 1.5 contradict each other: that is sample 72000 at 48000 Hz; ",
        ),
        ("onset_s,window_stop_s\n1,0.5\n", "line 2: window_stop_s = 0.5: expected more than 1, the onset"),
        ("onset_s,window_start_s\n1,1.5\n", "line 2: window_start_s = 1.5: expected at most 1, the onset"),
        ("#,Name,Start\nM1,a,1.0\n", "line 1: no column End; expected #,Name,Start,End,Length"),
        ("#,Name,Start,End\nX1,a,1.0,\n", "line 2: # = 'X1': expected M and a number for a marker, R and a number"),
        ("#,Name,Start,End\nR1,a,1.0,\n", "line 2: End = '': expected a time, where the region ends"),
        ("#,Name,Start,End\nR1,a,2.0,1.0\n", "line 2: End = '1.0': expected a time from 2.0, where the region starts"),
        ("#,Name,Start,End\nM1,a,,\n", "line 2: Start = '': expected a time"),
        ("#,Name,Start,End\nM1,a,-0:01.000,\n", "line 2: Start = '-0:01.000': expected a time from 0"),
        ("#,Name,Start,End\nM1,a,01:00:01:12,\n", "line 2: Start = '01:00:01:12': expected a time to the millisecond"),
        ("#,Name,Start,End\nM1,a,01:00:01;12,\n", "line 2: Start = '01:00:01;12': expected a time to the millisecond"),
        (
            "#,Name,Start,End\nM1,a,5.1.00,\n",
            "line 2: Start = '5.1.00': expected a time to the millisecond or the sample",
        ),
        ("#,Name,Start,End\nM1,shot-1 a,1.0,\nM2,shot-1 b,2.0,\n", "line 3: id = 'shot-1': line 2 has it too"),
        (
            "#,Name,Start,End\nM1,a,0:05.000,\nM2,b,0:05.000,\n",
            "line 3: Start = '0:05.000', sample 240000: line 2 has it",
        ),
        (
            "#,Name,Start,End\nR1,a,1:05.0,1:05.0\n",
            "line 2: End = '1:05.0': expected more than Start = '1:05.0', the onset",
        ),
        ("#,Name,Start,End\nR1,a,500,500\n", "line 2: End = '500': expected more than Start = '500', the onset"),
        (
            b"onset_s\n1\0\n",
            f"not text; expected {READ}",
        ),
        ("{}", "JSON without schema = 'blastline.timeline/1'; expected an edited timeline: timeline.json, "),
    ],
)
def test_a_table_that_cannot_be_used_is_refused(tmp_path: Path, text: str | bytes, complaint: str) -> None:
    assert refusal(tmp_path, text).startswith(complaint)


WHOLE = (
    "id,onset_sample,onset_s,gain_db\r\nshot-0001,48000,1.0,0.0\r\nshot-0002,150300,3.13125,-6.0",
    "#,Name,Start,End,Length\nR1,shot-0001,0:01.000,0:01.500,0:00.500\nR2,shot-0002,0:02.000,0:02.500,0:00.500",
)


@pytest.mark.parametrize("whole", WHOLE, ids=["table", "reaper"])
def test_a_table_that_was_cut_off_in_a_row_is_refused(tmp_path: Path, whole: str) -> None:
    """What is left of a number is a number, and would put the shot elsewhere; the last cell alone cannot be told."""
    after_header = whole.index("\n") + 1
    for stop in range(after_header + 1, len(whole)):
        kept = whole[:stop]
        last = kept.splitlines()[-1]
        if kept.endswith(("\r", "\n")) or last.count(",") == whole.splitlines()[0].count(","):
            continue
        told = refusal(tmp_path, kept)
        assert told.startswith(f"line {len(kept.splitlines())}: the file ends in it, after {last.rpartition(',')[2]!r}")


@pytest.mark.parametrize("whole", WHOLE, ids=["table", "reaper"])
@pytest.mark.parametrize("end", ["", "\n", "\r\n", "\n\n", "\n,,,", "\n \t"])
def test_a_whole_last_row_needs_no_line_end(tmp_path: Path, whole: str, end: str) -> None:
    assert len(read(tmp_path, whole + end).edits) == 2


def test_a_short_row_that_a_line_end_follows_is_whole(tmp_path: Path) -> None:
    assert len(read(tmp_path, "onset_s,id,gain_db\n1.5\n2.5,b\n\n").edits) == 2
    assert len(read(tmp_path, "onset_s,id,gain_db\n1.5\n2.5,b\n,,,").edits) == 2


@pytest.mark.parametrize("name", ["edited.csv", "edited.tsv", "edited.txt"])
@pytest.mark.parametrize("text", ["sep=;\n", "sep=;", "sep=;\n;;;\n", 'sep=;\n""; \n\n'])
def test_a_table_without_a_filled_cell_is_refused(tmp_path: Path, name: str, text: str) -> None:
    assert refusal(tmp_path, text, name).startswith("line 1: no header; expected onset_sample or onset_s")


@pytest.mark.parametrize("text", [",,,", ",,,\n,\n", '""', '"",""\n', "\t\t\n", " , \r\n"])
def test_a_csv_of_blank_cells_is_refused(tmp_path: Path, text: str) -> None:
    assert refusal(tmp_path, text).startswith("line 1: no header; expected onset_sample or onset_s")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("hello\n", "line 1: 'hello': expected start, end and text, separated by tabs"),
        ("1.0 2.0 a\n", "line 1: '1.0 2.0 a': expected start, end and text, separated by tabs"),
        ("1.0\t2.0\ta\nx\t2.0\tb\n", "line 2: start = 'x': expected a number"),
        ("-1.0\t2.0\ta\n", "line 1: start = '-1.0': expected a time from 0, the first frame of the track"),
        ("2.0\t1.0\ta\n", "line 1: end = '1.0': expected a time from 2.0, where the label starts"),
        (
            "1.0\t1.0\tshot-0001 0.9\n2.0\t2.0\tshot-0001 0.9\n",
            "line 2: id = 'shot-0001': line 1 has it too; expected each once",
        ),
    ],
)
def test_labels_that_cannot_be_used_are_refused(tmp_path: Path, text: str, complaint: str) -> None:
    assert refusal(tmp_path, text, "labels.txt").startswith(complaint)


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("resolve", "an EDL"),
        ("cmx3600", "an EDL"),
        ("fcp7", "Final Cut Pro 7 XML"),
        ("fcpxml", "FCPXML"),
        ("otio", "OpenTimelineIO"),
        ("midi", "a MIDI file"),
        ("schema", "a JSON Schema"),
        ("webvtt", "subtitles"),
        ("avid", "Avid's markers"),
    ],
)
def test_a_file_for_a_tool_that_is_not_read_back_is_called_by_what_it_is(tmp_path: Path, name: str, what: str) -> None:
    (file,) = export_timeline(timeline(SHOT, BURST_SHOT), tmp_path, formats=[name])
    found = refusal(tmp_path, file.read_bytes(), f"edited{file.suffix}")
    assert found == f"{what}; expected {READ}"
    with pytest.raises(TimelineError, match=re.escape(f"{file}: {what}; expected a timeline.json")):
        read_timeline(file)


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"RIFF\x24\x08\x00\x00WAVEfmt ", "a WAV file"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "an AAF file or an old Office document"),
        (b"PK\x03\x04\x14\x00", "a workbook or another zip file"),
        (b"\x00\x00\x00\x20ftypisom", "an MP4 or QuickTime film"),
        (b"\x1a\x45\xdf\xa3\x01\x00", "a Matroska film"),
        (b'{"Version": 1.0, "Pattern": []}', "a Core Haptics pattern"),
        (b'{"schema": "blastline.truth/1", "shots": []}', "the truth about a scene's shots"),
        (b"<!DOCTYPE html><html></html>", "a web page"),
        (b"<REAPER_PROJECT 0.1\n>", "a REAPER project"),
        (b"001  AX       V     C        01:00:00:00 01:00:01:00 01:00:00:00 01:00:01:00\n", "an EDL"),
        (b"1\r\n00:00:01,000 --> 00:00:02,000\r\nbang\r\n", "subtitles"),
    ],
)
def test_what_another_program_writes_is_called_by_what_it_is(tmp_path: Path, content: bytes, what: str) -> None:
    assert refusal(tmp_path, content, "edited.txt") == f"{what}; expected {READ}"


@pytest.mark.parametrize("text", ["100\t200\tV C x\n", "1.0\t2.0\tTITLE: x\n", "1\t2\t<a>\n"])
def test_a_label_that_reads_like_another_tools_file_is_a_label(tmp_path: Path, text: str) -> None:
    (tmp_path / "labels.txt").write_text(text)
    assert len(read_edits(tmp_path / "labels.txt").edits) == 1


@pytest.mark.parametrize("name", ["csv", "audacity", "reaper"])
def test_an_edited_table_is_told_where_it_can_be_read(tmp_path: Path, name: str) -> None:
    (file,) = export_timeline(timeline(SHOT, BURST_SHOT), tmp_path, formats=[name])
    with pytest.raises(
        TimelineError, match=r"which only `blastline render --timeline` reads; expected a timeline\.json"
    ):
        read_timeline(file)


@pytest.mark.parametrize(
    ("edit", "complaint"),
    [
        (
            lambda t: t.update(schema="blastline.timeline/2", version="9.0"),
            "schema = 'blastline.timeline/2', written by",
        ),
        (
            lambda t: t["events"][1].pop("onset_s") and t["events"][1].pop("onset_sample"),
            "events[1]: no onset; expected",
        ),
        (lambda t: t["events"][1].update(onset_s=-1.0), "events[1].onset_s = -1.0: expected a number, 0 or more"),
        (lambda t: t["events"][1].update(onset_sample="2"), "events[1].onset_sample = '2': expected a whole number"),
        (lambda t: t["events"][1].update(id="a\0b"), "events[1].id = 'a\\x00b': expected a text without NUL"),
        (lambda t: t["events"][1].update(id="shot-0001"), "events[1]: id = 'shot-0001': events[0] has it too"),
        (
            lambda t: t["events"][1]["window"].update(stop_sample=5),
            "events[1]: window_stop_sample = 5: expected more than 96000",
        ),
        (
            lambda t: t["events"][1].update(onset_sample=90_000, onset_s=1.0),
            "events[1]: onset_sample = 90000 and onset_s = 1 contradict each other",
        ),
    ],
)
def test_a_document_that_cannot_be_used_is_refused(
    tmp_path: Path, edit: Callable[[dict[str, Any]], object], complaint: str
) -> None:
    plain = json.loads(encode(timeline()))
    edit(plain)
    assert refusal(tmp_path, json.dumps(plain), "edited.json").startswith(complaint)


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TimelineError, match=re.escape(f"{tmp_path / 'none.csv'}: no such file; expected an edited")):
        read_edits(tmp_path / "none.csv")
    with pytest.raises(TimelineError, match="cannot be read: Is a directory"):
        read_edits(tmp_path)


def test_every_export_is_read_by_its_file_name_as_it_is(tmp_path: Path) -> None:
    for file in export_timeline(timeline(), tmp_path, formats=["json", "csv", "audacity"]):
        assert samples(read_edits(file)) == [SHOT.onset_sample, BURST_SHOT.onset_sample]
