"""The film's timecode on the command line: said by the user, asked for where it is needed, told where it rounds."""

import json
import re
import struct
from fractions import Fraction
from pathlib import Path

import pytest
import soundfile
import wavinfo

from blastline.export import FORMATS, HAPTIC_FORMATS, known_formats, read_timeline
from blastline.export.frames import FRAME_FORMATS
from blastline.model import encode
from commands import BELIEVE, RATE_HZ, blastline, write_film
from films import COUNTINGS, film
from media import impulses, write_media


@pytest.fixture(scope="module")
def mix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_film(tmp_path_factory.mktemp("mix") / "mix.wav", length_s=2.5, shots_s=(1.0,))


@pytest.fixture(scope="module")
def rules(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rules")
    (folder / "quality").mkdir()
    (folder / "quality" / "draft.toml").write_text(BELIEVE)
    return folder


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    file = tmp_path / "timeline.json"
    file.write_bytes(encode(film(COUNTINGS[1], onsets=[999, 48_000])))
    return file


def test_a_mix_gets_timecode_and_frame_formats_when_the_rate_is_said(mix: Path, rules: Path, tmp_path: Path) -> None:
    ended = blastline(
        *("render", mix, "-o", tmp_path / "out", "--quality", "draft", "--rules", rules),
        *("--frame-rate", "23.976", "--start-timecode", "01:00:00:00", "--format", ",".join(FORMATS)),
    )
    assert ended.code == 0, ended
    told = [line for line in ended.err.splitlines() if "whole frames" in line]
    assert [line.split(":")[0].split(", ") for line in told] == [[name for name in FORMATS if name in FRAME_FORMATS]]
    timeline = read_timeline(tmp_path / "out" / "timeline.json")
    assert (timeline.source.start_timecode, timeline.source.frame_rate) == ("01:00:00:00", "24000/1001")
    assert timeline.events[0].timecode == "01:00:01:00"
    reference = wavinfo.WavInfoReader(str(tmp_path / "out" / "drive.wav")).bext.time_reference
    assert reference == 3603.6 * RATE_HZ
    report = (tmp_path / "out" / "report.html").read_text("utf-8")
    for known in FORMATS.values():
        assert f'<a href="{known.file_name}">' in report
        assert (tmp_path / "out" / known.file_name).exists()
    assert blastline("check", tmp_path / "out", "--audio", mix, "--quiet").code == 0


@pytest.mark.parametrize(("said", "early"), [(None, True), ("01:00:00:00", False)])
def test_sound_before_the_picture_is_stamped_where_it_plays_or_else_it_is_told(
    rules: Path, tmp_path: Path, said: str | None, early: bool
) -> None:
    """A time stamp cannot be before midnight; a drive that is placed by one which is too late would lag the film."""
    movie = write_media(
        tmp_path / "film.mkv",
        [impulses(96_000, [48_000])],
        codec="pcm_s16le",
        picture_rate=Fraction(24),
        timecode=said,
        audio_delay_s=-0.5,
    )
    common = ("--quality", "draft", "--rules", rules, "--no-report", "--quiet")
    ended = blastline("render", movie, "-o", tmp_path / "out", *common)
    source = read_timeline(tmp_path / "out" / "timeline.json").source
    assert source.start_offset_s == -0.5
    stamp_s = wavinfo.WavInfoReader(str(tmp_path / "out" / "drive.wav")).bext.time_reference / RATE_HZ
    warnings = [line for line in ended.err.splitlines() if "before 00:00:00" in line]
    if early:
        assert stamp_s == 0.0
        assert len(warnings) == 1
        assert warnings[0].startswith("warning: the sound begins 0.500 s before 00:00:00")
        assert source.warnings == (warnings[0].removeprefix("warning: "),)
    else:
        assert stamp_s == 3599.5
        assert (warnings, source.warnings) == ([], ())


def test_an_edited_timeline_keeps_a_start_that_was_said_as_a_clock(mix: Path, rules: Path, tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    said = ("--frame-rate", "29.97df", "--start-timecode", "01:00:00.250")
    common = ("--quality", "draft", "--rules", rules, "--no-report")
    assert blastline("render", mix, "-o", first, *said, *common).code == 0
    assert blastline("render", mix, "-o", second, "--timeline", first / "timeline.json", *common).code == 0
    earlier, later = (read_timeline(folder / "timeline.json") for folder in (first, second))
    assert later.source == earlier.source
    assert [event.timecode for event in later.events] == [event.timecode for event in earlier.events]
    assert earlier.events[0].timecode.startswith("01:00:01;")


def test_a_film_that_is_too_long_for_an_edl_is_refused_before_it_is_heard(tmp_path: Path) -> None:
    rate_hz, head = 8000, 44
    frames = 24 * 3600 * rate_hz
    said = (b"RIFF", head - 8 + frames, b"WAVEfmt ", 16, 1, 1, rate_hz, rate_hz, 1, 8, b"data", frames)
    with (tmp_path / "long.wav").open("wb") as file:
        file.write(struct.pack("<4sI8sIHHIIHH4sI", *said))
        file.truncate(head + frames)  # a hole, which takes no room
    words = ("--format", "json,cmx3600", "--frame-rate", "24", "--quiet")
    complaint = blastline("render", tmp_path / "long.wav", "-o", tmp_path / "out", *words).complaint
    assert complaint.startswith("--format cmx3600: long.wav lasts 24:00:00.000; ")
    assert not (tmp_path / "out").exists()


def test_a_mix_without_a_frame_rate_is_refused_before_it_is_heard(mix: Path, tmp_path: Path) -> None:
    ended = blastline("render", mix, "-o", tmp_path / "out", "--format", "json,resolve", "--quiet")
    assert ended.complaint == "--format resolve: mix.wav has no frame rate; give the film's, such as --frame-rate 24"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ("--frame-rate fast", "--frame-rate 'fast': no rate of film timecode"),
        ("--start-timecode 1:00", "--start-timecode '1:00': expected HH:MM:SS:FF"),
        ("--start-timecode 01:00:00:00", "the film has no frame rate; give --frame-rate as well"),
        ("--start-timecode 00:01:00;00 --frame-rate 29.97", "drop-frame has no such number"),
    ],
)
@pytest.mark.parametrize("command", ["render", "detect"])
def test_timecode_that_cannot_be_is_one_line(
    mix: Path, tmp_path: Path, command: str, words: str, complaint: str
) -> None:
    assert complaint in blastline(command, mix, "-o", tmp_path / "out", *words.split(), "--quiet").complaint
    assert not (tmp_path / "out").exists()


def test_detect_names_events_by_the_users_timecode(mix: Path, rules: Path) -> None:
    words = ("--quality", "draft", "--rules", rules, "--frame-rate", "29.97df", "--start-timecode", "00:59:59;00")
    ended = blastline("detect", mix, *words, "--quiet")
    [event, *_] = json.loads(ended.out)["events"]
    assert event["timecode"] == "01:00:00;00"


def test_export_tells_what_rounding_moves_and_is_quiet_when_asked(saved: Path, tmp_path: Path) -> None:
    ended = blastline("export", saved, "--format", "otio,avid,webvtt,csv", "-o", tmp_path / "cues")
    assert ended.code == 0
    assert ended.out.splitlines() == [
        str(tmp_path / "cues" / FORMATS[name].file_name) for name in ("otio", "avid", "webvtt", "csv")
    ]
    assert ended.err.splitlines() == [
        "otio, avid: times are whole frames, 24 a second, at most 20.83 ms off; "
        "shot-0001 moves farthest, by -20.812 ms",
        "webvtt: times are whole milliseconds; shot-0001 moves farthest, by +0.188 ms",
    ]
    quiet = blastline("export", saved, "--format", "otio", "-o", tmp_path / "cues", "--overwrite", "--quiet")
    assert (quiet.code, quiet.err) == (0, "")


def test_export_takes_another_timecode(saved: Path, tmp_path: Path) -> None:
    words = ("--frame-rate", "25", "--start-timecode", "10:00:00:00")
    assert blastline("export", saved, "--format", "json,avid", "-o", tmp_path / "cues", *words).code == 0
    written = read_timeline(tmp_path / "cues" / "timeline.json")
    assert [event.timecode for event in written.events] == ["10:00:00:01", "10:00:01:00"]
    assert "10:00:01:00" in (tmp_path / "cues" / "timeline.avid.txt").read_text("utf-8")
    assert [event.onset_sample for event in written.events] == [999, 48_000]


def test_formats_lists_each_with_its_tool() -> None:
    told = re.split(r"\n(?=\S)", blastline("formats").out.rstrip())
    assert [each.split()[0] for each in told] == [*FORMATS, *HAPTIC_FORMATS]
    for known, (first, *more) in zip(
        known_formats((*FORMATS, *HAPTIC_FORMATS)), map(str.splitlines, told), strict=True
    ):
        assert known.files[0] in first
        assert more[-1].strip() == known.tool


def test_formats_has_its_exactness_in_one_column() -> None:
    lines = blastline("formats").out.splitlines()
    exact = [known.exactness for known in known_formats((*FORMATS, *HAPTIC_FORMATS))]
    ends = [line for line in lines if line.endswith(tuple(exact))]
    assert {len(line) - max(len(each) for each in exact if line.endswith(each)) for line in ends} == {35}


def test_the_drive_of_a_broadcast_wave_keeps_its_time_of_day(rules: Path, mix: Path, tmp_path: Path) -> None:
    """A rate alone names the frames; the time reference stays the file's own, to the sample."""
    samples, rate_hz = soundfile.read(mix)
    first = blastline(
        "render",
        mix,
        "-o",
        tmp_path / "a",
        "--quality",
        "draft",
        "--rules",
        rules,
        "--frame-rate",
        "25",
        "--start-timecode",
        "10:00:00:07",
        "--format",
        "json",
        "--no-report",
    )
    assert first.code == 0, first
    stamped = tmp_path / "a" / "drive.wav"  # a broadcast wave with 10:00:00:07 at 25 frames a second
    again = blastline("detect", stamped, "--quality", "draft", "--rules", rules, "--frame-rate", "24", "--quiet")
    source = json.loads(again.out)["source"]
    assert source["start_timecode"] == "10:00:00.280000"
    assert (len(samples), rate_hz) == (source["frames"], RATE_HZ)
