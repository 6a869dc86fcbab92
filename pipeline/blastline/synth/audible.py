"""What of a shot is heard in a scene, decided from the parts that it was made of, never from what a detector finds.

    echo   heard where, in its first 3 ms and in some octave, it is as strong as everything else there together: bed,
           tail, decaying blast, other echoes, other sounds. The level then doubles.
    blast  heard until what comes straight from the weapon has fallen by 20 dB or everything else is stronger, or until
           the first reflection that is heard.

Three milliseconds is about what hearing resolves in time (the shortest gap heard in noise, Plomp 1964), and a sound
masks another in its own band (Fletcher 1940). Echoes that start within two milliseconds of a stronger one are heard as
one with it, those within four milliseconds of the onset as one with the blast. Dynamics weigh all parts of a sum alike,
so parts are compared as the linear links of the recording chain leave them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..units import samples_from_ms
from .colour import Colour, filtered
from .echoes import HeardEcho
from .tone import Samples

HEARD_S, LEAD_S = 0.51, 0.02
"""So long after its onset a shot's echoes are judged, and so long before it the filters begin to settle."""

MARGIN_DB = 0.0
FUSED_MS, BLAST_FUSED_MS = 2.0, 4.0
BLAST_END = 0.1
"""The blast is over where it stays below this part of its peak: -20 dB."""

_FIRST_MS, _GRAIN_MS = 3.0, 1.0
_OCTAVES_HZ = (500.0, 1_000.0, 2_000.0, 4_000.0, 8_000.0)
_FAINTEST = 1e-6  # -60 dB: less is not worth a figure


@dataclass(frozen=True, eq=False)
class Parts:
    """What a shot was made of, before the recording chain: the whole, what came straight, its echoes.

    `whole` begins `lead` samples before the onset, `direct` at it.
    """

    whole: Samples
    lead: int
    direct: Samples
    echoes: tuple[HeardEcho, ...]
    colour: Colour


@dataclass(frozen=True)
class Audible:
    """How far each echo stands out, which of them are heard, and how many samples of the blast; late echoes are not."""

    margins_db: tuple[float, ...]
    heard: tuple[bool, ...]
    blast: int


@dataclass(frozen=True, eq=False)
class _Heads:
    """The first milliseconds of echoes as they are in the scene, a row each, and when they start after the onset."""

    waves: Samples
    delays: tuple[int, ...]

    def together(self, rows: NDArray[np.intp], start: int, stop: int) -> Samples:
        """Return the sum of some of them between two samples."""
        total = np.zeros(stop - start)
        for row in rows:
            _add(total, self.delays[row] - start, self.waves[row])
        return total


def audible(parts: Parts, alone: Samples, everything: Samples, *, lead: int, rate_hz: int, rounding: float) -> Audible:
    """Return what is heard of a shot whose onset is sample `lead` of `everything`, the scene around it.

    `alone` is the shot as the scene has it, over the same samples; `rounding` the rms of the file's rounding.
    """
    first = samples_from_ms(_FIRST_MS, rate_hz)
    whole = np.zeros(everything.size)
    _add(whole, lead - parts.lead, filtered(parts.whole, parts.colour, rate_hz=rate_hz))
    gains = _gains(alone, whole, first)[lead:]
    after = everything[lead:]
    heads = _heads(parts, gains, rate_hz)
    leaders = _leaders(heads, first, samples_from_ms(FUSED_MS, rate_hz))
    margins = _margins_db(heads, leaders, everything, lead=lead, rate_hz=rate_hz, rounding=rounding)
    heard = [leader == row and margins[row] >= MARGIN_DB for row, leader in enumerate(leaders)]
    near = samples_from_ms(BLAST_FUSED_MS, rate_hz)
    direct = heads.together(np.flatnonzero(np.array(heads.delays) < near), 0, after.size)
    straight = filtered(parts.direct, parts.colour, rate_hz=rate_hz)[: after.size]
    direct[: straight.size] += straight * gains[: straight.size]
    ends = [delay for delay, yes in zip(heads.delays, heard, strict=True) if yes and delay >= near]
    ends.append(_blast_length(direct, after - direct, samples_from_ms(_GRAIN_MS, rate_hz), rounding=rounding))
    return Audible(tuple(margins), tuple(heard), max(1, min(ends)))


def _heads(parts: Parts, gains: Samples, rate_hz: int) -> _Heads:
    """Return the echoes that start while the scene is listened to."""
    echoes = [echo for echo in parts.echoes if echo.delay < gains.size]
    waves = np.zeros((len(echoes), max((echo.head.size for echo in echoes), default=1)))
    for row, echo in zip(waves, echoes, strict=True):
        row[: echo.head.size] = echo.head * gains[echo.delay]
    return _Heads(filtered(waves, parts.colour, rate_hz=rate_hz), tuple(echo.delay for echo in echoes))


def _gains(alone: Samples, whole: Samples, first: int) -> Samples:
    """Return what the dynamics and the mix made of a part that starts at each sample: over its first milliseconds."""
    product, square = _running(alone * whole, first), _running(whole * whole, first)
    return np.asarray(np.divide(product, square, out=np.zeros_like(product), where=square > 1e-12 * square.max()))


def _leaders(heads: _Heads, first: int, fused: int) -> list[int]:
    """Return for each echo the one that it is heard as: itself, or a stronger one that starts almost with it."""
    leaders = [-1] * len(heads.delays)
    delays = np.array(heads.delays)
    for row in np.argsort(-np.sum(heads.waves[:, :first] ** 2, axis=1), kind="stable").tolist():
        if leaders[row] < 0:
            for member in np.flatnonzero(np.abs(delays - delays[row]) <= fused).tolist():
                leaders[member] = row if leaders[member] < 0 else leaders[member]
    return leaders


def _margins_db(
    heads: _Heads, leaders: list[int], everything: Samples, *, lead: int, rate_hz: int, rounding: float
) -> list[float]:
    """Return how much stronger each echo, with what is heard as one with it, is than the rest in its best octave."""
    from scipy.signal import butter, sosfilt

    first = samples_from_ms(_FIRST_MS, rate_hz)
    best = np.full(len(leaders), _FAINTEST)
    chosen = np.array(leaders, np.intp)
    for centre_hz in (each for each in _OCTAVES_HZ if each < 0.3 * rate_hz):
        edges = centre_hz / np.sqrt(2.0), centre_hz * np.sqrt(2.0)
        sections = butter(2, edges, "bandpass", fs=rate_hz, output="sos")
        band = sosfilt(sections, everything)[lead:]
        ours = _Heads(sosfilt(sections, heads.waves), heads.delays)
        floor = first * rounding**2 * (edges[1] - edges[0]) / (0.5 * rate_hz)
        for row, (delay, leader) in enumerate(zip(heads.delays, leaders, strict=True)):
            stop = min(delay + first, band.size)
            members = np.flatnonzero(chosen == row) if leader == row else np.array([row])
            own = ours.together(members, delay, stop)
            rest = band[delay:stop] - own
            best[row] = max(best[row], float(own @ own) / max(float(rest @ rest) + floor, 1e-30))
    return [float(10.0 * np.log10(each)) for each in best]


def _blast_length(direct: Samples, rest: Samples, grain: int, *, rounding: float) -> int:
    """Return when the direct sound has fallen by 20 dB for good or, from its peak on, is weaker than the rest."""
    size = np.abs(direct)
    if not size.any():
        return 1
    end = int(np.flatnonzero(size >= BLAST_END * size.max())[-1]) + 1
    drowned = _running(direct**2, grain) < _running(rest**2, grain) + grain * rounding**2
    drowned[: int(size.argmax())] = False
    runs = _running(drowned.astype(np.float64), grain) >= grain - 0.5
    return min(end, int(runs.argmax())) if runs.any() else end


def _running(values: Samples, width: int) -> Samples:
    """Return the sum of each value and the `width - 1` after it."""
    sums = np.concatenate([[0.0], np.cumsum(values), np.zeros(width - 1)])
    sums[values.size + 1 :] = sums[values.size]
    return np.asarray(sums[width:] - sums[:-width], np.float64)


def _add(total: Samples, at: int, part: Samples) -> None:
    """Add a part to a sum at a sample, which may lie before its start; what lies outside is left out."""
    start, stop = max(at, 0), min(at + part.size, total.size)
    if start < stop:
        total[start:stop] += part[start - at : stop - at]
