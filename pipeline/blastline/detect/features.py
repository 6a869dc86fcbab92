"""What the verifier knows of a candidate besides its spectrograms: its shape band by band, and its neighbourhood."""

import numpy as np
from numpy.typing import NDArray

from .bandshape import bandshape_names
from .neighbours import neighbourhood_names


def feature_names() -> tuple[str, ...]:
    """Return the names of the columns of `features`, in order."""
    return (*bandshape_names(), *neighbourhood_names())


def features(bandshapes: NDArray[np.float64], neighbourhoods: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the features of candidates, shape (n, features), of their rows of `bandshape` and `neighbourhood`."""
    return np.concatenate([bandshapes, neighbourhoods], axis=1)
