"""What the verifier knows of a candidate: its shape band by band, its waveform, and its neighbourhood."""

import numpy as np
from numpy.typing import NDArray

from .bandshape import bandshape, bandshape_names
from .neighbours import neighbourhood_names
from .waveshape import waveshape, waveshape_names


def feature_names() -> tuple[str, ...]:
    """Return the names of the columns of `features`, in order."""
    return (*bandshape_names(), *waveshape_names(), *neighbourhood_names())


def features(
    samples: NDArray[np.float32],
    levels: NDArray[np.float64],
    onsets: NDArray[np.intp],
    standing: NDArray[np.float64],
    rate_hz: int,
) -> NDArray[np.float64]:
    """Return the features of candidates, shape (n, features).

    `onsets` are indices into `samples`, `levels` their band levels, `standing` their rows of `neighbourhood`.
    """
    return np.concatenate([bandshape(levels), waveshape(samples, onsets, rate_hz), standing], axis=1)
