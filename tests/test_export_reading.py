"""A timeline that cannot be used is refused in one line: the file, the place, the value and what was expected."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given

from blastline.errors import TimelineError
from blastline.export import export_timeline, read_timeline
from blastline.model import Timeline, encode
from timelines import any_timeline, timeline

Edit = Callable[[dict[str, Any]], object]


def refusal(file: Path) -> str:
    """Return the one line with which a file is refused."""
    with pytest.raises(TimelineError, match=re.escape(f"{file}: ")) as raised:
        read_timeline(file)
    assert "\n" not in str(raised.value)
    return str(raised.value).removeprefix(f"{file}: ")


@pytest.mark.parametrize(
    ("edit", "complaint"),
    [
        (
            lambda t: t.update(schema="blastline.timeline/2", version="9.0"),
            "schema = 'blastline.timeline/2', written by",
        ),
        (lambda t: t.update(schema="blastline.timeline/2"), "this version reads only 'blastline.timeline/1'"),
        (lambda t: t.update(schema=1), "schema = 1"),
        (lambda t: t.pop("schema"), "JSON without schema = 'blastline.timeline/1'"),
        (lambda t: t.pop("source"), "source: is missing"),
        (lambda t: t.update(quality="best"), "quality = 'best': expected one of: draft, reference, standard"),
        (lambda t: t["events"][1].pop("onset_s"), "events[1].onset_s: is missing"),
        (lambda t: t["events"][1].update(onset_s="2"), "events[1].onset_s = '2': expected a number, not a text"),
        (
            lambda t: t["events"][0].update(onset_sample=-1),
            "events[0].onset_sample = -1: expected a whole number, 0 or more",
        ),
        (
            lambda t: t["events"][0].update(onset_sample=0.5),
            "events[0].onset_sample = 0.5: expected a whole number, not one with decimals",
        ),
        (lambda t: t["events"][0].update(onset_s=-0.5), "events[0].onset_s = -0.5: expected a time from 0"),
        (lambda t: t["events"][0].update(confidence=1.5), "events[0].confidence = 1.5: expected a number, 1 or less"),
        (lambda t: t["events"][0].update(id="shot-0002"), "events[1].id = 'shot-0002': events[0] has it too"),
        (
            lambda t: t["events"][0]["blast"].update(start_sample=-5),
            "events[0].blast.start_sample = -5: expected a time",
        ),
        (
            lambda t: t["events"][0]["blast"].update(start_sample=10**9),
            "events[0].blast: a span must not run backwards",
        ),
        (
            lambda t: t["events"][0]["reflections"][1].update(delay_ms=-2.0),
            "events[0].reflections[1].delay_ms = -2.0: expected a time from 0",
        ),
        (
            lambda t: t["events"][0]["window"].update(fade_in_samples=None),
            "window.fade_in_samples = null: expected a whole number",
        ),
        (
            lambda t: t["rejections"][0]["evidence"].update(probability="x"),
            "rejections[0].evidence.probability = 'x': expected a number",
        ),
        (
            lambda t: t["source"].update(sample_rate_hz=0),
            "source.sample_rate_hz = 0: expected a whole number, 1 or more",
        ),
        (
            lambda t: t["source"].update(start_timecode="junk"),
            "source.start_timecode = 'junk': expected HH:MM:SS:FF, HH:MM:SS;FF, HH:MM:SS.mmm or null",
        ),
        (lambda t: t["source"].update(start_timecode=""), "source.start_timecode = ''"),
        (
            lambda t: t["source"].update(frame_rate="fast"),
            "source.frame_rate = 'fast': expected frames a second, such as 25 or 24000/1001, or null",
        ),
        (lambda t: t["source"].update(frame_rate="24/0"), "source.frame_rate = '24/0'"),
        (lambda t: t["source"].update(frame_rate="0"), "source.frame_rate = '0'"),
        (
            lambda t: t["source"].update(frames=90_000),
            "events[1].onset_sample = 96000: expected a sample of the film, which has 90000 frames, 1.875 s",
        ),
        (
            lambda t: t["events"][0].update(onset_s=407.0),
            "events[0].onset_s = 407.0: expected 1.0000208333333334, where onset_sample = 48001 plays",
        ),
        (lambda t: t["events"][0].update(onset_s=48_001.6 / 48_000), "events[0].onset_s = 1.0000333"),
        (
            lambda t: t["events"][0]["window"].update(start_sample=72_000, stop_sample=47_713),
            "events[0].window.start_sample = 72000: expected at most 48001, the onset",
        ),
        (
            lambda t: t["events"][1]["window"].update(start_sample=96_000, stop_sample=96_000),
            "events[1].window.stop_sample = 96000: expected more than 96000, the onset",
        ),
        (
            lambda t: t["events"][1]["window"].update(start_sample=96_001),
            "events[1].window.start_sample = 96001: expected at most 96000, the onset",
        ),
        (
            lambda t: t["events"][1]["window"].update(stop_sample=96_000),
            "events[1].window.stop_sample = 96000: expected more than 96000, the onset",
        ),
        (
            lambda t: t["events"][1]["window"].update(stop_sample=120_001),
            "events[1].window.stop_sample = 120001: expected an end in the film, which has 120000 frames, 2.5 s",
        ),
        (
            lambda t: t["events"][1]["window"].update(fade_in_samples=3_000),
            "fade_in_samples = 3000 and fade_out_samples = 1920: expected fades that its 4288 samples have room for",
        ),
        (
            lambda t: t["events"][0]["reflections"][1].update(stop_sample=52_000),
            "events[0].reflections[1].stop_sample = 52000: expected at least start_sample = 52001",
        ),
        (
            lambda t: t["rejections"][0].update(at_sample=2**63),
            "rejections[0].at_sample = 9223372036854775808: expected a whole number up to 2^53",
        ),
        (lambda t: t["events"][0].update(gain_db=1e300), "events[0].gain_db = 1e+300: expected -60 to 24 dB"),
        (
            lambda t: t["source"].update(start_offset_s=-1e300),
            "source.start_offset_s = -1e+300: expected -1e+09 to 1e+09 s",
        ),
        (lambda t: t["events"][0]["blast"].update(stop_sample=2**70), "events[0].blast.stop_sample = 1180591620717"),
    ],
)
def test_a_field_that_does_not_fit_is_named(tmp_path: Path, edit: Edit, complaint: str) -> None:
    plain = json.loads(encode(timeline()))
    edit(plain)
    file = tmp_path / "timeline.json"
    file.write_text(json.dumps(plain))
    assert complaint in refusal(file)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "an empty file"),
        (b"RIFF\xff\x00\x00\x00WAVE", "a WAV file; expected a timeline.json"),
        (encode(timeline())[:-20], "not JSON: it ends too early"),
        (b'{"schema": 1,\n "e": \xc3\xa9 12,5}', "line 2, column 7: not JSON: invalid character"),
        (b'{"schema": NaN}', "not JSON"),
        (b'{"events": [{"onset_s": 1.5,}]}', "line 1, column 29: not JSON: "),
        (b'[{"onset_sample": 4800}, ', "not JSON: it ends too early"),
        (b"[" * 100_000, "not JSON"),
        (b"[]", "JSON without schema"),
        (b"3", "JSON without schema"),
        (b"{}", "JSON without schema"),
    ],
)
def test_a_file_that_is_no_timeline_is_refused(tmp_path: Path, content: bytes, complaint: str) -> None:
    file = tmp_path / "timeline.json"
    file.write_bytes(content)
    assert complaint in refusal(file)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_a_timeline_is_read_in_every_encoding_that_shells_write(tmp_path: Path, encoding: str) -> None:
    whole = timeline()
    whole = msgspec.structs.replace(whole, source=msgspec.structs.replace(whole.source, name="réel 日本.mkv"))
    file = tmp_path / "timeline.json"
    file.write_bytes(encode(whole).decode().replace("\n", "\r\n").encode(encoding))
    assert read_timeline(file) == whole


def test_a_file_that_is_not_there_and_a_folder_are_refused(tmp_path: Path) -> None:
    assert refusal(tmp_path / "none.json") == "no such file; expected a timeline.json"
    assert refusal(tmp_path).startswith("cannot be read: Is a directory")


@pytest.mark.parametrize(
    "edit",
    [
        lambda t: t["source"].update(frames=0),
        lambda t: t["source"].update(frames=100_000),
        lambda t: t["source"].update(frame_rate=None, start_timecode=None),
        lambda t: t["source"].update(start_timecode="10:00:00.040"),
        lambda t: t["source"].update(start_timecode="00:75:00;99"),
        lambda t: t["events"][0].update(onset_s=48_001.49 / 48_000),
        lambda t: t["events"][1]["window"].update(start_sample=96_000, stop_sample=96_001, fade_out_samples=0),
        lambda t: t["events"][1]["window"].update(fade_in_samples=2_368),
    ],
    ids=["unknown length", "to the end", "no timecode", "clock", "as the film says", "onset", "one sample", "fades"],
)
def test_what_is_just_possible_is_read(tmp_path: Path, edit: Edit) -> None:
    plain = json.loads(encode(timeline()))
    plain["events"][1]["window"].update(fade_in_samples=0)
    edit(plain)
    file = tmp_path / "timeline.json"
    file.write_text(json.dumps(plain))
    assert json.loads(encode(read_timeline(file))) == plain


@given(any_timeline())
def test_what_is_written_is_read(tmp_path_factory: pytest.TempPathFactory, written: Timeline) -> None:
    file = tmp_path_factory.getbasetemp() / "written.json"
    file.write_bytes(encode(written))
    assert read_timeline(file) == written


def test_a_key_of_a_later_minor_version_is_let_pass(tmp_path: Path) -> None:
    plain = json.loads(encode(timeline()))
    plain["events"][0]["colour"] = "red"
    file = tmp_path / "timeline.json"
    file.write_text(json.dumps(plain))
    assert read_timeline(file) == timeline()


@pytest.mark.parametrize("start", ["01:00:00:00", "01:00:00;02", "01:00:00.5", "23:59:59.999", None])
def test_a_start_is_read_as_it_can_be_said(tmp_path: Path, start: str | None) -> None:
    film = timeline()
    source = msgspec.structs.replace(film.source, start_timecode=start, frame_rate="30000/1001")
    [file] = export_timeline(msgspec.structs.replace(film, source=source), tmp_path, formats=["json"])
    assert read_timeline(file).source.start_timecode == start
