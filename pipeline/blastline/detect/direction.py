r"""From where a shot comes: which loudspeakers play what is new at its onset.

       before      |  blast          D = C(blast) - C(before)   covariance of the channels' first differences
    ---------------|\  /\            M = D D
                   | \/  \           w = length of each of M's rows
    `span` samples |  `span`         azimuth = direction of sum w u, u the loudspeakers' unit vectors

What sounds before the onset goes on and cancels in D. Where one sound is panned to several loudspeakers with gains g, D
is proportional to g g', so are its powers, and w to g: the velocity vector, which inverts the tangent law of panning
(Pulkki 1997). Where the loudspeakers play unlike sounds, D is diagonal and the louder one counts for more, as in the
energy vector (Gerzon 1992). The square lets go of what the bed leaves. The length of the energy vector, of w squared,
says how narrow the source is. The first difference favours the shock over the voice that goes on.
"""

import math
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..model import Channels, Shot, Span
from ..ruleset import ChannelRules
from ..units import gain_from_db, samples_from_ms

_GUARD_MS = 0.5
"""The blast is taken to begin so much before its onset, which may be that late in one of the channels."""


def placed(shots: Sequence[Shot], channels: Channels | None, *, rate_hz: int, rules: ChannelRules) -> list[Shot]:
    """Return the shots with their azimuths, as far as their channels can be read and tell one."""
    if channels is None:
        return list(shots)
    guard, span = samples_from_ms(_GUARD_MS, rate_hz), samples_from_ms(rules.azimuth_ms, rate_hz)
    found = []
    for shot in shots:
        onset = max(0, shot.onset - guard)
        start = max(0, onset - span)
        samples = channels.read(Span(start, min(onset + guard + span, max(onset + 1, shot.span.stop))))
        toward = None
        if samples is not None:
            toward = direction(samples, onset - start, channels.azimuths_deg, rise_db=rules.azimuth_rise_db)
        found.append(shot if toward is None else _with(shot, *toward))
    return found


def direction(
    samples: NDArray[np.floating], onset: int, azimuths_deg: Sequence[float | None], *, rise_db: float
) -> tuple[float, float] | None:
    """Return azimuth, in degrees from -180 (not included) to 180, and focus, 0 to 1, of what begins at an index.

    `samples` is (frames, channels). None where the energy does not rise by `rise_db`, or comes from all sides alike.
    """
    there = [(channel, deg) for channel, deg in enumerate(azimuths_deg) if deg is not None]
    there.sort(key=lambda each: each[1])  # sums do not depend on the order of the channels
    heard = samples[:, [channel for channel, _ in there]].astype(np.float64)
    steep = np.diff(heard, axis=0, prepend=heard[:1])
    before, blast = _covariance(steep[:onset]), _covariance(steep[onset:])
    level = float(np.trace(blast))
    if level <= 0.0 or level < np.trace(before) * gain_from_db(rise_db) ** 2:
        return None
    new = (blast - before) / level
    weights = np.sqrt(np.square(new @ new).sum(axis=1))
    toward = np.exp(1j * np.radians([deg for _, deg in there]))
    velocity = complex(weights @ toward) / float(weights.sum())
    energy = complex(np.square(weights) @ toward) / float(np.square(weights).sum())
    if abs(velocity) < _NOWHERE:
        return None
    azimuth = round(math.degrees(math.atan2(velocity.imag, velocity.real)), 1)
    return (180.0 if azimuth == -180.0 else azimuth + 0.0), round(min(1.0, abs(energy)), 3)


_NOWHERE = 0.05
"""A vector so short points anywhere: equal sounds from all around."""


def _covariance(steep: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(steep.T @ steep / max(1, steep.shape[0]), np.float64)


def _with(shot: Shot, azimuth_deg: float, focus: float) -> Shot:
    return msgspec.structs.replace(shot, azimuth_deg=azimuth_deg, azimuth_focus=focus)
