"""Where sound breaks off into zeros, as where a copy of a file lacks some of its blocks, or was never finished.

Short stretches are told where the sound comes back as abruptly. Longer ones, and those that last to the end, are usual
after a hard cut: they are told only where, in the file, they lie as storage does. By chance one in a thousand does, of
frames as long as 32 bytes up to one in 128. How loud the sound before them is matters as little as it can: it is not
faded, nor so soft as the last bits of a fade. What begins on a whole second is a cut: samples that begin on a block, as
some programs have them, may have a block on every second.

bytes of the file   ...sound sound|0 0 0 0 ... 0 0|sound sound...
                                  ^ a multiple of 4 KiB, also within a frame: what is behind it there is 0, too
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..plurals import times
from .track import Samples, Stored

SHORTEST_S, LONGEST_S = 0.005, 3.0
"""Blocks of storage are 4 KiB and more: 5 ms of six channels, 24 bits and 48 kHz. Longer silences are meant."""

_ABRUPT = 10.0**-2.0
"""Sound that is faded, or stops where it crosses zero, is softer than -40 dBFS beside the zeros."""

_BLOCK_BYTES = 4_096
"""File systems and copiers write, and leave out, multiples of this."""

_SOFTEST = 2.0**-13
"""A fade ends in the last bits: what is softer than four steps of 16 bits may be the end of one."""

_NEAR_S, _BEFORE_S, _FADED = 0.0005, 0.02, 0.125
"""What is softer by 18 dB just before the zeros than it was a little earlier has been faded, as soft cuts are too."""


@dataclass(frozen=True)
class _Stretch:
    """Zeros that go on: where they began, and whether the sound before them is abrupt and ends with a block."""

    start: int
    is_abrupt: bool
    is_by_block: bool


class Dropouts:
    """What has been seen so far of such places in a track; `stored` is how its samples lie in the file, if known."""

    def __init__(self, rate_hz: int, stored: Stored | None = None) -> None:
        """Begin before the first frame."""
        self._rate_hz, self._stored = rate_hz, stored
        self._shortest, self._longest = round(SHORTEST_S * rate_hz), round(LONGEST_S * rate_hz)
        # frames that far apart are looked at first: a lost block silences so many in a row, soft sound hardly ever does
        self._every = max(1, self._shortest // 4)
        self._in_a_row = max(1, self._shortest // self._every)
        self._near, self._holds = max(1, round(_NEAR_S * rate_hz)), 2 + round(_BEFORE_S * rate_hz)
        self._frames = 0
        self._held: Samples | None = None  # the last frames of what was seen
        self._stretch: _Stretch | None = None  # the zeros that go on at the end of what was seen
        self.count, self.first, self.frames = 0, 0, 0

    def hear(self, samples: Samples) -> None:
        """Note the next frames, all channels of them, shape (frames, channels)."""
        if not len(samples):
            return
        held = np.zeros((self._holds, samples.shape[1]), samples.dtype) if self._held is None else self._held
        if self._stretch is not None or not samples[-1].any() or self._may_hold_one(samples):
            self._look(np.concatenate([held, samples]))
        self._frames += len(samples)
        self._held = np.concatenate([held, samples[-self._holds :]])[-self._holds :]

    def warnings(self) -> Iterator[str]:
        """Yield what a user has to know, a line each, once all samples have been seen."""
        if self.count:
            first_s, lost_s = self.first / self._rate_hz, self.frames / self._rate_hz
            yield (
                f"the sound breaks off into zeros {times(self.count)} and comes back as abruptly, first at "
                f"{first_s:.3f} s: a part of the file may be lost, {lost_s:.3f} s in all"
            )
        last = self._stretch
        if last is not None and last.is_by_block and self._frames - last.start >= self._shortest:
            start_s, lasts_s = last.start / self._rate_hz, (self._frames - last.start) / self._rate_hz
            yield (
                f"the sound breaks off into zeros at {start_s:.3f} s, which last to the end, for {lasts_s:.3f} s: "
                "the rest of the file may be lost, as of a copy that was never finished"
            )

    def _may_hold_one(self, samples: Samples) -> bool:
        """Return whether zeros may begin and end in these frames."""
        still = ~samples[:: self._every].any(axis=1)
        if np.count_nonzero(still) < self._in_a_row:
            return False
        return bool(sliding_window_view(still, self._in_a_row).all(axis=1).any())

    def _look(self, samples: Samples) -> None:
        """Find the stretches of zeros behind the frames that are held; one at the end may go on in the next frames."""
        holds = self._holds
        still = np.asarray(~samples[holds:].any(axis=1), np.bool_)
        edges = np.flatnonzero(np.diff(np.concatenate([[not samples[holds - 1].any()], still])))
        begins = still[edges]
        # soft sound is full of short ones: they are none, but for one at the end, which may go on
        lasting = begins & (np.diff(edges, append=len(still) + self._shortest) >= self._shortest)
        ends = ~begins & np.concatenate([[True], lasting])[:-1]
        for edge in edges[lasting | ends].tolist():
            frame, before, after = self._frames + edge, samples[edge : edge + holds], samples[edge + holds]
            if still[edge]:
                self._stretch = self._begun(frame, before)
            elif self._stretch is not None:
                self._end(self._stretch, frame, after)
                self._stretch = None

    def _begun(self, frame: int, before: Samples) -> _Stretch | None:
        """Return the stretch of zeros that begins at a frame; None where the sound before it is not abrupt."""
        is_abrupt, is_by_block = bool(np.abs(before[-1]).max() >= _ABRUPT), self._breaks_off_with_block(frame, before)
        return _Stretch(frame, is_abrupt, is_by_block) if is_abrupt or is_by_block else None

    def _breaks_off_with_block(self, frame: int, before: Samples) -> bool:
        """Return whether zeros begin with a block of the file, to the byte, and what is before them was not faded."""
        if self._stored is None or not frame % self._rate_hz:
            return False
        channels, width = before.shape[1], self._stored.frame_bytes // before.shape[1]
        behind = self._stored.place(frame) % _BLOCK_BYTES  # so many bytes of zeros lie between the block and here
        ahead = _BLOCK_BYTES - behind  # or so many between here and the block, where channels that are silent have them
        is_there = behind < self._stored.frame_bytes and not before[-1, channels - behind // width :].any()
        if not is_there and (ahead >= self._stored.frame_bytes or before[-1, : -(-ahead // width)].any()):
            return False
        # of a frame that a block divides, what is left may be soft: those before it tell how loud it was
        levels = np.abs(before[:-1] if behind and is_there else before).max(axis=1)
        return bool(levels[-self._near :].max() >= max(_SOFTEST, _FADED * levels.max()))

    def _end(self, stretch: _Stretch, frame: int, after: Samples) -> None:
        """Count a stretch of zeros that ends before a frame, if it may be a loss."""
        length = frame - stretch.start
        is_abrupt, is_by_block = bool(np.abs(after).max() >= _ABRUPT), False
        if self._stored is not None:
            before = -self._stored.place(frame) % _BLOCK_BYTES
            width = self._stored.frame_bytes // after.shape[0]
            if before < self._stored.frame_bytes and not after[: before // width].any():
                # of a sample that a block divides, what is left of it may be soft
                is_by_block = is_abrupt or before > 0
        is_short = length <= self._longest and stretch.is_abrupt and is_abrupt
        if length >= self._shortest and (is_short or (stretch.is_by_block and is_by_block)):
            self.first = self.first if self.count else stretch.start
            self.count += 1
            self.frames += length
