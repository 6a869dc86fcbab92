"""Whether a shot's drive is under way when its attack begins, and at rest or with the shot before until then."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from .. import dsp
from ..model import Event
from ..units import SILENCE_DB, db_from_gain
from .comparison import Comparison, Samples
from .due import ATTACK_MS, MISSING, DueDrive, due_before_next, due_before_window
from .feeling import Felt
from .hearing import Heard, Part

_BEFORE_MS = 20.0
"""Where a pre-echo is looked for in a drive of unknown making, and before a shot that does not open its window.

Up to there the drive belongs to the shot before; what opens a window has to be at rest from its opening on.
"""

_GRAIN_MS = 0.5
"""A drive crosses zero; over this long it is plain whether it moves."""

_REST = 0.01
"""A drive below this share of its attack's most is at rest."""

_ASKED = 0.1
"""A drive is asked for where this share of the attack's most is due."""


@dataclass(frozen=True)
class PreEcho:
    """What is felt before a shot beyond what is due there, and how much may be, in dB of the shot's peak.

    `level_db` is None where no drive that may be due is borne out, so that nothing can be told.
    """

    level_db: float | None
    due_db: float


NO_PRE_ECHO = PreEcho(SILENCE_DB, SILENCE_DB)


def late_start(shared: Comparison, heard: Heard, felt: Felt, due_drives: tuple[DueDrive, ...]) -> float | None:
    """Return how many samples after the onset, or after it is first asked for, the drive is under way.

    Where no drive that may be due is borne out it is not known what is asked for: a drive at rest is late all the
    same, of one that moves nothing can be told, and None is returned.
    """
    onset, lead = heard.core.start, shared.samples(shared.lead_ms)
    attack = slice(onset - lead, max(onset + 1, min(onset + shared.samples(ATTACK_MS), heard.core.stop)))
    grain = min(shared.samples(_GRAIN_MS), attack.stop - attack.start)
    found = []
    for due in (each.drive[attack] for each in due_drives if each.gain != 0.0):  # 0 is that of a drive at rest
        asked, moves = _first(_running_energy(due, grain), _running_energy(due - felt.drive[attack], grain))
        found.append(float(max(0, moves - max(asked, lead))))
    return min(found) if found else _rest_after(felt.drive[attack], grain, lead)


def _rest_after(drive: Samples, grain: int, lead: int) -> float | None:
    """Return how many samples after the lead a drive is still at rest, None where it is not."""
    energy = _running_energy(drive, grain)
    resting = int(np.argmax(energy > _REST**2 * energy.max())) if energy.any() else len(drive)
    return float(resting - lead) if resting > lead else None


def _first(due: Samples, missing: Samples) -> tuple[int, int]:
    """Return where a drive is first asked for and where it is first under way; the end where it never is."""
    asked = due >= _ASKED**2 * due.max()
    under_way = np.flatnonzero(asked & (missing <= MISSING**2 * due))
    return int(np.argmax(asked)), int(under_way[0]) if under_way.size else len(due)


def pre_echo(
    shared: Comparison, event: Event, part: Part, heard: Heard, felt: Felt, due_drives: tuple[DueDrive, ...]
) -> PreEcho:
    """Return what is felt before a shot: of a drive whose making is known, nothing beyond what is due may be.

    Where the making is unknown, so is what is due, and as much may be felt as is heard.
    """
    onset, lead = heard.core.start, shared.samples(shared.lead_ms)
    peak = _peak(felt.vibration[heard.core])
    since = part.since - heard.span.start
    first = max(0, since if part.opens else max(onset - shared.samples(_BEFORE_MS), since))
    before = slice(first, onset - max(lead, shared.samples(shared.rules.preecho_guard_ms)))
    if peak == 0.0 or before.stop <= first:
        return NO_PRE_ECHO
    if event.drive is None:
        before = slice(max(first, onset - shared.samples(_BEFORE_MS)), before.stop)
        felt_db = db_from_gain(_peak(felt.vibration[before]) / peak)
        return PreEcho(felt_db, db_from_gain(_peak(heard.intended[before]) / peak))
    if part.opens:
        dues = [due_before_window(heard, due_drives[0] if due_drives else None)]
    else:
        due_before = partial(due_before_next, shared, heard, felt, since=since, stop=onset - lead)
        dues = [due_before(due) for due in due_drives]
    beyond = [_peak(dsp.run_filter(shared.felt, (felt.drive - due)[before])) for due in dues]
    return PreEcho(db_from_gain(min(beyond) / peak) if beyond else None, SILENCE_DB)


def _running_energy(samples: Samples, length: int) -> Samples:
    """Return the energy of every run of so many samples."""
    sums = np.cumsum(np.concatenate([[0.0], samples**2]))
    return np.asarray(sums[length:] - sums[:-length], dtype=np.float64)


def _peak(samples: Samples) -> float:
    return float(np.abs(samples).max(initial=0.0))
