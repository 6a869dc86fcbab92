"""The drive's amplitude and frequency over time, never averaged across an attack.

    amplitude(t) = min(1, sqrt(2 mean(drive^2 over [s, min(s + average, next attack)))))
    s = max(last attack before t or at it, t - average)

is what a sine needs to have the drive's power. An average that only looks back reports every attack late, and one that
looks across it early. This one has all of an attack in the point at its start, keeps it for the length of the average,
so that no power is lost, and rises on the line that leads up to it from a point a millisecond before:

            .------.
           /        `-.
    ------'            `----
"""

import math

import numpy as np
from numpy.typing import NDArray

from ...ruleset import HapticRules
from .curve import Curve
from .track import ms_gap

Samples = NDArray[np.float64]

_FRAMES = 512
"""Spectra that are made at once, so that a long fight takes no more memory than a shot."""


def grid(attacks: list[int], stop: int, *, step: int, gap: int) -> NDArray[np.int64]:
    """Return the points to read up to `stop`, ascending: each attack, every step after it, `gap` before the next."""
    points: list[NDArray[np.int64]] = []
    for start, end in zip(attacks, [*attacks[1:], stop], strict=True):
        steps = np.arange(start, max(start + 1, end - gap - step + 1), step, dtype=np.int64)
        foot = [end - gap] if end < stop and end - gap > steps[-1] else []
        points.append(np.concatenate([steps, np.array(foot, np.int64)]))
    return np.concatenate(points)


def amplitudes(drive: Samples, points: NDArray[np.int64], attacks: list[int], *, average: int) -> Samples:
    """Return the amplitude at each point, shape (points,), as in the formula above; all are indices into `drive`."""
    energy = np.concatenate([[0.0], np.cumsum(drive * drive)])
    walls = np.array(attacks)
    starts = np.maximum(walls[np.searchsorted(walls, points, side="right") - 1], points - average)
    ends = np.minimum(starts + average, _ends(points, attacks, len(drive)))
    mean = (energy[ends] - energy[starts]) / np.maximum(ends - starts, 1)
    return np.asarray(np.minimum(np.sqrt(2.0 * np.maximum(mean, 0.0)), 1.0), dtype=np.float64)


def frequencies(
    drive: Samples,
    points: NDArray[np.int64],
    attacks: list[int],
    *,
    rate_hz: int,
    rules: HapticRules,
    band: tuple[float, float],
) -> Samples:
    """Return the power-weighted mean frequency in Hz at each point, (points,), within the band; silence keeps the last.

    What happens at the point itself counts most: the window falls like the second half of a Hann window.
    """
    size = max(2, math.ceil(rules.spectrum_ms * rate_hz / 1000.0))
    window = np.cos(np.linspace(0.0, math.pi / 2.0, size, endpoint=False)) ** 2
    bins_hz = np.fft.rfftfreq(2 * size, 1.0 / rate_hz)
    chosen = (bins_hz >= band[0]) & (bins_hz <= band[1])
    ends = _ends(points, attacks, len(drive))
    total, moment = np.empty(len(points)), np.empty(len(points))
    for first in range(0, len(points), _FRAMES):
        some = slice(first, first + _FRAMES)
        places = points[some, None] + np.arange(size)
        inside = places < ends[some, None]
        frames = np.where(inside, drive[np.minimum(places, len(drive) - 1)], 0.0) * window
        power = np.abs(np.fft.rfft(frames, 2 * size)[:, chosen]) ** 2
        total[some], moment[some] = power.sum(axis=1), power @ bins_hz[chosen]
    heard = total > 0.0
    mean = np.clip(moment / np.where(heard, total, 1.0), *band)
    return _kept(mean, heard, otherwise=math.sqrt(band[0] * band[1]))


def amplitude_curve(drive: Samples, attacks: list[int], *, origin: int, rate_hz: int, rules: HapticRules) -> Curve:
    """Return the amplitude of a segment that begins at frame `origin`, from 0 to 0; `attacks` are indices into it.

    Where an attack falls on its first sample the line up to it begins before the segment, unless the film does not.
    """
    gap = ms_gap(rate_hz)
    step = max(gap, math.ceil(rules.step_ms * rate_hz / 1000.0))
    starts = sorted({0, *attacks})
    points = grid(starts, len(drive), step=step, gap=gap)
    values = amplitudes(drive, points, starts, average=math.ceil(rules.average_ms * rate_hz / 1000.0))
    if 0 not in attacks:
        values[0] = 0.0
    elif origin > 0:
        points, values = np.concatenate([[-min(gap, origin)], points]), np.concatenate([[0.0], values])
    end = max(len(drive), int(points[-1]) + gap)
    return Curve(origin + np.concatenate([points, [end]]), np.concatenate([values, [0.0]]))


def frequency_curve(
    drive: Samples,
    attacks: list[int],
    amplitude: Curve,
    *,
    origin: int,
    rate_hz: int,
    rules: HapticRules,
    band: tuple[float, float],
) -> Curve:
    """Return the frequency in Hz over the same range as the amplitude."""
    gap = ms_gap(rate_hz)
    step = max(gap, math.ceil(rules.spectrum_step_ms * rate_hz / 1000.0))
    starts = sorted({0, *attacks})
    points = grid(starts, len(drive), step=step, gap=gap)
    values = frequencies(drive, points, starts, rate_hz=rate_hz, rules=rules, band=band)
    whole = Curve(origin + points, values)
    return whole.part(int(amplitude.samples[0]), int(amplitude.samples[-1]))


def _ends(points: NDArray[np.int64], attacks: list[int], stop: int) -> NDArray[np.int64]:
    """Return for each point the attack after it, or `stop`."""
    walls = np.array([*attacks, stop], np.int64)
    return walls[np.minimum(np.searchsorted(walls, points, side="right"), len(walls) - 1)]


def _kept(values: Samples, known: NDArray[np.bool_], *, otherwise: float) -> Samples:
    """Return the values with each unknown one replaced by the last known before it, or the first known after."""
    if not known.any():
        return np.full(len(values), otherwise)
    last = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return values[np.where(last < 0, int(np.argmax(known)), last)]
