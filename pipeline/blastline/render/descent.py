"""The constrained drive's problem at the full rate, by FFT: judged, and solved by steps down the slope.

    minimise  1/2 |H u - t|^2   over  |u| <= 1

With N = H'H and b = H't, the gradient is N u - b.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Iterate:
    """A drive u and N u, shape (frames,) each, and the objective; worked out once, since N u takes two transforms."""

    drive: Samples
    normal: Samples
    objective: float


@dataclass(frozen=True, eq=False)
class BoxProblem:
    """1/2 u'Nu - b'u over |u| <= 1, N a symmetric Toeplitz matrix by its spectrum on a zero-padded circle.

    `spectrum` is that of N's first row, around a circle of `padded` samples, `rhs` is b, shape (frames,). `lipschitz`
    is the most by which N stretches a drive: a step down the slope over it never overshoots.
    """

    spectrum: Samples
    padded: int
    rhs: Samples
    lipschitz: float

    def normal(self, u: Samples) -> Samples:
        """Return N u."""
        from scipy.fft import irfft, rfft

        product: Samples = irfft(self.spectrum * rfft(u, self.padded), self.padded)
        return product[: len(u)]

    def step_from(self, u: Samples, normal: Samples) -> Samples:
        """Return where a step down the slope leads, within the limit."""
        return np.asarray(np.clip(u - (normal - self.rhs) / self.lipschitz, -1.0, 1.0), dtype=np.float64)

    def to_gain(self, found: Iterate) -> float:
        """Return by how much the best drive's objective may be lower at most: its duality gap (Frank and Wolfe)."""
        gradient = found.normal - self.rhs
        return float(np.sum(np.abs(gradient) + gradient * found.drive))

    def objective(self, u: Samples) -> float:
        """Return 1/2 u'Nu - b'u."""
        return self.at(u).objective

    def at(self, u: Samples) -> Iterate:
        """Return a drive with its N u and its objective."""
        normal = self.normal(u)
        # not np.dot: its threads burn more time than they save, and their number would change the last bit
        return Iterate(u, normal, float(np.sum(u * (0.5 * normal - self.rhs))))


@dataclass(frozen=True, eq=False)
class Convolution:
    """H for drives of so many `frames`, by its spectrum around a circle of `padded` samples: room for what it rings."""

    frames: int
    felt_frames: int
    padded: int
    response: NDArray[np.complex128]

    @classmethod
    def of(cls, impulse: Samples, frames: int) -> "Convolution":
        """Return H from its impulse response."""
        from scipy.fft import next_fast_len, rfft

        felt_frames = frames + len(impulse) - 1
        padded = next_fast_len(felt_frames, real=True)
        return cls(frames, felt_frames, padded, rfft(impulse, padded))

    def felt(self, drive: Samples) -> Samples:
        """Return H u, shape (felt_frames,): what is felt of a drive, and what rings after its end."""
        from scipy.fft import irfft, rfft

        felt: Samples = irfft(self.response * rfft(drive, self.padded), self.padded)
        return felt[: self.felt_frames]

    def problem(self, wanted: Samples) -> BoxProblem:
        """Return the problem with one unknown for each sample of a drive; `wanted` is to be felt, silence after it.

        Every step needs N of the drive's own samples alone: its circle is short, however long H rings.
        """
        from scipy.fft import irfft, next_fast_len, rfft

        rhs = irfft(np.conj(self.response) * rfft(wanted, self.padded), self.padded)[: self.frames]
        power = self.response.real**2 + self.response.imag**2
        lipschitz, short = float(np.max(power)), next_fast_len(2 * self.frames - 1, real=True)
        if short >= self.padded:
            return BoxProblem(power, self.padded, rhs, lipschitz)
        row, lags = np.zeros(short), irfft(power, self.padded)[: self.frames]
        row[: self.frames], row[short - self.frames + 1 :] = lags, lags[:0:-1]
        return BoxProblem(rfft(row).real, short, rhs, lipschitz)


def restarted_fista(problem: BoxProblem, start: Iterate, *, iterations: int, tolerance: float) -> Iterate:
    """Return the minimum, no worse than `start`, after at most so many iterations of the fast gradient method.

    This is FISTA (Beck and Teboulle 2009) with restart (O'Donoghue and Candes 2015), each iteration one FFT there and
    back. It stops where five iterations lower the objective by less than `tolerance` of its size, the explained energy.
    """
    best, y, ny, t = start, start.drive, start.normal, 1.0
    lowest = [best.objective]
    for _ in range(iterations):
        step = problem.at(problem.step_from(y, ny))
        if step.objective > lowest[-1]:
            if y is best.drive:
                break  # a plain gradient step that does not descend: at the minimum, to rounding
            y, ny, t = best.drive, best.normal, 1.0
            continue
        t_next = (1.0 + (1.0 + 4.0 * t * t) ** 0.5) / 2.0
        momentum = (t - 1.0) / t_next
        y = step.drive + momentum * (step.drive - best.drive)
        ny, t = step.normal + momentum * (step.normal - best.normal), t_next
        best = step
        lowest.append(step.objective)
        if len(lowest) > 5 and lowest[-6] - step.objective <= tolerance * abs(step.objective):
            break
    return best
