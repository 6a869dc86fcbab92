"""Laws of spans and clips, and the contract of `timeline.json`."""

import json
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from blastline.model import Check, Clip, Span, Timeline, encode, schema
from timelines import SHOT, any_timeline, timeline

SCHEMA_FILE = Path(__file__).parents[1] / "docs" / "timeline.schema.json"


@st.composite
def spans(draw: st.DrawFn) -> Span:
    start = draw(st.integers(-20, 40))
    return Span(start, start + draw(st.integers(0, 30)))


@given(spans(), spans(), st.integers(-40, 100))
def test_a_sample_is_in_the_intersection_where_it_is_in_both(a: Span, b: Span, sample: int) -> None:
    assert (sample in (a & b)) == (sample in a and sample in b)


@given(spans(), spans(), spans())
def test_intersection_is_a_meet(a: Span, b: Span, c: Span) -> None:
    assert a & b == b & a
    assert (a & b) & c == a & (b & c)
    assert a & a == a
    assert a & (a | b) == a


@given(spans(), spans(), spans())
def test_union_is_the_smallest_span_that_covers_both(a: Span, b: Span, c: Span) -> None:
    union = a | b
    assert union == b | a
    assert union | c == a | (b | c)
    assert union & a == a
    assert union & b == b
    assert {union.start, union.stop} <= {a.start, a.stop, b.start, b.stop}


@given(spans(), spans(), st.integers(-100, 100))
def test_a_delay_in_is_a_delay_out(a: Span, b: Span, delay: int) -> None:
    def later(span: Span) -> Span:
        return Span(span.start + delay, span.stop + delay)

    assert later(a) & later(b) == later(a & b)
    assert later(a) | later(b) == later(a | b)
    assert len(later(a)) == len(a)
    assert (later(a) < later(b)) == (a < b)


@given(spans())
def test_length_truth_and_membership_agree(span: Span) -> None:
    inside = [sample for sample in range(-40, 100) if sample in span]
    assert len(span) == len(inside)
    assert bool(span) == bool(inside)


@given(st.lists(spans()))
def test_spans_sort_by_their_start(unsorted: list[Span]) -> None:
    starts = [span.start for span in sorted(unsorted)]
    assert starts == sorted(starts)


def test_a_span_must_not_run_backwards() -> None:
    with pytest.raises(ValueError, match="a span must not run backwards: 4 to 3"):
        Span(4, 3)
    with pytest.raises(msgspec.ValidationError, match="must not run backwards"):
        msgspec.convert({"start_sample": 4, "stop_sample": 3}, Span)


@given(st.data())
def test_a_cut_holds_the_films_samples_at_their_place(data: st.DataObject) -> None:
    start, frames = data.draw(st.integers(0, 50)), data.draw(st.integers(1, 50))
    film = np.arange(200.0).reshape(100, 2)
    clip = Clip(film[start : start + frames], 48_000, start)
    first = data.draw(st.integers(clip.span.start, clip.span.stop))
    part = Span(first, data.draw(st.integers(first, clip.span.stop)))
    cut = clip.slice(part)
    assert cut.span == part
    np.testing.assert_array_equal(cut.samples, film[part.start : part.stop])
    np.testing.assert_array_equal(clip.slice(clip.span).samples, clip.samples)


@pytest.mark.parametrize("span", [Span(9, 12), Span(12, 21), Span(0, 30)])
def test_a_cut_outside_the_clip_is_refused(span: Span) -> None:
    with pytest.raises(ValueError, match="does not lie within"):
        Clip(np.zeros((10, 1)), 48_000, 10).slice(span)


def test_detection_listens_to_the_first_column_and_the_last_one_drives() -> None:
    two = Clip(np.array([[1.0, 2.0]]), 48_000)
    one = Clip(np.array([[3.0]]), 48_000)
    assert (two.heard[0], two.driving[0], one.heard[0], one.driving[0]) == (1.0, 2.0, 3.0, 3.0)


@given(any_timeline())
def test_a_timeline_survives_its_file(original: Timeline) -> None:
    assert msgspec.json.decode(encode(original), type=Timeline) == original


def test_a_timeline_that_was_read_is_written_as_it_was() -> None:
    """A check may have counted: 48000, where a number belongs."""
    counted = msgspec.structs.replace(timeline(SHOT), checks=(Check("sample_rate", None, True, 48_000, 48_000, "Hz"),))
    assert encode(msgspec.json.decode(encode(counted), type=Timeline)) == encode(counted)


def test_the_files_keys_are_those_that_were_promised() -> None:
    plain = json.loads(encode(timeline()))
    promised = ["schema", "version", "quality", "rules_digest", "source", "actuator", "events", "rejections", "checks"]
    assert list(plain) == [*promised, "phase", "background", "level_db", "edits", "budget"]
    shot = plain["events"][0]
    assert list(shot)[:7] == ["id", "onset_sample", "onset_s", "timecode", "confidence", "burst", "shot_in_burst"]
    assert list(shot)[7:15] == ["peak_dbfs", "snr_db", "blast", "reflections", "window", "drive", "origin", "gain_db"]
    assert list(shot)[15:] == ["heard_in", "azimuth_deg", "azimuth_focus", "decisions"]
    assert plain["edits"] is None
    assert plain["budget"] is None
    source = {"name", "sha256", "sample_rate_hz", "frames", "channels", "start_timecode", "frame_rate"}
    assert source <= set(plain["source"])
    assert list(plain["actuator"]) == ["name", "digest"]
    assert list(shot["blast"]) == ["start_sample", "stop_sample"]
    assert list(shot["reflections"][0]) == ["start_sample", "stop_sample", "delay_ms", "level_db"]
    assert list(shot["window"]) == ["start_sample", "stop_sample", "fade_in_samples", "fade_out_samples"]
    assert list(shot["drive"]) == [
        "model",
        "reason",
        "peak",
        "perceived_gain_db",
        "fidelity",
        "solver_steps",
        "explained",
        "evidence",
        "made_of",
        "raised_db",
    ]
    assert list(plain["rejections"][0]) == ["at_sample", "reason", "evidence"]
    assert list(plain["checks"][0]) == ["name", "event", "passed", "measured", "limit", "unit"]


def test_a_timeline_that_could_not_be_read_back_is_not_written() -> None:
    with pytest.raises(msgspec.ValidationError, match="snr_db"):
        encode(timeline(msgspec.structs.replace(SHOT, snr_db=math.nan)))


def test_the_shipped_schema_is_that_of_the_types() -> None:
    assert json.loads(SCHEMA_FILE.read_text(encoding="utf-8")) == json.loads(json.dumps(schema())), "run: make schema"
