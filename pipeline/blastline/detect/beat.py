"""Music keeps a beat, to a few milliseconds, and a drum on it is no shot.

    |     |  |     |     |  |  |       some of the sounds around skip places of one grid, as rhythm has it
    . . . . . . . . . . . . . . . .    the grid; shots lie anywhere

The grid is the highest peak of the periodogram of a point process (Bartlett, J. R. Stat. Soc. B 25, 1963), fitted to
the sounds that lie on it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BeatRules, BurstRules
from .rows import runs_of

Times = NDArray[np.float64]

_SAME_MS = 60.0
"""What comes so soon after another sound belongs to it."""

_SLOWEST_ROW_MS = 3000.0
"""Somebody may fire, walk or hammer evenly, with pauses: one even row, up to so slow, is no rhythm by itself."""

_FEWEST_BESIDE = 4
"""So many sounds have to keep the grid beside the fullest row."""

_MOSTLY = 0.6  # of the gaps
_PIECE, _FEWEST_IN_PIECE = 0.25, 4  # of a window; sounds on the grid, that tell that it is kept there
_BY_CHANCE = 0.05  # of the places

_WRITTEN_MS, _WRITTEN = 50.0, 0.85
"""Times that somebody wrote down are multiples of this, hence of many grids: where sounds are so near to multiples, as
the mean resultant length of their phases, they tell of no beat. It is .88 where half begin 8 ms after the others."""

_SPEEDS = np.outer((1.0, 1.001, 1.0 / 1.001), (1.0, 0.96, 1.0 / 0.96)).ravel()
"""Or as long as that became at the speed of television: 24 frames a second as 23.976, or as 25."""

_STRIDE = 8  # of a window: so much of it is asked about at once
_BEFORE = (0.0, 7 / 16, 7 / 8)  # of a window, before what is asked about: music may begin or end there
_FINER = 4  # frequencies, than what a window tells apart
_AT_ONCE = 256  # of them
_NARROWING = (3.0, 1.5, 1.0, 1.0)  # of what lies on the grid, while it is fitted


@dataclass(frozen=True)
class _Grid:
    period: float
    phase: float

    def holds(self, times: Times, within: float) -> NDArray[np.bool_]:
        """Return which times lie on the grid."""
        return np.asarray(np.abs(times - self.phase - self.places(times) * self.period) <= within)

    def places(self, times: Times) -> Times:
        """Return the nearest place of the grid for each time, in periods."""
        return np.asarray(np.round((times - self.phase) / self.period), np.float64)


def on_the_beat(
    shots: NDArray[np.intp], heard: NDArray[np.intp], *, rate_hz: int, rules: BeatRules, bursts: BurstRules
) -> NDArray[np.bool_]:
    """Return which of n shots keep the beat of what is heard around them, shape (n,).

    Onsets in samples, ascending; `heard` are all sudden sounds, shots among them. Of a run as fast as a gun fires, half
    has to, and then all of it does: on a grid of a tenth of a second rounds lie by chance.
    """
    found = np.zeros(shots.size, bool)
    asked_ms, heard_ms = (np.asarray(1000.0 / rate_hz * each, np.float64) for each in (shots, heard))
    sounds_ms = heard_ms[np.diff(heard_ms, prepend=-np.inf) > _SAME_MS]
    window_ms = 1000.0 * rules.window_s
    start = 0
    while start < shots.size:
        stop = int(np.searchsorted(asked_ms, asked_ms[start] + window_ms / _STRIDE, side="right"))
        for before in _BEFORE:
            begin_ms = asked_ms[start] - before * window_ms
            grid = _beat(sounds_ms, begin_ms, rules, bursts.longest_gap_ms)
            if grid is not None:
                found[start:stop] |= grid.holds(asked_ms[start:stop], rules.within_ms)
        start = stop
    for run in runs_of(asked_ms, bursts.longest_gap_ms):
        found[run] = 2 * found[run].sum() >= run.size > 0
    return found


def _beat(heard: Times, begin: float, rules: BeatRules, longest_gap: float) -> _Grid | None:
    """Return the grid that the sounds of the window from `begin` on keep, all in ms; None where they keep none."""
    sounds = _between(heard, begin, begin + 1000.0 * rules.window_s)
    if sounds.size < rules.fewest:
        return None
    grid = _strongest(sounds, rules)
    for wide in _NARROWING:
        near = grid.holds(sounds, wide * rules.within_ms)
        if near.sum() < rules.fewest:
            return None
        grid = _Grid(*np.polyfit(grid.places(sounds[near]), sounds[near], 1).tolist())
        if not 0.9 * rules.shortest_ms <= grid.period <= 1.1 * rules.longest_ms:
            return None
    near = grid.holds(sounds, rules.within_ms)
    begins = np.diff(sounds, prepend=-np.inf) > longest_gap  # what follows as fast as a gun fires is a grid by itself
    on_grid = sounds[near & begins]
    if near.sum() < max(rules.fewest, rules.share * sounds.size) or on_grid.size < max(
        rules.fewest_apart, rules.share * begins.sum()
    ):
        return None
    even = _is_even(grid, sounds[near], rules) or _is_even(grid, on_grid, rules)
    if _is_written(on_grid) or (even and not _goes_on(grid, heard, begin, rules)):
        return None
    return _coarsest(grid, sounds[near], rules) if _is_rhythm(grid, on_grid, int(begins.sum()), rules) else None


def _is_written(times: Times) -> bool:
    """Return whether times are as near to multiples of what people write down as a grid allows."""
    phases = np.outer(2.0 * np.pi / (_WRITTEN_MS * _SPEEDS), times)
    return bool((np.abs(np.exp(1j * phases).mean(axis=1)) >= _WRITTEN).any())


def _is_even(grid: _Grid, on_grid: Times, rules: BeatRules) -> bool:
    """Return whether most gaps are alike, and no longer than a grid's: an even row, or fire that misses some rounds."""
    gaps = np.bincount(np.diff(grid.places(on_grid)).astype(np.intp))
    usual = int(np.argmax(gaps))
    return bool(usual * grid.period <= rules.longest_ms and gaps[usual] >= _MOSTLY * gaps.sum())


def _goes_on(grid: _Grid, heard: Times, begin: float, rules: BeatRules) -> bool:
    """Return whether the grid is kept for longer than a window: no belt lasts so long, nor do bursts share a grid.

    Half a window before it and half a one after it are heard as well, piece by piece.
    """
    edges = begin + 1000.0 * rules.window_s * np.arange(-0.5, 1.5 + _PIECE, _PIECE)
    around = _between(heard, edges[0], edges[-1])
    sounds, on_grid = (np.histogram(each, edges)[0] for each in (around, around[grid.holds(around, rules.within_ms)]))
    kept = np.flatnonzero(on_grid >= np.maximum(_FEWEST_IN_PIECE, rules.share * sounds))
    return bool(kept.size) and bool((kept[-1] - kept[0]) * _PIECE > 1.0)


def _between(times: Times, start: float, stop: float) -> Times:
    first, last = np.searchsorted(times, (start, stop))
    return times[first:last]


def _is_rhythm(grid: _Grid, on_grid: Times, count: int, rules: BeatRules) -> bool:
    """Return whether the grid is kept, of so many sounds in all, by more than those of any one even row."""
    places = grid.places(on_grid).astype(np.intp)
    for apart in range(int(1.01 * rules.longest_ms / grid.period) + 1, int(_SLOWEST_ROW_MS / grid.period) + 1):
        row = int(np.bincount(places % apart).max())
        if on_grid.size - row < max(_FEWEST_BESIDE, rules.share * (count - row)):
            return False
    return True


def _coarsest(grid: _Grid, on_grid: Times, rules: BeatRules) -> _Grid:
    """Return the grid of twice the period, and again, as long as that holds as good as all that lies on this one."""
    while 2.0 * grid.period <= rules.longest_ms:
        odd = grid.places(on_grid) % 2 == 1
        if min(odd.mean(), 1.0 - odd.mean()) > _BY_CHANCE:
            break
        grid = _Grid(2.0 * grid.period, grid.phase + (grid.period if odd.mean() > 0.5 else 0.0))
    return grid


def _strongest(sounds: Times, rules: BeatRules) -> _Grid:
    """Return the grid at the highest peak of the periodogram of some sounds, in ms."""
    step = 1.0 / (_FINER * 1000.0 * rules.window_s)
    frequencies = np.arange(1.0 / rules.longest_ms, 1.0 / rules.shortest_ms + step, step)
    since = sounds - sounds[0]
    sums = np.concatenate(
        [
            np.exp(2j * np.pi * np.outer(frequencies[first : first + _AT_ONCE], since)).sum(axis=1)
            for first in range(0, frequencies.size, _AT_ONCE)
        ]
    )
    best = int(np.argmax(np.abs(sums)))
    period = 1.0 / float(frequencies[best])
    return _Grid(period, float(sounds[0] + np.angle(sums[best]) / (2.0 * np.pi) * period))
