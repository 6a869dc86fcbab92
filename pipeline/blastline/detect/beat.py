"""Music keeps a beat, and a drum on it is no shot.

    |     |  |     |     |  |  |       some of the sounds around skip places of one grid, as rhythm has it
    . . . . . . . . . . . . . . . .    the grid; shots lie anywhere

A sound is a drum where half of all sounds around lie on the grid to a few milliseconds, and it does, or where it does
to a few more and of those that sound like it, as strokes of one drum do, more lie there than chance would have.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BeatRules, BurstRules
from .beat_grid import BeatGrid, Passage, Times, chance_of, fitted_grid, of_no_row, strongest_grid
from .fire import ScoredCandidates
from .rows import runs_of

_SAME_MS = 60.0
"""What comes so soon after another sound belongs to it."""

_STRIDE = 8  # of a window: so much of it is asked about at once
_BEFORE = (0.0, 7 / 16, 7 / 8)  # of a window, before what is asked about: music may begin or end there
_NARROWING = (3.0, 1.5, 1.0, 1.0)  # of what lies on a grid exactly, while it is fitted
_WIDE = (0.25, 0.15, 0.12)  # of a period: what lies on one roughly
_WRITTEN, _ROUGHLY_WRITTEN = 0.85, 0.5  # it is .88 where half begin 8 ms after the others, .50 where 16.7 ms
_FEW_ODD = 0.05  # of the places


def on_the_beat(
    asked: NDArray[np.intp], heard: ScoredCandidates, *, rate_hz: int, rules: BeatRules, bursts: BurstRules
) -> NDArray[np.bool_]:
    """Return which of n sounds, ascending indices of those that are heard, keep the beat around them, shape (n,).

    Of a run as fast as a gun fires half has to: on a grid of a tenth of a second rounds lie by chance.
    """
    found = np.zeros(asked.size, bool)
    film_ms = np.asarray(1000.0 / rate_hz * heard.onsets, np.float64)
    asked_ms = film_ms[asked]
    sounds = np.flatnonzero(np.diff(film_ms, prepend=-np.inf) > _SAME_MS)
    sounds_ms = film_ms[sounds]
    for start_ms, last_ms in _strides(film_ms, 1000.0 * rules.window_s / _STRIDE, bursts.longest_gap_ms):
        some = slice(np.searchsorted(asked_ms, start_ms), np.searchsorted(asked_ms, last_ms, side="right"))
        for before in _BEFORE if some.start < some.stop else ():
            passage = Passage(sounds_ms, start_ms - 1000.0 * before * rules.window_s, rules, bursts.longest_gap_ms)
            if passage.sounds.size < rules.fewest:
                continue
            peak = strongest_grid(passage)
            exact, rough = _exact(peak, passage), _rough(peak, passage)
            if exact is not None:
                found[some] |= exact.holds(asked_ms[some], rules.within_ms)
            if rough is not None:
                around = sounds[passage.part()]
                found[some] |= _with_those_alike(rough, asked[some], around, heard, film_ms, rules)
    for run in runs_of(asked_ms, bursts.longest_gap_ms):
        found[run] &= 2 * found[run].sum() >= run.size
    return found


def _strides(times: Times, length: float, longest_gap: float) -> Iterator[tuple[float, float]]:
    """Yield the first and the last sound of what is asked about at once: a run, or so long a part of one.

    Were the windows of all runs counted from one sound, any before it would move them, and with them what keeps a beat.
    """
    for run in runs_of(times, longest_gap) if times.size else ():
        part = np.floor((times[run] - times[run[0]]) / length)
        for same in np.split(times[run], np.flatnonzero(np.diff(part)) + 1):
            yield float(same[0]), float(same[-1])


def _exact(peak: BeatGrid, passage: Passage) -> BeatGrid | None:
    """Return the grid that half of all sounds of a passage keep, to a few milliseconds; None where they keep none."""
    rules, sounds = passage.rules, passage.sounds
    grid = fitted_grid(peak, passage, [wide * rules.within_ms for wide in _NARROWING], _WRITTEN)
    if grid is None:
        return None
    near, begins = grid.holds(sounds, rules.within_ms), passage.begins
    most = near.sum() >= max(rules.fewest, rules.share * sounds.size)
    return _coarsest(grid, sounds[near], rules) if most and near[begins].mean() >= rules.share else None


def _rough(peak: BeatGrid, passage: Passage) -> BeatGrid | None:
    """Return the grid around which the sounds of a passage lie, further off; None where that may be chance.

    At one period, n sounds that come anywhere have phases with a resultant of R by a chance of exp(-n R^2) (Rayleigh).
    """
    rules = passage.rules
    grid = fitted_grid(peak, passage, [wide * peak.period for wide in _WIDE], _ROUGHLY_WRITTEN)
    if grid is None:
        return None
    told = passage.sounds[of_no_row(passage.sounds)]
    return grid if told.size * grid.resultant(told) ** 2 >= rules.alike_resultant else None


def _with_those_alike(
    grid: BeatGrid,
    asked: NDArray[np.intp],
    around: NDArray[np.intp],
    heard: ScoredCandidates,
    film_ms: Times,
    rules: BeatRules,
) -> NDArray[np.bool_]:
    """Return which of n sounds lie on a grid with more of those around that are alike than chance would put there."""
    apart = np.abs(film_ms[asked, None] - film_ms[around]) > _SAME_MS
    as_loud = np.abs(heard.peaks_dbfs[asked, None] - heard.peaks_dbfs[around]) <= rules.alike_level_db
    differ_db = np.abs(heard.sounds[asked, None] - heard.sounds[around]).mean(axis=2)
    alike = apart & as_loud & (differ_db <= rules.alike_sound_db)
    own, others = (grid.holds(film_ms[which], rules.alike_within_ms) for which in (asked, around))
    for row in alike:
        places = np.flatnonzero(row)
        row[places] = of_no_row(film_ms[around[places]])
    count, kept = alike.sum(axis=1), (alike & others).sum(axis=1)
    unlikely = chance_of(kept, count, grid, rules.alike_within_ms) <= rules.by_chance
    return np.asarray(own & unlikely)


def _coarsest(grid: BeatGrid, on_grid: Times, rules: BeatRules) -> BeatGrid:
    """Return the grid of twice the period, and again, as long as that holds as good as all that lies on this one."""
    while 2.0 * grid.period <= rules.longest_ms:
        odd = grid.places(on_grid) % 2 == 1
        if min(odd.mean(), 1.0 - odd.mean()) > _FEW_ODD:
            break
        grid = BeatGrid(2.0 * grid.period, grid.phase + (grid.period if odd.mean() > 0.5 else 0.0))
    return grid
