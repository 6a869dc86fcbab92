"""Apple's haptic patterns: the vibration in one file, the pulses in another, for two players started together.

A parameter curve changes every event of its pattern, so pulses beside it would be bent by it. A continuous event lasts
at most 30 s (CHHapticEvent.duration); a curve gets at most 16 points, and the point where two meet is in both; the
times of its points count from its own time. Core Haptics' intensity is felt as its square, so it is the root of the
amplitude that is written, and reduced; the sharpness 0 to 1 stands for 65 to 300 Hz, as the MPEG reference encoder
reads it.
"""

import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from .curve import Curve, reduced
from .rounding import Rounding, late_ms, mistuned, within
from .track import HapticTrack, VibrationSegment

CONTINUOUS, TRANSIENTS = "timeline.continuous.ahap", "timeline.transients.ahap"
LONGEST_EVENT_S = 30.0
MOST_POINTS = 16
DULL_HZ, SHARP_HZ = 65.0, 300.0

_DECIMALS = 6
_SILENCE = {"HapticIntensity": 0.0, "HapticSharpness": 0.0}

Pattern = dict[str, Any]


def write_ahap(track: HapticTrack, folder: Path) -> Rounding:
    """Write both files; in a film without vibration each holds one event of no intensity, as a pattern needs one."""
    rounding = Rounding(pulses=len(track.pulses))
    patterns: list[Pattern] = []
    for segment in track.segments:
        some, errors = _segment(segment, track)
        patterns += some
        rounding |= errors
    onsets_s = np.array([pulse.sample / track.rate_hz for pulse in track.pulses])
    pulses = [
        _event(
            "HapticTransient",
            time_s,
            {"HapticIntensity": _intensity(p.amplitude), "HapticSharpness": _sharpness(p.frequency_hz)},
        )
        for p, time_s in zip(track.pulses, onsets_s, strict=True)
    ]
    _write(folder / CONTINUOUS, patterns or [_event("HapticContinuous", 0.0, _SILENCE, duration_s=1.0)])
    _write(folder / TRANSIENTS, pulses or [_event("HapticTransient", 0.0, _SILENCE)])
    return rounding | Rounding(late_ms(onsets_s, np.round(onsets_s, _DECIMALS)))


def _segment(segment: VibrationSegment, track: HapticTrack) -> tuple[list[Pattern], Rounding]:
    """Return the events and curves of a segment; the curves alone say how strong and how sharp it is."""
    rate_hz, span = track.rate_hz, segment.span
    root = segment.amplitude.with_values(np.sqrt(segment.amplitude.values))
    # |a^2 - b^2| = |a - b| (a + b), at most twice |a - b| where both are at most 1
    few = reduced(root, track.amplitude_error / 2.0)
    intensity = few.with_values(np.round(few.values, 4))
    tone_hz, notes = within(segment.frequency_hz, DULL_HZ, SHARP_HZ)
    few_hz = reduced(tone_hz, track.frequency_error, relative=True)
    sharpness = few_hz.with_values(np.round(_sharpnesses(few_hz.values), 4))
    start_s, stop_s = span.start / rate_hz, span.stop / rate_hz
    patterns = [*continuous_events(start_s, stop_s)]
    patterns += _curves("HapticIntensityControl", intensity, rate_hz)
    patterns += _curves("HapticSharpnessControl", sharpness, rate_hz)
    played = root.with_values(intensity.at(root.samples) ** 2)
    times_s = np.concatenate([intensity.samples, sharpness.samples]) / rate_hz
    return patterns, Rounding(
        late_ms(times_s, np.round(times_s, _DECIMALS)),
        float(np.max(np.abs(played.values - segment.amplitude.values))),
        mistuned(tone_hz, sharpness.with_values(DULL_HZ + (SHARP_HZ - DULL_HZ) * sharpness.values)),
        points=len(intensity) + len(sharpness),
        notes=notes,
    )


def continuous_events(start_s: float, stop_s: float) -> Iterator[Pattern]:
    """Yield continuous events of full intensity that follow one on another, none longer than Core Haptics plays."""
    # in whole steps of the file: rounded one by one, the ends of 30 s can come to stand a step too far apart
    steps_per_s = 10**_DECIMALS
    first, last = round(start_s * steps_per_s), round(stop_s * steps_per_s)
    count = max(1, math.ceil((last - first) / (LONGEST_EVENT_S * steps_per_s)))
    edges = [(first + (last - first) * index // count) / steps_per_s for index in range(count + 1)]
    for start, stop in itertools.pairwise(edges):
        full = {"HapticIntensity": 1.0, "HapticSharpness": 0.0}
        yield _event("HapticContinuous", start, full, duration_s=stop - start)


def _curves(parameter: str, curve: Curve, rate_hz: int) -> Iterator[Pattern]:
    """Yield a curve in pieces of at most `MOST_POINTS`; each begins with the last point of the one before."""
    times_s = np.round(curve.samples / rate_hz, _DECIMALS)
    for first in range(0, max(1, len(curve) - 1), MOST_POINTS - 1):
        piece = slice(first, first + MOST_POINTS)
        points = [
            {"Time": _seconds(time_s - times_s[first]), "ParameterValue": value}
            for time_s, value in zip(times_s[piece], curve.values[piece].tolist(), strict=True)
        ]
        yield {
            "ParameterCurve": {
                "ParameterID": parameter,
                "Time": _seconds(times_s[first]),
                "ParameterCurveControlPoints": points,
            }
        }


def _event(kind: str, time_s: float, parameters: dict[str, float], *, duration_s: float | None = None) -> Pattern:
    event: dict[str, Any] = {"Time": _seconds(time_s), "EventType": kind}
    if duration_s is not None:
        event["EventDuration"] = _seconds(duration_s)
    event["EventParameters"] = [{"ParameterID": key, "ParameterValue": value} for key, value in parameters.items()]
    return {"Event": event}


def _write(path: Path, patterns: list[Pattern]) -> None:
    path.write_bytes(msgspec.json.encode({"Version": 1.0, "Pattern": patterns}) + b"\n")


def _seconds(time_s: float) -> float:
    return round(float(time_s), _DECIMALS)


def _intensity(amplitude: float) -> float:
    return round(math.sqrt(amplitude), 4)


def _sharpness(frequency_hz: float) -> float:
    return float(np.round(_sharpnesses(np.array([frequency_hz])), 4)[0])


def _sharpnesses(frequencies_hz: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.clip((frequencies_hz - DULL_HZ) / (SHARP_HZ - DULL_HZ), 0.0, 1.0)
