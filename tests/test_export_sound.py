"""Formats that hold seconds, milliseconds or ticks, read by what we did not write: every event at its time."""

import csv
import json
import re
from fractions import Fraction
from pathlib import Path

import av
import jsonschema
import mido
import msgspec
import pandas
import pytest
import webvtt

from blastline.export import FORMATS, export_timeline, rounding
from blastline.export.frames import FRAME_FORMATS
from blastline.export.midi import NOTE, beat_of, velocity
from blastline.export.table import COLUMNS, table
from blastline.export.words import label, note, one_line
from blastline.model import Timeline, encode
from blastline.report.words import fixed
from films import COUNTINGS, HOSTILE, ONSETS, Counting, film

RATES_HZ = [8_000, 11_025, 16_000, 22_050, 32_000, 44_100, 48_000, 88_200, 96_000, 176_400, 192_000, 384_000]


def written(timeline: Timeline, folder: Path, name: str) -> Path:
    [file] = export_timeline(timeline, folder, formats=[name])
    return file


def in_order(timeline: Timeline) -> list[int]:
    return sorted(event.onset_sample for event in timeline.events)


# MIDI


def notes(file: mido.MidiFile) -> list[tuple[int, int, int]]:
    """Return start, end and velocity of each note, in ticks; a note that is not ended fails."""
    [track] = [track for track in file.tracks if track.name == "shots"]
    found: list[tuple[int, int, int]] = []
    open_at: list[tuple[int, int]] = []
    now = 0
    for message in track:
        now += message.time
        if message.type == "note_on" and message.velocity:
            assert open_at == []  # what overlaps on one pitch cuts itself off
            open_at = [(now, message.velocity)]
        elif message.type in ("note_off", "note_on"):
            assert message.note == NOTE
            [(start, level)] = open_at
            found.append((start, now, level))
            open_at = []
    assert open_at == []
    return found


def tick_s(file: mido.MidiFile) -> Fraction:
    [tempo] = [message.tempo for message in file.tracks[0] if message.type == "set_tempo"]
    return Fraction(tempo, 1_000_000 * file.ticks_per_beat)


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_midi_ticks_are_samples(tmp_path: Path, rate_hz: int) -> None:
    timeline = film(rate_hz=rate_hz)
    file = mido.MidiFile(written(timeline, tmp_path, "midi"), charset="utf-8")
    assert tick_s(file) == Fraction(1, rate_hz)
    assert file.ticks_per_beat <= 0x7FFF
    assert [start for start, _, _ in notes(file)] == in_order(timeline)
    assert rounding(timeline, ["midi"]) == ()


def test_midi_of_a_rate_without_a_beat_is_at_the_nearest_tick(tmp_path: Path) -> None:
    timeline = film(rate_hz=44_101)
    file = mido.MidiFile(written(timeline, tmp_path, "midi"))
    for (start, _, _), onset in zip(notes(file), in_order(timeline), strict=True):
        assert abs(start * tick_s(file) - Fraction(onset, 44_101)) <= tick_s(file) / 2
    [line] = rounding(timeline, ["midi"])
    assert line.startswith("midi: a tick is 20.83 us; shot-")


def test_midi_of_a_film_that_is_silent_for_hours(tmp_path: Path) -> None:
    onsets = [48_000, 9 * 3600 * 48_000, 23 * 3600 * 48_000 + 1]
    file_path = written(film(onsets=onsets), tmp_path, "midi")
    file = mido.MidiFile(file_path)
    assert [start for start, _, _ in notes(file)] == onsets
    assert all(message.time <= 0x0FFFFFFF for track in file.tracks for message in track)
    assert file.length == pytest.approx(onsets[-1] / 48_000 + 0.5)


def test_midi_notes_have_the_level_and_markers_the_names(tmp_path: Path) -> None:
    timeline = film(name=HOSTILE)
    file = mido.MidiFile(written(timeline, tmp_path, "midi"), charset="utf-8")
    by_onset = sorted(timeline.events, key=lambda event: event.onset_sample)
    assert [level for _, _, level in notes(file)] == [velocity(event.peak_dbfs) for event in by_onset]
    assert file.tracks[0].name == one_line(HOSTILE)
    now, found = 0, []
    for message in file.tracks[0]:
        now += message.time
        if message.type == "marker":
            found.append((now, message.text))
    assert found == [(event.onset_sample, label(event)) for event in by_onset]


def test_velocity_rises_with_level_and_stays_within_midi() -> None:
    levels = [velocity(peak_dbfs) for peak_dbfs in range(-300, 20)]
    assert levels == sorted(levels)
    assert (levels[0], levels[-1]) == (1, 127)


@pytest.mark.parametrize(
    ("rate", "start", "expected"),
    [
        ("24", "01:00:00:12", (24, 1, 0, 0, 12, 0)),
        ("25", "10:00:00:24", (25, 10, 0, 0, 24, 0)),
        ("30", "01:00:00:00", (30, 1, 0, 0, 0, 0)),
        ("30000/1001", "00:59:59;29", (29.97, 0, 59, 59, 29, 0)),
        ("48", "01:00:00:03", (24, 1, 0, 0, 1, 50)),
        ("50", "01:00:00:01", (25, 1, 0, 0, 0, 50)),
        ("60000/1001", "00:01:00;04", (29.97, 0, 1, 0, 2, 0)),
        ("60", "01:00:00:02", (30, 1, 0, 0, 1, 0)),
        ("24000/1001", "01:00:00:00", None),
        ("30000/1001", "01:00:00:00", None),
    ],
)
def test_midi_has_the_start_where_it_has_the_rate(
    tmp_path: Path, rate: str, start: str, expected: tuple[float, int, int, int, int, int] | None
) -> None:
    file = mido.MidiFile(written(film(Counting(rate, start)), tmp_path, "midi"))
    found = [
        (m.frame_rate, m.hours, m.minutes, m.seconds, m.frames, m.sub_frames)
        for m in file.tracks[0]
        if m.type == "smpte_offset"
    ]
    assert found == ([] if expected is None else [expected])


def test_midi_start_is_that_of_the_sound(tmp_path: Path) -> None:
    timeline = film(Counting("25", "01:00:00:00"), offset_s=-0.0102)
    [offset] = [m for m in mido.MidiFile(written(timeline, tmp_path, "midi")).tracks[0] if m.type == "smpte_offset"]
    assert (offset.hours, offset.minutes, offset.seconds, offset.frames, offset.sub_frames) == (0, 59, 59, 24, 75)


@pytest.mark.parametrize("rate_hz", [*RATES_HZ, 47_952, 44_101, 1_000, 12_345])
def test_the_pulse_is_a_tempo_that_midi_can_hold(rate_hz: int) -> None:
    beat = beat_of(rate_hz)
    assert 1 <= beat.ticks_per_beat <= 0x7FFF
    assert 1 <= beat.tempo_us <= 0xFFFFFF
    for sample in (0, 1, rate_hz, 7 * 3600 * rate_hz + 1):
        time_s = Fraction(beat.ticks(sample, rate_hz) * beat.tempo_us, 1_000_000 * beat.ticks_per_beat)
        assert abs(time_s - Fraction(sample, rate_hz)) <= Fraction(beat.tempo_us, 2_000_000 * beat.ticks_per_beat)


# WebVTT


def test_webvtt_to_the_millisecond(tmp_path: Path) -> None:
    timeline = film(name=HOSTILE, offset_s=0.0205)
    captions = webvtt.read(str(written(timeline, tmp_path, "webvtt"))).captions
    by_onset = sorted(timeline.events, key=lambda event: event.onset_sample)
    assert [caption.identifier for caption in captions] == [event.id for event in by_onset]
    for caption, event in zip(captions, by_onset, strict=True):
        exact_s = event.onset_sample / 48_000 + 0.0205
        assert re.fullmatch(r"\d\d:\d\d:\d\d\.\d{3}", caption.start)
        assert abs(_clock_s(caption.start) - exact_s) <= 0.0005 + 1e-9
        assert _clock_s(caption.end) > _clock_s(caption.start)
        assert caption.text == label(event)
    assert re.fullmatch(
        r"webvtt: times are whole milliseconds; shot-\d+ moves farthest, by [+-]0\.\d{3} ms",
        rounding(timeline, ["webvtt"])[0],
    )


def test_webvtt_shows_even_a_shot_that_the_next_one_ends_at_once(tmp_path: Path) -> None:
    captions = webvtt.read(str(written(film(onsets=[48_000, 48_010]), tmp_path, "webvtt"))).captions
    assert [_clock_s(each.end) > _clock_s(each.start) for each in captions] == [True, True]


def test_webvtt_shows_what_comes_before_the_picture_at_its_start(tmp_path: Path) -> None:
    [caption] = webvtt.read(str(written(film(onsets=[480], offset_s=-0.5), tmp_path, "webvtt"))).captions
    assert caption.start == "00:00:00.000"
    assert caption.end > caption.start


def test_webvtt_arrows_and_tags_in_names_are_text(tmp_path: Path) -> None:
    plain = film(onsets=[48_000])
    [event] = plain.events
    odd = msgspec.structs.replace(plain, events=(msgspec.structs.replace(event, id="a --> b <i>&amp;"),))
    text = written(odd, tmp_path, "webvtt").read_text("utf-8")
    assert text.count("-->") == 1
    assert text.split("\n")[2] == "a -- > b <i>&amp;"
    [caption] = webvtt.read(str(tmp_path / "timeline.vtt")).captions
    assert caption.raw_text.startswith("a --&gt; b &lt;i&gt;&amp;amp; 0.97")


@pytest.mark.parametrize("identity", ["A&B", "<shot>", "1 > 2", "a->b", "&lt;"])
def test_webvtt_identifiers_are_read_as_they_stand(tmp_path: Path, identity: str) -> None:
    [event] = film(onsets=[48_000]).events
    named = msgspec.structs.replace(film(), events=(msgspec.structs.replace(event, id=identity),))
    assert written(named, tmp_path, "webvtt").read_text("utf-8").split("\n")[2] == identity


@pytest.mark.parametrize("identity", ["NOTE", "NOTE 2", "STYLE", "REGION-4", "WEBVTT"])
def test_webvtt_an_event_called_like_a_block_of_another_kind_is_still_shown(tmp_path: Path, identity: str) -> None:
    """FFmpeg, which mpv reads with, skips whole blocks by how their first line begins."""
    [event] = film(onsets=[48_000]).events
    named = msgspec.structs.replace(film(), events=(msgspec.structs.replace(event, id=identity),))
    file = written(named, tmp_path, "webvtt")
    with av.open(str(file), format="webvtt") as container:
        cues = [bytes(packet).decode() for packet in container.demux() if packet.size]
    assert cues == [label(named.events[0])]
    [caption] = webvtt.read(str(file)).captions
    assert caption.identifier is not None
    assert caption.identifier.strip() == identity


def _clock_s(text: str) -> float:
    match = re.fullmatch(r"(\d+):([0-5]\d):([0-5]\d\.\d+)", text)
    assert match
    return 3600 * int(match[1]) + 60 * int(match[2]) + float(match[3])


# REAPER, Audacity, tables


@pytest.mark.parametrize("rate_hz", [44_100, 48_000, 192_000])
def test_reaper_regions_are_at_the_sample(tmp_path: Path, rate_hz: int) -> None:
    timeline = film(name=HOSTILE, rate_hz=rate_hz)
    raw = written(timeline, tmp_path, "reaper").read_bytes()
    assert not raw.startswith(b"\xef\xbb\xbf")
    rows = list(csv.DictReader(raw.decode("utf-8").splitlines()))
    assert raw.startswith(b"#,Name,Start,End,Length\n")
    by_onset = sorted(timeline.events, key=lambda event: event.onset_sample)
    assert [row["#"] for row in rows] == [f"R{number}" for number in range(1, len(rows) + 1)]
    for row, event, after in zip(rows, by_onset, [*by_onset[1:], None], strict=True):
        start, end, length = (round(_clock_s(row[key]) * rate_hz) for key in ("Start", "End", "Length"))
        assert (row["Name"], start) == (label(event), event.onset_sample)
        assert end == start + length
        assert end <= (event.window.stop if after is None else after.onset_sample)


def test_labels_with_commas_quotes_and_tabs_stay_one_field(tmp_path: Path) -> None:
    plain = film(onsets=[48_000])
    odd = tuple(msgspec.structs.replace(event, id='a,"b"\tc\nd') for event in plain.events)
    timeline = msgspec.structs.replace(plain, events=odd)
    [row] = csv.DictReader(written(timeline, tmp_path, "reaper").read_text("utf-8").splitlines())
    assert row["Name"].startswith('a,"b" c d 0.97')
    [line] = written(timeline, tmp_path, "audacity").read_text("utf-8").splitlines()
    assert line.split("\t")[2].startswith('a,"b" c d 0.97')


def test_labels_tell_what_a_designer_needs() -> None:
    shots = {event.id: event for event in film().events}
    assert label(shots["shot-0001"]) == "shot-0001 0.97 -3.1 dBFS filter"
    assert label(shots["shot-0004"]) == "shot-0004 0.50 burst 1.4 -9.0 dBFS"


@pytest.mark.parametrize("peak_dbfs", [-0.04, -0.0, 0.02, -0.06, -3.05, 1.25])
def test_a_marker_tells_the_level_that_the_report_does(peak_dbfs: float) -> None:
    """There is no level of -0.0 dBFS, as loud recordings have it that end at full scale."""
    shot = msgspec.structs.replace(film().events[0], peak_dbfs=peak_dbfs)
    told = f"{fixed(peak_dbfs, 1).replace('−', '-')} dBFS"
    assert told in label(shot).split(" ", 2)[2]
    assert f"peak {told}" in note(shot, Fraction(0))
    assert "-0.0 " not in label(shot)


def test_the_table_says_how_far_from_its_frame_an_event_is(tmp_path: Path) -> None:
    timeline = film(COUNTINGS[3])
    read = pandas.read_csv(written(timeline, tmp_path, "csv"), dtype=dict(COLUMNS))
    assert read["timecode_offset_ms"].abs().max() <= 500 * 1001 / 30_000
    bare = msgspec.structs.replace(timeline, source=msgspec.structs.replace(timeline.source, frame_rate=None))
    assert pandas.read_csv(written(bare, tmp_path, "csv"))["timecode_offset_ms"].isna().all()


def test_the_table_has_one_plain_type_a_column() -> None:
    whole = table(film())
    assert {name: str(dtype) for name, dtype in whole.dtypes.items()} == dict(COLUMNS)
    assert whole["burst"].isna().sum() == len(ONSETS) - 3
    assert table(film(onsets=[])).dtypes.equals(whole.dtypes)


# JSON Schema


def test_the_schema_accepts_what_we_write_and_refuses_what_is_wrong(tmp_path: Path) -> None:
    rules = json.loads(written(film(), tmp_path, "schema").read_text("utf-8"))
    jsonschema.Draft202012Validator.check_schema(rules)
    validator = jsonschema.Draft202012Validator(rules)
    for counting in COUNTINGS:
        validator.validate(json.loads(encode(film(counting, name=HOSTILE))))
    wrong = json.loads(encode(film()))
    wrong["events"][0]["confidence"] = 2
    assert [error.json_path for error in validator.iter_errors(wrong)] == ["$.events[0].confidence"]
    shipped = Path(__file__).parents[1] / "docs" / "timeline.schema.json"
    assert json.loads(shipped.read_text("utf-8")) == rules


# What is said about rounding


def test_rounding_names_the_event_that_moves_farthest() -> None:
    timeline = film(COUNTINGS[1], onsets=[0, 999, 48_000])
    assert rounding(timeline, ["json", "resolve", "csv", "otio", "resolve"]) == (
        "resolve, otio: times are whole frames, 24 a second, at most 20.83 ms off; "
        "shot-0002 moves farthest, by -20.812 ms",
    )
    assert rounding(film(onsets=[]), ["webvtt"]) == ("webvtt: times are whole milliseconds; there are no events",)


@pytest.mark.parametrize(("rate", "name"), [("24000/1001", "23.976"), ("60000/1001", "59.94"), ("100", "100")])
def test_rounding_calls_a_rate_as_people_do(rate: str, name: str) -> None:
    [line] = rounding(film(Counting(rate, "01:00:00:00"), onsets=[0]), ["avid"])
    assert f"whole frames, {name} a second," in line


def test_rounding_is_told_apart_where_the_clip_begins_beside_the_films_start() -> None:
    timeline = film(Counting("25", "01:00:00.019000"), onsets=[0, 48_000])
    in_time, in_clip = rounding(timeline, ["resolve", "otio", "fcp7", "fcpxml"])
    assert in_time.startswith("resolve: ")
    assert in_time.endswith("by -19.000 ms")
    assert in_clip.startswith("otio, fcp7, fcpxml: ")
    assert in_clip.endswith("; no event moves")


@pytest.mark.parametrize(
    ("rate", "has"), [("24000/1001", True), ("50", True), ("60", True), ("48", False), ("120", False)]
)
def test_a_rate_that_final_cut_does_not_have_is_told(rate: str, has: bool) -> None:
    told = rounding(film(Counting(rate, "01:00:00:00"), onsets=[0]), ["resolve", "fcpxml"])
    doubtful = [line for line in told if "Final Cut Pro may not open the file" in line]
    assert [line.partition(":")[0] for line in doubtful] == ([] if has else ["fcpxml"])


@pytest.mark.parametrize(
    ("start", "begins_s", "passes"),
    [
        ("23:59:59:12", 0.0, True),
        ("23:59:50:00", 0.0, False),
        ("00:00:00:00", 0.0, False),
        ("00:00:00:00", -0.5, True),  # the first shot comes before the first picture
        ("00:00:00:00", 0.5, False),
    ],
)
def test_an_edl_of_a_film_that_passes_midnight_is_told(start: str, begins_s: float, passes: bool) -> None:
    timeline = film(Counting("24", start), onsets=[0, 48_000])
    source = msgspec.structs.replace(timeline.source, frames=96_000, start_offset_s=begins_s)
    timeline = msgspec.structs.replace(timeline, source=source)
    told = rounding(timeline, ["resolve", "cmx3600", "otio", "avid"])
    doubtful = [line for line in told if "passes midnight" in line]
    assert [line.partition(":")[0] for line in doubtful] == (["resolve, cmx3600"] if passes else [])


@pytest.mark.parametrize(("rate", "start"), [("24", "23:59:58:00"), ("25", "23:59:58:00"), ("48", "23:59:58:00")])
@pytest.mark.parametrize("more", [-1, 0, 1])
def test_a_film_passes_midnight_only_where_a_frame_of_it_is_behind(rate: str, start: str, more: int) -> None:
    """One that ends there has its last frame before; an edit that ends with it is written to 00:00:00:00."""
    timeline = film(Counting(rate, start), onsets=[0, 48_000])
    source = msgspec.structs.replace(timeline.source, frames=2 * 48_000 + more * 48_000 // int(rate))
    told = rounding(msgspec.structs.replace(timeline, source=source), ["resolve", "cmx3600", "otio", "avid"])
    for words, of in (
        ("the film passes midnight", ["resolve", "cmx3600"] if more > 0 else []),
        ("an edit ends at midnight, written 00:00:00:00", ["cmx3600"] if more == 0 else []),
    ):
        names = [line.partition(":")[0].split(", ") for line in told if words in line]
        assert names == ([of] if of else [])


@pytest.mark.parametrize("frames", [96_000, 96_500])
def test_a_marker_on_the_last_frame_before_midnight_ends_there(frames: int) -> None:
    """Whether the shot is in that frame or in the rest of one that is too little to be counted."""
    timeline = film(Counting("24", "23:59:58:00"), onsets=[frames - 10])
    source = msgspec.structs.replace(timeline.source, frames=frames)
    told = rounding(msgspec.structs.replace(timeline, source=source), ["resolve", "avid"])
    assert [line.partition(":")[0] for line in told if "an edit ends at midnight" in line] == ["resolve"]
    assert not any("passes midnight" in line for line in told)


def test_a_rounding_is_one_line_whatever_the_shot_is_called() -> None:
    timeline = film(Counting("24", "00:00:00:00"), onsets=[1_000])
    (event,) = timeline.events
    named = msgspec.structs.replace(timeline, events=(msgspec.structs.replace(event, id="reel\n1"),))
    (line,) = rounding(named, ["otio"])
    assert "; reel 1 moves farthest" in line


def test_every_format_says_how_exact_it_is() -> None:
    assert all(known.exactness for known in FORMATS.values())
    frames = {name for name, known in FORMATS.items() if known.exactness.startswith("nearest frame")}
    assert frames == FRAME_FORMATS
