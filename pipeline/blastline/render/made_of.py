"""Of which mix the drive of a window is made: the mains, unless they do not hold one of its shots.

Two channels that play a shot against each other cancel in the mains, and only there: `sides`, half their difference,
hold it, without what both play. Where other shots of the window are in the mains alone, the louder channel has all.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Clip, MadeOf
from ..units import samples_from_ms

_CELL_MS = 0.5
"""Means over so much keep what lies in the band of vibration, up to about 1 kHz, and nothing far above it."""

_AROUND_MS = 40.0
"""So long after the onset, and as long before it, is compared."""

_WEAKER = 0.25
"""The first sign that the mains lack a shot: the energy that it brings them is less than this share, 6 dB, of what it
brings the sides, or less than the energy that was there before."""

_ALIKE, _LATEST_MS = 0.6, 2.0
"""The second: they hold less than this share of the shot's waveform in the sides, even with one of the two delayed by
up to 2 ms. A shot from one side, or one that reaches two microphones one after the other, is in both mixes."""

_CHANNELS: tuple[MadeOf, MadeOf] = ("left", "right")


def is_lacking(audio: Clip, onset: int) -> bool:
    """Return whether the mains lack, in the band of vibration, the shot that begins at a sample and the sides hold."""
    if audio.sides is None or audio.samples.shape[1] > 1:
        return False
    at, rate_hz = onset - audio.start, audio.rate_hz
    mains, sides = (_OnsetEnergy.around(mix, at, rate_hz) for mix in (audio.heard, audio.sides))
    if sides.brought <= 0.0 or mains.brought >= max(_WEAKER * sides.brought, mains.before):
        return False
    latest = round(_LATEST_MS / _CELL_MS)
    likeness = np.abs(np.correlate(np.pad(mains.now, latest), sides.now, "valid")).max()
    return bool(likeness < _ALIKE * (sides.now @ sides.now))


def choose_made_of(audio: Clip, onsets: Sequence[int]) -> MadeOf:
    """Return what the drive of a window is to be made of; its shots begin at the samples `onsets` of the film.

    `audio` holds them, with its sides if the film has any.
    """
    lacking = [is_lacking(audio, onset) for onset in onsets]
    if not any(lacking):
        return "mains"
    if all(lacking):
        return "sides"
    return max(_CHANNELS, key=lambda channel: _brought_by(audio, channel, onsets))


def _brought_by(audio: Clip, channel: MadeOf, onsets: Sequence[int]) -> float:
    """Return how much energy shots bring to a channel."""
    played = audio.driving_of(channel)
    return sum(_OnsetEnergy.around(played, onset - audio.start, audio.rate_hz).brought for onset in onsets)


@dataclass(frozen=True, eq=False)
class _OnsetEnergy:
    """The energy of a mix after an onset, and what of it came with the onset.

    `now` are the means of the cells after the onset, less the constant that was there before. `before` is the energy
    that as many cells had before it; `brought` is how much more there is now.
    """

    now: NDArray[np.float64]
    before: float

    @property
    def brought(self) -> float:
        return float(self.now @ self.now) - self.before

    @classmethod
    def around(cls, mix: NDArray[np.floating], at: int, rate_hz: int) -> "_OnsetEnergy":
        """Return what an onset at an index of a mix brings."""
        cell = max(1, samples_from_ms(_CELL_MS, rate_hz))
        length = cell * round(_AROUND_MS / _CELL_MS)
        before = mix[max(0, at - length) : at]
        now, was = (_means(part, cell) for part in (mix[at : at + length], before[len(before) % cell :]))
        # a film begins at rest, at its first level: what was before may be less than a cell, or nothing
        constant = (before if before.size else mix[at : at + 1]).mean(dtype=np.float64)
        still = was - constant
        return cls(now - constant, float(still @ still) * len(now) / max(1, len(was)))


def _means(samples: NDArray[np.floating], cell: int) -> NDArray[np.float64]:
    whole = samples[: len(samples) - len(samples) % cell].astype(np.float64)
    return np.asarray(whole.reshape(-1, cell).mean(axis=1), np.float64)
