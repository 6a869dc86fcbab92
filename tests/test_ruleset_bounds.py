"""What a rule file may ask for has ends on both sides, and from end to end a film can be searched with it."""

import math
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import inspect
from numpy.typing import NDArray

from blastline.detect import find_shots, verifier_of
from blastline.model import Channels, Clip, Span
from blastline.ruleset import QualityRules, SceneRules, load_measuring, load_rules
from blastline.ruleset.table import Table
from blastline.ruleset.tables import SegmentRules

RATE_HZ = 48_000
TIER = load_rules("standard").tier
VERIFIER = verifier_of(TIER)
TABLES = [field.type for field in msgspec.structs.fields(QualityRules) if field.name not in ("schema", "source")]
RISING = ("report_from", "round_threshold", "even_threshold", "company_threshold", "burst_threshold", "threshold")
"""An order that the thresholds of [verify] may have."""
ASCENDING = (
    ("shortest_gap_ms", "longest_gap_ms"),
    ("sides_company_threshold", "sides_threshold"),
    ("shortest_ms", "longest_ms"),
)


def numbers(table: type[Table]) -> dict[str, tuple[Any, Any]]:
    """Return the lowest and the highest value of each number in a table."""
    found = {}
    plain = inspect.type_info(table)
    assert isinstance(plain, inspect.StructType)
    for field in plain.fields:
        kinds = field.type.types if isinstance(field.type, inspect.UnionType) else (field.type,)
        for kind in kinds:
            if isinstance(kind, inspect.FloatType):
                low = kind.ge if kind.gt is None else math.nextafter(kind.gt, math.inf)
                high = kind.le if kind.lt is None else math.nextafter(kind.lt, -math.inf)
                found[field.name] = (low, high)
            elif isinstance(kind, inspect.IntType):
                found[field.name] = (kind.ge, kind.le)
    return found


def film() -> NDArray[np.float32]:
    """Return two seconds of noise, with a bang that comes again and again, weaker."""
    random = np.random.default_rng(3)
    samples = random.normal(0.0, 1e-3, 2 * RATE_HZ)
    time_s = np.arange(4_000) / RATE_HZ
    bang = np.exp(-time_s / 0.02) * random.normal(size=time_s.size)
    for start in range(10_000, samples.size - bang.size, 6_000):
        samples[start : start + bang.size] += (0.8 if start == 10_000 else 0.2) * bang
    return np.asarray(np.clip(samples, -1.0, 1.0), np.float32)


FILM = film()


def two_channels(span: Span) -> NDArray[np.float32]:
    """Return a stretch of the film as both of its loudspeakers play it."""
    return FILM[span.start : span.stop, None] * np.array([1.0, 0.5], np.float32)


@st.composite
def tables(draw: st.DrawFn) -> QualityRules:
    """Draw a tier whose numbers are at an end of what is allowed, or as they come; SegmentRules stay as they come."""
    plain = msgspec.to_builtins(TIER)
    for name, table in ((name, getattr(TIER, name)) for name in plain if isinstance(plain[name], dict)):
        if not isinstance(table, SegmentRules):
            usual = plain[name]
            drawn: dict[str, Any] = {
                key: draw(st.sampled_from([usual[key], *ends])) for key, ends in numbers(type(table)).items()
            }
            if name == "verify":
                drawn |= dict(zip(RISING, sorted(drawn[key] for key in RISING), strict=True))
            for low, high in ASCENDING:
                if low in drawn and drawn[low] >= drawn[high]:
                    drawn |= {low: usual[low], high: usual[high]}
            if drawn.get("longest_loop_s", math.inf) < drawn.get("longest_gap_ms", 0.0) / 1000.0:
                drawn["longest_loop_s"] = 60.0
            plain[name] = usual | drawn
    return msgspec.convert(plain, QualityRules)


@pytest.mark.parametrize("table", [*[table for table in TABLES if table is not SegmentRules], SceneRules])
def test_every_number_has_a_lowest_and_a_highest_value(table: type[Table]) -> None:
    open_ends = [key for key, ends in numbers(table).items() if None in ends]
    assert open_ends == []


@settings(max_examples=60)
@given(tables(), st.sampled_from([8_000, RATE_HZ]))
def test_a_film_is_searched_to_its_end_by_rules_at_their_ends(tier: QualityRules, rate_hz: int) -> None:
    clip = Clip(FILM[:, None], rate_hz, sides=FILM if tier.channels.sides else None)
    channels = Channels((-30.0, 30.0), None, two_channels)
    found = find_shots([clip], rate_hz=rate_hz, tier=tier, verifier=VERIFIER, channels=channels)
    assert [shot.onset for shot in found.shots] == sorted(shot.onset for shot in found.shots)


@pytest.mark.parametrize(
    ("low", "high"),
    [
        ("shortest_gap_ms", "longest_gap_ms"),
        ("shortest_ms", "longest_ms"),
        ("earliest_reflection_ms", "latest_reflection_ms"),
        ("rumble_hz", "band_hz"),
        ("rumble_hz", "highest_hz"),
    ],
)
def test_a_range_that_ends_where_it_begins_is_refused_in_every_table(low: str, high: str) -> None:
    fields = [getattr(TIER, field.name) for field in msgspec.structs.fields(TIER)]
    tables = [table for table in (*fields, load_measuring().fit) if hasattr(table, low) and hasattr(table, high)]
    assert tables
    for table in tables:
        with pytest.raises(ValueError, match=f"{low} = .* expected less than {high}"):
            msgspec.structs.replace(table, **{high: getattr(table, low)})
