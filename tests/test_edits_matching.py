"""Whatever a designer does to a table or a label track, exactly that comes back, and nothing else has changed."""

import csv
import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from random import Random

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from blastline.errors import TimelineError
from blastline.export import export_timeline
from blastline.export.edits import Wanted, match, read_edits
from blastline.model import Event, Span, Timeline, Window, encode
from timelines import RATE_HZ, SHOT, timeline

SHARED_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
RATES_HZ = (44_100, 48_000, 96_000, 192_000)
FILM_S = 3 * 3600


@dataclass(frozen=True)
class Edits:
    """A timeline and what is done to it: new onsets by id (None: deleted), and onsets of new events."""

    before: Timeline
    onsets: Mapping[str, int | None]
    added: Sequence[int]

    @property
    def rate_hz(self) -> int:
        """Return the film's sample rate."""
        return self.before.source.sample_rate_hz

    @property
    def originals(self) -> dict[str, Event]:
        """Return the events before the edits, by id."""
        return {event.id: event for event in self.before.events}

    @property
    def expected(self) -> dict[str, int]:
        """Return the onset of each event after the edits, new ones under the next free numbers."""
        left = {name: onset for name, onset in self.onsets.items() if onset is not None}
        return left | {f"shot-{len(self.onsets) + n:04d}": onset for n, onset in enumerate(self.added, start=1)}


@st.composite
def films(draw: st.DrawFn) -> Timeline:
    """Draw a timeline at any rate with up to six shots anywhere in a long film, one or two to a window."""
    rate_hz = draw(st.sampled_from(RATES_HZ))
    gaps = draw(st.lists(st.integers(rate_hz // 4, FILM_S * rate_hz // 8), max_size=6))
    events: list[Event] = []
    share = st.booleans()
    onset = draw(st.integers(rate_hz // 100, rate_hz))
    for number, gap in enumerate(gaps, start=1):
        window = Window(onset - draw(st.integers(0, rate_hz // 100)), onset + rate_hz // 5, 0, 0)
        if draw(share) and events:
            window = Window(events[-1].window.start, window.stop, 0, 0)
            events[-1] = msgspec.structs.replace(events[-1], window=window)
        confidence = draw(st.integers(0, 10_000)) / 10_000
        events.append(
            msgspec.structs.replace(
                SHOT,
                id=f"shot-{number:04d}",
                onset_sample=onset,
                onset_s=onset / rate_hz,
                confidence=confidence,
                blast=Span(onset, onset + 100),
                window=window,
            )
        )
        onset += gap
    whole = timeline(*events) if events else msgspec.structs.replace(timeline(), events=())
    source = msgspec.structs.replace(whole.source, sample_rate_hz=rate_hz, frames=FILM_S * rate_hz)
    return msgspec.structs.replace(whole, source=source)


@st.composite
def edited(draw: st.DrawFn) -> Edits:
    """Draw a timeline and edits to it, none of which puts two events within 2 ms of another's old or new place."""
    before = draw(films())
    rate_hz = before.source.sample_rate_hz
    taken = [event.onset_sample for event in before.events]

    def free(onset: int) -> bool:
        alone = all(abs(onset - other) > rate_hz // 500 for other in taken)
        if alone:
            taken.append(onset)
        return alone

    onsets: dict[str, int | None] = {}
    for event in before.events:
        what = draw(st.sampled_from(["keep", "move", "delete"]))
        moved = max(0, event.onset_sample + draw(st.integers(-rate_hz // 5, rate_hz // 5)))
        onsets[event.id] = None if what == "delete" else event.onset_sample
        if what == "move" and free(moved):
            onsets[event.id] = moved
    added = [onset for onset in draw(st.lists(st.integers(0, (FILM_S - 1) * rate_hz), max_size=3)) if free(onset)]
    return Edits(before, onsets, added)


def wanted_of(file: Path, edits: Edits) -> Wanted:
    """Return what is read back from an edited file beside its original."""
    return match(read_edits(file), edits.originals, rate_hz=edits.rate_hz)


def require_exactly(wanted: Wanted, edits: Edits, *, within: int = 0) -> None:
    """Assert that the edits came back: untouched onsets exactly, others within so many samples."""
    found = {wish.id: wish for wish in wanted.wishes}
    assert found.keys() == edits.expected.keys()
    for name, wish in found.items():
        before = edits.originals.get(name)
        if before is not None and edits.onsets[name] == before.onset_sample:
            assert (wish.onset, wish.unmoved, wish.origin) == (before.onset_sample, True, "found")
        else:
            assert abs(wish.onset - edits.expected[name]) <= within
            assert (wish.unmoved, wish.origin) == (False, "moved" if before else "added")
    assert {event.id for event in wanted.deleted} == {n for n, onset in edits.onsets.items() if onset is None}
    onsets = [wish.onset for wish in wanted.wishes]
    assert onsets == sorted(onsets)


@SHARED_FOLDER
@given(films(), st.sampled_from(["json", "csv", "audacity", "reaper"]))
def test_what_is_exported_and_not_edited_comes_back_to_the_sample(tmp_path: Path, before: Timeline, name: str) -> None:
    [file] = export_timeline(before, tmp_path, formats=[name])
    originals = {event.id: event for event in before.events}
    rate_hz = before.source.sample_rate_hz
    with_original = match(read_edits(file), originals, rate_hz=rate_hz)
    assert [wish.was for wish in with_original.wishes] == list(before.events)
    assert all(wish.unmoved and not wish.changed for wish in with_original.wishes)
    assert [wish.window for wish in with_original.wishes] == [event.window for event in before.events]
    assert with_original.deleted == ()
    alone = match(read_edits(file), None, rate_hz=rate_hz)
    assert [(wish.id, wish.onset) for wish in alone.wishes] == [(e.id, e.onset_sample) for e in before.events]
    assert {wish.origin for wish in alone.wishes} <= {"found"}


@SHARED_FOLDER
@given(edited(), st.sampled_from(["onset_sample", "onset_s"]), st.randoms(use_true_random=False))
def test_edits_of_one_time_column_of_a_table_come_back(
    tmp_path: Path, edits: Edits, column: str, random: Random
) -> None:
    """A spreadsheet's user changes the column that they think in, adds short rows, and sorts as they like."""
    [file] = export_timeline(edits.before, tmp_path, formats=["csv"])
    with file.open(newline="") as text:
        rows = [row for row in csv.DictReader(text) if edits.onsets[row["id"]] is not None]
    for row in rows:
        if row["onset_sample"] != str(edits.onsets[row["id"]]):
            row[column] = _cell(column, edits.onsets[row["id"]] or 0, edits.rate_hz)
    new = [{column: _cell(column, onset, edits.rate_hz)} for onset in edits.added]
    random.shuffle(rows)
    _write(file, [*rows, *new])
    require_exactly(wanted_of(file, edits), edits)


@SHARED_FOLDER
@given(edited())
def test_a_spreadsheet_that_shows_few_digits_moves_nothing(tmp_path: Path, edits: Edits) -> None:
    """Excel saves what it shows: ten digits of the seconds, all of the samples."""
    [file] = export_timeline(edits.before, tmp_path, formats=["csv"])
    with file.open(newline="") as text:
        rows = [row for row in csv.DictReader(text) if edits.onsets[row["id"]] is not None]
    for row in rows:
        for name in ("onset_s", "window_start_s", "window_stop_s", "peak_dbfs", "confidence"):
            row[name] = f"{float(row[name]):.10g}"
        row["onset_sample"] = str(edits.onsets[row["id"]])
    _write(file, [*rows, *({"onset_sample": str(onset)} for onset in edits.added)])
    kept = {name: onset for name, onset in edits.onsets.items() if onset in (None, edits.originals[name].onset_sample)}
    if kept.keys() == edits.onsets.keys():
        require_exactly(wanted_of(file, edits), edits)


@SHARED_FOLDER
@given(edited(), st.sampled_from([6, 9]))
def test_edits_of_a_label_track_come_back(tmp_path: Path, edits: Edits, decimals: int) -> None:
    """Audacity writes six decimals; a label that was dragged keeps its text, a new one may have none."""
    file = tmp_path / "labels.txt"
    lines = []
    for event in edits.before.events:
        onset = edits.onsets[event.id]
        if onset is not None:
            start_s, stop_s = onset / edits.rate_hz, max(onset + 1, event.window.stop) / edits.rate_hz
            lines.append(f"{start_s:.{decimals}f}\t{stop_s:.{decimals}f}\t{event.id} {event.confidence:.2f}\n")
    lines += [f"{onset / edits.rate_hz:.6f}\t{onset / edits.rate_hz:.6f}\t\n" for onset in edits.added]
    file.write_text("".join(lines))
    require_exactly(wanted_of(file, edits), edits)


@SHARED_FOLDER
@given(edited())
def test_edits_of_reapers_regions_come_back_to_its_millisecond(tmp_path: Path, edits: Edits) -> None:
    file = tmp_path / "regions.csv"
    lines = ["#,Name,Start,End,Length\n"]
    for event in edits.before.events:
        onset = edits.onsets[event.id]
        if onset is not None:
            start, stop = onset / edits.rate_hz, max(event.window.stop, onset + edits.rate_hz // 100) / edits.rate_hz
            lines.append(f"R1,{event.id} {event.confidence:.2f},{_clock(start)},{_clock(stop)},\n")
    lines += [f"M1,,{_clock(onset / edits.rate_hz)},,\n" for onset in edits.added]
    file.write_text("".join(lines))
    require_exactly(wanted_of(file, edits), edits, within=edits.rate_hz // 2000 + 1)


def _cell(column: str, onset: int, rate_hz: int) -> str:
    """Return what is typed: seconds with all decimals, since 0.0 alone in its column could be 0.01 to a decimal."""
    return str(onset) if column == "onset_sample" else f"{onset / rate_hz:.9f}"


def _clock(seconds: float) -> str:
    whole, ms = divmod(round(seconds * 1000), 1000)
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}.{ms:03}"


def _write(file: Path, rows: Sequence[Mapping[str, str]]) -> None:
    columns = list(dict.fromkeys(name for row in rows for name in row)) or ["onset_s"]
    with file.open("w", newline="") as text:
        table = csv.DictWriter(text, columns)
        table.writeheader()
        table.writerows(rows)


EVENT = msgspec.structs.replace(SHOT, id="shot-0001")
MATE = msgspec.structs.replace(
    SHOT, id="shot-0002", onset_sample=57_601, onset_s=57_601 / 48_000, blast=Span(57_601, 57_700)
)


@pytest.mark.parametrize(
    ("count_hz", "what"),
    [
        (Fraction(24_000, 1001), "frames"),
        (Fraction(25), "frames"),
        (Fraction(60), "frames"),
        (Fraction(44_100), "samples at 44100 Hz"),
        (Fraction(96_000), "samples at 96000 Hz"),
    ],
)
@pytest.mark.parametrize("round_off", [math.floor, round])
def test_numbers_of_another_ruler_are_no_samples(
    tmp_path: Path, count_hz: Fraction, what: str, round_off: Callable[[Fraction], int]
) -> None:
    """Two of five shots were moved or renamed; two are in one frame."""
    onsets = [48_001, 57_601, 58_001, 480_000, 9_600_007]
    events = [
        msgspec.structs.replace(EVENT, id=f"shot-{n:04}", onset_sample=at, blast=Span(at, at + 9), window=_around(at))
        for n, at in enumerate(onsets, start=1)
    ]
    numbers = [round_off(at * count_hz / 48_000) for at in onsets]
    numbers[3] += round_off(7 * count_hz)
    file = tmp_path / "markers.csv"
    rows = [f"M{n},shot-{n:04} 0.97,{number},,\n" for n, number in enumerate(numbers, start=1)]
    file.write_text("".join(["#,Name,Start,End,Length\n", *rows[:4], "M5,mine,7,,\n"]))
    said = f"line 2: Start = '{numbers[0]}': counts {what}, as the original's times tell; expected seconds, or samples"
    with pytest.raises(TimelineError, match=re.escape(said)):
        match(read_edits(file), {event.id: event for event in events}, rate_hz=48_000)


def test_samples_of_few_shots_that_were_moved_are_samples(tmp_path: Path) -> None:
    """Half of the rows tell nothing, and none does that fits as it is."""
    file = tmp_path / "markers.csv"
    file.write_text("#,Name,Start,End,Length\nM1,shot-0001,25,,\nM2,shot-0002,57602,,\nM3,shot-0003,1,,\n")
    first = msgspec.structs.replace(EVENT, id="shot-0003", onset_sample=0, blast=Span(0, 9), window=_around(0))
    wanted = match(read_edits(file), {event.id: event for event in (EVENT, MATE, first)}, rate_hz=48_000)
    assert [(wish.id, wish.onset) for wish in wanted.wishes] == [
        ("shot-0003", 1),
        ("shot-0001", 25),
        ("shot-0002", 57_602),
    ]


def _around(onset: int) -> Window:
    return Window(max(0, onset - 200), onset + 300, 0, 0)


def table(tmp_path: Path, text: str, *events: Event) -> Wanted:
    """Return what a table wants of a film in which these events were found."""
    file = tmp_path / "edited.csv"
    file.write_text(text)
    return match(read_edits(file), {event.id: event for event in events}, rate_hz=48_000)


@pytest.mark.parametrize(
    ("row", "onset"),
    [
        ("48001,1.5", 72_000),
        ("72000,1.000020833", 72_000),
        ("72000,1.5", 72_000),
        ("48001,1.00002", 48_001),
        ("48001,1", 48_001),
        (",1.000021", 48_001),
        (",1.0001", 48_005),
        ("48002,1.000020833", 48_002),
    ],
)
def test_of_sample_and_seconds_the_one_that_was_edited_counts(tmp_path: Path, row: str, onset: int) -> None:
    [wish] = table(tmp_path, f"id,onset_sample,onset_s\nshot-0001,{row}\n", EVENT).wishes
    assert (wish.onset, wish.unmoved) == (onset, onset == 48_001)


def test_seconds_of_few_digits_in_a_document_were_typed(tmp_path: Path) -> None:
    found = msgspec.structs.replace(EVENT, onset_sample=49_920, onset_s=1.04, blast=Span(49_920, 50_100))
    fields = msgspec.to_builtins(timeline(found))
    fields["events"][0]["onset_s"] = 1.0
    file = tmp_path / "edited.json"
    file.write_bytes(msgspec.json.encode(fields))
    [wish] = match(read_edits(file), {found.id: found}, rate_hz=48_000).wishes
    assert (wish.onset, wish.unmoved) == (48_000, False)


@pytest.mark.parametrize("inside", ["\x0b", "\x0c", "\x85", "\u2028"])
def test_what_ends_no_line_divides_no_row(tmp_path: Path, inside: str) -> None:
    text = f"id,onset_sample,note\nshot-0001,48001,a{inside}b\nshot-0002,57601,c\n"
    first, second = table(tmp_path, text, EVENT, MATE).wishes
    assert first.unmoved
    assert second.unmoved


def test_an_id_with_more_digits_than_any_count_is_only_a_name(tmp_path: Path) -> None:
    name = f"shot-{'9' * 5000}"
    fresh, named = table(tmp_path, f"id,onset_sample\n{name},48001\n,5\n").wishes
    assert (fresh.id, named.id) == ("shot-0001", name)


def test_a_short_number_that_somebody_typed_is_exact(tmp_path: Path) -> None:
    longer = "shot-0002,1.200020833\n"
    [first, _] = table(tmp_path, f"id,onset_s\nshot-0001,1\n{longer}", EVENT, MATE).wishes
    assert (first.onset, first.unmoved) == (48_000, False)
    [alone] = table(tmp_path, "id,onset_s\nshot-0001,1.1\n", msgspec.structs.replace(EVENT, onset_sample=51_000)).wishes
    assert (alone.onset, alone.unmoved) == (52_800, False)


def test_digits_that_ran_out_late_in_a_film_move_nothing(tmp_path: Path) -> None:
    """Ten digits are 10 us after the first 10,000 seconds: two samples at 192 kHz."""
    late = round(10_500.123454 * 192_000)
    known = {
        "a": msgspec.structs.replace(EVENT, id="a"),
        "b": msgspec.structs.replace(EVENT, id="b", onset_sample=late),
    }
    file = tmp_path / "edited.csv"
    file.write_text("id,onset_s\na,0.2500052083\nb,10500.12345\n")
    assert [wish.unmoved for wish in match(read_edits(file), known, rate_hz=192_000).wishes] == [True, True]


@pytest.mark.parametrize(
    ("row", "onset"),
    [("48001,1.5,48001", 72_000), ("72000,1.000020833,48001", 72_000), ("48001,1.00002,48001", 48_001)],
)
def test_without_the_original_the_blast_tells_which_was_edited(tmp_path: Path, row: str, onset: int) -> None:
    [wish] = table(tmp_path, f"id,onset_sample,onset_s,blast_start_sample\nshot-0001,{row}\n").wishes
    assert wish.onset == onset


def test_a_row_that_lost_its_id_is_the_event_at_its_time(tmp_path: Path) -> None:
    wanted = table(tmp_path, "onset_s\n1.20\n1.000\n3.0\n", EVENT, MATE)
    assert [(w.id, w.onset, w.unmoved) for w in wanted.wishes] == [
        ("shot-0001", 48_001, True),
        ("shot-0002", 57_601, True),
        ("shot-0003", 144_000, False),
    ]


@SHARED_FOLDER
@given(films(), st.data(), st.sampled_from(["json", "csv", "audacity", "reaper"]))
def test_an_event_with_another_id_is_the_same_event(
    tmp_path: Path, before: Timeline, data: st.DataObject, name: str
) -> None:
    """Who gives shots names of their own has deleted and added nothing, whatever tool wrote the file."""
    new = {
        event.id: f"shot-9{index:03d}" if data.draw(st.booleans()) else event.id
        for index, event in enumerate(before.events)
    }
    renamed = tuple(msgspec.structs.replace(event, id=new[event.id]) for event in before.events)
    [file] = export_timeline(msgspec.structs.replace(before, events=renamed), tmp_path, formats=[name])
    originals = {event.id: event for event in before.events}
    wanted = match(read_edits(file), originals, rate_hz=before.source.sample_rate_hz)
    assert [(wish.id, wish.was) for wish in wanted.wishes] == [(new[event.id], event) for event in before.events]
    assert all(wish.unmoved and not wish.changed for wish in wanted.wishes)
    assert [wish.window for wish in wanted.wishes] == [event.window for event in before.events]
    assert wanted.deleted == ()


@pytest.mark.parametrize("identity", ["", "mine"])
@pytest.mark.parametrize("column", ["onset_sample", "onset_s"])
@pytest.mark.parametrize("suffix", [".csv", ".json"])
def test_a_copied_row_with_another_onset_is_added(tmp_path: Path, identity: str, column: str, suffix: str) -> None:
    """Whatever else the copy says, "found" among it, nobody had found it there."""
    before = timeline(EVENT)
    [file] = export_timeline(before, tmp_path, formats=[suffix[1:]])
    onset = 144_000
    said = onset if column == "onset_sample" else onset / RATE_HZ
    if suffix == ".csv":
        with file.open(newline="") as text:
            [row] = csv.DictReader(text)
        _write(file, [row, row | {"id": identity, column: str(said)}])
    else:
        plain = json.loads(file.read_bytes())
        plain["events"].append(plain["events"][0] | {"id": identity or None, column: said})
        file.write_text(json.dumps(plain))
    original, copy = match(read_edits(file), {EVENT.id: EVENT}, rate_hz=RATE_HZ).wishes
    assert (original.was, original.unmoved, original.origin) == (EVENT, True, "found")
    assert (copy.id, copy.onset, copy.was, copy.origin) == (identity or "shot-0002", onset, None, "added")


@pytest.mark.parametrize("seconds", ["12.4", "12.400"])
def test_a_rounded_time_that_is_there_twice_is_refused(tmp_path: Path, seconds: str) -> None:
    """The first row is the original event, a sample later; the second is no shot a sample beside it."""
    event = msgspec.structs.replace(SHOT, onset_sample=round(12.4 * RATE_HZ) + 1)
    (tmp_path / "edited.csv").write_text(f"onset_s\n{seconds}\n{seconds}\n")
    with pytest.raises(TimelineError, match=r"edited\.csv: line 3: onset_s = 12\.4\d*: line 2 has it too, at 12\.4"):
        match(read_edits(tmp_path / "edited.csv"), {event.id: event}, rate_hz=RATE_HZ)


def test_a_new_id_takes_no_event_that_another_row_names(tmp_path: Path) -> None:
    wanted = table(tmp_path, "id,onset_s\nmine,1.00002\nshot-0001,3.0\nother,1.20002\n", EVENT, MATE)
    assert [(wish.id, wish.was) for wish in wanted.wishes] == [("mine", None), ("other", MATE), ("shot-0001", EVENT)]
    assert wanted.deleted == ()


def test_a_new_id_is_none_that_was_ever_used(tmp_path: Path) -> None:
    wanted = table(tmp_path, "id,onset_s\n,3.0\nshot-0007,4.0\n,5.0\n", EVENT, MATE)
    assert [wish.id for wish in wanted.wishes] == ["shot-0008", "shot-0007", "shot-0009"]


def test_a_shared_window_is_kept_only_while_all_its_shots_are(tmp_path: Path) -> None:
    both = "id,onset_s\nshot-0001,1.00002\nshot-0002,1.20002\n"
    assert [wish.window for wish in table(tmp_path, both, EVENT, MATE).wishes] == [SHOT.window] * 2
    one = table(tmp_path, both.rsplit("shot-0002", 1)[0], EVENT, MATE)
    assert [(wish.window, wish.start, wish.stop) for wish in one.wishes] == [(None, None, None)]


@pytest.mark.parametrize(
    ("cells", "complaint"),
    [
        (f"{SHOT.window.stop},0.5", "window_stop_s = 0.5: expected more than 1.00002083"),
        ("24000,1.5", "window_stop_sample = 24000: expected more than 48001"),
        ("24000,0.5", "window_stop_sample = 24000: expected more than 48001"),
        (",0.5", "window_stop_s = 0.5: expected more than 1.00002083"),
    ],
)
def test_an_end_that_cannot_be_is_named_by_the_cell_that_counts(tmp_path: Path, cells: str, complaint: str) -> None:
    """A number that stands nowhere in the file could not be found there."""
    row = f"id,onset_s,window_stop_sample,window_stop_s\nshot-0001,1.00002,{cells}\n"
    with pytest.raises(TimelineError, match=complaint.replace(".", r"\.")):
        table(tmp_path, row, EVENT)


def test_an_end_that_was_edited_is_kept_and_the_other_stays(tmp_path: Path) -> None:
    [wish] = table(tmp_path, "id,onset_s,window_stop_s\nshot-0001,1.00002,1.25\n", EVENT).wishes
    assert (wish.window, wish.start, wish.stop, wish.changed) == (None, SHOT.window.start, 60_000, True)


def test_a_window_cut_shorter_than_its_fades_keeps_its_ends_and_gets_new_fades(tmp_path: Path) -> None:
    window = msgspec.structs.replace(SHOT.window, stop=SHOT.onset_sample + 1_500)
    cut = msgspec.structs.replace(EVENT, window=window)
    file = tmp_path / "timeline.json"
    file.write_bytes(encode(timeline(cut)))
    [wish] = match(read_edits(file), None, rate_hz=RATE_HZ).wishes
    assert (wish.window, wish.start, wish.stop) == (None, window.start, window.stop)


def test_a_window_that_stayed_behind_in_a_table_is_planned_anew(tmp_path: Path) -> None:
    row = f"id,onset_s,window_start_sample,window_stop_sample\nshot-0001,3.0,{SHOT.window.start},{SHOT.window.stop}\n"
    [wish] = table(tmp_path, row, EVENT).wishes
    assert (wish.window, wish.start, wish.stop) == (None, None, None)


@pytest.mark.parametrize(("cell", "confidence"), [("0.96875", 0.96875), ("0.97", 0.96875), ("0.5", 0.5), ("", 0.96875)])
def test_a_confidence_with_fewer_digits_is_the_same(tmp_path: Path, cell: str, confidence: float) -> None:
    [wish] = table(tmp_path, f"id,onset_s,confidence\nshot-0001,1.00002,{cell}\n", EVENT).wishes
    assert (wish.confidence, wish.changed) == (confidence, confidence != EVENT.confidence)


def test_a_gain_changes_an_event_and_moves_nothing(tmp_path: Path) -> None:
    [wish] = table(tmp_path, "id,onset_s,gain_db\nshot-0001,1.00002,-3\n", EVENT).wishes
    assert (wish.gain_db, wish.changed, wish.unmoved, wish.window) == (-3.0, True, True, SHOT.window)


@pytest.mark.parametrize(
    ("before", "cell", "after"),
    [
        (0.5, "0", 0.0),
        (1.5, "2", 2.0),
        (2.5, "2", 2.0),
        (-1.5, "-1", -1.0),
        (1.25, "1.2", 1.2),
        (1.2345, "1.23", 1.2345),
    ],
)
def test_a_gain_that_a_hand_types_short_is_what_it_says(tmp_path: Path, before: float, cell: str, after: float) -> None:
    event = msgspec.structs.replace(EVENT, gain_db=before)
    [wish] = table(tmp_path, f"id,onset_s,gain_db\nshot-0001,1.00002,{cell}\n", event).wishes
    assert wish.gain_db == after


def test_a_shot_can_be_rated_as_sure_or_as_none(tmp_path: Path) -> None:
    for cell, rated in (("1", 1.0), ("0", 0.0), ("0.9", 0.9)):
        [wish] = table(tmp_path, f"id,onset_s,confidence\nshot-0001,1.00002,{cell}\n", EVENT).wishes
        assert wish.confidence == rated
