"""What the verifier knows of a candidate besides its spectrograms: its shape band by band, and its neighbourhood."""

import numpy as np
from numpy.typing import NDArray

from .bandshape import bandshape_names
from .neighbours import as_in_a_burst, neighbourhood_names


def feature_names() -> tuple[str, ...]:
    """Return the names of the columns of `features`, in order."""
    return (*bandshape_names(), *neighbourhood_names())


def features(bandshapes: NDArray[np.float64], neighbourhoods: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the features of candidates, shape (n, features), of their rows of `bandshape` and `neighbourhood`."""
    return np.concatenate([bandshapes, neighbourhoods], axis=1)


def features_as_in_a_burst(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return features, shape (n, features), as if what is alike around each candidate were no more than a burst."""
    shapes, neighbourhoods = np.split(rows, [len(bandshape_names())], axis=1)
    return features(shapes, as_in_a_burst(neighbourhoods))
