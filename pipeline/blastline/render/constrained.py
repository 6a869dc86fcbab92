"""The drive within the actuator's limit that is felt most like the sound: box-constrained least squares.

    minimise  1/2 |H u - t|^2   over  |u| <= 1

H is the felt response as a convolution that may ring out after the window, t the sound in the band. An interior-point
method solves it (`interior`), at the full rate or for the corners of a drive that runs in straight lines between them
(every `stride` samples, so that the limit at the corners is the limit everywhere and nothing shifts in time; but never
further apart than steers what the actuator answers above the band). What it found is judged, and polished, on the
problem itself (`descent`).
docs/rendering.md tells what else was tried.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..ruleset import RenderRules
from .banded import Recursion, hat, well_conditioned_stride
from .descent import BoxProblem, Convolution, Iterate, restarted_fista
from .interior import fewest_unknowns, solve_box_qp

Samples = NDArray[np.float64]

_UNAIDED = 300
"""Gradient steps where the interior-point method cannot do it all: for a few samples, where rounding has ended it,
where its straight lines are felt less like the sound than the compensator's drive cut off at the limit, where they
turn over too slowly for it, or where H remembers so much that its corners are wider apart than asked: by themselves
they would lose 2 to 4 % of energy.
"""

_UNSETTLED, _SETTLING = 0.01, 4
"""A drive that a safe step down the slope still moves by more than this share of its rms gets so many steps at least.

Corners 4 kHz apart tell too coarsely when a drive that is at its limit most of the time turns over: of sounds raised by
18 dB and more, what was felt before the next shot of a burst was off by up to 0.15 of its peak. Nor do they tell enough
of a loud boom under a shot: at 0 dB that was off by up to 0.08 of the peak where this share was 0.04."""

_TURNING_HZ = 1000.0
"""Straight lines that may leave more to be gained than a tone of this frequency loses by them do not follow the sound.

At its limit, a drive that takes a time d to turn over has sin(x) / x of a square wave's tone, x = pi f d: 1 - x^2 / 6.
Of sounds that ring at 1 to 2.5 kHz corners 12 kHz apart lost up to 6 % of energy. The seat hardly feels these, so that
a safe step moves next to nothing there, and `_UNSETTLED` does not tell."""

_ALREADY = 0.1
"""The compensator's drive is solution enough where it leaves no more than this share of the tolerance."""


@dataclass(frozen=True)
class SolveSummary:
    """What a shot's drive took: the solver's steps, and the share of the wanted energy that it makes felt."""

    steps: int
    explained: float


def constrained_drive(
    target: Samples,
    *,
    starts: Sequence[int],
    impulse: Samples,
    recursion: Recursion,
    rate_hz: int,
    warm_start: Samples,
    rules: RenderRules,
) -> tuple[Samples, tuple[SolveSummary, ...]]:
    """Return the drive u, |u| <= 1, that is felt nearest to the target, shape (frames,), and what each shot took.

    `impulse` is H's response, `recursion` H as the solver works with it, `warm_start` a first guess: the compensator's
    drive. `starts`, in order, are where the drive of each shot may begin: it is 0 before the first, and solved from
    start to start. Each piece follows on from what the drive before it still rings, and may ring on as its first guess
    would if that were felt no more strongly than the sound; but no piece knows the next. Solved as one, the actuator
    would wind up for a shot up to 10 ms before it is heard, and spoil the end of the shot before.
    """
    drive, summaries = np.zeros(len(target)), []
    warm_start = np.clip(warm_start, -1.0, 1.0)
    for start, stop in pairwise([*starts, len(target)]):
        if start >= stop:
            summaries.append(SolveSummary(0, 0.0))
            continue
        rings = _ringing(drive[starts[0] : start], impulse)
        by_h, guess = Convolution.of(impulse, stop - start), warm_start[start:stop]
        felt = by_h.felt(guess)
        wanted = _wanted(target[start:stop], felt, rings=rings)
        energy = 0.5 * float(np.sum(wanted * wanted))
        missed = 0.5 * float(np.sum((felt - wanted) ** 2))
        drive[start:stop], summary = _piece(
            by_h.problem(wanted), guess, recursion, energy, missed, rate_hz=rate_hz, rules=rules
        )
        summaries.append(summary)
    return drive, tuple(summaries)


def _wanted(target: Samples, felt: Samples, *, rings: Samples) -> Samples:
    """Return what is to be felt of a piece, shape as what is `felt` of its first guess, where the last one `rings` on.

    After it that is the guess's ringing, as if the guess were felt no more strongly than what is wanted: where the
    limit cuts far into the guess, a seat with a slow resonance rings with that, not with the sound.
    """
    frames = len(target)
    wanted = np.concatenate([target, np.zeros(len(felt) - frames)])
    wanted[: len(rings)] -= rings[: len(wanted)]
    asked, guessed = (float(np.sum(each[:frames] ** 2)) for each in (wanted, felt))
    wanted[frames:] += felt[frames:] * (math.sqrt(asked / guessed) if asked < guessed else 1.0)
    return wanted


def _ringing(drive: Samples, impulse: Samples) -> Samples:
    """Return what is felt after a drive has ended, shape (len(impulse) - 1,)."""
    from scipy.signal import fftconvolve

    memory = len(impulse) - 1
    last = drive[max(0, len(drive) - memory) :]
    return np.asarray(fftconvolve(last, impulse)[len(last) :], dtype=np.float64) if len(last) else np.zeros(memory)


def _piece(
    problem: BoxProblem,
    guess: Samples,
    recursion: Recursion,
    energy: float,
    missed: float,
    *,
    rate_hz: int,
    rules: RenderRules,
) -> tuple[Samples, SolveSummary]:
    """Return the drive of one piece: the better of what the solver finds and the first guess, polished.

    `energy` is half that of what is wanted, of which the guess has `missed` so much.
    """
    asked = min(max(1, rate_hz // rules.solver_rate_hz), recursion.longest_stride)
    stride = well_conditioned_stride(recursion, asked, rate_hz)
    corners = corner_rhs(problem.rhs, stride)
    steps, polish, best = 0, _UNAIDED, None
    if missed <= _ALREADY * rules.tolerance * energy:
        polish = rules.polish_iterations
    elif len(corners) >= fewest_unknowns(recursion, stride):
        found = solve_box_qp(
            recursion,
            corners,
            guess[stride - 1 :: stride][: len(corners)],
            stride=stride,
            iterations=rules.iterations,
            tolerance=rules.tolerance,
        )
        steps, polish = found.steps, rules.polish_iterations if found.finished and stride == asked else _UNAIDED
        # where the limit is hardly met, the compensator's drive is better than straight lines, though it knows
        # nothing of what the shot before rings, or of the start before which it is 0
        straight = problem.at(between_corners(found.drive, stride, len(guess)))
        best = straight if energy + straight.objective <= missed else problem.at(guess)
        if best is not straight and missed > rules.tolerance * energy:
            polish = max(polish, _UNAIDED)
        elif _is_unsettled(problem, best):
            polish = max(polish, _SETTLING)
        left = min(problem.to_gain(straight) - (straight.objective - best.objective), energy + best.objective)
        if left > _left_by_lines(stride / rate_hz, rules.tolerance) * abs(best.objective):
            polish = max(polish, _UNAIDED)
    solution = restarted_fista(problem, best or problem.at(guess), iterations=polish, tolerance=rules.tolerance)
    return solution.drive, SolveSummary(steps, max(0.0, -solution.objective / energy) if energy > 0.0 else 1.0)


def _is_unsettled(problem: BoxProblem, found: Iterate) -> bool:
    """Return whether a step down the slope would still move a drive by more than its corners should leave."""
    moved = problem.step_from(found.drive, found.normal) - found.drive
    return bool(np.sum(moved * moved) > _UNSETTLED**2 * np.sum(found.drive * found.drive))


def _left_by_lines(corner_s: float, tolerance: float) -> float:
    """Return what share of the explained energy straight lines between corners so far apart may leave to be gained."""
    return (math.pi * _TURNING_HZ * corner_s) ** 2 / 6.0 + 2.0 * tolerance


def corner_rhs(rhs: Samples, stride: int) -> Samples:
    """Return b of the same problem for drives that are straight between corners `stride` samples apart.

    Corner k lies on sample (k + 1) stride - 1 and the drive is 0 one sample before the first and after the last.
    Empty where there is no room for one.
    """
    rise = hat(stride)
    if len(rhs) < len(rise):
        return np.zeros(0)
    around_each = np.lib.stride_tricks.sliding_window_view(rhs, len(rise))[::stride]
    return np.asarray(np.einsum("ij,j->i", around_each, rise), dtype=np.float64)


def between_corners(corners: Samples, stride: int, frames: int) -> Samples:
    """Return the drive that runs in straight lines from corner to corner, shape (frames,)."""
    places = np.arange(len(corners) + 2) * stride - 1
    drive = np.interp(np.arange(frames), places, np.concatenate([[0.0], corners, [0.0]]))
    return np.asarray(np.clip(drive, -1.0, 1.0), dtype=np.float64)
