"""Meta's `.haptic` 1.0 (Lofelt before it): a file for each reel, and a table that says where in the film each begins.

Readers keep its seconds in 32 bits; below 1,024 s neighbouring ones are 2^-14 s = 0.061 ms apart, so reels are shorter.
Each lasts to where the next begins, so that reels in a row are the film. Amplitude 1 is the actuator's limit; frequency
0 to 1 stands for 30 to 600 Hz, as Meta's own analysis maps it. A pulse is an emphasis, which may not be weaker than the
vibration at its point.
"""

import csv
import itertools
from fractions import Fraction
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...model import Span
from ...plurals import counted
from ...timecode import clock_text
from .curve import Curve, reduced
from .reels import reel_edges
from .rounding import Rounding, late_ms, mistuned, off, within
from .track import HapticTrack, Pulse

REELS, INDEX = "timeline.reel-*.haptic", "timeline.reels.csv"
LOW_HZ, HIGH_HZ = 30.0, 600.0

_DECIMALS = 6
_VALUE_DECIMALS = 4


def write_haptic(track: HapticTrack, folder: Path) -> Rounding:
    """Write the reels and their table; a reel without vibration is two points of amplitude 0."""
    amplitude, frequency, rounding = _lines(track)
    edges = reel_edges(track)
    digits = max(2, len(str(len(edges) - 1)))
    rows = []
    for number, (start, stop) in enumerate(itertools.pairwise(edges), start=1):
        reel = Span(start, stop)
        name = REELS.replace("*", f"{number:0{digits}}")
        pulses = [pulse for pulse in track.pulses if pulse.sample in reel]
        reel_lines = [
            _amplitude_points(amplitude, pulses, reel, track.rate_hz),
            _frequency_points(frequency, reel, track.rate_hz),
        ]
        rounding |= Rounding(max(_late_ms(amplitude, reel, track.rate_hz), _late_ms(frequency, reel, track.rate_hz)))
        _write(folder / name, track, *reel_lines)
        rows.append(
            [
                name,
                start,
                _seconds(start / track.rate_hz),
                clock_text(Fraction(start // track.rate_hz), 0, hour_digits=1),
                _seconds(min(stop, track.frames) / track.rate_hz),
                len(pulses),
            ]
        )
    _write_index(folder / INDEX, rows)
    return rounding | Rounding(notes=(f"{counted(len(rows), 'reel')}, see {INDEX}",))


def _lines(track: HapticTrack) -> tuple[Curve, Curve, Rounding]:
    """Return the film's amplitude and frequency as one curve each, 0 to 1, reduced, with a point at every pulse."""
    empty = Curve(np.zeros(0, np.int64), np.zeros(0))
    amplitudes, frequencies, rounding = [empty], [empty], Rounding(pulses=len(track.pulses))
    onsets = np.array([pulse.sample for pulse in track.pulses], np.int64)
    for segment in track.segments:
        few = reduced(segment.amplitude, track.amplitude_error)
        own = onsets[(onsets >= segment.span.start) & (onsets <= segment.span.stop)]
        samples = np.union1d(few.samples, own)
        line = Curve(samples, np.round(few.at(samples), _VALUE_DECIMALS))
        tone_hz, notes = within(segment.frequency_hz, LOW_HZ, HIGH_HZ)
        few_hz = reduced(tone_hz, track.frequency_error, relative=True)
        toned = few_hz.with_values(np.round(_normalised(few_hz.values), _VALUE_DECIMALS))
        amplitudes.append(line)
        frequencies.append(toned)
        back_hz = toned.with_values(LOW_HZ + (HIGH_HZ - LOW_HZ) * toned.values)
        errors = (off(segment.amplitude, line), mistuned(tone_hz, back_hz))
        rounding |= Rounding(0.0, *errors, points=len(line) + len(toned), notes=notes)
    return _chained(amplitudes), _chained(frequencies), rounding


def _amplitude_points(curve: Curve, pulses: list[Pulse], reel: Span, rate_hz: int) -> list[dict[str, Any]]:
    pulse_at = {pulse.sample: pulse for pulse in pulses}
    points = []
    for sample, value in _within(curve, reel):
        point: dict[str, Any] = {"time": _seconds((sample - reel.start) / rate_hz), "amplitude": value}
        pulse = pulse_at.get(sample)
        if pulse is not None:
            strength = max(value, round(pulse.amplitude, _VALUE_DECIMALS))
            tone = float(np.round(_normalised(np.array([pulse.frequency_hz])), _VALUE_DECIMALS)[0])
            point["emphasis"] = {"amplitude": strength, "frequency": tone}
        points.append(point)
    return points


def _frequency_points(curve: Curve, reel: Span, rate_hz: int) -> list[dict[str, Any]]:
    if not len(curve):
        return []
    return [{"time": _seconds((s - reel.start) / rate_hz), "frequency": value} for s, value in _within(curve, reel)]


def _within(curve: Curve, reel: Span) -> list[tuple[int, float]]:
    """Return the points of a reel, with one at its start and one at its end; 0 where the film has no vibration."""
    part = curve.part(reel.start, reel.stop) if len(curve) else Curve(np.array([reel.start, reel.stop]), np.zeros(2))
    values = np.round(part.values, _VALUE_DECIMALS)
    return list(zip(part.samples.tolist(), values.tolist(), strict=True))


def _late_ms(curve: Curve, reel: Span, rate_hz: int) -> float:
    """Return how far the times of a reel are off once a reader has put them into 32 bits."""
    if not len(curve):
        return 0.0
    exact_s = (curve.part(reel.start, reel.stop).samples - reel.start) / rate_hz
    return late_ms(exact_s, np.round(exact_s, _DECIMALS).astype(np.float32).astype(np.float64))


def _write(path: Path, track: HapticTrack, amplitude: list[dict[str, Any]], frequency: list[dict[str, Any]]) -> None:
    path.write_bytes(
        msgspec.json.encode(
            {
                "version": {"major": 1, "minor": 0, "patch": 0},
                "metadata": {
                    "editor": "blastline",
                    "source": track.title,
                    "tags": ["gunshot"],
                    "description": f"vibration for {track.actuator}",
                },
                "signals": {"continuous": {"envelopes": {"amplitude": amplitude, "frequency": frequency}}},
            }
        )
        + b"\n"
    )


def _write_index(path: Path, rows: list[list[Any]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["file", "start_sample", "start_s", "start", "stop_s", "pulses"])
        writer.writerows(rows)


def _chained(curves: list[Curve]) -> Curve:
    return Curve(np.concatenate([c.samples for c in curves]), np.concatenate([c.values for c in curves]))


def _normalised(frequencies_hz: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.clip((frequencies_hz - LOW_HZ) / (HIGH_HZ - LOW_HZ), 0.0, 1.0)


def _seconds(time_s: float) -> float:
    return round(float(time_s), _DECIMALS)
