"""Gunshots: a voice is fired, each time a little differently.

direct = blast + gas jet + roar + second pulse       through the air
sound  = direct + echoes + tail + boom        from the onset on
       + shock of the bullet, mechanics       some of them earlier
heard  = sound through the recording chain
"""

import math
from dataclasses import dataclass

import numpy as np

from ..model import Span
from ..units import SILENCE_DB, db_from_gain, gain_from_db, ms_from_samples
from .audible import BLAST_END, HEARD_S, LEAD_S, Parts
from .chance import chance, fork, pick
from .colour import air, record
from .echoes import HEAD_S, HeardEcho, overlaid, with_acoustics
from .rooms import ENVIRONMENTS
from .tone import Samples, peak, trimmed
from .truth import ShotTruth, TrueReflection
from .voices import Mechanism, Voice, draw_voice, varied
from .waves import band_burst, boom, friedlander, n_wave
from .weapons import WEAPONS

PEAK_WITHIN_S = 0.05
FAINTEST_LISTED_DB = -30.0
"""Weaker reflections belong to the tail."""


@dataclass(frozen=True, eq=False)
class Fired:
    """A shot with a peak of 1 within 50 ms of its onset, its truth counted from its first sample, and its parts."""

    samples: Samples
    truth: ShotTruth
    parts: Parts


@dataclass(frozen=True, eq=False)
class _Direct:
    """What comes straight from the weapon, with a peak of 1, and where its blast ends, the roar left out.

    `pulse` is a second pulse that comes when the blast is over, if there is one, and `first` what comes without it.
    """

    samples: Samples
    first: Samples
    stop: int
    pulse: HeardEcho | None


def random_shot(rng: np.random.Generator, rate_hz: int) -> tuple[Samples, int, ShotTruth]:
    """Return a shot from the widest family: samples, index of the onset, truth counted from the first sample."""
    weapon = pick(rng, tuple(WEAPONS))
    environment = pick(rng, ENVIRONMENTS)
    voice = draw_voice(rng, weapon, environment=environment, clean=chance(rng, 0.1))
    samples, truth = fire(rng, rate_hz, voice)
    return samples, truth.onset_sample, truth


def fire(rng: np.random.Generator, rate_hz: int, voice: Voice) -> tuple[Samples, ShotTruth]:
    """Return one shot, with a peak of 1 within 50 ms of its onset, and its truth counted from its first sample."""
    fired = fire_apart(rng, rate_hz, voice)
    return fired.samples, fired.truth


def fire_apart(rng: np.random.Generator, rate_hz: int, voice: Voice) -> Fired:
    """Return the same shot with its parts."""
    this = varied(rng, voice)
    direct = _direct(fork(rng), rate_hz, this)
    sound, echoes = with_acoustics(fork(rng), direct.samples, this.acoustics, rate_hz=rate_hz)
    if direct.pulse is not None:
        echoes = tuple(sorted((*echoes, direct.pulse), key=lambda echo: echo.delay))
    echoes = tuple(echo for echo in echoes if db_from_gain(echo.gain) >= FAINTEST_LISTED_DB)
    others = _mechanics(fork(rng), rate_hz, this) + _sound_design(rate_hz, this)
    shock = _shock(rate_hz, this)
    lead = max([0, *(-at for at, _ in [*others, *shock])])
    whole = overlaid([(lead + at, part) for at, part in [(0, sound), *others, *shock]])
    heard = trimmed(record(whole, this.colour, rate_hz=rate_hz))
    heard = heard / peak(heard[lead : lead + math.ceil(PEAK_WITHIN_S * rate_hz)])
    accept = tuple(lead + at for at, _ in shock[:1])
    truth = _truth(this, direct.stop, echoes, lead=lead, accept=accept, rate_hz=rate_hz)
    first = max(0, lead - math.ceil(LEAD_S * rate_hz))
    near = whole[first : lead + math.ceil(HEARD_S * rate_hz)].copy()
    straight = direct.first[: math.ceil(HEARD_S * rate_hz)].copy()
    return Fired(heard, truth, Parts(near, lead - first, straight, echoes, this.colour))


def _direct(rng: np.random.Generator, rate_hz: int, voice: Voice) -> _Direct:
    """Return the direct sound after the air; it starts with the rise.

    The roar belongs to the sound but not to the blast, which is over long before it.
    """
    wave = friedlander(rate_hz, positive_ms=voice.positive_ms, rise_ms=voice.rise_ms, decay=voice.decay)
    # room for the ringing of the air's low-pass
    parts = [(0, wave), (0, np.zeros(len(wave) + round(0.005 * rate_hz)))]
    if voice.jet_db > SILENCE_DB:
        attack_ms = 0.1 + voice.rise_ms
        jet = band_burst(
            fork(rng), rate_hz, band_hz=voice.jet_band_hz, attack_ms=attack_ms, decay_ms=voice.jet_decay_ms
        )
        parts.append((0, jet * gain_from_db(voice.jet_db)))
    pulses = []
    if voice.second_pulse is not None:
        delay_ms, level_db = voice.second_pulse
        pulses.append((round(delay_ms * 1e-3 * rate_hz), wave * gain_from_db(level_db)))
    distance_m, muffle = voice.acoustics.distance_m, voice.muffle
    blast = air(overlaid(parts + pulses), distance_m, rate_hz=rate_hz, muffle=muffle)
    roar = air(overlaid(_roars(rng, rate_hz, voice)), distance_m, rate_hz=rate_hz, muffle=muffle)
    sound = overlaid([(0, blast), (0, roar)])
    top, pulse = peak(sound), None
    first = sound
    for delay, again in pulses:
        alone = air(overlaid(parts), distance_m, rate_hz=rate_hz, muffle=muffle)
        if _last_loud(alone) < delay:
            blast, first = alone, overlaid([(0, alone), (0, roar)])
            later = air(again, distance_m, rate_hz=rate_hz, muffle=muffle) / top
            pulse = HeardEcho(delay, peak(later), later[: math.ceil(HEAD_S * rate_hz)])
    return _Direct(np.asarray(sound / top, dtype=np.float64), first / top, _last_loud(blast) + 1, pulse)


def _last_loud(blast: Samples) -> int:
    return int(np.flatnonzero(np.abs(blast) >= BLAST_END * peak(blast))[-1])


def _roars(rng: np.random.Generator, rate_hz: int, voice: Voice) -> list[tuple[int, Samples]]:
    return [
        (
            0,
            band_burst(fork(rng), rate_hz, band_hz=roar.band_hz, attack_ms=roar.attack_ms, decay_ms=roar.decay_ms)
            * gain_from_db(roar.level_db),
        )
        for roar in voice.roars
    ]


def _mechanics(rng: np.random.Generator, rate_hz: int, voice: Voice) -> list[tuple[int, Samples]]:
    return [(round(part.at_s * rate_hz), _click(fork(rng), rate_hz, part)) for part in voice.mechanisms]


def _click(rng: np.random.Generator, rate_hz: int, part: Mechanism) -> Samples:
    band = (0.6 * part.centre_hz, 1.6 * part.centre_hz)
    burst = band_burst(rng, rate_hz, band_hz=band, attack_ms=0.05, decay_ms=part.decay_ms)
    return burst * gain_from_db(part.level_db)


def _sound_design(rate_hz: int, voice: Voice) -> list[tuple[int, Samples]]:
    if voice.boom is None:
        return []
    tone = boom(
        rate_hz,
        start_hz=voice.boom.start_hz,
        stop_hz=voice.boom.stop_hz,
        attack_ms=voice.boom.attack_ms,
        decay_ms=voice.boom.decay_ms,
    )
    return [(0, tone * gain_from_db(voice.boom.level_db))]


def _shock(rate_hz: int, voice: Voice) -> list[tuple[int, Samples]]:
    """Return the bullet's N-wave and its bounce off the ground, both earlier than the blast where it is far enough."""
    if voice.shock is None:
        return []
    wave = n_wave(rate_hz, length_ms=voice.shock.length_ms, rise_ms=voice.shock.rise_ms)
    wave = wave * gain_from_db(voice.shock.level_db)
    at = -round(voice.shock.lead_s * rate_hz)
    return [(at, wave), (at + round(0.0035 * rate_hz), 0.4 * wave)]


def _truth(
    voice: Voice, blast: int, echoes: tuple[HeardEcho, ...], *, lead: int, accept: tuple[int, ...], rate_hz: int
) -> ShotTruth:
    before = [lead + round(part.at_s * rate_hz) for part in voice.mechanisms if part.at_s < 0.0]
    return ShotTruth(
        onset_sample=lead,
        onset_s=lead / rate_hz,
        start_sample=min([lead, *accept, *before]),
        weapon=voice.weapon,
        environment=voice.environment,
        distance_m=voice.acoustics.distance_m,
        rise_ms=voice.rise_ms,
        snr_db=-SILENCE_DB,
        peak_dbfs=0.0,
        blast=Span(lead, lead + blast),
        reflections=tuple(
            TrueReflection(
                lead + echo.delay,
                lead + echo.delay + blast,
                ms_from_samples(echo.delay, rate_hz),
                db_from_gain(echo.gain),
            )
            for echo in echoes
        ),
        accept_samples=accept,
    )
