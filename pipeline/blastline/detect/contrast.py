"""A candidate's spectrograms against what was heard just before it: a shot under a voice should look like a shot.

    level   as in the spectrogram: against the attack of all that sounds
    rise    over the mean power of the same band before the onset
    rest    what is left when that power is taken off, against the attack of what is left
    decay   the same, against the same band's loudest moment in the attack: whatever the sound's colour

Spectral subtraction (Boll 1979): what went on before the onset is taken to go on after it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .spectrogram import ATTACK, HIGHEST_DB, LOWEST_DB, NEAR, WIDE, SpectrogramLayout, Spectrograms

CONTRASTS = 4
SCALE_DB = 15.0
"""Levels and decays enter the networks as dB / 15 + 1, rises as dB / 15: within about one around zero."""

RISE_DB, DECAY_DB = (-10.0, 45.0), (-45.0, 15.0)
_WIDE_ATTACK = slice(11, 15)  # the wide frames that hear the attack
_LEAST_REST = np.float32(0.03)  # of a power: where it is no louder than before, that much of it counts as new
_LOG_PER_DB = np.float32(np.log(10.0) / 10.0)


@dataclass(frozen=True, eq=False)
class Contrasts:
    """Spectrograms of n candidates as networks take them: `near` (n, frames, bands, CONTRASTS) and `wide`, float32."""

    near: NDArray[np.float32]
    wide: NDArray[np.float32]

    def taken(self, which: NDArray[np.intp]) -> "Contrasts":
        """Return those of some of the candidates."""
        return Contrasts(self.near[which], self.wide[which])


def contrasts(shown: Spectrograms) -> Contrasts:
    """Return the spectrograms of n candidates against what was before them."""
    (near_rise, near_rest), (wide_rise, wide_rest) = _new(shown.near, NEAR), _new(shown.wide, WIDE)
    attack = near_rest[:, ATTACK].mean(axis=2).max(axis=1, initial=-np.inf)[:, None, None]
    near_decay, wide_decay = _decay(near_rest, ATTACK), _decay(wide_rest, _WIDE_ATTACK)
    return Contrasts(
        _scaled(shown.near, near_rise, near_rest - attack, near_decay),
        _scaled(shown.wide, wide_rise, wide_rest - attack, wide_decay),
    )


def _new(levels: NDArray[np.float32], layout: SpectrogramLayout) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return how far each level is over what was before the onset, and what is left without that, in dB."""
    power = np.exp(levels * _LOG_PER_DB)
    before = power[:, : layout.before].mean(axis=1, keepdims=True)
    rest = np.maximum(power - before, _LEAST_REST * power)
    return levels - np.log(before) / _LOG_PER_DB, np.log(rest, out=rest) / _LOG_PER_DB


def _decay(rest: NDArray[np.float32], attack: slice) -> NDArray[np.float32]:
    """Return the rest against the loudest that each band has in the frames of the attack, in dB."""
    return np.asarray(rest - rest[:, attack].max(axis=1, keepdims=True, initial=-np.inf), np.float32)


def _scaled(
    level: NDArray[np.float32], rise: NDArray[np.float32], rest: NDArray[np.float32], decay: NDArray[np.float32]
) -> NDArray[np.float32]:
    scaled = np.empty((*level.shape, CONTRASTS), np.float32)
    scaled[..., 0] = level / SCALE_DB + 1.0
    scaled[..., 1] = np.clip(rise, *RISE_DB) / SCALE_DB
    scaled[..., 2] = np.clip(rest, LOWEST_DB, HIGHEST_DB) / SCALE_DB + 1.0
    scaled[..., 3] = np.clip(decay, *DECAY_DB) / SCALE_DB + 1.0
    return scaled
