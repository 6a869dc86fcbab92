r"""A shot's parts: the blast, its discrete reflections, and where the decay is over.

    |\                       blast: onset to the end of the direct sound
    | \  /\    .-.           reflections: copies of the blast, later, weaker
    |  \/  \__/   \__        decay: down to `decay_db` below its start, to the background, or to the next sound

The blast is over where its envelope has fallen by `blast_decay_db`, where it is no louder than what was there before
it, or where its first reflection begins. Reflections are lags at which the sound after the blast answers to it; they
have to stand out of their own neighbourhood: a tail full of overlapping echoes holds no discrete one.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import DecayEnd, Reflection, Shot, ShotEvidence, Span
from ..ruleset import LONGEST_DECAY_MS, SegmentRules
from ..units import db_from_gain, gain_from_db, ms_from_samples, samples_from_ms
from .echoes import counting_echoes

BACKGROUND_MS = 200.0
PEAK_MS = 20.0
_CELL_MS, _CELLS_PER_GRAIN = 0.5, 50
_SMOOTH_MS = _CELL_MS * _CELLS_PER_GRAIN  # a period of the lowest boom that a film puts under a shot
_RISE_AGAIN = 2.0  # the decay is over where the level, once 12 dB down, doubles: something else has begun
_DECAYED = 0.25
_SLOW_MS = 100.0  # a seat moves from 5 Hz to 1 kHz: the mean over so long is slower than that, a cell's as fast
_OVER_BACKGROUND = 1.4  # 3 dB: at less, the sound itself is softer than the background
# A Friedlander blast stays below a tenth of its peak for two thirds of its positive phase where it crosses zero: a peak
# held a little longer does not take the crossing for the end.
_HOLD_PER_PHASE = 0.8
_HOLD_MS = (0.1, 2.0)
_DROWNED = 2.0
_RINGING_MS = 8.0  # before an attack, of a resampler or a lossy codec, is the attack's
_GRAIN_MS, _USUAL_MS = 1.0, 5.0
_ECHO_MS = 3.0  # how loud an echo is, its beginning tells, as in a scene's truth


def segment(
    samples: NDArray[np.float32],
    onset: int,
    *,
    film_start: int,
    film_stop: int,
    confidence: float,
    rate_hz: int,
    rules: SegmentRules,
) -> Shot:
    """Return the shot whose blast starts at index `onset` of `samples`, a stretch that starts at `film_start`.

    `film_stop` is where the film, or what is known of it, ends. The shot's evidence is what is measured here; whoever
    judged it adds the rest.
    """
    stop = min(onset + reach(rate_hz=rate_hz, rules=rules), film_stop - film_start)
    wave, still = _heard(samples, onset, stop, rate_hz)
    quiet = still[: max(0, still.size - samples_from_ms(_RINGING_MS, rate_hz))]
    background = float(np.sqrt(quiet @ quiet / quiet.size)) if quiet.size else 0.0
    peak = float(np.abs(wave[: samples_from_ms(PEAK_MS, rate_hz)]).max(initial=0.0))
    usual = _usual_power(still, rate_hz)
    blast = _blast_length(wave, peak, usual, rate_hz=rate_hz, rules=rules)
    room_db, echoes = counting_echoes(wave, still, blast, rate_hz=rate_hz, rules=rules)
    blast = min([blast, *(lag for lag, _ in echoes[:1])])
    at = film_start + onset
    length, ended = _decay(still, wave, rate_hz=rate_hz, rules=rules)
    return Shot(
        onset=at,
        confidence=confidence,
        peak_dbfs=db_from_gain(peak),
        snr_db=db_from_gain(peak / max(background, 1e-12)),
        blast=Span(at, at + blast),
        reflections=tuple(
            Reflection(at + lag, at + lag + blast, ms_from_samples(lag, rate_hz), level_db) for lag, level_db in echoes
        ),
        span=Span(at, at + length),
        evidence=ShotEvidence(
            None, 0, room_db, ended, copies=len(echoes), drowned_db=_drowned_db(wave, usual, rate_hz=rate_hz)
        ),
    )


def peak_dbfs(samples: NDArray[np.float32], onset: int, rate_hz: int) -> float:
    """Return the `peak_dbfs` of the shot that starts at an index of `samples`, where nothing else is asked."""
    wave = samples[onset : onset + samples_from_ms(PEAK_MS, rate_hz)]
    constant = _constant(samples, onset, rate_hz)
    return db_from_gain(max(float(wave.max()) - constant, constant - float(wave.min())))


def reach(*, rate_hz: int, rules: SegmentRules) -> int:
    """Return how many samples from its onset on tell of a shot: of its decay, and of its latest reflection."""
    decay = samples_from_ms(rules.longest_ms, rate_hz) + samples_from_ms(2 * _SMOOTH_MS, rate_hz)
    if rules.reflection_level_db is None:
        return decay
    latest_ms = min(rules.latest_reflection_ms + rules.longest_blast_ms, LONGEST_DECAY_MS)
    return max(decay, samples_from_ms(latest_ms, rate_hz))


def _heard(
    samples: NDArray[np.float32], onset: int, stop: int, rate_hz: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the sound from an onset on and that just before it, without its mean: a constant is no sound."""
    constant = _constant(samples, onset, rate_hz)
    before = samples[max(0, onset - samples_from_ms(BACKGROUND_MS, rate_hz)) : onset]
    return samples[onset:stop].astype(np.float64) - constant, before.astype(np.float64) - constant


def _constant(samples: NDArray[np.float32], onset: int, rate_hz: int) -> float:
    """Return the mean of the sound just before an onset; its first sample where nothing is before it."""
    before = samples[max(0, onset - samples_from_ms(BACKGROUND_MS, rate_hz)) : onset]
    return float(np.mean(before, dtype=np.float64) if before.size else samples[onset])


def _blast_length(wave: NDArray[np.float64], peak: float, usual: float, *, rate_hz: int, rules: SegmentRules) -> int:
    """Return where the envelope has first fallen by `blast_decay_db` or into the usual power, in samples."""
    # no blast is shorter than a sample, though its rule may be
    longest = min(wave.shape[0], max(1, samples_from_ms(rules.longest_blast_ms, rate_hz)))
    if longest == 0:
        return 0
    grain = max(1, samples_from_ms(_GRAIN_MS, rate_hz))
    near = wave[: 2 * longest]
    top = int(np.argmax(np.abs(near[:longest])))
    turned = np.flatnonzero(near[top:] * near[top] < 0.0)
    phase = top + int(turned[0]) if turned.size else longest
    shortest_hold, longest_hold = (max(1, samples_from_ms(ms, rate_hz)) for ms in _HOLD_MS)
    hold = min(max(int(_HOLD_PER_PHASE * phase), shortest_hold), longest_hold)
    over = running_peak(np.abs(near), hold)[top:longest] < peak * gain_from_db(-rules.blast_decay_db)
    # both together are twice the power of either where the blast is as loud as the rest, for as long as it is measured
    power = np.convolve(np.concatenate([near**2, np.zeros(grain)]), np.full(grain, 1.0 / grain))[grain - 1 :]
    over |= running_peak(power, grain)[top:longest] < _DROWNED * usual
    found = np.flatnonzero(over)
    return max(1, top + int(found[0]) if found.size else longest)


def _usual_power(still: NDArray[np.float64], rate_hz: int) -> float:
    """Return the median power of the 5 ms stretches before the onset: an earlier shot among them hides no blast."""
    grain = max(1, samples_from_ms(_USUAL_MS, rate_hz))
    grains = np.square(still[still.shape[0] % grain :]).reshape(-1, grain)
    return float(np.median(grains.mean(axis=1))) if grains.size else 0.0


def _drowned_db(wave: NDArray[np.float64], usual: float, *, rate_hz: int) -> float:
    """Return at which level against the blast an echo is, in power, as the usual sound before the blast."""
    direct = wave[: samples_from_ms(_ECHO_MS, rate_hz)]
    power = float(np.mean(np.square(direct))) if direct.size else 0.0
    return db_from_gain(float(np.sqrt(usual / power))) if power > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class _Decay:
    """Of each 25 ms after an onset: whether it has fallen, is softer than the background, or has risen again."""

    fallen: NDArray[np.bool_]
    drowned: NDArray[np.bool_]
    risen: NDArray[np.bool_]

    @property
    def over(self) -> NDArray[np.bool_]:
        return self.fallen | self.drowned | self.risen

    @classmethod
    def of(cls, power: NDArray[np.float64], onset: int, decay_db: float) -> "_Decay":
        """Return how a sound decays from a cell on, by the power in each, until the end of a grain."""
        quiet, wave = power[: max(0, onset - round(_RINGING_MS / _CELL_MS))], power[onset:]
        level = np.sqrt(wave.reshape(-1, _CELLS_PER_GRAIN).mean(axis=1))
        background = float(np.sqrt(quiet.mean())) if quiet.size else 0.0
        start = float(level[:2].max(initial=0.0))
        lowest = np.minimum.accumulate(level)
        return cls(
            level < start * gain_from_db(-decay_db),
            level < _OVER_BACKGROUND * background,
            (lowest < _DECAYED * start) & (level > _RISE_AGAIN * lowest),
        )


def _decay(
    still: NDArray[np.float64], wave: NDArray[np.float64], *, rate_hz: int, rules: SegmentRules
) -> tuple[int, DecayEnd]:
    """Return when a shot's decay is over, both as it is heard and in what of it can be felt; and how it ended.

    Rain drowns the hiss of a tail long before its boom. What swings more slowly than a seat moves counts in neither.
    """
    from scipy.ndimage import uniform_filter1d

    shortest, longest = samples_from_ms(rules.shortest_ms, rate_hz), samples_from_ms(rules.longest_ms, rate_hz)
    cell = max(1, samples_from_ms(_CELL_MS, rate_hz))
    grain = cell * _CELLS_PER_GRAIN
    before, after = still[still.size % cell :], wave[: wave.size // grain * grain]
    cells = np.concatenate([before, after]).reshape(-1, cell)
    means, powers = cells @ np.full(cell, 1.0 / cell), np.einsum("ij,ij->i", cells, cells) / cell
    slow = uniform_filter1d(means, round(_SLOW_MS / _CELL_MS)) if means.size else means
    heard, felt = (
        _Decay.of(power, before.size // cell, rules.decay_db)
        for power in (np.maximum(0.0, powers - slow * (2.0 * means - slow)), np.square(means - slow))
    )
    over = heard.over & felt.over & (np.arange(heard.over.size) * grain >= shortest)
    found = np.flatnonzero(over[:-1] & over[1:]) if over.size > 1 else np.empty(0, np.intp)
    longest = min(longest, int(wave.shape[0]))
    if not found.size or int(found[0]) * grain >= longest:
        return max(1, longest), "longest"
    first = int(found[0])
    ended: DecayEnd = "fallen" if heard.fallen[first] else "background" if heard.drowned[first] else "next sound"
    return max(1, first * grain), ended


def running_peak(magnitude: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Return the largest of each sample and the `width - 1` after it."""
    from scipy.ndimage import maximum_filter1d

    ahead = maximum_filter1d(magnitude, width, mode="constant", cval=0.0, origin=-(width // 2))
    return np.asarray(ahead, np.float64)
