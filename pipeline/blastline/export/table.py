"""`timeline.csv`: one flat row per event, the unit in each column's name."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from ..model import Event, Source, Timeline
from ..timecode import FrameScale, frame_scale, frame_time

if TYPE_CHECKING:
    from pandas import DataFrame

COLUMNS: Mapping[str, str] = MappingProxyType(
    {
        "id": "string",
        "onset_sample": "Int64",
        "onset_s": "float64",
        "timecode": "string",
        "timecode_offset_ms": "float64",
        "confidence": "float64",
        "burst": "Int64",
        "shot_in_burst": "Int64",
        "peak_dbfs": "float64",
        "snr_db": "float64",
        "azimuth_deg": "float64",
        "azimuth_focus": "float64",
        "heard_in": "string",
        "blast_start_sample": "Int64",
        "blast_stop_sample": "Int64",
        "reflections": "Int64",
        "first_reflection_delay_ms": "float64",
        "window_start_sample": "Int64",
        "window_stop_sample": "Int64",
        "window_start_s": "float64",
        "window_stop_s": "float64",
        "gain_db": "float64",
        "origin": "string",
        "drive_model": "string",
        "drive_reason": "string",
        "drive_peak": "float64",
        "perceived_gain_db": "float64",
        "fidelity": "float64",
        "drive_made_of": "string",
    }
)
"""The columns in order, each with its pandas type; a cell is empty where an event has no such value.

Text is pandas' own `string`: as `str` pandas 2 takes what is missing for the text None.

`timecode_offset_ms` is how much later than the frame of `timecode` the event is: empty where that is a clock.

`pandas.read_csv(path, dtype=dict(COLUMNS))` gives back every number to the last bit; pandas 2 needs
`float_precision="round_trip"` for it, which later ones do by themselves.
"""


def table(timeline: Timeline) -> "DataFrame":
    """Return the events as a pandas table with the columns and types of `COLUMNS`, as Parquet and databases take it."""
    import pandas

    rows = [_row(event, timeline.source) for event in timeline.events]
    return pandas.DataFrame(rows, columns=list(COLUMNS)).astype(dict(COLUMNS))


def write_csv(timeline: Timeline, path: Path) -> None:
    """Write the events' `table`."""
    table(timeline).to_csv(path, index=False, lineterminator="\n", encoding="utf-8")


def _row(event: Event, source: Source) -> dict[str, str | float | None]:
    """Return one event's cells."""
    drive, rate_hz, scale = event.drive, source.sample_rate_hz, frame_scale(source)
    first = min(event.reflections, key=lambda reflection: reflection.start, default=None)
    return {
        "id": event.id,
        "onset_sample": event.onset_sample,
        "onset_s": event.onset_s,
        "timecode": event.timecode,
        "timecode_offset_ms": _offset_ms(event, source, scale) if scale else None,
        "confidence": event.confidence,
        "burst": event.burst,
        "shot_in_burst": event.shot_in_burst,
        "peak_dbfs": event.peak_dbfs,
        "snr_db": event.snr_db,
        "azimuth_deg": event.azimuth_deg,
        "azimuth_focus": event.azimuth_focus,
        "heard_in": event.heard_in,
        "blast_start_sample": event.blast.start,
        "blast_stop_sample": event.blast.stop,
        "reflections": len(event.reflections),
        "first_reflection_delay_ms": first.delay_ms if first else None,
        "window_start_sample": event.window.start,
        "window_stop_sample": event.window.stop,
        "window_start_s": event.window.start / rate_hz,
        "window_stop_s": event.window.stop / rate_hz,
        "gain_db": event.gain_db,
        "origin": event.origin,
        "drive_model": drive.model if drive else None,
        "drive_reason": drive.reason if drive else None,
        "drive_peak": drive.peak if drive else None,
        "perceived_gain_db": drive.perceived_gain_db if drive else None,
        "fidelity": drive.fidelity if drive else None,
        "drive_made_of": drive.made_of if drive else None,
    }


def _offset_ms(event: Event, source: Source, scale: FrameScale) -> float:
    return float(1000 * frame_time(source, event.onset_sample, scale).offset_s)
