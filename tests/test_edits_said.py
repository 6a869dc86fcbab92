"""What a row says of an event beside its time: gains in labels, and what stays where nothing is said."""

import json
from decimal import ROUND_HALF_UP, Decimal
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from blastline.errors import TimelineError
from blastline.export.edits import Wanted, match, read_edits
from blastline.model import Event, Span, Window, encode
from timelines import BURST_SHOT, RATE_HZ, SHOT, timeline

EVENT = msgspec.structs.replace(SHOT, id="shot-0001")


def labels(folder: Path, text: str, *, before_db: float = 0.0, with_original: bool = True) -> Wanted:
    """Return what a label of this text wants of one event that was asked to be so much stronger."""
    (folder / "labels.txt").write_text(f"1.000021\t1.000021\t{text}\n")
    event = msgspec.structs.replace(EVENT, gain_db=before_db)
    return match(read_edits(folder / "labels.txt"), {event.id: event} if with_original else None, rate_hz=RATE_HZ)


def table(folder: Path, text: str, *events: Event) -> Wanted:
    """Return what a table wants of a film in which these events were found."""
    (folder / "edited.csv").write_text(text)
    return match(read_edits(folder / "edited.csv"), {event.id: event for event in events}, rate_hz=RATE_HZ)


@pytest.mark.parametrize("at", [0, 1])
def test_a_shot_at_the_very_beginning_of_a_film_has_a_past_as_any_other(tmp_path: Path, at: int) -> None:
    shot = msgspec.structs.replace(
        EVENT, onset_sample=at, onset_s=at / RATE_HZ, blast=Span(at, at + 400), window=Window(0, 9_600, 0, 1920)
    )
    document = json.loads(encode(timeline(shot)))
    for onset in (at, 2_400):
        document["events"][0]["onset_sample"] = onset
        (tmp_path / "edited.json").write_text(json.dumps(document))
        [wish] = match(read_edits(tmp_path / "edited.json"), None, rate_hz=RATE_HZ).wishes
        assert (wish.id, wish.onset, wish.unmoved) == (shot.id, onset, onset == at)
        assert wish.origin == ("found" if onset == at else "moved")


@pytest.mark.parametrize("said", ["onset_sample", "onset_s"])
@pytest.mark.parametrize("moved_by", [0, 4_800])
def test_one_number_of_an_onset_is_enough_to_tell_a_shot_that_stayed_from_one_that_was_moved(
    tmp_path: Path, said: str, moved_by: int
) -> None:
    """A script that moves a shot by one of the two leaves out the other, which is no longer true."""
    onset = EVENT.onset_sample + moved_by
    document = json.loads(encode(timeline(EVENT)))
    fields = document["events"][0]
    fields |= {"onset_sample": onset, "onset_s": onset / RATE_HZ}
    fields |= {"blast": {"start_sample": EVENT.onset_sample, "stop_sample": EVENT.onset_sample + 400}}
    for other in {"onset_sample", "onset_s"} - {said}:
        del fields[other]
    (tmp_path / "edited.json").write_text(json.dumps(document))
    [wish] = match(read_edits(tmp_path / "edited.json"), None, rate_hz=RATE_HZ).wishes
    assert wish.was is not None
    assert (wish.id, wish.onset, wish.unmoved) == (EVENT.id, onset, moved_by == 0)
    assert wish.origin == ("moved" if moved_by else "found")


@pytest.mark.parametrize("key", ["confidence", "gain_db", "origin", "timecode", "burst", "shot_in_burst"])
@pytest.mark.parametrize("emptied", [False, True])
def test_a_shot_that_lacks_what_nothing_is_measured_for_is_the_one_that_it_was(
    tmp_path: Path, key: str, *, emptied: bool
) -> None:
    document = json.loads(encode(timeline()))
    document["events"][1].pop(key)
    if emptied:
        document["events"][1][key] = None
    (tmp_path / "edited.json").write_text(json.dumps(document))
    [_, wish] = match(read_edits(tmp_path / "edited.json"), None, rate_hz=RATE_HZ).wishes
    assert wish.was is not None
    assert (wish.was.blast, wish.window, wish.origin) == (BURST_SHOT.blast, BURST_SHOT.window, "found")
    assert (wish.unmoved, wish.changed) == (True, False)
    assert (wish.confidence, wish.gain_db) == (1.0 if key == "confidence" else BURST_SHOT.confidence, 0.0)


def without(key: str, folder: Path, *, moved_by: int) -> Path:
    """Return a timeline that is edited without its original: its second shot lacks a key, and was moved."""
    document = json.loads(encode(timeline()))
    fields = document["events"][1]
    del fields[key]
    fields |= {"onset_sample": BURST_SHOT.onset_sample + moved_by, "onset_s": None}
    (folder / "edited.json").write_text(json.dumps(document))
    return folder / "edited.json"


@pytest.mark.parametrize("key", ["window", "reflections", "peak_dbfs", "snr_db"])
@pytest.mark.parametrize("moved_by", [0, 4_800])
def test_a_shot_of_which_something_has_to_be_measured_anew_was_not_added(
    tmp_path: Path, key: str, moved_by: int
) -> None:
    edited = without(key, tmp_path, moved_by=moved_by)
    wishes = match(read_edits(edited), None, rate_hz=RATE_HZ).wishes
    assert [wish.id for wish in wishes] == [SHOT.id, BURST_SHOT.id]
    assert (wishes[1].origin, wishes[1].confidence) == ("moved" if moved_by else "found", BURST_SHOT.confidence)


@pytest.mark.parametrize(
    ("key", "moved_by", "origin"), [("id", 0, "found"), ("id", 4_800, "added"), ("blast", 0, "added")]
)
def test_a_shot_without_an_id_is_found_where_it_was_and_a_copy_or_one_without_a_past_is_added(
    tmp_path: Path, key: str, moved_by: int, origin: str
) -> None:
    edited = without(key, tmp_path, moved_by=moved_by)
    assert match(read_edits(edited), None, rate_hz=RATE_HZ).wishes[1].origin == origin


@pytest.mark.parametrize(
    "told", ["shot-0001", "shot-0001 0.97 -3.1 dBFS", "shot-0001 0.97 -3.1 dBFS filter", "boom", ""]
)
@pytest.mark.parametrize("typed", ["gain -6 dB", "door? gain -6 dB", "gain: -6dB", "GAIN=-6,0 dB.", "gain \u20136 dB"])
@pytest.mark.parametrize("before", [0.0, -2.0])
@pytest.mark.parametrize("with_original", [True, False])
def test_a_gain_at_the_end_of_a_label_is_read_whatever_stands_before_it(
    tmp_path: Path, told: str, typed: str, before: float, *, with_original: bool
) -> None:
    wanted = labels(tmp_path, f"{told} {typed}", before_db=before, with_original=with_original)
    assert [wish.gain_db for wish in wanted.wishes] == [-6.0]
    assert not wanted.notes


@pytest.mark.parametrize(
    ("text", "after_db", "unread"),
    [
        ("shot-0001 0.97 -3.1 dBFS filter gain -6 dB (was gain 2 dB)", -6.0, "gain 2 dB"),
        ("shot-0001 gain -6 dB was too much", -2.0, "gain -6 dB"),
        ("shot-0001 gain -6", -2.0, "gain -6"),
        ("shot-0001 (-6 dB)", -2.0, "-6 dB"),
        ("shot-0001 gain minus 6 dB", -2.0, "6 dB"),
        ("shot-0001 0.97 -3.1 dBFS filter -6 dB", -2.0, "-6 dB"),
    ],
)
def test_a_gain_elsewhere_in_a_label_is_a_word_and_told(
    tmp_path: Path, text: str, after_db: float, unread: str
) -> None:
    wanted = labels(tmp_path, text, before_db=-2.0)
    assert [wish.gain_db for wish in wanted.wishes] == [after_db]
    assert f"not used: {unread!r} of shot-0001; a gain stands at the end" in wanted.notes[0]


def test_two_gains_in_a_label_are_refused(tmp_path: Path) -> None:
    with pytest.raises(TimelineError, match=r"line 1: .*: two gains, -6 dB and 2 dB; expected one, at the end"):
        labels(tmp_path, "shot-0001 0.97 -3.1 dBFS filter gain -6 dB, was gain 2 dB")


def test_an_id_that_reads_like_a_gain_is_none(tmp_path: Path) -> None:
    named = msgspec.structs.replace(EVENT, id="gain 2 dB")
    (tmp_path / "labels.txt").write_text("1.000021\t1.000021\tgain 2 dB\n")
    wanted = match(read_edits(tmp_path / "labels.txt"), {named.id: named}, rate_hz=RATE_HZ)
    assert [(wish.id, wish.gain_db) for wish in wanted.wishes] == [("gain 2 dB", 0.0)]


def test_what_an_exported_table_no_longer_says_is_as_usual_and_told_without_an_original(tmp_path: Path) -> None:
    """A row that somebody has added says no more than its onset, and nothing is told of it."""
    rows = "id,onset_sample,blast_start_sample,confidence,gain_db\nshot-0001,48001,48001,0.97,\nmine,96000,,,\n"
    (tmp_path / "alone.csv").write_text(rows)
    wanted = match(read_edits(tmp_path / "alone.csv"), None, rate_hz=RATE_HZ)
    assert [(wish.confidence, wish.gain_db) for wish in wanted.wishes] == [(0.97, 0.0), (None, 0.0)]
    assert wanted.notes == ("as usual, since the file says nothing there: gain_db of shot-0001",)


def test_what_a_file_no_longer_says_is_as_in_the_original_and_told(tmp_path: Path) -> None:
    event = msgspec.structs.replace(EVENT, gain_db=-6.0)
    header = "id,onset_s,window_start_s,window_start_sample,window_stop_s,confidence,gain_db\n"
    wanted = table(tmp_path, f"{header}shot-0001,1.00002,,,,,\n", event)
    [wish] = wanted.wishes
    assert (wish.gain_db, wish.window, wish.confidence, wish.changed) == (-6.0, SHOT.window, event.confidence, False)
    assert wanted.notes == (
        "kept as in the original, since the file says nothing there: gain_db of shot-0001; window_start of shot-0001; "
        "window_stop of shot-0001; confidence of shot-0001",
    )
    [alone] = match(read_edits(tmp_path / "edited.csv"), None, rate_hz=RATE_HZ).wishes
    assert (alone.gain_db, alone.window, alone.start, alone.stop, alone.confidence) == (0.0, None, None, None, None)


def one_decimal(value: float) -> str:
    """Return a number as a spreadsheet shows it, halves away from zero."""
    return str(Decimal(repr(value)).quantize(Decimal("0.1"), ROUND_HALF_UP))


@given(st.lists(st.tuples(st.integers(0, 1000), st.integers(-600, 600)), min_size=1, max_size=6))
def test_a_spreadsheet_that_shows_one_decimal_changes_no_number(numbers: list[tuple[int, int]]) -> None:
    events = [
        msgspec.structs.replace(
            EVENT, id=f"shot-{n}", onset_sample=n, confidence=thousandths / 1000, gain_db=cents / 100
        )
        for n, (thousandths, cents) in enumerate(numbers, start=48_001)
    ]
    rows = [f"{e.id},{e.onset_sample},{one_decimal(e.confidence)},{one_decimal(e.gain_db)}\n" for e in events]
    with TemporaryDirectory() as folder:
        wanted = table(Path(folder), f"id,onset_sample,confidence,gain_db\n{''.join(rows)}", *events)
    assert [(wish.confidence, wish.gain_db) for wish in wanted.wishes] == [(e.confidence, e.gain_db) for e in events]


def test_a_short_number_among_long_ones_was_typed(tmp_path: Path) -> None:
    other = msgspec.structs.replace(EVENT, id="shot-0002", onset_sample=96_000)
    rows = "id,onset_sample,confidence,gain_db\nshot-0001,48001,0.9,0.1\nshot-0002,96000,0.96875,-2.25\n"
    events = [msgspec.structs.replace(each, confidence=0.93, gain_db=0.12) for each in (EVENT, other)]
    wish = table(tmp_path, rows, *events).wishes[0]
    assert (wish.confidence, wish.gain_db) == (0.9, 0.1)


@pytest.mark.parametrize("row", ["shot-0001,1.00002,0", "shot-0001,1.00002,-6"])
def test_nothing_is_told_of_what_a_file_says_or_has_no_column_for(tmp_path: Path, row: str) -> None:
    event = msgspec.structs.replace(EVENT, gain_db=-6.0)
    assert not table(tmp_path, f"id,onset_s,gain_db\n{row}\n", event).notes
    assert not table(tmp_path, "id,onset_s\nshot-0001,1.00002\n", EVENT).notes
