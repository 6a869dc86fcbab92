r"""From where a shot comes: which loudspeakers play what is new at its onset.

       before      |  blast          D = C(blast) - C(before)   covariances of the channels' first differences
    ---------------|\  /\            S = the channels whose own energy rises
                   | \/  \           M = D[:, S] D[S, S]
    `span` samples |  `span`         w = length of each of M's rows, less what chance gives it
                                     azimuth = direction of sum w u, u the loudspeakers' unit vectors

What sounds before the onset goes on and cancels in D; the first difference favours the shock over a voice that goes on.
Where one sound is panned to several loudspeakers with gains g, D is proportional to g g' and w to g: the velocity
vector, which inverts the tangent law of panning (Pulkki 1997). Where the loudspeakers play unlike sounds, D is diagonal
and the louder one counts for more, as in the energy vector (Gerzon 1992). A channel whose energy does not rise, such as
a centre full of dialogue, counts as far as it plays what the others play. The length of the energy vector, of w
squared, says how narrow the source is.
"""

import math
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..model import Channels, Shot, Span
from ..ruleset import ChannelRules
from ..units import gain_from_db, samples_from_ms
from .near import have_near
from .sides import SAME_MS

_GUARD_MS = 0.5
"""The blast is taken to begin so much before its onset, which may be that late in one of the channels."""

_ALIKE_MS = 0.2
"""The sound of a film resembles itself for so long: two that have nothing in common seem alike by as much as that
leaves of the blast."""

_AGAINST = 0.25
"""Channels whose sum has so little of the energy that they have cancel each other: that comes from nowhere."""

_NOWHERE = 0.05
"""A vector so short points anywhere: equal sounds from all around."""


def with_azimuths(
    shots: Sequence[Shot],
    channels: Channels | None,
    *,
    rate_hz: int,
    rules: ChannelRules,
    side_onsets: Sequence[int] = (),
) -> list[Shot]:
    """Return the shots with their azimuths, as far as their channels can be read and tell one.

    `side_onsets` were heard in the sides: what rises there at the same time may be a voice.
    """
    if channels is None:
        return list(shots)
    guard, span = samples_from_ms(_GUARD_MS, rate_hz), samples_from_ms(rules.azimuth_ms, rate_hz)
    in_sides = have_near([shot.onset for shot in shots], side_onsets, samples_from_ms(SAME_MS, rate_hz)).tolist()
    found = []
    for shot, elsewhere in zip(shots, in_sides, strict=True):
        onset = max(0, shot.onset - guard)
        start = max(0, onset - span)
        samples = channels.read(Span(start, min(onset + guard + span, max(onset + 1, shot.span.stop))))
        toward = None
        if samples is not None:
            toward = direction(
                samples,
                onset - start,
                channels.azimuths_deg,
                rate_hz=rate_hz,
                rise_db=rules.azimuth_rise_db,
                doubtful=channels.centre if elsewhere else None,
            )
        found.append(shot if toward is None else _with(shot, *toward))
    return found


def direction(
    samples: NDArray[np.floating],
    onset: int,
    azimuths_deg: Sequence[float | None],
    *,
    rate_hz: int,
    rise_db: float,
    doubtful: int | None = None,
) -> tuple[float, float] | None:
    """Return azimuth, in degrees from -180 (not included) to 180, and focus, 0 to 1, of what begins at an index.

    `samples` is (frames, channels). None where no channel's energy rises by `rise_db`, or all sides play alike. The
    `doubtful` channel counts only as far as it plays what others play, where others rise.
    """
    there = [(channel, deg) for channel, deg in enumerate(azimuths_deg) if deg is not None]
    there.sort(key=lambda each: each[1])  # sums do not depend on the order of the channels
    heard = samples[:, [channel for channel, _ in there]].astype(np.float64)
    steep = np.diff(heard, axis=0, prepend=heard[:1])
    was, now = _covariance(steep[:onset]), _covariance(steep[onset:])
    rising = (now.diagonal() >= gain_from_db(rise_db) ** 2 * was.diagonal()) & (now.diagonal() > 0.0)
    sure = rising & np.array([channel != doubtful for channel, _ in there])
    share = min(1.0, samples_from_ms(_ALIKE_MS, rate_hz) / max(1, steep.shape[0] - onset))
    weights = _weights(was, now, sure if sure.any() else rising, share)
    if not weights.any():
        return None
    toward = np.exp(1j * np.radians([deg for _, deg in there]))
    velocity = complex(weights @ toward) / float(weights.sum())
    energy = complex(np.square(weights) @ toward) / float(np.square(weights).sum())
    if abs(velocity) < _NOWHERE:
        return None
    azimuth = round(math.degrees(math.atan2(velocity.imag, velocity.real)), 1)
    return (180.0 if azimuth == -180.0 else azimuth + 0.0), round(min(1.0, abs(energy)), 3)


def _weights(
    was: NDArray[np.float64], now: NDArray[np.float64], rising: NDArray[np.bool_], share: float
) -> NDArray[np.float64]:
    """Return how strongly each channel plays what is new, shape (channels,); zeros where nothing does, or where they
    play it against each other.

    Two channels that have nothing in common seem to share `share` of their energies.
    """
    if not rising.any():
        return np.zeros(rising.size)
    scale = float(now.diagonal()[rising].sum())
    new = (now - was) / scale
    core = new[np.ix_(rising, rising)]
    if core.sum() < _AGAINST * core.trace():
        return np.zeros(rising.size)
    squares = np.square(new[:, rising] @ core).sum(axis=1)
    chance = np.where(rising, 0.0, now.diagonal() / scale * share * float(np.square(core).sum()))
    return np.asarray(np.sqrt(np.maximum(squares - chance, 0.0)), np.float64)


def _covariance(steep: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(steep.T @ steep / max(1, steep.shape[0]), np.float64)


def _with(shot: Shot, azimuth_deg: float, focus: float) -> Shot:
    return msgspec.structs.replace(shot, azimuth_deg=azimuth_deg, azimuth_focus=focus)
