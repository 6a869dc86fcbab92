"""The drive within the actuator's limit that is felt most like the sound: box-constrained least squares.

    minimise  1/2 |H u - t|^2   over  |u| <= 1

H is the felt response as a convolution that may ring out after the window, t the sound in the band. Solved coarse to
fine: first for the corners of a drive that runs in straight lines between them (every `q` samples, so that the limit
at the corners is the limit everywhere and nothing shifts in time), then at the full rate from there. Each is FISTA
(Beck and Teboulle 2009) with restart (O'Donoghue and Candes 2015), and each iteration is one FFT there and back:
with N = H'H and b = H't, the gradient is N u - b and the objective falls out of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..ruleset import RenderRules

Samples = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BoxProblem:
    """1/2 u'Nu - b'u over |u| <= 1, N a symmetric Toeplitz matrix by its spectrum on a zero-padded circle."""

    spectrum: Samples
    padded: int
    rhs: Samples

    def normal(self, u: Samples) -> Samples:
        """Return N u."""
        from scipy.fft import irfft, rfft

        product: Samples = irfft(self.spectrum * rfft(u, self.padded), self.padded)
        return product[: len(u)]

    def objective(self, u: Samples) -> float:
        """Return 1/2 u'Nu - b'u."""
        return _objective(u, self.normal(u), self.rhs)


def constrained_drive(
    target: Samples, *, starts: Sequence[int], impulse: Samples, rate_hz: int, warm: Samples, rules: RenderRules
) -> Samples:
    """Return the drive u, |u| <= 1, whose felt vibration is nearest to the target; shape (frames,) as the target.

    `warm` is a first guess of it, the compensator's drive. `starts`, in order, are where the drive of each shot may
    begin: it is 0 before the first, and solved from start to start. Each piece follows on from what the drive before
    it still rings, and may ring on as its first guess would; but no piece knows the next. Solved as one, the actuator
    would wind up for a shot up to 10 ms before it is heard, and spoil the end of the shot before.
    """
    drive = np.zeros(len(target))
    warm = np.clip(warm, -1.0, 1.0)
    for start, stop in pairwise([*starts, len(target)]):
        if start < stop:
            wanted = np.concatenate([target[start:stop], _ringing(warm[start:stop], impulse)])
            rings = _ringing(drive[starts[0] : start], impulse)[: len(wanted)]
            wanted[: len(rings)] -= rings
            drive[start:stop] = _coarse_to_fine(wanted, warm[start:stop], impulse, rate_hz=rate_hz, rules=rules)
    return drive


def _ringing(drive: Samples, impulse: Samples) -> Samples:
    """Return what is felt after a drive has ended, shape (len(impulse) - 1,)."""
    from scipy.signal import fftconvolve

    memory = len(impulse) - 1
    last = drive[max(0, len(drive) - memory) :]
    return np.asarray(fftconvolve(last, impulse)[len(last) :], dtype=np.float64) if len(last) else np.zeros(memory)


def _coarse_to_fine(wanted: Samples, start: Samples, impulse: Samples, *, rate_hz: int, rules: RenderRules) -> Samples:
    """Return the drive of one piece: solved for its corners, then polished at the full rate."""
    fine = full_problem(wanted, impulse, frames=len(start))
    stride = max(1, rate_hz // rules.solver_rate_hz)
    if stride == 1 or len(start) < 4 * stride:
        return minimise(fine, start, iterations=rules.iterations, tolerance=rules.tolerance)
    coarse = coarse_problem(fine.rhs, impulse, stride)
    corners = start[stride - 1 :: stride][: len(coarse.rhs)]
    solved = minimise(coarse, corners, iterations=rules.iterations, tolerance=rules.tolerance)
    straight = between_corners(solved, stride, len(start))
    # where the limit is hardly met, the compensator's drive is the better guess
    better = min(straight, start, key=fine.objective)
    return minimise(fine, better, iterations=rules.polish_iterations, tolerance=rules.tolerance)


def full_problem(wanted: Samples, impulse: Samples, *, frames: int) -> BoxProblem:
    """Return the problem with one unknown for each of the first `frames` samples of what is wanted to be felt."""
    from scipy.fft import irfft, next_fast_len, rfft

    padded = next_fast_len(max(len(wanted), frames + len(impulse) - 1), real=True)
    response = rfft(impulse, padded)
    rhs = irfft(np.conj(response) * rfft(wanted, padded), padded)[:frames]
    return BoxProblem(response.real**2 + response.imag**2, padded, rhs)


def coarse_problem(rhs: Samples, impulse: Samples, stride: int) -> BoxProblem:
    """Return the same problem for drives that are straight between corners `stride` samples apart.

    Corner k lies on sample (k + 1) stride - 1 and the drive is 0 one sample before the first and after the last.
    """
    from scipy.fft import next_fast_len, rfft

    hat = _hat(stride)
    bend = np.convolve(impulse, hat)
    lags = _autocorrelation(bend)[::stride]
    inner = np.convolve(rhs, hat, "valid")[::stride]
    padded = next_fast_len(len(inner) + len(lags) - 1, real=True)
    circle = np.zeros(padded)
    circle[: len(lags)] = lags
    circle[padded - len(lags) + 1 :] += lags[:0:-1]
    return BoxProblem(np.maximum(rfft(circle).real, 0.0), padded, inner)


def between_corners(corners: Samples, stride: int, frames: int) -> Samples:
    """Return the drive that runs in straight lines from corner to corner, shape (frames,)."""
    places = np.arange(len(corners) + 2) * stride - 1
    drive = np.interp(np.arange(frames), places, np.concatenate([[0.0], corners, [0.0]]))
    return np.asarray(np.clip(drive, -1.0, 1.0), dtype=np.float64)


def minimise(problem: BoxProblem, start: Samples, *, iterations: int, tolerance: float) -> Samples:
    """Return the minimum, no worse than `start`, after at most so many iterations.

    It stops where five iterations lower the objective by less than `tolerance` of its size, the explained energy.
    """
    normal, rhs, lipschitz = problem.normal, problem.rhs, float(np.max(problem.spectrum))
    u, nu = start, normal(start)
    y, ny, t = u, nu, 1.0
    lowest = [_objective(u, nu, rhs)]
    for _ in range(iterations):
        step = np.clip(y - (ny - rhs) / lipschitz, -1.0, 1.0)
        nstep = normal(step)
        value = _objective(step, nstep, rhs)
        if value > lowest[-1]:
            if y is u:
                break  # a plain gradient step that does not descend: at the minimum, to rounding
            y, ny, t = u, nu, 1.0
            continue
        t_next = (1.0 + (1.0 + 4.0 * t * t) ** 0.5) / 2.0
        momentum = (t - 1.0) / t_next
        y, ny, t = step + momentum * (step - u), nstep + momentum * (nstep - nu), t_next
        u, nu = step, nstep
        lowest.append(value)
        if len(lowest) > 5 and lowest[-6] - value <= tolerance * abs(value):
            break
    return u


def _objective(u: Samples, nu: Samples, rhs: Samples) -> float:
    # not np.dot: its threads burn more time than they save, and their number would change the last bit
    return float(np.sum(u * (0.5 * nu - rhs)))


def _hat(stride: int) -> Samples:
    rise = np.arange(1.0, stride + 1.0) / stride
    return np.concatenate([rise, rise[-2::-1]])


def _autocorrelation(samples: Samples) -> Samples:
    """Return the sums of products at lags 0, 1, 2, ..."""
    from scipy.fft import irfft, next_fast_len, rfft

    padded = next_fast_len(2 * len(samples) - 1, real=True)
    spectrum = rfft(samples, padded)
    lags: Samples = irfft(spectrum.real**2 + spectrum.imag**2, padded)
    return lags[: len(samples)]
