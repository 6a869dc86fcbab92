"""Formats that count frames, read by what we did not write: every event within half a frame, its offset beside it."""

import io
import math
import re
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree

import msgspec
import opentimelineio as otio
import pycmx
import pytest

from blastline.errors import RuleError
from blastline.export import export_timeline, require_frame_rate, require_late_enough
from blastline.export.frames import FRAME_FORMATS
from blastline.export.rounding import rounding
from blastline.model import Timeline
from blastline.timebase import parse_timebase, retimed
from blastline.timecode import frames_per_day
from films import COUNTINGS, HOSTILE, ONSETS, Counting, film

Found = list[tuple[str, Fraction]]
"""Names or texts of markers with their times, in seconds of real time from the film's first frame."""

every_counting = pytest.mark.parametrize("counting", COUNTINGS, ids=lambda each: f"{each.rate}@{each.start}")


def written(timeline: Timeline, folder: Path, name: str) -> Path:
    [file] = export_timeline(timeline, folder, formats=[name])
    return file


def frames_of(timecode: str, counting: Counting) -> int:
    """Return a timecode's frame, by opentimelineio, from the film's first one; past midnight it counts on."""
    rate = float(counting.fraction)
    assert (";" in timecode) == counting.drop_frame
    frame, start = (round(otio.opentime.from_timecode(text, rate).value) for text in (timecode, counting.start))
    day = round(otio.opentime.from_timecode("23:59:59" + counting.start[8] + "00", rate).value) + round(rate)
    return int(frame - start) % int(day)


def assert_each_event_is_there(found: Found, timeline: Timeline, counting: Counting) -> None:
    """Check that each event has one marker that names it, at most half a frame away, which says how far."""
    half = Fraction(1, 2) / counting.fraction
    for event in timeline.events:
        [(text, time_s)] = [each for each in found if re.search(rf"\b{event.id}\b", each[0])]
        exact_s = Fraction(event.onset_sample, 48_000)
        assert abs(exact_s - time_s) <= half
        offsets = re.findall(r"[+-]\d+\.\d\d(?= ms)", text)
        assert any(abs(Fraction(offset) / 1000 - (exact_s - time_s)) <= Fraction(6, 10**6) for offset in offsets)
        if not re.search(r" \+ |; ", text):
            assert f"{event.confidence:.2f}" in text
            assert f"{event.peak_dbfs:.1f} dBFS" in text
            assert event.drive is None or event.drive.model in text


def resolve_markers(text: str, counting: Counting) -> list[tuple[str, str, str, Fraction, int]]:
    """Return the markers of a Resolve EDL by its rules: note, colour, name, time and frames."""
    title, fcm, empty, *rest = text.split("\n")
    assert title.startswith("TITLE: ")
    assert (fcm, empty) == ("FCM: DROP FRAME" if counting.drop_frame else "FCM: NON-DROP FRAME", "")
    clock = r"\d\d:\d\d:\d\d[:;]\d\d"
    found = []
    for number, (head, said, gap) in enumerate(zip(rest[::3], rest[1::3], rest[2::3], strict=False), start=1):
        match = re.fullmatch(rf"(\d{{3,}})  001      V     C        ({clock}) ({clock}) \2 \3  ", head)
        assert match
        assert int(match[1]) == number
        start, after = (frames_of(match[group], counting) for group in (2, 3))
        assert after == start + 1
        marker = re.fullmatch(r"([^|]*) \|C:ResolveColor(Red|Blue) \|M:([^|]+) \|D:([1-9]\d*)", said)
        assert marker
        assert gap == ""
        found.append((marker[1], marker[2], marker[3], start / counting.fraction, int(marker[4])))
    return found


@every_counting
def test_resolve(tmp_path: Path, counting: Counting) -> None:
    timeline = film(counting)
    text = written(timeline, tmp_path, "resolve").read_text("utf-8")
    markers = resolve_markers(text, counting)
    assert_each_event_is_there([(f"{n} {name}", time_s) for n, _, name, time_s, _ in markers], timeline, counting)
    assert len({time_s for *_, time_s, _ in markers}) == len(markers)
    edits = list(pycmx.parse_cmx3600(io.StringIO(text)).events)
    assert len(edits) == len(markers)
    for edit, (_, _, _, time_s, _) in zip(edits, markers, strict=True):
        assert frames_of(edit.edits[0].record_in, counting) / counting.fraction == time_s
    assert abs(markers[-1][-1] - counting.fraction / 2) <= 1


def test_events_on_one_frame_share_a_marker_that_names_them_all(tmp_path: Path) -> None:
    counting = COUNTINGS[1]
    timeline = film(counting, onsets=[48_000, 48_100, 48_200, 96_000])
    markers = resolve_markers(written(timeline, tmp_path, "resolve").read_text("utf-8"), counting)
    assert [len(re.findall("shot-", name)) for _, _, name, _, _ in markers] == [3, 1]
    last = timeline.events[2]
    lasts_s = Fraction(min(last.window.stop, 96_000) - last.onset_sample, 48_000)
    assert abs(markers[0][-1] - lasts_s * counting.fraction) <= 1, "as long as the longest of them"
    assert_each_event_is_there([(f"{n} {name}", time_s) for n, _, name, time_s, _ in markers], timeline, counting)
    lines = written(timeline, tmp_path, "avid").read_text("utf-8").splitlines()
    assert [line.count("shot-") for line in lines] == [3, 1]


@pytest.mark.parametrize("counting", [COUNTINGS[1], COUNTINGS[3], COUNTINGS[4]], ids=lambda each: each.rate)
@pytest.mark.parametrize("more", [-2, -1, 0, 1, 100_000])
def test_a_film_that_timecode_cannot_tell_the_days_of_is_refused_or_told(
    tmp_path: Path, counting: Counting, more: int
) -> None:
    """An EDL would have an edit of no length, or one too short by a day; two markers would have one timecode."""
    day = frames_per_day(math.ceil(counting.fraction), drop_frame=counting.drop_frame)
    frames = round((day + more) / counting.fraction * 48_000)
    timeline = film(counting, onsets=[0, frames - 48_000])
    timeline = msgspec.structs.replace(timeline, source=msgspec.structs.replace(timeline.source, frames=frames))
    edl = tmp_path / "timeline.cmx3600.edl"
    if more < 0:
        written(timeline, tmp_path, "cmx3600")
        [edit] = [line for line in edl.read_text("utf-8").splitlines() if line.startswith("001")]
        assert edit.split()[-1] != edit.split()[-2]
        assert frames_of(edit.split()[-1], counting) == day + more
    else:
        with pytest.raises(
            RuleError, match=r"--format cmx3600: film\.mkv lasts 2\d:\d\d:\d\d\.\d{3}; .* 24 hours of timecode"
        ):
            written(timeline, tmp_path, "cmx3600")
        assert not edl.exists()
    for name in ("resolve", "avid"):
        [line] = rounding(timeline, [name])
        assert ("one timecode may stand for two moments" in line) == (more > 0)
    for name in ("otio", "fcpxml"):
        [line] = rounding(timeline, [name])
        assert "two moments" not in line
    markers = fcpxml_markers(written(timeline, tmp_path, "fcpxml"), counting)
    assert_each_event_is_there(markers, timeline, counting)


@every_counting
def test_avid(tmp_path: Path, counting: Counting) -> None:
    timeline = film(counting)
    found = []
    for line in written(timeline, tmp_path, "avid").read_text("utf-8").split("\n")[:-1]:
        user, timecode, track, colour, comment, one = line.split("\t")
        assert (user, track, one) == ("blastline", "TC1", "1")
        assert colour in ("red", "blue")
        found.append((comment, frames_of(timecode, counting) / counting.fraction))
    assert_each_event_is_there(found, timeline, counting)


@every_counting
def test_cmx3600(tmp_path: Path, counting: Counting) -> None:
    timeline = film(counting)
    file = written(timeline, tmp_path, "cmx3600")
    text = file.read_text("utf-8")
    [event] = pycmx.parse_cmx3600(io.StringIO(text)).events
    [edit] = event.edits
    assert (edit.channels.video, edit.channels.audio) == (True, False)
    assert (edit.source, edit.clip_name, edit.record_in) == ("FILM", "film.mkv", counting.start)
    assert (edit.source_in, edit.source_out) == (edit.record_in, edit.record_out)
    length_s = frames_of(edit.record_out, counting) / counting.fraction
    assert abs(length_s - Fraction(timeline.source.frames, 48_000)) <= 1 / counting.fraction
    clock = r"\d\d:\d\d:\d\d" + counting.start[8] + r"\d\d"
    found = re.findall(rf"^\* LOC: ({clock}) (?:RED    |BLUE   ) (\S.*)$", text, re.MULTILINE)
    times = [(said, frames_of(timecode, counting) / counting.fraction) for timecode, said in found]
    assert len(times) == len(ONSETS)
    assert_each_event_is_there(times, timeline, counting)
    if not counting.drop_frame:  # the adapter does not read locators with a semicolon
        [clip] = otio.adapters.read_from_file(str(file), rate=float(counting.fraction)).find_clips()
        assert [marker.name for marker in clip.markers] == [said for _, said in found]
        start = clip.source_range.start_time
        read = [round((marker.marked_range.start_time - start).value) / counting.fraction for marker in clip.markers]
        assert read == [time_s for _, time_s in times]


def sequence_markers(sequence: Any, counting: Counting) -> Found:
    rate = float(counting.fraction)
    assert all(marker.marked_range.start_time.rate == pytest.approx(rate) for marker in sequence.tracks.markers)
    return [(_said(m), round(m.marked_range.start_time.value) / counting.fraction) for m in sequence.tracks.markers]


def _said(marker: Any) -> str:
    comment = marker.metadata.get("fcp_xml", {}).get("comment") or marker.comment
    return f"{marker.name} {comment}"


@every_counting
def test_otio(tmp_path: Path, counting: Counting) -> None:
    timeline = film(counting)
    sequence = otio.adapters.read_from_file(str(written(timeline, tmp_path, "otio")))
    assert (
        frames_of(sequence.global_start_time.to_timecode(float(counting.fraction), counting.drop_frame), counting) == 0
    )
    assert_each_event_is_there(sequence_markers(sequence, counting), timeline, counting)
    in_order = sorted(timeline.events, key=lambda event: event.onset_sample)
    for marker, event in zip(sequence.tracks.markers, in_order, strict=True):
        facts = marker.metadata["blastline"]
        assert (facts["id"], facts["onset_sample"]) == (event.id, event.onset_sample)
        assert (facts["burst"], facts["shot_in_burst"]) == (event.burst, event.shot_in_burst)
    video, audio = sequence.tracks
    assert (video.kind, audio.kind) == ("Video", "Audio")
    [clip] = video
    assert clip.source_range.start_time == sequence.global_start_time
    assert (clip.media_reference.target_url, clip.name) == ("film.mkv", "film.mkv")
    start = clip.source_range.start_time
    on_clip = [(_said(m), round((m.marked_range.start_time - start).value) / counting.fraction) for m in clip.markers]
    assert on_clip == sequence_markers(sequence, counting)


@every_counting
def test_fcp7(tmp_path: Path, counting: Counting) -> None:
    timeline = film(counting)
    file = written(timeline, tmp_path, "fcp7")
    sequence = otio.adapters.read_from_file(str(file), "fcp_xml")
    assert_each_event_is_there(sequence_markers(sequence, counting), timeline, counting)
    assert (
        frames_of(sequence.global_start_time.to_timecode(float(counting.fraction), counting.drop_frame), counting) == 0
    )
    [clip] = sequence.tracks[0]
    on_clip = [(_said(m), round(m.marked_range.start_time.value) / counting.fraction) for m in clip.markers]
    assert on_clip == sequence_markers(sequence, counting)
    root = ElementTree.parse(file).getroot()
    assert (root.tag, root.get("version")) == ("xmeml", "4")
    for timecode in root.iter("timecode"):
        assert timecode.findtext("string") == counting.start
        assert timecode.findtext("displayformat") == ("DF" if counting.drop_frame else "NDF")
    for rate in root.iter("rate"):
        ntsc = counting.fraction.denominator != 1
        assert rate.findtext("ntsc") == ("TRUE" if ntsc else "FALSE")
        assert Fraction(rate.findtext("timebase", "")) == round(counting.fraction)


@pytest.mark.parametrize("rate", ["24000/1001", "30000/1001", "48000/1001", "60000/1001"])
def test_fcp7_labels_a_start_shortly_before_midnight_as_the_film_does(tmp_path: Path, rate: str) -> None:
    """Non-drop timecode runs slower than the clock: 24 hours of it last 86 seconds longer."""
    timeline = film(Counting(rate, "23:59:50:00"), onsets=[0, 48_000])
    root = ElementTree.parse(written(timeline, tmp_path, "fcp7")).getroot()
    starts = [(each.findtext("string"), each.findtext("frame")) for each in root.iter("timecode")]
    assert starts
    assert set(starts) == {("23:59:50:00", str((24 * 3600 - 10) * math.ceil(Fraction(rate))))}


CHILDREN = {
    "fcpxml": ("resources", "event"),
    "resources": ("format", "asset"),
    "asset": ("media-rep",),
    "event": ("project",),
    "project": ("sequence",),
    "sequence": ("spine",),
    "format": (),
    "media-rep": (),
    "marker": (),
}
"""What FCPXML's published grammar lets us write: the children of each element, in this order."""

NEEDED = {
    "format": {"id"},
    "asset": {"id"},
    "media-rep": {"src"},
    "sequence": {"format"},
    "asset-clip": {"ref"},
    "gap": {"duration"},
    "marker": {"start", "value"},
}


def fcpxml_markers(file: Path, counting: Counting) -> Found:
    """Return the markers of an FCPXML file by the rules of its grammar, with real time from the film's first frame."""
    text = file.read_text("utf-8")
    assert text.startswith('<?xml version="1.0" encoding="UTF-8"?>\n<!DOCTYPE fcpxml>\n<fcpxml version="1.9">')
    root = ElementTree.fromstring(text)
    for element in root.iter():
        assert NEEDED.get(element.tag, set()) <= set(element.attrib)
        tags = tuple(child.tag for child in element)
        if element.tag in CHILDREN:
            assert tags == CHILDREN[element.tag]
        elif element.tag in ("asset-clip", "gap"):
            assert set(tags) <= {"marker"}
        else:
            assert element.tag == "spine"
            assert tags in (("asset-clip",), ("gap", "asset-clip"))
        for key in {"start", "duration", "offset", "tcStart", "frameDuration"} & set(element.attrib):
            assert re.fullmatch(r"-?\d+(/\d+)?s", element.attrib[key])
            frames = seconds(element.attrib[key]) * counting.fraction
            assert frames.denominator == 1  # Final Cut refuses what is not on a frame
    sequence = root.find(".//sequence")
    assert sequence is not None
    assert sequence.get("tcFormat") == ("DF" if counting.drop_frame else "NDF")
    start_s, end_s = seconds(sequence.attrib["tcStart"]), seconds(sequence.attrib["tcStart"])
    found = []
    for clip in root.findall(".//spine/*"):
        assert seconds(clip.attrib["offset"]) == end_s
        end_s += seconds(clip.attrib["duration"])
        shift_s = seconds(clip.attrib["offset"]) - seconds(clip.attrib["start"]) - start_s
        for marker in clip:
            time_s = seconds(marker.attrib["start"]) + shift_s
            assert seconds(clip.attrib["start"]) <= seconds(marker.attrib["start"])
            assert time_s + seconds(marker.attrib["duration"]) <= end_s - start_s
            found.append((f"{marker.attrib['value']} {marker.attrib['note']}", time_s))
    assert end_s - start_s == seconds(sequence.attrib["duration"])
    return found


def seconds(text: str) -> Fraction:
    return Fraction(text.removesuffix("s"))


@every_counting
def test_fcpxml(tmp_path: Path, counting: Counting) -> None:
    timeline = film(counting)
    file = written(timeline, tmp_path, "fcpxml")
    assert_each_event_is_there(fcpxml_markers(file, counting), timeline, counting)
    start_s = seconds(ElementTree.parse(file).getroot().findall(".//sequence")[0].attrib["tcStart"])
    first = otio.opentime.from_timecode(counting.start, float(counting.fraction))
    assert start_s == round(first.value) / counting.fraction
    if counting.rate == "24000/1001":
        assert 'frameDuration="1001/24000s"' in file.read_text("utf-8")


@pytest.mark.parametrize("start", ["10:00:00.001000", "10:00:00.019000", "10:00:00.021000", "10:00:00.039000"])
@pytest.mark.parametrize("rate", ["25", "24000/1001"])
def test_markers_keep_to_the_sound_of_a_clip_that_begins_between_two_frames(
    tmp_path: Path, start: str, rate: str
) -> None:
    counting = Counting(rate, start)
    timeline = film(counting, onsets=range(0, 96_000, 1_777), name="mix.wav", has_picture=False)
    assert_markers_keep_to_the_clip(timeline, counting, tmp_path)


@pytest.mark.parametrize("has_picture", [False, True])
@pytest.mark.parametrize("clock", ["01:00:00.010", "01:00:00.020", "00:59:59.999", "01:00:00.000"])
@pytest.mark.parametrize("rate", ["29.97df", "59.94df"])
def test_markers_keep_to_the_clip_where_a_clock_became_drop_frame(
    tmp_path: Path, rate: str, clock: str, has_picture: bool
) -> None:
    filmed = film(Counting("25", clock), onsets=range(0, 96_000, 1_777), name="mix.wav", has_picture=has_picture)
    timeline = retimed(filmed, parse_timebase(clock, rate))
    source = timeline.source
    assert source.start_timecode
    assert source.frame_rate
    counting = Counting(source.frame_rate, source.start_timecode)
    assert counting.drop_frame
    assert_markers_keep_to_the_clip(timeline, counting, tmp_path)
    half_ms = float(500 / counting.fraction)
    for line in rounding(timeline, ["otio", "fcp7", "fcpxml"]):
        moved = re.search(r"by ([+-]\d+\.\d+) ms$", line)
        assert moved
        assert abs(float(moved[1])) <= half_ms
        assert has_picture or "in the clip, which begins on the nearest frame" in line


def assert_markers_keep_to_the_clip(timeline: Timeline, counting: Counting, tmp_path: Path) -> None:
    """Check that in each format with a clip the markers are where its sound has the events."""
    found = fcpxml_markers(written(timeline, tmp_path, "fcpxml"), counting)
    assert_each_event_is_there(found, timeline, counting)
    for name in ("otio", "fcp7"):
        file = str(written(timeline, tmp_path, name))
        sequence = otio.adapters.read_from_file(file, "fcp_xml" if name == "fcp7" else None)
        assert_each_event_is_there(sequence_markers(sequence, counting), timeline, counting)
        [clip] = sequence.tracks[0]
        begins = 0 if name == "fcp7" else clip.source_range.start_time.value
        inside = [(_said(m), round(m.marked_range.start_time.value - begins) / counting.fraction) for m in clip.markers]
        assert_each_event_is_there(inside, timeline, counting)


def test_a_shot_before_the_picture_has_its_place(tmp_path: Path) -> None:
    counting, offset_s = Counting("25", "01:00:00:00"), -0.2
    timeline = film(counting, onsets=[480, 48_000], offset_s=offset_s)
    half = Fraction(1, 50)

    def near(found: list[Fraction], shift_s: Fraction) -> None:
        onsets = [Fraction(480, 48_000) - Fraction(1, 5), 1 - Fraction(1, 5)]
        assert len(found) == 2
        assert all(abs(time_s - shift_s - onset) <= half for time_s, onset in zip(found, onsets, strict=True))

    before_s = Fraction(5, 25)  # 0.19 s before the first picture: five frames
    near([time_s for _, time_s in fcpxml_markers(written(timeline, tmp_path, "fcpxml"), counting)], before_s)
    for name in ("otio", "fcp7"):
        sequence = otio.adapters.read_from_file(
            str(written(timeline, tmp_path, name)), "fcp_xml" if name == "fcp7" else None
        )
        assert sequence.global_start_time.to_timecode() == "00:59:59:20"
        near([time_s for _, time_s in sequence_markers(sequence, counting)], before_s)
        gap, clip = sequence.tracks[0]
        assert gap.duration().value == 5
        assert len(clip.markers) == 1
    for name in ("resolve", "avid", "cmx3600"):
        assert "00:59:59:20" in written(timeline, tmp_path, name).read_text("utf-8")


def test_timecode_goes_on_past_midnight(tmp_path: Path) -> None:
    counting = Counting("24", "23:59:59:00")
    timeline = film(counting, onsets=[0, 48_000, 96_000])
    markers = resolve_markers(written(timeline, tmp_path, "resolve").read_text("utf-8"), counting)
    assert [time_s for *_, time_s, _ in markers] == [0, 1, 2]
    for name in ("resolve", "avid", "cmx3600"):
        assert "00:00:00:00" in written(timeline, tmp_path, name).read_text("utf-8")
    assert [time_s for _, time_s in fcpxml_markers(written(timeline, tmp_path, "fcpxml"), counting)] == [0, 1, 2]
    for name, adapter in (("otio", None), ("fcp7", "fcp_xml")):
        sequence = otio.adapters.read_from_file(str(written(timeline, tmp_path, name)), adapter)
        assert [time_s for _, time_s in sequence_markers(sequence, counting)] == [0, 1, 2]


@pytest.mark.parametrize("name", sorted(FRAME_FORMATS))
def test_names_that_break_careless_writers(tmp_path: Path, name: str) -> None:
    counting = COUNTINGS[1]
    plain = film(counting, name=HOSTILE)
    odd = tuple(msgspec.structs.replace(event, id=f"{event.id} a|b\t<&>\n") for event in plain.events)
    timeline = msgspec.structs.replace(plain, events=odd)
    file = written(timeline, tmp_path, name)
    readers: dict[str, Callable[[], list[str]]] = {
        "resolve": lambda: [each[2] for each in resolve_markers(file.read_text("utf-8"), counting)],
        "avid": lambda: [line.split("\t")[4] for line in file.read_text("utf-8").splitlines()],
        "cmx3600": lambda: [m.name for m in otio.adapters.read_from_file(str(file)).find_clips()[0].markers],
        "otio": lambda: [m.name for m in otio.adapters.read_from_file(str(file)).tracks.markers],
        "fcp7": lambda: [m.name for m in otio.adapters.read_from_file(str(file), "fcp_xml").tracks.markers],
        "fcpxml": lambda: [said for said, _ in fcpxml_markers(file, counting)],
    }
    names = " ".join(readers[name]())
    assert all(f"shot-{number:04} a{'/' if name == 'resolve' else '|'}b <&>" in names for number in range(1, 11))
    if name in ("otio", "fcp7"):
        [clip] = otio.adapters.read_from_file(str(file), "fcp_xml" if name == "fcp7" else None).tracks[0]
        assert unquote(clip.media_reference.target_url) == HOSTILE
    if name == "fcpxml":
        [media] = ElementTree.parse(file).getroot().findall(".//media-rep")
        assert unquote(media.attrib["src"]) == HOSTILE


@pytest.mark.parametrize("name", sorted(FRAME_FORMATS))
def test_without_a_frame_rate_they_are_refused_in_one_line(tmp_path: Path, name: str) -> None:
    sound = msgspec.structs.replace(film(), source=msgspec.structs.replace(film().source, frame_rate=None))
    line = f"--format {name}: film.mkv has no frame rate; give the film's, such as --frame-rate 24"
    with pytest.raises(RuleError, match=re.escape(line)):
        export_timeline(sound, tmp_path, formats=[name])
    odd = msgspec.structs.replace(sound.source, frame_rate="27/2")
    with pytest.raises(RuleError, match="has 27/2 frames a second, which no timecode counts"):
        require_frame_rate(["csv", name], odd)
    require_frame_rate(["csv", "midi"], odd)


@pytest.mark.parametrize("rate", ["100", "120000/1001", "120"])
def test_fast_rates_are_written_or_refused_in_one_line(tmp_path: Path, rate: str) -> None:
    counting = Counting(rate, "01:00:00;00" if "/" in rate else "01:00:00:00")
    timeline = film(counting)
    with pytest.raises(
        RuleError, match=r"--format fcp7: film\.mkv has [\d.]+ frames a second; this format holds up to 60"
    ):
        export_timeline(timeline, tmp_path, formats=["fcp7"])
    found = fcpxml_markers(written(timeline, tmp_path, "fcpxml"), counting)
    assert_each_event_is_there(found, timeline, counting)
    for name in sorted(FRAME_FORMATS - {"fcp7"}):
        assert written(timeline, tmp_path, name).exists()


@pytest.mark.parametrize("name", sorted(FRAME_FORMATS))
def test_a_shot_before_midnight_is_written_or_refused_in_one_line(tmp_path: Path, name: str) -> None:
    counting = Counting("24", "00:00:01:00")
    timeline = film(counting, onsets=[0, 480_000])
    early = msgspec.structs.replace(timeline, source=msgspec.structs.replace(timeline.source, start_offset_s=-2.0))
    if name in ("fcp7", "fcpxml", "otio"):
        line = f"--format {name}: film.mkv: shot-0001 is 24 frames before 00:00:00:00; this format begins there: choose"
        with pytest.raises(RuleError, match=re.escape(line)):
            export_timeline(early, tmp_path, formats=[name])
        assert not list(tmp_path.iterdir())
    else:
        assert written(early, tmp_path, name).stat().st_size > 0


@pytest.mark.parametrize("name", ["fcp7", "fcpxml", "otio"])
@pytest.mark.parametrize("onsets", [[], [48_000]])
def test_sound_alone_that_begins_before_midnight_is_told_without_a_shot_there(
    tmp_path: Path, name: str, onsets: list[int]
) -> None:
    alone = film(Counting("24", "00:00:00:00"), onsets=onsets, has_picture=False)
    early = msgspec.structs.replace(alone, source=msgspec.structs.replace(alone.source, start_offset_s=-0.04))
    with pytest.raises(RuleError, match=r"film\.mkv: its sound begins 1 frame before 00:00:00:00; this format begins"):
        export_timeline(early, tmp_path, formats=[name])


@pytest.mark.parametrize("name", sorted(FRAME_FORMATS))
@pytest.mark.parametrize(("late_s", "is_too_early"), [(-1.021, False), (-2.0, True), (-9.0, True)])
def test_sound_that_begins_before_midnight_is_refused_before_the_work(
    name: str, late_s: float, is_too_early: bool
) -> None:
    """But a codec's lead-in, in which no shot lies."""
    source = msgspec.structs.replace(film(Counting("24", "00:00:01:00"), onsets=[]).source, start_offset_s=late_s)
    if is_too_early and name in ("fcp7", "fcpxml", "otio"):
        with pytest.raises(RuleError, match=rf"its sound begins {-1.0 - late_s:.3f} s before 00:00:00:00"):
            require_late_enough([name], source)
    else:
        require_late_enough([name], source)


@pytest.mark.parametrize("name", sorted(FRAME_FORMATS))
def test_a_film_without_shots_can_be_opened(tmp_path: Path, name: str) -> None:
    counting = COUNTINGS[3]
    file = written(film(counting, onsets=[]), tmp_path, name)
    if name in ("otio", "fcp7"):
        assert len(otio.adapters.read_from_file(str(file), "fcp_xml" if name == "fcp7" else None).tracks.markers) == 0
    elif name == "fcpxml":
        assert fcpxml_markers(file, counting) == []
    elif name == "cmx3600":
        assert len(list(pycmx.parse_cmx3600(io.StringIO(file.read_text("utf-8"))).events)) == 1


@pytest.mark.parametrize("name", ["mix.wav", "take 1.oga", "sound.mov", "stem.mxf"])
def test_sound_alone_has_no_picture_track(tmp_path: Path, name: str) -> None:
    timeline = film(name=name, has_picture=False)
    sequence = otio.adapters.read_from_file(str(written(timeline, tmp_path, "otio")))
    [track] = sequence.tracks
    assert track.kind == "Audio"
    assert len(track[0].markers) == len(ONSETS)
    assert "hasVideo" not in written(timeline, tmp_path, "fcpxml").read_text("utf-8")
    [event] = pycmx.parse_cmx3600(io.StringIO(written(timeline, tmp_path, "cmx3600").read_text("utf-8"))).events
    assert [(edit.channels.video, edit.channels.audio) for edit in event.edits] == [(False, True)]
