"""The level of a whole film in a few thousand numbers, gathered while the film streams by."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Clip
from ..units import samples_from_ms

_STEP_MS = 20.0


@dataclass(frozen=True, eq=False)
class Overview:
    """The largest magnitude in each `step` samples of the film, from its first; shape (steps,)."""

    step: int
    peaks: NDArray[np.float32]

    def columns(self, count: int) -> NDArray[np.float32]:
        """Return the peaks of at most `count` equal parts of the film."""
        if not len(self.peaks):
            return np.zeros(0, np.float32)
        starts = np.unique(np.linspace(0, len(self.peaks), count, endpoint=False).astype(np.int64))
        return np.asarray(np.maximum.reduceat(self.peaks, starts), dtype=np.float32)


class OverviewMeter:
    """Watches the blocks of a film go by and keeps the peak of every 20 ms of what detection hears."""

    def __init__(self, rate_hz: int) -> None:
        """Begin with nothing heard."""
        self._step = max(1, samples_from_ms(_STEP_MS, rate_hz))
        self._peaks: list[NDArray[np.float32]] = []
        self._rest = np.zeros(0, np.float32)

    def watch(self, blocks: Iterable[Clip]) -> Iterator[Clip]:
        """Yield the blocks as they come; each is metered before it is handed on."""
        for clip in blocks:
            self.add(clip)
            yield clip

    def add(self, clip: Clip) -> None:
        """Take in the block that follows the last one."""
        heard = np.concatenate([self._rest, clip.heard]) if len(self._rest) else clip.heard
        whole = len(heard) - len(heard) % self._step
        steps = heard[:whole].reshape(-1, self._step)
        self._peaks.append(np.maximum(steps.max(axis=1), -steps.min(axis=1)).astype(np.float32))
        self._rest = np.array(heard[whole:], dtype=np.float32)

    def overview(self) -> Overview:
        """Return what was heard so far."""
        last = np.abs(self._rest).max(keepdims=True) if len(self._rest) else np.zeros(0, np.float32)
        return Overview(self._step, np.concatenate([*self._peaks, last]).astype(np.float32))
