"""Where a segment of the old film may lie in the new one: normalised correlation of fingerprints, over a whole film.

    c(u) = sum z_old(t + k) . z_new(u + k) / sqrt( sum |z_old(t + k)|^2 * sum |z_new(u + k)|^2 )

for every frame u at once: the new film lies ready as the spectra of overlapping blocks, as in overlap-save convolution.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .fingerprint import FRAME_HZ, Fingerprint

_BLOCK = 4096

MIN_ENERGY_SHARE = 0.2
"""What a place has to have of a segment's energy: against silence, chance alone correlates."""


@dataclass(frozen=True)
class Hit:
    """A segment of the old film, centred on `old_s`, found in the new one, centred on `new_s`."""

    old_s: float
    new_s: float
    scale: float
    score: float


class Haystack:
    """The new film, ready to be searched for segments of up to `longest_s`."""

    def __init__(self, new: Fingerprint, longest_s: float) -> None:
        """Transform the film's blocks, each of which overlaps the next by the longest segment."""
        from scipy import fft

        self._new = new
        self._longest = round(longest_s * FRAME_HZ)
        self._hop = _BLOCK - self._longest
        count = -(-len(new) // self._hop)
        padded = np.zeros((count * self._hop + self._longest, new.frames.shape[1]), np.float32)
        padded[: len(new)] = new.frames
        blocks = np.stack([padded[n * self._hop : n * self._hop + _BLOCK] for n in range(count)])
        self._spectra = fft.rfft(blocks, axis=1).transpose(1, 2, 0).copy()  # (frequencies, bands, blocks)
        self._energy = np.concatenate([[0.0], np.cumsum(np.einsum("ij,ij->i", padded, padded), dtype=np.float64)])

    def best(self, pattern: NDArray[np.float32], count: int) -> Iterator[tuple[int, float]]:
        """Yield the places (first frame, correlation) where a pattern fits best, each a second from the others."""
        correlation = self.correlation(pattern)
        for _ in range(count):
            at = int(np.argmax(correlation))
            if correlation[at] <= 0.0:
                return
            yield at, float(correlation[at])
            correlation[max(0, at - FRAME_HZ) : at + FRAME_HZ + 1] = 0.0

    def correlation(self, pattern: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the correlation at every frame at which the pattern may start."""
        from scipy import fft

        spectrum = np.conj(fft.rfft(pattern, _BLOCK, axis=0))
        products = np.matmul(spectrum[:, None, :], self._spectra)[:, 0, :]
        found = fft.irfft(products, _BLOCK, axis=0)[: self._hop].T.reshape(-1)
        here = self._energy[len(pattern) :] - self._energy[: -len(pattern)]
        own = float(np.sum(pattern.astype(np.float64) ** 2))
        found, here = found[: here.shape[0]], here[: found.shape[0]]
        enough = here > MIN_ENERGY_SHARE * own
        return np.where(enough, found / np.sqrt(np.where(enough, here * own, 1.0)), 0.0).astype(np.float32)
