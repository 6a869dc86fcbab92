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
from ..medians import weighted_median
from .comparison import Comparison, Samples
from .feeling import Felt
from .hearing import Heard
from .known import as_known, energy, own_drive, without_fade

ATTACK_MS = 12.0
"""The longest blast of the segmentation: the attack's peak lies within."""

MISSING = 0.5
"""A drive does what is due where no more than this share of it is missing: 0.2 in right ones, 1 at rest."""

STRETCH_MS = 10.0
"""So short that a hole of 3 ms shows, and so long that a drive may turn over a little aside."""

FAINT = 1e-3
"""What is due of a drive counts as this share of the limit at least: rounding to 16 bits is 9e-6 to 15e-6 rms."""

_LOUD = 0.1
"""A gain is told from samples of at least this share of the largest, which are few."""

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


def adjoints_of(shared: Comparison, heard: Heard, felt: Felt, *, piece: slice) -> Adjoints:
    """Return the adjoints of a shot as its drive was made for: `piece` is where in the span that is the shot's own.

    So without what the opening of its window leaves ringing, for no drive undoes that, without the drive of the next
    shot and without the fade-out.
    """
    wet = _unsolved(heard, 1.0 if heard.solved else _gain_of_wet(heard, felt))
    left = np.where(heard.weights > 0.0, _opening(heard, wet), 0.0) - wet  # `own` is at rest until the window opens
    known = as_known(shared, heard, felt, gain=heard.gain, since=piece.start, stop=piece.stop)
    vibration = known.vibration - dsp.run_filter(shared.felt, left) if left.any() else known.vibration
    return Adjoints(shared.adjoint(known.wanted / heard.gain), shared.adjoint(vibration))


def possible_drives(shared: Comparison, heard: Heard, felt: Felt, adjoints: Adjoints) -> tuple[DueDrive, ...]:
    """Return the drives that are due with the gains that a shot may have been rendered with.

    Two are tried for a solved drive: the gain that was asked for, and the one that is measured, by comparing H'H u with
    H't where the drive is free of its limit. The second is uncertain where little of the drive is free.
    """
    if not heard.solved:
        return (unsolved_drive(shared, heard, felt),)
    rest = _rest(shared, heard)
    free = np.flatnonzero(felt.free[rest]) + rest.start
    limit, whole, found = shared.rules.peak, without_fade(shared, heard, felt), []
    for gain in (heard.gain, _gain(adjoints.intended[free], adjoints.felt[free])):
        descent = gain * adjoints.intended - adjoints.felt
        found.append(DueDrive(gain, np.clip(whole + _LONG * shared.step * descent, -limit, limit)))
    return tuple(found)


def unsolved_drive(shared: Comparison, heard: Heard, felt: Felt) -> DueDrive:
    """Return the drive that is due without a solver.

    Its gain is the one that most of its stretches have, be it that of its loud samples or that after its attack: either
    may be missing.
    """
    rest = _rest(shared, heard)
    free = np.flatnonzero(felt.free[rest]) + rest.start
    gains = [_gain_of_wet(heard, felt), *([_gain(heard.wet[free], felt.drive[free])] if free.size else [])]
    dues = [DueDrive(gain, _unsolved(heard, gain)) for gain in gains]

    def strays(due: DueDrive) -> tuple[int, float]:
        apart = _departures(shared, heard, felt, due)
        return int(np.count_nonzero(apart > shared.rules.departure)), float(np.minimum(apart, 1.0).sum())

    return min(dues, key=strays)


def upright(heard: Heard, dues: tuple[DueDrive, ...]) -> tuple[DueDrive, ...]:
    """Return those of the drives that may be due which move as they are meant to, not the other way.

    An inverted drive is known for one by the sign of its gain, but is not due.
    """
    return tuple(due for due in dues if due.gain > 0.0) or (DueDrive(heard.gain, _unsolved(heard, heard.gain)),)


def borne_out(shared: Comparison, heard: Heard, felt: Felt, dues: tuple[DueDrive, ...]) -> tuple[DueDrive, ...]:
    """Return those of the drives that may be due which a solved one follows after the attack; perhaps none."""
    rest = _rest(shared, heard)
    return tuple(
        due
        for due in dues
        if not heard.solved or energy((due.drive - felt.drive)[rest]) <= MISSING**2 * energy(due.drive[rest])
    )


def departure(shared: Comparison, heard: Heard, felt: Felt, dues: tuple[DueDrive, ...]) -> float | None:
    """Return by how much a drive departs from what is due in its worst stretch, as a share of that; None if too short.

    A whole shot hides what happens to a part of it, for most of its energy is in the attack. Each stretch is compared
    with itself, so a drive that rests or turns over long after the bang departs as plainly there. The best of what may
    be due counts.
    """
    found = [_departures(shared, heard, felt, due) for due in dues]
    return min((float(shares.max()) for shares in found if shares.size), default=None)


def away_from_due(shared: Comparison, heard: Heard, felt: Felt) -> float:
    """Return how far a drive without a solver is from what is due, from its onset on, as the energy between them."""
    own = slice(heard.core.start, max(heard.core.stop, heard.stop))
    due = heard.fading * unsolved_drive(shared, heard, felt).drive
    return energy((own_drive(heard, felt) - due)[own])


def _departures(shared: Comparison, heard: Heard, felt: Felt, due: DueDrive) -> Samples:
    """Return by which share of it a drive is not what is due in each of a shot's stretches; shape (stretches,).

    The fade-out of its window is its own as well. A solved drive is compared up to where H is asked for what the drive
    does not know or do.
    """
    length = shared.samples(STRETCH_MS)
    where = slice(heard.core.start, max(heard.core.start, heard.stop - (shared.memory if heard.solved else 0)))
    faded = heard.fading * due.drive
    apart, asked = (rms_of(in_stretches(each[where], length)) for each in (own_drive(heard, felt) - faded, faded))
    return np.asarray(apart / (asked + FAINT), dtype=np.float64)


def in_stretches(samples: Samples, length: int) -> Samples:
    """Return whole stretches of so many samples, shape (stretches, length); the rest is left out."""
    return samples[: len(samples) // length * length].reshape(-1, length)


def rms_of(stretches: Samples) -> Samples:
    """Return the rms of each stretch, shape (stretches,)."""
    return np.asarray(np.sqrt(np.mean(stretches**2, axis=1)), dtype=np.float64)


def due_before_window(heard: Heard, due: DueDrive | None) -> Samples:
    """Return the drive that is due up to the first shot of a window; where it is solved, with no gain."""
    return _opening(heard, np.zeros(len(heard.span)) if heard.solved or due is None else due.drive)


def due_before_next(shared: Comparison, heard: Heard, felt: Felt, due: DueDrive, *, since: int, stop: int) -> Samples:
    """Return the drive that is due up to sample `stop` of a span, where that of a further shot of the window begins.

    A solver does not know what comes: it expects its drive to ring on as the compensator's would, which it was given
    from where the drive of the shot before begins, `since`.
    """
    if not heard.solved:
        return due.drive
    known = as_known(shared, heard, felt, gain=due.gain, since=since, stop=stop)
    limit = shared.rules.peak
    return np.clip(known.drive + shared.step * shared.adjoint(known.wanted - known.vibration), -limit, limit)


def _unsolved(heard: Heard, gain: float) -> Samples:
    """Return the drive of an open window without a solver, which keeps to the limit; rest, where there is one."""
    return np.zeros(len(heard.span)) if heard.solved else np.clip(gain * heard.wet, -1.0, 1.0)


def _opening(heard: Heard, wet: Samples) -> Samples:
    return dsp.cross_fade(heard.background, wet, heard.weights)


def _rest(shared: Comparison, heard: Heard) -> slice:
    """Return the part of a shot after its attack, up to where the next begins to be asked for; none of a short."""
    start = min(heard.core.stop, heard.core.start + shared.samples(ATTACK_MS))
    return slice(start, max(start, heard.core.stop - shared.memory))


def _gain_of_wet(heard: Heard, felt: Felt) -> float:
    """Return the gain that most of a drive without a solver has where the limit does not hold it down.

    Most by energy: what is missing of it, at its beginning or its end, does not count. The one that was asked for where
    the limit holds all of it down.
    """
    wet, free = heard.wet[heard.core], felt.free[heard.core]
    loud = np.flatnonzero(free & (np.abs(wet) > _LOUD * np.max(np.abs(wet), where=free, initial=0.0)))
    if not loud.size:
        return heard.gain
    return weighted_median(felt.drive[heard.core][loud] / wet[loud], wet[loud] ** 2)


def _gain(intended: Samples, given: Samples) -> float:
    """Return the factor that brings a signal nearest to another; 1 where there is nothing of it."""
    own = energy(intended)
    return float(np.sum(intended * given)) / own if own > 0.0 else 1.0
