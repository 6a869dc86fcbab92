"""The grid that music is played to, and what keeps a grid but is no music: guns, and times that somebody wrote down.

The grid is the highest peak of the periodogram of a point process (Bartlett, J. R. Stat. Soc. B 25, 1963), fitted to
the sounds that lie on it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BeatRules

Times = NDArray[np.float64]

_SLOWEST_ROW_MS = 3000.0
"""Somebody may fire, walk or hammer evenly, with pauses: one even row, up to so slow, is no rhythm by itself."""

_FEWEST_BESIDE = 4
"""So many sounds have to keep the grid beside the fullest row."""

_MOSTLY = 0.6  # of the gaps
_PIECE = 0.25  # of a window: so long a piece of music
_FEWEST_IN_PIECE = 4  # sounds on the grid tell that it is kept in a piece

_LONGEST_ROLL = 16  # places: what goes on for longer may be fire
_MISSED = 2  # places from one round to the next, where one between them is not heard
_RESTS = 0.4  # of the gaps that are no step of a roll, longer than that

_PACE = 0.1  # of a gap, within which the next one is as long

_WRITTEN_MS = 50.0
"""Times that somebody wrote down are multiples of this, hence of many grids."""

_SPEEDS = np.outer((1.0, 1.001, 1.0 / 1.001), (1.0, 0.96, 1.0 / 0.96)).ravel()
"""Or as long as that became at the speed of television: 24 frames a second as 23.976, or as 25."""

_FINER = 4  # frequencies, than what a window tells apart
_PER_COARSE = 32  # of them


@dataclass(frozen=True)
class BeatGrid:
    """Places in time, all in ms: one at `phase`, and one each `period` before and after it."""

    period: float
    phase: float

    def holds(self, times: Times, within: float) -> NDArray[np.bool_]:
        """Return which times lie on the grid."""
        return np.asarray(np.abs(times - self.phase - self.places(times) * self.period) <= within)

    def places(self, times: Times) -> Times:
        """Return the nearest place of the grid for each time, in periods."""
        return np.asarray(np.round((times - self.phase) / self.period), np.float64)

    def resultant(self, times: Times) -> float:
        """Return the mean resultant length of the times' phases on the grid, 0 to 1."""
        return float(np.abs(np.exp(2j * np.pi * (times - self.phase) / self.period).mean()))


@dataclass(frozen=True, eq=False)
class Passage:
    """A window of a film, in ms: the film's sudden sounds, ascending, and where the window begins."""

    film: Times
    begin: float
    rules: BeatRules
    longest_gap: float
    """As fast as a gun fires: what follows so is a grid by itself."""

    def part(self, before: float = 0.0, after: float = 0.0) -> slice:
        """Return which of the film's sounds lie in the window, or so much of a window before or after it."""
        window = 1000.0 * self.rules.window_s
        ends = (self.begin - before * window, self.begin + (1.0 + after) * window)
        return slice(*np.searchsorted(self.film, ends).tolist())

    @property
    def sounds(self) -> Times:
        """The window's own sounds."""
        return self.film[self.part()]

    @property
    def begins(self) -> NDArray[np.bool_]:
        """Which of them nothing precedes as fast as a gun fires."""
        return np.asarray(np.diff(self.sounds, prepend=-np.inf) > self.longest_gap)


def of_no_row(times: Times) -> NDArray[np.bool_]:
    """Return which times, ascending, do not go on at the pace of the two before: a row tells of no grid but its own."""
    gaps = np.diff(times)
    told = np.ones(times.size, np.bool_)
    told[2:] = np.abs(np.diff(gaps)) > _PACE * gaps[:-1]
    return told


def strongest_grid(passage: Passage) -> BeatGrid:
    """Return the grid at the highest peak of the periodogram of a passage's sounds, one at least."""
    rules, sounds = passage.rules, passage.sounds
    step = 1.0 / (_FINER * 1000.0 * rules.window_s)
    frequencies = np.arange(1.0 / rules.longest_ms, 1.0 / rules.shortest_ms + step, step)
    since = sounds - sounds[0]
    # exp(i (a + b) t) = exp(i a t) exp(i b t), where a is one frequency of so many and b what the others lie above it
    coarse, fine = frequencies[::_PER_COARSE], step * np.arange(_PER_COARSE)
    by_coarse, by_fine = (np.exp(2j * np.pi * np.outer(each, since)) for each in (coarse, fine))
    sums = (by_coarse @ by_fine.T).ravel()[: frequencies.size]
    best = int(np.argmax(np.abs(sums)))
    period = 1.0 / float(frequencies[best])
    return BeatGrid(period, float(sounds[0] + np.angle(sums[best]) / (2.0 * np.pi) * period))


def fitted_grid(grid: BeatGrid, passage: Passage, within: Sequence[float], written: float) -> BeatGrid | None:
    """Return the grid fitted to what lies on it, ever nearer; None where that is too little, or guns may do the same.

    It has to hold `fewest_apart` of those that nothing precedes as fast as a gun fires. They may be written down where
    they are so near to multiples of 50 ms, as the mean resultant length of their phases.
    """
    rules, sounds = passage.rules, passage.sounds
    for wide in within:
        near = grid.holds(sounds, wide)
        if near.sum() < rules.fewest_apart:
            return None
        grid = BeatGrid(*np.polyfit(grid.places(sounds[near]), sounds[near], 1).tolist())
        if not 0.9 * rules.shortest_ms <= grid.period <= 1.1 * rules.longest_ms:
            return None
    near, begins = grid.holds(sounds, within[-1]), passage.begins
    every, apart = sounds[near], sounds[near & begins]
    if apart.size < rules.fewest_apart or _is_written(apart, written):
        return None
    even = _is_even(grid, every, rules) or _is_even(grid, apart, rules)
    if even and not _goes_on(grid, passage):
        return None
    return grid if _is_rhythm(grid, apart, int(begins.sum()), within[-1], rules) else None


def _is_written(times: Times, written: float) -> bool:
    """Return whether times are near to multiples of what people write down."""
    phases = np.outer(2.0 * np.pi / (_WRITTEN_MS * _SPEEDS), times)
    return bool((np.abs(np.exp(1j * phases).mean(axis=1)) >= written).any())


def _is_even(grid: BeatGrid, on_grid: Times, rules: BeatRules) -> bool:
    """Return whether most gaps are alike, and no longer than a grid's: an even row, or fire that misses some rounds."""
    gaps = np.bincount(np.diff(grid.places(on_grid)).astype(np.intp))
    usual = int(np.argmax(gaps))
    return bool(usual * grid.period <= rules.longest_ms and gaps[usual] >= _MOSTLY * gaps.sum())


def _goes_on(grid: BeatGrid, passage: Passage) -> bool:
    """Return whether the grid is kept for longer than a window, by rolls: the bursts of one gun share none.

    Half a window before it and half a one after it are heard as well, piece by piece. What goes on for longer than a
    roll, or rests hardly longer than where a round is not heard, may be fire.
    """
    rules = passage.rules
    edges = passage.begin + 1000.0 * rules.window_s * np.arange(-0.5, 1.5 + _PIECE, _PIECE)
    around = passage.film[passage.part(0.5, 0.5)]
    near = around[grid.holds(around, rules.within_ms)]
    sounds, on_grid = (np.histogram(each, edges)[0] for each in (around, near))
    kept = np.flatnonzero(on_grid >= np.maximum(_FEWEST_IN_PIECE, rules.share * sounds))
    if not kept.size or (kept[-1] - kept[0]) * _PIECE <= 1.0:
        return False
    places = grid.places(near)
    gaps = np.diff(places)
    ends = np.flatnonzero(gaps > 1.0)
    rolls = places[np.append(ends, -1)] - places[np.append(0, ends + 1)] + 1.0
    fire = rolls[rolls > _LONGEST_ROLL].sum()
    return bool(fire < rules.share * near.size and (gaps > _MISSED).sum() >= _RESTS * ends.size)


def _is_rhythm(grid: BeatGrid, on_grid: Times, count: int, within: float, rules: BeatRules) -> bool:
    """Return whether the grid is kept, of so many sounds in all, by more than those of any one even row."""
    places = grid.places(on_grid).astype(np.intp)
    for apart in range(int(1.01 * rules.longest_ms / grid.period) + 1, int(_SLOWEST_ROW_MS / grid.period) + 1):
        row = int(np.bincount(places % apart).max())
        beside, left = on_grid.size - row, count - row
        if beside < max(_FEWEST_BESIDE, rules.share * left) or chance_of(beside, left, grid, within) > rules.by_chance:
            return False
    return True


def chance_of(
    on_grid: NDArray[np.intp] | int, count: NDArray[np.intp] | int, grid: BeatGrid, within: float
) -> NDArray[np.float64]:
    """Return how likely so many of some sounds, or more, lie on a grid if they come anywhere, of the same shape."""
    from scipy.special import bdtrc

    return np.asarray(bdtrc(np.asarray(on_grid) - 1.0, count, min(1.0, 2.0 * within / grid.period)))
