"""What the picture of a shot shows: the sound, the drive, and what is felt of either."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..model import Event, Phase, RandomAccessSound, Span, Timeline
from ..ruleset import ActuatorProfile
from ..units import gain_from_db, samples_from_ms

Samples = NDArray[np.float64]

_BEFORE_MS = 12.0
_LONGEST_MS = 400.0


@dataclass(frozen=True, eq=False)
class EventSound:
    """A shot over `span`, shape (frames,) each: its sound, what of it should be felt, the drive, and what is felt of
    direct conversion and of the drive.
    """

    event: Event
    span: Span
    rate_hz: int
    audio: Samples
    target: Samples
    drive: Samples
    felt_direct: Samples
    felt_drive: Samples
    other_onsets: tuple[int, ...]

    @property
    def times_ms(self) -> Samples:
        """Return the time of each sample from the onset on."""
        samples = np.arange(self.span.start, self.span.stop) - self.event.onset_sample
        return np.asarray(samples * (1000.0 / self.rate_hz), dtype=np.float64)


def event_sound(
    event: Event, timeline: Timeline, *, audio: RandomAccessSound, drive: RandomAccessSound, profile: ActuatorProfile
) -> EventSound:
    """Return a shot's sound from just before its onset to its window's end, at most 0.4 s.

    What should be felt is the sound in the band, in the timeline's phase and at its level and the shot's own.
    """
    rate_hz, frames = audio.rate_hz, timeline.source.frames
    start = max(0, event.onset_sample - samples_from_ms(_BEFORE_MS, rate_hz))
    longest = event.onset_sample + samples_from_ms(_LONGEST_MS, rate_hz)
    shown = Span(start, min(frames, longest, max(event.window.stop, event.onset_sample + 1)))
    response = dsp.felt_response(profile)
    settle = round(dsp.settle_s(response, dsp.band(profile)) * rate_hz)
    whole = Span(max(0, start - settle), min(frames, shown.stop + settle))
    kept = slice(shown.start - whole.start, shown.stop - whole.start)
    sound = np.asarray(audio.read(whole, sides=event.made_of != "mains").driving_of(event.made_of), dtype=np.float64)
    driving = np.asarray(drive.read(whole).driving, dtype=np.float64)
    felt = dsp.discretise(response, rate_hz)
    gain = gain_from_db(timeline.level_db + event.gain_db)
    return EventSound(
        event,
        shown,
        rate_hz,
        audio=sound[kept],
        target=gain * _in_band(sound, rate_hz, profile, timeline.phase)[kept],
        drive=driving[kept],
        felt_direct=dsp.run_filter(felt, np.clip(sound, -1.0, 1.0))[kept],
        felt_drive=dsp.run_filter(felt, driving)[kept],
        other_onsets=tuple(
            other.onset_sample for other in timeline.events if other.onset_sample in shown and other.id != event.id
        ),
    )


def _in_band(sound: Samples, rate_hz: int, profile: ActuatorProfile, phase: Phase) -> Samples:
    """Return a sound in the band of vibration: filtered forwards, or half of it forwards and half backwards."""
    sections = dsp.band_sections(profile, rate_hz, phase)
    return dsp.run_both_ways(sections, sound, backwards=sections if phase == "zero" else None)


def envelope(values: Samples, columns: int) -> tuple[Samples, Samples]:
    """Return a curve that looks the same in `columns` columns: index and value of each column's extremes, in order."""
    width = math.ceil(len(values) / columns)
    if width <= 2:
        return np.arange(len(values), dtype=np.float64), values
    table = np.pad(values, (0, -len(values) % width), mode="edge").reshape(-1, width)
    rows = np.arange(len(table)) * width
    ends = np.stack([rows + table.argmin(axis=1), rows + table.argmax(axis=1)])
    index = np.unique(np.concatenate([[0], np.minimum(ends.ravel(), len(values) - 1), [len(values) - 1]]))
    return index.astype(np.float64), values[index]


def spectrum_db(samples: Samples, rate_hz: int, bands_hz: Samples) -> Samples:
    """Return the level of a piece of sound between neighbouring frequencies of `bands_hz`, in decibels.

    The magnitude of the Fourier transform in seconds, full scale being 1, root mean square over each band; where a
    band lies between two bins, interpolated.
    """
    size = 1 << max(14, (len(samples) - 1).bit_length())
    power = np.abs(np.fft.rfft(samples, size)) ** 2 / rate_hz**2
    total = np.concatenate([[0.0], np.cumsum(power)])
    edges = bands_hz * size / rate_hz
    at_edges = np.interp(edges, np.arange(len(total)) - 0.5, total)
    mean = np.diff(at_edges) / np.diff(edges)
    return np.asarray(10.0 * np.log10(np.maximum(mean, 1e-30)), dtype=np.float64)
