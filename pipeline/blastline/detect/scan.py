"""Which steps of the tracks are candidates: sudden rises over everything that was there just before."""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import ScanRules
from ..units import gain_from_db, levels_db
from .pace import Pace, evenly_placed
from .segment import PEAK_MS
from .tracks import STEPS_PER_HOP, Grid

_AROUND_MS = 2000.0
CRACK_MS = 4.0  # the crack of a bullet rises more than the blast that comes as soon as this after it


def rise_ratios(track: NDArray[np.float32], history: int, floor: float | NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the ratio of each step's value to the largest one in the `history` steps before it, the last one left out.

    `track` is (steps,) or (steps, bands), each band on its own, and so is what is returned; what lies under the floor,
    one for all or one for each step, is silence. A rise that straddles two steps would hide itself if the step right
    before it counted.
    """
    padded = np.concatenate([np.zeros((history + 1, *track.shape[1:]), np.float32), track])
    past = sliding_maximum(padded, history)[: track.shape[0]]
    return np.asarray(track / np.maximum(past, floor), np.float32)


def sliding_maximum(values: NDArray[np.float32], length: int) -> NDArray[np.float32]:
    """Return the largest of every `length` successive rows, from each row on that has so many: `length` - 1 rows fewer.

    By doubling: the largest of eight is the larger of two largest of four. A few passes over whole arrays are several
    times as fast as a filter that looks at each sample, and the scan spends most of its time here.

    >>> sliding_maximum(np.array([3, 1, 2, 5, 4], np.float32), 3).tolist()
    [3.0, 5.0, 5.0]
    """
    have, best = 1, values
    while 2 * have <= length:
        best = np.maximum(best[:-have], best[have:])
        have *= 2
    rest = length - have
    return np.maximum(best[:-rest], best[rest:]) if rest else best


def band_rises(bands: NDArray[np.float32], history: int, floor: float | NDArray[np.float32]) -> NDArray[np.float32]:
    """Return each frame's rise as an amplitude ratio, shape (hops,): the mean, in dB, of the two bands that rise most.

    A shot under a loud dialogue still towers in the bands that the voice leaves free; two bands, since a single one
    rises with any tone. A frame overlaps its neighbours, so the history ends two frames before it, as in `rise_ratios`.
    """
    first = second = np.zeros(bands.shape[0], np.float32)
    for energy in rise_ratios(bands, history, np.square(floor)[..., None]).T:
        second = np.maximum(second, np.minimum(first, energy))
        first = np.maximum(first, energy)
    return np.asarray(np.sqrt(np.sqrt(first * second)), np.float32)


def silence(peak: NDArray[np.float32], *, grid: Grid, rules: ScanRules) -> NDArray[np.float32]:
    """Return up to which peak each step is silence, shape (steps,): `floor_dbfs`, or `range_db` under the loudest near.

    So what is silence in a film is silence in a quieter copy.
    """
    reach = grid.steps(_AROUND_MS)
    loudest = sliding_maximum(np.pad(peak, reach), 2 * reach + 1)
    floor = np.maximum(loudest * gain_from_db(-rules.range_db), gain_from_db(rules.floor_dbfs))
    return np.asarray(floor, np.float32)


def loudest_around(peak: NDArray[np.float32], steps: NDArray[np.intp], *, grid: Grid) -> NDArray[np.float32]:
    """Return the largest peak within two seconds of each of n steps, shape (n,), as `silence` counts them."""
    reach = grid.steps(_AROUND_MS)
    around = [peak[max(0, step - reach) : step + reach + 1] for step in steps.tolist()]
    return np.array([part.max(initial=0.0) for part in around], np.float32)


def candidate_steps(
    peak: NDArray[np.float32],
    slope: NDArray[np.float32],
    bands: NDArray[np.float32],
    *,
    grid: Grid,
    rules: ScanRules,
    pace: Pace,
) -> NDArray[np.intp]:
    """Return the n steps that are candidates, ascending, shape (n,); the tracks are those of a `Chunk`.

    A step is one where its rise, over the required jump, is at least 1 in any track and nothing in the next
    `separation_ms` or just before it rises more. In a row at the `pace` of automatic fire a rise of `row_jump_db` in
    the waveform is enough: where a shot lingers, the next never towers over it.
    """
    history, apart = grid.steps(rules.history_ms), grid.steps(rules.separation_ms)
    floor = silence(peak, grid=grid, rules=rules)
    rises = rise_ratios(peak, history, floor)
    score = rises / gain_from_db(rules.jump_db)
    if rules.difference_jump_db is not None:
        # a slope of the floor's height is as near to silence as a peak of it
        sharper = rise_ratios(slope, history, floor)
        np.maximum(score, sharper / gain_from_db(rules.difference_jump_db), out=score)
        np.maximum(rises, sharper, out=rises)
    if rules.band_jump_db is not None:
        frames = band_rises(
            bands, history // STEPS_PER_HOP, floor[: bands.shape[0] * STEPS_PER_HOP : STEPS_PER_HOP]
        ) / gain_from_db(rules.band_jump_db)
        # a frame ends with its hop: what it heard lies in the hop's first step as likely as in its second
        np.maximum(score, np.repeat(frames, STEPS_PER_HOP), out=score)
    heard = peak > floor
    steps = _steepest(score, heard, least=1.0, apart=apart, grid=grid)
    if rules.row_jump_db is None:
        return steps
    perhaps = np.union1d(steps, _steepest(rises, heard, least=gain_from_db(rules.row_jump_db), apart=apart, grid=grid))
    loud_db = levels_db(sliding_maximum(np.pad(peak, (0, grid.steps(PEAK_MS) - 1)), grid.steps(PEAK_MS))[perhaps])
    in_row = evenly_placed(perhaps * grid.step, loud_db, pace, rate_hz=grid.rate_hz)
    return np.union1d(steps, perhaps[in_row])


def _steepest(
    rises: NDArray[np.float32], heard: NDArray[np.bool_], *, least: float, apart: int, grid: Grid
) -> NDArray[np.intp]:
    """Return the steps that are `heard`, rise by at least so much, and more than any other up to `apart` away.

    Of those before it only the last few count: an earlier one may be another sound.
    """
    before = min(apart, grid.steps(CRACK_MS))
    best = sliding_maximum(np.pad(rises, (before, apart)), before + apart + 1)
    return np.flatnonzero((rises >= least) & (rises >= best) & heard)
