"""The drive that is due around an onset, sample for sample.

What is felt of a drive at the actuator's limit does not have the shape of the sound, so comparing the two does not tell
whether they begin at the same place. But what the drive has to do at each moment is known:

    until a window's first shot    the background fades out; a drive without a solver fades in over it
    direct, filter                 the sound, the compensator's output
    constrained                    what a step down the slope of |H u - t| within the limit leads to: from the best
                                   drive it leads nowhere, however far H u stays from t

H remembers no more than a few milliseconds, so the last of these holds for each moment by itself.
"""

from dataclasses import dataclass

import numpy as np

from .. import dsp
from .comparison import Comparison, Samples
from .hearing import Felt, Heard

ATTACK_MS = 12.0
"""The longest blast of the segmentation: the attack's peak lies within."""

MISSING = 0.5
"""A drive does what is due where no more than this share of it is missing: 0.2 in right ones, 1 at rest."""

_LONG = 16.0
"""A step so many times the safe one makes up at once for all that is missing where |H| is a quarter of its largest."""


@dataclass(frozen=True, eq=False)
class Adjoints:
    """H't and H'H u: the adjoint of H, applied to what is intended and to what is felt.

    A drive can only change what is left of both after that. Shape (frames,) each, over the span of `Heard`.
    """

    intended: Samples
    felt: Samples


@dataclass(frozen=True, eq=False)
class DueDrive:
    """The drive that is due in the open window, from the shot's lead on, if rendered with a gain; shape (frames,)."""

    gain: float
    drive: Samples


def adjoints_of(shared: Comparison, heard: Heard, felt: Felt) -> Adjoints:
    """Return the adjoints of a shot without what the opening of its window leaves ringing: no drive undoes that."""
    wet = _unsolved(heard, 1.0 if heard.solved else _gain_of_wet(shared, heard, felt))
    left = _opening(heard, wet) - wet
    vibration = felt.own - dsp.run_filter(shared.felt, left) if left.any() else felt.own
    return Adjoints(shared.adjoint(heard.intended), shared.adjoint(vibration))


def due_drives(shared: Comparison, heard: Heard, felt: Felt, adjoints: Adjoints) -> tuple[DueDrive, ...]:
    """Return the drives that may be due: those that the actual drive follows after the attack; perhaps none.

    Two gains are tried for a solved drive: the one that was asked for, and the one that is measured, by comparing H'H u
    with H't where the drive is free of its limit. The second is uncertain where little of the drive is free.
    """
    if not heard.solved:
        gain = _gain_of_wet(shared, heard, felt)
        return (DueDrive(gain, _unsolved(heard, gain)),)
    rest = _rest(shared, heard)
    free = np.flatnonzero(felt.free[rest]) + rest.start
    limit, found = shared.rules.peak, []
    for gain in (heard.gain, _gain(adjoints.intended[free], adjoints.felt[free])):
        descent = gain * adjoints.intended - adjoints.felt
        due = np.clip(felt.drive + _LONG * shared.step * descent, -limit, limit)
        if _energy((due - felt.drive)[rest]) <= MISSING**2 * _energy(due[rest]):
            found.append(DueDrive(gain, due))
    return tuple(found)


def due_before_window(heard: Heard, due: DueDrive | None) -> Samples:
    """Return the drive that is due up to the first shot of a window; where it is solved, with no gain."""
    return _opening(heard, np.zeros(len(heard.span)) if heard.solved or due is None else due.drive)


def due_before_next(shared: Comparison, heard: Heard, felt: Felt, due: DueDrive, *, since: int, stop: int) -> Samples:
    """Return the drive that is due up to sample `stop` of a span, where that of a further shot of the window begins.

    A solver does not know what comes: it expects its drive to ring on as the compensator's would, which it was given
    from where the drive of the shot before begins, `since`.
    """
    if not heard.solved or heard.wet is None:
        return due.drive
    at = np.arange(len(heard.span))
    limit, early = shared.rules.peak, at < stop
    first_guess = np.where(early & (at >= since), due.gain * heard.wet, 0.0)
    rings = dsp.run_filter(shared.felt, np.clip(first_guess, -limit, limit))
    wanted = np.where(early, due.gain * heard.intended, rings)
    drive = np.where(early, felt.drive, 0.0)
    vibration = felt.own - dsp.run_filter(shared.felt, felt.drive - drive)
    return np.clip(drive + shared.step * shared.adjoint(wanted - vibration), -limit, limit)


def _unsolved(heard: Heard, gain: float) -> Samples:
    """Return the drive of an open window without a solver, which keeps to the limit; rest, where there is one."""
    return np.zeros(len(heard.span)) if heard.solved or heard.wet is None else np.clip(gain * heard.wet, -1.0, 1.0)


def _opening(heard: Heard, wet: Samples) -> Samples:
    return dsp.cross_fade(heard.background, wet, heard.weights)


def _rest(shared: Comparison, heard: Heard) -> slice:
    """Return the part of a shot after its attack, up to where the next begins to be asked for; none of a short."""
    start = min(heard.core.stop, heard.core.start + shared.samples(ATTACK_MS))
    return slice(start, max(start, heard.core.stop - shared.memory))


def _gain_of_wet(shared: Comparison, heard: Heard, felt: Felt) -> float:
    """Return the gain with which a drive without a solver was rendered, told where the limit does not hold it down."""
    if heard.wet is None:
        return 1.0
    rest = _rest(shared, heard)
    where = rest if rest.stop > rest.start else heard.core
    free = np.flatnonzero(felt.free[where]) + where.start
    return _gain(heard.wet[free], felt.drive[free])


def _gain(intended: Samples, given: Samples) -> float:
    """Return the factor that brings a signal nearest to another; 1 where there is nothing of it."""
    own = _energy(intended)
    return float(np.sum(intended * given)) / own if own > 0.0 else 1.0


def _energy(samples: Samples) -> float:
    return float(np.sum(samples**2))
