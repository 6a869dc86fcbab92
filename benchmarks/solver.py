"""Ways to solve the constrained drive: `python benchmarks/solver.py [--scenes weak indoors surround] [--shots 2]`.

Takes the first single shots of some fixtures, poses the box-constrained problem at the full rate, and prints for each
method what it leaves above the best drive known, as a share of the energy that is to be felt, and its CPU time per
second of sound. The best drive is the interior-point method's at a tolerance of 1e-9, after 300 gradient steps more.
"""

import argparse
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from blastline.render import DriveFilters, drive_filters, needed_audio
from blastline.render.banded import hat
from blastline.render.constrained import between_corners, corner_rhs
from blastline.render.descent import BoxProblem, Convolution, restarted_fista
from blastline.render.filters import compensated, in_band
from blastline.render.interior import solve_box_qp
from blastline.ruleset import load_actuator, load_rules
from blastline.study.truth import true_scenes

Samples = NDArray[np.float64]
Solve = Callable[["Case"], Samples]
FIXTURES = Path(__file__).parents[1] / "fixtures"


@dataclass(frozen=True, eq=False)
class Case:
    """A shot: the problem at the full rate, the energy that is to be felt, and the compensator's drive, clipped."""

    problem: BoxProblem
    energy: float
    start: Samples
    filters: DriveFilters

    @property
    def lipschitz(self) -> float:
        return self.problem.lipschitz


def cases(names: list[str], shots: int) -> Iterator[Case]:
    """Yield the first single shots, of those that the compensator cannot play, of each scene."""
    tier = load_rules("standard").tier
    profile, _ = load_actuator("crowson-t108sm")
    for scene in true_scenes(FIXTURES, tier, names):
        filters = drive_filters(profile, scene.track.rate_hz, "causal")
        taken = 0
        for planned in scene.windows:
            span = needed_audio(planned, frames=scene.frames, filters=filters, rules=tier.render)
            sound = np.asarray(scene.track.read(span).driving, dtype=np.float64)
            first = max(0, scene.shots[planned.shots[0]].onset - scene.track.rate_hz // 1000 - span.start)
            drive = compensated(sound, filters)[first:]
            if taken == shots or len(planned.shots) > 1 or np.max(np.abs(drive)) <= 1.0:
                continue
            taken += 1
            target = in_band(sound, filters)[first:]
            problem = Convolution.of(filters.impulse, len(target)).problem(target)
            yield Case(problem, 0.5 * float(np.sum(target**2)), np.clip(drive, -1.0, 1.0), filters)


def projected_gradient(case: Case, iterations: int) -> Samples:
    u = case.start
    for _ in range(iterations):
        u = np.clip(u - (case.problem.normal(u) - case.problem.rhs) / case.lipschitz, -1.0, 1.0)
    return u


def fista(case: Case, iterations: int) -> Samples:
    """FISTA without restart."""
    u = y = case.start
    t = 1.0
    for _ in range(iterations):
        step = np.clip(y - (case.problem.normal(y) - case.problem.rhs) / case.lipschitz, -1.0, 1.0)
        t_next = (1.0 + (1.0 + 4.0 * t * t) ** 0.5) / 2.0
        y = step + (t - 1.0) / t_next * (step - u)
        u, t = step, t_next
    return u


def fista_restart(case: Case, iterations: int) -> Samples:
    return restarted_fista(case.problem, case.problem.at(case.start), iterations=iterations, tolerance=0.0).drive


def anderson(case: Case, iterations: int, memory: int = 6) -> Samples:
    """Anderson acceleration of the projected gradient, safeguarded: a step that does not descend is a plain one."""
    problem, u = case.problem, case.start
    images: list[Samples] = []
    residuals: list[Samples] = []
    value = problem.objective(u)
    for _ in range(iterations):
        image = np.clip(u - (problem.normal(u) - problem.rhs) / case.lipschitz, -1.0, 1.0)
        images, residuals = [*images[-memory:], image], [*residuals[-memory:], image - u]
        stacked = np.stack(residuals)
        gram = stacked @ stacked.T
        weights = np.linalg.lstsq(gram + 1e-10 * np.trace(gram) * np.eye(len(gram)), np.ones(len(gram)))[0]
        mixed = np.clip(weights / np.sum(weights) @ np.stack(images), -1.0, 1.0)
        mixed_value = problem.objective(mixed)
        if mixed_value < value:
            u, value = mixed, mixed_value
        else:
            u, value = image, problem.objective(image)
            images, residuals = [], []
    return u


def admm(case: Case, iterations: int, penalty: float = 0.02, relaxation: float = 1.0) -> Samples:
    """ADMM on the zero-padded circle: there the normal matrix is inverted by one FFT; the padding is held at 0."""
    problem, frames = case.problem, len(case.start)
    padded = np.zeros(problem.padded)
    padded[:frames] = problem.rhs
    z, dual = np.zeros(problem.padded), np.zeros(problem.padded)
    z[:frames] = case.start
    weight = penalty * case.lipschitz
    inverse = 1.0 / (problem.spectrum + weight)
    for _ in range(iterations):
        u = irfft(rfft(padded + weight * (z - dual)) * inverse, problem.padded)
        u = relaxation * u + (1.0 - relaxation) * z
        dual += u
        z = np.zeros(problem.padded)
        z[:frames] = np.clip(dual[:frames], -1.0, 1.0)
        dual -= z
    return np.asarray(z[:frames])


def newton_cg(case: Case, iterations: int, inner: int = 30) -> Samples:
    """Projected Newton (Bertsekas 1982): preconditioned CG on the free samples, a search along the bent path."""
    problem, u = case.problem, case.start
    damped = problem.spectrum + 1e-6 * case.lipschitz
    value = problem.objective(u)
    for _ in range(iterations):
        slope = problem.normal(u) - problem.rhs
        free = ~(((u >= 1.0) & (slope < 0.0)) | ((u <= -1.0) & (slope > 0.0)))
        x, r = np.zeros_like(u), np.where(free, -slope, 0.0)
        z = np.where(free, irfft(rfft(r, problem.padded) / damped, problem.padded)[: len(u)], 0.0)
        p, rz = z, float(r @ z)
        for _ in range(inner):
            step = np.where(free, problem.normal(p), 0.0)
            alpha = rz / float(p @ step)
            x, r = x + alpha * p, r - alpha * step
            z = np.where(free, irfft(rfft(r, problem.padded) / damped, problem.padded)[: len(u)], 0.0)
            rz, before = float(r @ z), rz
            if rz <= 1e-6 * before or rz <= 0.0:
                break
            p = z + rz / before * p
        for halving in range(12):
            tried = np.clip(u + 0.5**halving * x, -1.0, 1.0)
            if (lower := problem.objective(tried)) < value:
                u, value = tried, lower
                break
        else:
            break
    return u


def coarse_fista(case: Case, rate_hz: int, iterations: int, polish: int) -> Samples:
    """FISTA for the corners, then at the full rate: the solver before the interior-point method."""
    stride = case.filters.rate_hz // rate_hz
    bend = np.convolve(case.filters.impulse, hat(stride))
    size = next_fast_len(2 * len(bend), real=True)
    lags = irfft(np.abs(rfft(bend, size)) ** 2, size)[: len(bend)][::stride]
    inner = corner_rhs(case.problem.rhs, stride)
    padded = next_fast_len(len(inner) + len(lags), real=True)
    circle = np.zeros(padded)
    circle[: len(lags)] = lags
    circle[padded - len(lags) + 1 :] += lags[:0:-1]
    power = np.maximum(rfft(circle).real, 0.0)
    coarse = BoxProblem(power, padded, inner, float(np.max(power)))
    start = case.start[stride - 1 :: stride][: len(inner)]
    corners = restarted_fista(coarse, coarse.at(start), iterations=iterations, tolerance=0.0).drive
    drive = min(between_corners(corners, stride, len(case.start)), case.start, key=case.problem.objective)
    return restarted_fista(case.problem, case.problem.at(drive), iterations=polish, tolerance=0.0).drive


def interior(case: Case, rate_hz: int, tolerance: float, polish: int) -> Samples:
    """The interior-point method for the corners, then gradient steps at the full rate."""
    stride = case.filters.rate_hz // rate_hz
    inner = corner_rhs(case.problem.rhs, stride)
    start = case.start[stride - 1 :: stride][: len(inner)]
    found = solve_box_qp(case.filters.recursion, inner, start, stride=stride, iterations=80, tolerance=tolerance)
    drive = min(between_corners(found.drive, stride, len(case.start)), case.start, key=case.problem.objective)
    return restarted_fista(case.problem, case.problem.at(drive), iterations=polish, tolerance=0.0).drive


def solving(method: Callable[..., NDArray[np.float64]], *settings: float, **named: float) -> Solve:
    """Return a method with its settings."""
    return lambda case: method(case, *settings, **named)


METHODS: dict[str, Solve] = {
    "compensator, clipped": lambda case: case.start,
    **{f"projected gradient, {n} iterations": solving(projected_gradient, n) for n in (20, 100)},
    **{f"FISTA, {n} iterations": solving(fista, n) for n in (20, 100, 300)},
    **{f"FISTA with restart, {n} iterations": solving(fista_restart, n) for n in (20, 100, 300)},
    **{f"Anderson, memory 6, {n} iterations": solving(anderson, n) for n in (20, 100)},
    **{f"ADMM, {n} iterations": solving(admm, n) for n in (20, 100)},
    **{f"ADMM, relaxed by 1.85, {n} iterations": solving(admm, n, relaxation=1.85) for n in (10, 20, 40)},
    **{f"projected Newton-CG, {n} steps": solving(newton_cg, n) for n in (3, 8)},
    **{
        f"FISTA {rate // 1000} kHz, {n} iterations, polish {polish}": solving(coarse_fista, rate, n, polish)
        for rate, n, polish in ((4000, 60, 0), (8000, 60, 0), (8000, 60, 4), (8000, 60, 30), (16000, 200, 30))
    },
    **{
        f"interior {rate // 1000} kHz, {tol:g}, polish {polish}": solving(interior, rate, tol, polish)
        for rate, tol, polish in (
            (4000, 1e-3, 0),
            (8000, 1e-3, 0),
            (8000, 1e-3, 1),
            (8000, 1e-3, 30),
            (16000, 1e-3, 0),
            (16000, 1e-5, 2),
            (24000, 1e-3, 2),
            (24000, 1e-5, 2),
            (24000, 1e-5, 30),
            (48000, 1e-3, 2),
            (48000, 1e-6, 2),
        )
    },
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", default=["weak", "indoors", "surround"])
    parser.add_argument("--shots", type=int, default=2)
    options = parser.parse_args()
    gaps: dict[str, list[float]] = defaultdict(list)
    costs: dict[str, float] = defaultdict(float)
    seconds = 0.0
    for case in cases(options.scenes, options.shots):
        start = case.problem.at(interior(case, case.filters.rate_hz, 1e-9, 300))
        lowest = restarted_fista(case.problem, start, iterations=300, tolerance=0.0).objective
        seconds += len(case.start) / case.filters.rate_hz
        for name, solve in METHODS.items():
            began = time.process_time()
            drive = solve(case)
            costs[name] += time.process_time() - began
            gaps[name].append((case.problem.objective(drive) - lowest) / case.energy)
    print(f"{len(gaps['compensator, clipped'])} shots, {seconds:.1f} s of sound")
    print("| method | above the best, mean | most | CPU s per s |")
    print("| --- | --- | --- | --- |")
    for name, values in gaps.items():
        print(f"| {name} | {np.mean(values):.1e} | {max(values):.1e} | {costs[name] / seconds:.3f} |")


if __name__ == "__main__":
    main()
