"""MPEG's haptics interchange file, ISO/IEC 23090-31: for backrest and seat pan a band of transients and one of waves.

    sum of a channel = transients (22 ms each in the reference player) + waves, clipped at 1

So a transient is only what its attack's peak is above the wave, at least a tenth of it, and the wave leaves it that
room: a wave of 0.95 beside a transient of 0.1 is written as 0.9. Transients that exceed 1 with one another are weakened
alike. Positions are whole milliseconds: at the finest timescale a wave could last no more than 1.4 s in the 16 bits
that the binary form has for its keyframes.
"""

import itertools
import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ...errors import TimelineError
from ...timecode import clock
from ...units import rescaled_all
from .curve import Curve, reduced
from .rounding import Rounding, late_ms, mistuned, off
from .sharing import shared, together
from .track import HapticTrack, Pulse, VibrationSegment

FILE = "timeline.hjif"
TICKS_PER_S = 1000
LONGEST_EFFECT = 65_535
MOST_EFFECTS = 65_535
LATEST_POSITION = 2**25 - 1
TRANSIENT_TICKS = 22
LEAST_SHARE = 0.1

BACKREST, SEAT_PAN = 0x300, 0xC00080
"""Upper and lower back; waist and both thighs."""

_QUIETEST = 1 / 255
_VALUE_DECIMALS = 4
_SHOT, _BURST = "WeaponCombat/Gun", "WeaponCombat/Machinegun"

Json = dict[str, Any]


def write_hjif(track: HapticTrack, folder: Path) -> Rounding:
    """Write the file. Raises TimelineError for more effects, or later ones, than the format can count."""
    transients, rounding = _transients(track)
    waves: list[Json] = []
    for segment in track.segments:
        effects, errors = _wave(segment, transients, track)
        waves += effects
        rounding |= errors
    for name, count in (("pulses", len(transients)), ("waves", len(waves))):
        if count > MOST_EFFECTS:
            raise TimelineError(f"hjif: {count} {name}: expected at most {MOST_EFFECTS}, all that the format can count")
    latest = max([0, *(position for position, _, _ in transients), *(wave["position"] for wave in waves)])
    if latest > LATEST_POSITION:
        found, end = (clock(ticks, TICKS_PER_S, decimals=3) for ticks in (latest, LATEST_POSITION))
        raise TimelineError(f"hjif: an effect at {found}: expected none after {end}, all that the format can count")
    low, high = math.floor(track.low_hz), math.ceil(track.high_hz)
    limits = {"lower_frequency_limit": low, "upper_frequency_limit": high}
    bands = [
        {"band_type": "Transient", **limits, "effects": [_transient(*each) for each in transients]},
        {"band_type": "VectorialWave", **limits, "effects": waves},
    ]
    (folder / FILE).write_bytes(msgspec.json.encode(_experience(track, bands)) + b"\n")
    return rounding


def _experience(track: HapticTrack, bands: list[Json]) -> Json:
    """Return the whole file around the bands, which both parts of the seat share.

    The date is required but no date of making is told, so that the same drive gives the same file.
    """
    seat = ((1, "backrest", BACKREST), (2, "seat pan", SEAT_PAN))
    return {
        "version": "2023",
        "profile": "Main",
        "level": 1,
        "date": "1970-01-01",
        "description": f"gunshot vibration for {track.title}",
        "timescale": TICKS_PER_S,
        "avatars": [],
        "syncs": [{"timestamp": 0, "timescale": TICKS_PER_S}],
        "perceptions": [
            {
                "id": 0,
                "avatar_id": 0,
                "description": "seat",
                "perception_modality": "Vibrotactile",
                "effect_library": [],
                "reference_devices": [
                    {
                        "id": number,
                        "name": track.actuator,
                        "body_part_mask": mask,
                        "minimum_frequency": track.low_hz,
                        "maximum_frequency": track.high_hz,
                        "type": "Unknown",
                    }
                    for number, _, mask in seat
                ],
                "channels": [
                    {
                        "id": number,
                        "description": name,
                        "gain": 1.0,
                        "mixing_coefficient": 1.0,
                        "body_part_mask": mask,
                        "reference_device_id": number,
                        "bands": bands,
                    }
                    for number, name, mask in seat
                ],
            }
        ],
    }


def _transients(track: HapticTrack) -> tuple[list[tuple[int, float, Pulse]], Rounding]:
    """Return (position, amplitude, pulse) for each pulse: its peak above the wave, in its share of 1."""
    samples = np.array([pulse.sample for pulse in track.pulses], np.int64)
    positions: list[int] = rescaled_all(samples, track.rate_hz, TICKS_PER_S).tolist()
    steps = 10**_VALUE_DECIMALS
    asked = [
        round(steps * max(pulse.amplitude - wave, LEAST_SHARE * pulse.amplitude, _QUIETEST))
        for pulse, wave in zip(track.pulses, _waves_at(track), strict=True)
    ]
    given = shared(positions, asked, length=TRANSIENT_TICKS, room=steps)
    found = [(p, a / steps, pulse) for p, a, pulse in zip(positions, given, track.pulses, strict=True)]
    weaker = sum(a < b for a, b in zip(given, asked, strict=True))
    notes = (f"{weaker} pulses less than {TRANSIENT_TICKS} ms apart are weakened, so that they stay within 1",)
    errors = late_ms(samples / track.rate_hz, np.array(positions, np.int64) / TICKS_PER_S)
    return found, Rounding(errors, pulses=len(found), notes=notes if weaker else ())


def _waves_at(track: HapticTrack) -> Iterator[float]:
    """Yield the amplitude of the wave at each pulse."""
    places = iter(track.segments)
    segment = next(places, None)
    for pulse in track.pulses:
        while segment is not None and segment.span.stop < pulse.sample:
            segment = next(places, None)
        yield 0.0 if segment is None else float(segment.amplitude.at(np.array([pulse.sample]))[0])


def _transient(position: int, amplitude: float, pulse: Pulse) -> Json:
    keyframe = {
        "relative_position": 0,
        "amplitude_modulation": amplitude,
        "frequency_modulation": round(pulse.frequency_hz),
    }
    effect: Json = {"effect_type": "Basis", "position": position, "phase": 0.0, "base_signal": "Sine"}
    if not pulse.is_echo:
        effect["semantic_keywords"] = _BURST if pulse.burst else _SHOT
    return {**effect, "keyframes": [keyframe]}


def _wave(
    segment: VibrationSegment, transients: Sequence[tuple[int, float, Pulse]], track: HapticTrack
) -> tuple[list[Json], Rounding]:
    """Return a segment as effects of at most `LONGEST_EFFECT` ticks that follow one on another, and its errors."""
    rate_hz = track.rate_hz
    line = reduced(segment.amplitude, track.amplitude_error)
    tone = reduced(segment.frequency_hz, track.frequency_error, relative=True)
    amplitude, frequency = _on_ticks(line, rate_hz), _on_ticks(tone, rate_hz)
    room = _with_room(amplitude, transients)
    held = float(np.max(amplitude.at(room.samples) - room.values))
    start, stop = int(amplitude.samples[0]), int(amplitude.samples[-1])
    edges = [*range(start, stop, LONGEST_EFFECT), stop]
    effects = [
        _effect(room.part(first, last), frequency.part(first, last)) for first, last in itertools.pairwise(edges)
    ]
    exact_s = np.concatenate([line.samples, tone.samples]) / rate_hz
    written_s = np.concatenate([rescaled_all(c.samples, rate_hz, TICKS_PER_S) for c in (line, tone)]) / TICKS_PER_S
    errors = Rounding(
        late_ms(exact_s, written_s),
        off(segment.amplitude, line.with_values(np.round(line.values, _VALUE_DECIMALS))),
        mistuned(segment.frequency_hz, tone.with_values(np.round(tone.values))),
        points=len(room) + len(frequency),
        notes=("beside a transient the wave leaves it room, so that both stay within 1",) if held > 0.0 else (),
    )
    return effects, errors


def _effect(amplitude: Curve, frequency: Curve) -> Json:
    keyframes: dict[int, Json] = {}
    for tick, value in zip(amplitude.samples.tolist(), amplitude.values.tolist(), strict=True):
        keyframes[tick] = {"amplitude_modulation": round(value, _VALUE_DECIMALS)}
    for tick, value in zip(frequency.samples.tolist(), frequency.values.tolist(), strict=True):
        keyframes.setdefault(tick, {})["frequency_modulation"] = round(value)
    start = int(amplitude.samples[0])
    return {
        "effect_type": "Basis",
        "position": start,
        "phase": 0.0,
        "base_signal": "Sine",
        "keyframes": [{"relative_position": tick - start, **keyframes[tick]} for tick in sorted(keyframes)],
    }


def _with_room(amplitude: Curve, transients: Sequence[tuple[int, float, Pulse]]) -> Curve:
    """Return the wave, at most what is left beside each transient while it lasts; all times are in ticks."""
    start, stop = int(amplitude.samples[0]), int(amplitude.samples[-1])
    first = bisect_left(transients, start - TRANSIENT_TICKS, key=itemgetter(0))
    last = bisect_right(transients, stop, key=itemgetter(0))
    positions, amplitudes = [p for p, _, _ in transients[first:last]], [a for _, a, _ in transients[first:last]]
    corners = [amplitude.samples]
    ceilings: list[tuple[int, float]] = []
    for position in positions:
        ceiling = max(0.0, 1.0 - sum(amplitudes[together(positions, position, TRANSIENT_TICKS)]))
        end = position + TRANSIENT_TICKS
        during = amplitude.part(max(start, position), max(start, min(stop, end)))
        if np.max(during.values) > ceiling:
            ceilings.append((position, ceiling))
            # one tick outside, the wave is what it was
            corners.append(np.clip([position - 1, position, end, end + 1], start, stop))
    ticks = np.unique(np.concatenate(corners))
    values = amplitude.at(ticks)
    for position, ceiling in ceilings:
        during_ticks = slice(*np.searchsorted(ticks, (position, position + TRANSIENT_TICKS + 1)))
        values[during_ticks] = np.minimum(values[during_ticks], ceiling)
    return Curve(ticks, values)


def _on_ticks(curve: Curve, rate_hz: int) -> Curve:
    """Return the curve on whole ticks; of points that come to share one the strongest."""
    ticks = rescaled_all(curve.samples, rate_hz, TICKS_PER_S)
    chosen, firsts = np.unique(ticks, return_index=True)
    return Curve(chosen, np.maximum.reduceat(curve.values, firsts))
