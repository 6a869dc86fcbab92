"""Which places in time have others near them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def have_near(
    places: Sequence[int] | NDArray[np.intp], others: Sequence[int] | NDArray[np.intp], reach: int
) -> NDArray[np.bool_]:
    """Return which of n places have one of the others within reach, shape (n,); both in any order.

    >>> have_near([100, 10], [13], reach=3).tolist()
    [False, True]
    """
    at, ascending = np.array(places, np.intp), np.sort(np.array(others, np.intp))
    return np.asarray(
        np.searchsorted(ascending, at + reach, side="right") > np.searchsorted(ascending, at - reach, side="left")
    )
