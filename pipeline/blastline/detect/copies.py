"""Whether a shot copies an earlier one: an echo, or the same sound again, has the waveform of what it repeats.

    attack     the first 16 ms of a shot and 1 ms at either side, 0.4 to 10 kHz
    likeness   the largest normalised cross-correlation of two attacks, the later one up to 1 ms early or late

Where a place is quiet a clear echo is .8 and more like its shot, different shots of one gun .3 to .6. `reflections`
finds echoes too faint to be candidates; this asks only of two shots that were found, so it costs next to nothing, and
tells of echoes that come later than reflections are looked for.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..units import samples_from_ms

_TEMPLATE_MS, _SHIFT_MS, _SETTLING_MS = 16.0, 1.0, 4.0
_BAND_HZ = (400.0, 10_000.0)
_LOUDEST, _STILL = 32_767, 1e-9


def attack(samples: NDArray[np.float32], onset: int, rate_hz: int) -> bytes:
    """Return the attack of the shot at an index of `samples`, 16-bit, scaled to its peak; none at the samples' ends."""
    before, after, settling = (
        samples_from_ms(ms, rate_hz) for ms in (_SHIFT_MS, _TEMPLATE_MS + _SHIFT_MS, _SETTLING_MS)
    )
    start, stop = onset - before, onset + after
    if start < 0 or stop > samples.shape[0]:
        return b""
    first = max(0, start - settling)
    heard = _band_passed(samples[first : stop + settling], rate_hz)[start - first : stop - first]
    peak = float(np.abs(heard).max())
    return np.round(heard * (_LOUDEST / peak)).astype(np.int16).tobytes() if peak > _STILL else b""


def likeness(later: bytes, earlier: list[bytes]) -> NDArray[np.float64]:
    """Return how like an attack is to each of n earlier ones, 0 to 1, shape (n,); 0 to one that is not known."""
    like = np.zeros(len(earlier))
    known = [place for place, each in enumerate(earlier) if later and len(each) == len(later)]
    if not known:
        return like
    heard = np.frombuffer(later, np.int16).astype(np.float32) / _LOUDEST
    shift = round(heard.shape[0] * _SHIFT_MS / (_TEMPLATE_MS + 2.0 * _SHIFT_MS))
    templates = np.array([np.frombuffer(earlier[place], np.int16)[shift:-shift] for place in known], np.float32)
    # one that lasts less than its margin may be still within it; any other has a square of 1 at least
    templates /= np.sqrt(np.maximum(np.square(templates).sum(axis=1, keepdims=True), 1.0))
    windows = np.lib.stride_tricks.sliding_window_view(heard, templates.shape[1])
    energies = np.square(windows).sum(axis=1, keepdims=True)
    like[known] = np.abs(windows @ templates.T / np.sqrt(np.maximum(energies, 1e-12))).max(axis=0)
    return like


def _band_passed(samples: NDArray[np.float32], rate_hz: int) -> NDArray[np.float32]:
    """Return the samples within the band, without delay: by a Butterworth filter of order 2, to and fro."""
    from scipy.fft import irfft, rfft  # not scipy.signal, whose import takes more than all attacks of a film

    around = samples - samples.mean()
    return np.asarray(irfft(rfft(around) * _response(around.shape[0], rate_hz), around.shape[0]), np.float32)


@cache
def _response(count: int, rate_hz: int) -> NDArray[np.float32]:
    """Return the gain at each frequency of a transform of so many samples."""
    low_hz, high_hz = _BAND_HZ
    hz = np.maximum(np.fft.rfftfreq(count, 1.0 / rate_hz), 1e-3)
    return np.asarray(1.0 / ((1.0 + (low_hz / hz) ** 4) * (1.0 + (hz / high_hz) ** 4)), np.float32)
