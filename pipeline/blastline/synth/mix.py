"""A scene as sound that can be read anywhere: beds, shots and negatives, mixed and limited, with their truth.

Every sample depends on its index alone. Beds are looped material, sounds are rendered when a block first needs them
and forgotten soon after, so a film of two hours needs no more memory than a clip, and the size of the blocks
changes nothing.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial

import msgspec
import numpy as np

from ..model import Span
from ..units import db_from_gain, gain_from_db, samples_from_s
from .audible import HEARD_S, LEAD_S, Parts, audible
from .bed_loop import BedLoop, bed_loop
from .beds import BedKind
from .chance import chance, generator
from .cues import cues, voice_of
from .layouts import CHANNELS, LFE, WITH_LFE, bed_feeds, mains, sound_gains
from .master import limited
from .negatives import random_negative
from .scene import BedItem, NegativeItem, Scene, ShotItem
from .shots import PEAK_WITHIN_S, fire_apart
from .tone import Samples, lowpass, peak, rms
from .truth import NegativeTruth, ShotTruth, moved
from .voices import Voice

BACKGROUND_S = 0.2
EARLIEST_S = 1.0
LATEST_S = 9.0
"""A sound reaches from a second before its onset to nine seconds after; what lies beyond is cut."""

TAKES = 5
TAKE_LENGTH_S = 600.0
"""Every bed of a kind plays from somewhere within ten minutes of one of five takes, which are made once."""

QUIETEST_DBFS = -70.0
"""A level given by `snr_db` counts nothing quieter than this, or the sound would vanish in a pause."""


@dataclass(frozen=True, eq=False)
class Sound:
    """A rendered cue: its samples in mono, where the first of them lies, the channels' gains, its truth, its parts."""

    samples: Samples
    start: int
    gains: Samples
    truth: ShotTruth | None
    parts: Parts | None

    @property
    def stop(self) -> int:
        """Return the sample after the last one."""
        return self.start + len(self.samples)


class SceneAudio:
    """The sound of a scene, read with `read`, and what it contains, with `shot_truths` and `negative_truths`."""

    def __init__(self, scene: Scene) -> None:
        """Lay out the cues; nothing is rendered yet."""
        self.scene = scene
        self.rate_hz = scene.rate_hz
        self.frames = scene.frames
        self.channels = CHANNELS[scene.layout]
        self.cues = tuple(sorted(cues(scene), key=lambda cue: (cue.onset, cue.name)))
        self._onsets = np.array([cue.onset for cue in self.cues], dtype=np.int64)
        self._bed: Callable[[BedKind, int], BedLoop] = lru_cache(maxsize=4)(self._make_bed)
        self._voice: Callable[[ShotItem, str], Voice] = lru_cache(maxsize=8)(partial(voice_of, scene))
        self._sound: Callable[[int], Sound] = lru_cache(maxsize=96)(self._make_sound)

    def read(self, start: int, stop: int, *, without: str | None = None) -> Samples:
        """Return the limited mix from `start` to `stop`, shape (frames, channels), without one family of cues."""
        return limited(self._sum(start, stop, without), self.scene.master)

    def blocks(self, size: int) -> Iterator[tuple[int, Samples]]:
        """Yield the whole scene as (first frame, samples)."""
        for start in range(0, self.frames, size):
            yield start, self.read(start, min(start + size, self.frames))

    def beds(self, start: int, stop: int) -> Samples:
        """Return the beds alone, not limited, shape (frames, channels)."""
        total = np.zeros((stop - start, self.channels))
        for item in self.scene.beds:
            first, last = self._reach(item)
            low, high = max(start, first), min(stop, last)
            if low < high:
                weights = _fades(low, high, first, last, fade=samples_from_s(item.fade_s, self.rate_hz))
                gain = gain_from_db(item.level_dbfs)
                rng = generator(self.scene.seed, "take", item.kind, f"{item.start_s:.6f}")
                take, start_in = int(rng.integers(TAKES)), samples_from_s(TAKE_LENGTH_S * rng.random(), self.rate_hz)
                for feed in bed_feeds(self.scene.layout, item.kind):
                    later = samples_from_s(feed.later_s, self.rate_hz) - first
                    played = self._bed(item.kind, take).read(start_in + low + later, start_in + high + later)
                    total[low - start : high - start, feed.channel] += gain * feed.gain * weights * played
        return total

    def shot_truths(self, span: Span) -> Iterator[ShotTruth]:
        """Yield the shots whose onset lies in the span, measured in the mix."""
        for index in range(*np.searchsorted(self._onsets, [span.start, span.stop])):
            sound, cue = self._sound(index), self.cues[index]
            if sound.truth is not None and sound.parts is not None:
                top, background = self._levels(index, cue.onset)
                yield msgspec.structs.replace(
                    _clamped(self._heard(sound.truth, sound.parts, sound), self.frames),
                    peak_dbfs=db_from_gain(top),
                    snr_db=db_from_gain(top) - db_from_gain(background),
                    burst=cue.burst,
                    shot_in_burst=cue.shot_in_burst,
                    azimuth_deg=None if self.channels == 1 else cue.item.azimuth_deg,
                )

    def negative_truths(self, span: Span) -> Iterator[NegativeTruth]:
        """Yield the negatives that start in the span."""
        for index in range(*np.searchsorted(self._onsets, [span.start, span.stop])):
            cue = self.cues[index]
            if isinstance(cue.item, NegativeItem):
                top = db_from_gain(peak(self._sound(index).samples))
                yield NegativeTruth(cue.onset, cue.onset / self.rate_hz, cue.item.kind, min(top, 0.0))

    def _sum(self, start: int, stop: int, without: str | None = None) -> Samples:
        total = self.beds(start, stop)
        for index in self._near(start, stop):
            if self.cues[index].family != without:
                _add(total, self._sound(index), start, rate_hz=self.rate_hz)
        return total

    def _heard(self, truth: ShotTruth, parts: Parts, sound: Sound) -> ShotTruth:
        """Return the truth with what is heard of the shot in the mix, before the limiter weighs all of it alike."""
        onset = truth.onset_sample
        start = max(0, onset - samples_from_s(LEAD_S, self.rate_hz))
        stop = min(self.frames, onset + samples_from_s(HEARD_S, self.rate_hz))
        alone = np.zeros((stop - start, self.channels))
        _add(alone, sound, start, rate_hz=self.rate_hz)
        found = audible(
            parts,
            mains(alone),
            mains(self._sum(start, stop)),
            lead=onset - start,
            rate_hz=self.rate_hz,
            rounding=0.5**self.scene.master.bits,
        )
        judged = zip(truth.reflections, found.margins_db, found.heard, strict=False)
        echoes = [msgspec.structs.replace(e, margin_db=margin, audible=heard) for e, margin, heard in judged]
        return msgspec.structs.replace(
            truth,
            reflections=(*echoes, *truth.reflections[len(echoes) :]),
            heard_blast=Span(onset, onset + found.blast),
        )

    def _levels(self, index: int, onset: int) -> tuple[float, float]:
        """Return the peak of a shot alone, limited, and the rms before it of all but its burst, with the rounding."""
        stop = min(self.frames, onset + samples_from_s(PEAK_WITHIN_S, self.rate_hz))
        alone = np.zeros((stop - onset, self.channels))
        _add(alone, self._sound(index), onset, rate_hz=self.rate_hz)
        span = self._background(onset)
        others = rms(mains(self.read(span.start, span.stop, without=self.cues[index].family)))
        rounding = 0.5**self.scene.master.bits
        return peak(mains(limited(alone, self.scene.master))), math.hypot(others, rounding)

    def _background(self, onset: int) -> Span:
        """Return the 200 ms before an onset, as much as there is; at the scene's start the 200 ms that follow."""
        length = samples_from_s(BACKGROUND_S, self.rate_hz)
        start = max(0, onset - length)
        return Span(start, onset) if onset - start >= length // 10 else Span(0, min(length, self.frames))

    def _reach(self, item: BedItem) -> tuple[int, int]:
        stop_s = self.scene.duration_s if item.stop_s is None else item.stop_s
        return samples_from_s(item.start_s, self.rate_hz), min(samples_from_s(stop_s, self.rate_hz), self.frames)

    def _near(self, start: int, stop: int) -> range:
        earliest = start - samples_from_s(LATEST_S, self.rate_hz)
        latest = stop + samples_from_s(EARLIEST_S, self.rate_hz)
        first, last = np.searchsorted(self._onsets, [earliest, latest])
        return range(int(first), int(last))

    def _make_bed(self, kind: BedKind, take: int) -> BedLoop:
        seed = int(generator(self.scene.seed, "bed", kind, take).integers(2**62))
        return bed_loop(seed, kind, duration_s=self.scene.duration_s, rate_hz=self.rate_hz)

    def _make_sound(self, index: int) -> Sound:
        cue = self.cues[index]
        item = cue.item
        rng = generator(self.scene.seed, cue.name)
        gains = sound_gains(generator(self.scene.seed, "pan", cue.family), self.scene.layout, item.azimuth_deg)
        if isinstance(item, ShotItem):
            fired = fire_apart(rng, self.rate_hz, self._voice(item, cue.family))
            samples, lead = fired.samples, fired.truth.onset_sample
            placed: ShotTruth | None = moved(fired.truth, cue.onset - lead, rate_hz=self.rate_hz)
            parts: Parts | None = fired.parts
        else:
            (samples, lead), placed, parts = random_negative(rng, self.rate_hz, item.kind), None, None
        cut = max(0, lead - samples_from_s(EARLIEST_S, self.rate_hz))
        samples = samples[cut : lead + samples_from_s(LATEST_S, self.rate_hz)]
        polarity = -1.0 if chance(generator(self.scene.seed, "polarity", cue.family), 0.5) else 1.0
        return Sound(polarity * self._gain(item, cue.first) * samples, cue.onset - lead + cut, gains, placed, parts)

    def _gain(self, item: ShotItem | NegativeItem, onset: int) -> float:
        if item.peak_dbfs is not None:
            return gain_from_db(item.peak_dbfs)
        assert item.snr_db is not None
        span = self._background(onset)
        under = self.beds(span.start, span.stop)
        if isinstance(item, ShotItem):
            for index in self._near(span.start, span.stop):
                if isinstance(self.cues[index].item, NegativeItem):
                    _add(under, self._sound(index), span.start, rate_hz=self.rate_hz)
        level = rms(mains(limited(under, self.scene.master)))
        hottest = gain_from_db(self.scene.master.ceiling_dbfs + self.scene.master.drive_db)
        return min(max(level, gain_from_db(QUIETEST_DBFS)) * gain_from_db(item.snr_db), hottest)


def _add(total: Samples, sound: Sound, start: int, *, rate_hz: int) -> None:
    """Add a sound to the block that begins at `start`, in every channel."""
    low, high = max(start, sound.start), min(start + len(total), sound.stop)
    if low >= high:
        return
    part = sound.samples[low - sound.start : high - sound.start]
    total[low - start : high - start] += part[:, None] * sound.gains
    if total.shape[1] in WITH_LFE:
        low_end = lowpass(sound.samples, 110.0, rate_hz=rate_hz, order=2)
        total[low - start : high - start, LFE] += 0.7 * low_end[low - sound.start : high - sound.start]


def _fades(low: int, high: int, first: int, last: int, *, fade: int) -> Samples:
    """Return the gain of a bed from `low` to `high`: sin^2 fades at its two ends, none where the fade is 0."""
    weights = np.ones(high - low)
    index = np.arange(low, high)
    edge = np.minimum(index - first, last - 1 - index)
    near = edge < fade
    weights[near] = np.sin((edge[near] + 0.5) / max(fade, 1) * (math.pi / 2.0)) ** 2
    return weights


def _clamped(truth: ShotTruth, frames: int) -> ShotTruth:
    """Return the truth without what lies after the end of the scene."""
    echoes = tuple(
        msgspec.structs.replace(echo, stop=min(echo.stop, frames)) for echo in truth.reflections if echo.start < frames
    )
    blast = Span(truth.blast.start, min(truth.blast.stop, frames))
    return msgspec.structs.replace(truth, blast=blast, reflections=echoes)
