"""From a timeline and its drive to the haptic track that every haptic format is written from.

windows ─► joined where they are within 2 ms ─► the drive in each ─► pulses at shots and echoes ─► amplitude, frequency
"""

from bisect import bisect_right
from collections.abc import Iterator, Sequence

import numpy as np

from ...errors import TimelineError
from ...model import Event, Span, Timeline
from ...ruleset import ActuatorProfile, HapticRules
from ...units import samples_from_ms
from .curve import Curve
from .envelope import Samples, amplitude_curve, frequency_curve
from .track import DriveReader, HapticTrack, Pulse, VibrationSegment, ms_gap


def haptic_track(
    timeline: Timeline, drive: DriveReader, *, profile: ActuatorProfile, rules: HapticRules
) -> HapticTrack:
    """Return the vibration of a film as its drive has it: nothing is taken from the film's own sound.

    A shot for which the drive stays at 0 gets no pulse and is named in `silent`. Raises TimelineError for a shot that
    lies outside the film.
    """
    source = timeline.source
    rate_hz, frames = source.sample_rate_hz, source.frames
    _refuse_outside(timeline)
    pulses: list[Pulse] = []
    segments: list[VibrationSegment] = []
    silent: list[str] = []
    for span, events in _joined(timeline.events, frames=frames, gap=2 * ms_gap(rate_hz)):
        samples = np.clip(np.asarray(drive(span), dtype=np.float64), -1.0, 1.0)  # no seat does more than its limit
        own, quiet = _pulses(samples, events, origin=span.start, rate_hz=rate_hz, rules=rules)
        silent += quiet
        if np.any(samples):
            rest = _rest(samples, own, origin=span.start, rate_hz=rate_hz)
            moving, origin = samples[rest:], span.start + rest
            segment = _segment(moving, own, origin=origin, rate_hz=rate_hz, rules=rules, profile=profile)
            segments.append(segment)
            pulses += [_with_frequency(pulse, segment.frequency_hz) for pulse in own]
    return HapticTrack(
        rate_hz,
        frames,
        title=source.name,
        actuator=profile.name,
        low_hz=profile.highpass.corner_hz,
        high_hz=profile.lowpass.corner_hz,
        pulses=tuple(pulses),
        segments=tuple(segments),
        amplitude_error=rules.amplitude_error,
        frequency_error=rules.frequency_error,
        reel_s=rules.reel_s,
        silent=tuple(silent),
    )


def _refuse_outside(timeline: Timeline) -> None:
    for index, event in enumerate(timeline.events):
        if event.onset_sample >= timeline.source.frames:
            raise TimelineError(
                f"events[{index}].onset_sample = {event.onset_sample}: expected a frame of the film, "
                f"which has {timeline.source.frames}"
            )


def _joined(events: Sequence[Event], *, frames: int, gap: int) -> Iterator[tuple[Span, list[Event]]]:
    """Yield the windows of the events in order, those nearer than `gap` as one, each with its events."""
    whole: Span | None = None
    members: list[Event] = []
    for event in sorted(events, key=lambda event: (_reach(event, frames).start, event.onset_sample)):
        reach = _reach(event, frames)
        if whole is not None and reach.start > whole.stop + gap:
            yield whole, members
            whole, members = None, []
        whole = reach if whole is None else whole | reach
        members.append(event)
    if whole is not None:
        yield whole, members


def _reach(event: Event, frames: int) -> Span:
    """Return an event's window inside the film, with its onset, wherever an edit has put that."""
    window = Span(min(event.window.start, frames), min(event.window.stop, frames))
    return window | Span(event.onset_sample, event.onset_sample + 1)


def _pulses(
    samples: Samples, events: Sequence[Event], *, origin: int, rate_hz: int, rules: HapticRules
) -> tuple[list[Pulse], list[str]]:
    """Return the pulses of a segment in order, without their frequency, and the shots for which the drive is at rest.

    The attack of a shot may begin a millisecond before its onset, as the drive may, and ends with the average.
    """
    lead, length = ms_gap(rate_hz), samples_from_ms(rules.average_ms, rate_hz)
    onsets = sorted({event.onset_sample - origin for event in events})
    ends = [*onsets, len(samples)]
    found: list[Pulse] = []
    silent: list[str] = []
    for event in sorted(events, key=lambda event: event.onset_sample):
        onset = event.onset_sample - origin
        following = ends[bisect_right(onsets, onset)]
        peak = _peak(samples, onset - lead, min(onset + length, max(following - lead, onset + 1)))
        if peak == 0.0:
            silent.append(event.id)
        elif not found or found[-1].sample < event.onset_sample:
            found.append(Pulse(event.onset_sample, peak, 0.0, event.id, burst=event.burst is not None))
    shots = [pulse.sample for pulse in found]
    apart = samples_from_ms(rules.echo_apart_ms, rate_hz)
    for event in events:
        for echo in event.reflections:
            start = echo.start - origin
            if not 0 < start < len(samples) or _has_near(shots, echo.start, apart):
                continue
            peak, before = _peak(samples, start, start + length), _peak(samples, start - length, start)
            if peak >= rules.least_echo and peak > before:
                found.append(Pulse(echo.start, peak, 0.0, event.id, is_echo=True))
    return _apart(found, apart), silent


def _has_near(shots: list[int], place: int, apart: int) -> bool:
    """Return whether one of the shots, which are in order, is less than `apart` from a place."""
    index = bisect_right(shots, place - apart)
    return index < len(shots) and shots[index] < place + apart


def _apart(pulses: list[Pulse], apart: int) -> list[Pulse]:
    """Return the pulses in order, without an echo that comes too soon after the pulse before it."""
    kept: list[Pulse] = []
    for pulse in sorted(pulses, key=lambda pulse: (pulse.sample, pulse.is_echo)):
        if not (pulse.is_echo and kept and pulse.sample - kept[-1].sample < apart):
            kept.append(pulse)
    return kept


def _peak(samples: Samples, start: int, stop: int) -> float:
    inside = samples[max(0, start) : max(0, stop)]
    return float(np.max(np.abs(inside))) if inside.size else 0.0


def _rest(samples: Samples, pulses: Sequence[Pulse], *, origin: int, rate_hz: int) -> int:
    """Return for how many samples a drive is at rest before it moves, but for the line that leads up to a pulse.

    A solved drive begins the lead before its shot. Averaged with the rest before it, the lead would be played early.
    """
    moves = int(np.flatnonzero(samples)[0])
    feet = [pulse.sample - origin - ms_gap(rate_hz) for pulse in pulses[:1]]
    return max(0, min([moves, *feet]))


def _segment(
    samples: Samples,
    pulses: Sequence[Pulse],
    *,
    origin: int,
    rate_hz: int,
    rules: HapticRules,
    profile: ActuatorProfile,
) -> VibrationSegment:
    attacks = [pulse.sample - origin for pulse in pulses]
    amplitude = amplitude_curve(samples, attacks, origin=origin, rate_hz=rate_hz, rules=rules)
    band = (profile.highpass.corner_hz, profile.lowpass.corner_hz)
    frequency = frequency_curve(samples, attacks, amplitude, origin=origin, rate_hz=rate_hz, rules=rules, band=band)
    return VibrationSegment(amplitude, frequency)


def _with_frequency(pulse: Pulse, frequency_hz: Curve) -> Pulse:
    """Return the pulse with the frequency that the drive has at its start."""
    at = float(frequency_hz.at(np.array([pulse.sample]))[0])
    return Pulse(pulse.sample, pulse.amplitude, at, pulse.event, is_echo=pulse.is_echo, burst=pulse.burst)
