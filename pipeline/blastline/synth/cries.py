"""What throats do suddenly: shouts, barks, coughs, and dialogue that was recorded too loud."""

import numpy as np

from .chance import between, chance, fork, log_between
from .echoes import overlaid
from .speech import Speaker, draw_speaker, phrase, vowel
from .tone import Samples, bandpass
from .waves import noise_burst, normalised


def shout(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one loud syllable or two."""
    speaker = draw_speaker(rng)
    loud = Speaker(speaker.pitch_hz * 1.5, 0.2, speaker.tract, speaker.pace_s, 0.05, 1.0)
    first = vowel(fork(rng), rate_hz, loud, pitch_hz=loud.pitch_hz, length_s=between(rng, (0.1, 0.5)))
    if chance(rng, 0.5):
        second = vowel(fork(rng), rate_hz, loud, pitch_hz=0.9 * loud.pitch_hz, length_s=between(rng, (0.1, 0.6)))
        first = np.concatenate([first, second])
    return normalised(first)


def clipped_speech(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a phrase that overdrove its recorder: flattened at a tenth to a half of its peak."""
    words = normalised(phrase(fork(rng), rate_hz, draw_speaker(rng)))
    limit = log_between(rng, (0.08, 0.5))
    return normalised(np.clip(words, -limit, limit))


def bark(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return 1-4 barks: short vowels of a rough, high voice that fall in pitch, with breath."""
    dog = Speaker(log_between(rng, (180.0, 700.0)), 0.1, between(rng, (0.7, 1.3)), 0.1, between(rng, (0.2, 1.0)), 1.0)
    parts = []
    at = 0
    for _ in range(int(rng.integers(1, 5))):
        call = vowel(fork(rng), rate_hz, dog, pitch_hz=dog.pitch_hz, length_s=between(rng, (0.06, 0.2)))
        parts.append((at, call))
        at += len(call) + round(between(rng, (0.08, 0.5)) * rate_hz)
    return normalised(overlaid(parts))


def cough(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return 1-3 coughs: the burst of opening, breath through the throat, a voiced end."""
    parts = []
    at = 0
    for _ in range(int(rng.integers(1, 4))):
        breath = noise_burst(
            fork(rng), rate_hz, attack_ms=between(rng, (2.0, 12.0)), decay_ms=between(rng, (25.0, 80.0))
        )
        breath = normalised(bandpass(breath, log_between(rng, (300.0, 900.0)), 4_000.0, rate_hz=rate_hz))
        voice = draw_speaker(rng)
        end = normalised(vowel(fork(rng), rate_hz, voice, pitch_hz=voice.pitch_hz, length_s=0.12))
        parts += [(at, breath), (at + round(0.06 * rate_hz), end * between(rng, (0.05, 0.6)))]
        at += round(between(rng, (0.25, 0.5)) * rate_hz)
    return normalised(overlaid(parts))
