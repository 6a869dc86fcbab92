"""The drive of a shot against the best there is, found by a method that shares nothing with the solver.

    scipy.optimize.lsq_linear on dense matrices, at a reduced rate: drives that run in straight lines between corners

It is slow, a few seconds for a tenth of a second of sound, so it is for a few shots only.
"""

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..render import DriveFilters
from ..render.constrained import between_corners, corner_rhs
from ..render.descent import Convolution
from ..render.interior import solve_box_qp
from ..ruleset import RenderRules

Samples = NDArray[np.float64]


class Optimum(msgspec.Struct, frozen=True):
    """What of |H u - t|^2 the solver leaves and what scipy leaves, as shares of |t|^2.

    `excess` is by which share the solver leaves more. `corners` are the unknowns, 1 / `rate_hz` apart.
    """

    scene: str
    onset_s: float
    corners: int
    rate_hz: float
    steps: int
    solver: float
    reference: float
    excess: float


def against_optimum(
    target: Samples,
    warm: Samples,
    *,
    scene: str,
    onset_s: float,
    filters: DriveFilters,
    rules: RenderRules,
    stride: int,
) -> Optimum:
    """Return the solver's residual and scipy's for a stretch of sound in the band.

    Drives are straight from corner to corner. The solver runs to the tier's tolerance, as in a rendering; both are
    judged on the dense problem.
    """
    from scipy.optimize import lsq_linear
    from scipy.signal import fftconvolve

    frames, memory = len(target), len(filters.impulse) - 1
    count = len(corner_rhs(target, stride))
    lines = np.stack([between_corners(unit, stride, frames) for unit in np.eye(count)], axis=1)
    matrix = fftconvolve(lines, filters.impulse[:, None], axes=0)
    wanted = np.concatenate([target, np.zeros(memory)])
    slow = lsq_linear(matrix, wanted, bounds=(-1.0, 1.0), tol=1e-12, lsq_solver="exact")
    problem = Convolution.of(filters.impulse, frames).problem(target)
    found = solve_box_qp(
        filters.recursion,
        corner_rhs(problem.rhs, stride),
        np.clip(warm, -1.0, 1.0)[stride - 1 :: stride][:count],
        stride=stride,
        iterations=rules.iterations,
        tolerance=rules.tolerance,
    )
    energy = float(np.sum(wanted**2))
    solver = float(np.sum((matrix @ found.drive - wanted) ** 2)) / energy
    reference = 2.0 * float(slow.cost) / energy
    return Optimum(
        scene, onset_s, count, filters.rate_hz / stride, found.steps, solver, reference, solver / reference - 1.0
    )
