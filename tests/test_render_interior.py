"""The interior-point solver against dense matrices, scipy, and what must hold of any minimum in a box."""

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import toeplitz
from scipy.optimize import lsq_linear
from scipy.signal import fftconvolve

from blastline import dsp
from blastline.model import Quality
from blastline.render import DriveFilters, drive_filters
from blastline.render.banded import Recursion, banded_hessian, q_diagonals, well_conditioned_stride
from blastline.render.constrained import SolveSummary, between_corners, constrained_drive, corner_rhs
from blastline.render.descent import Convolution, restarted_fista
from blastline.render.filters import compensated, felt, in_band
from blastline.render.interior import SHORTEST, _Newton, _State, solve_box_qp
from blastline.ruleset import ActuatorProfile, load_rules
from render_signals import CAUSAL, KINDS, PROFILE, film_with_shot

Samples = NDArray[np.float64]

SLOW_HZ = 8_000
SLOW = drive_filters(PROFILE, SLOW_HZ, "causal")


def profile(gain: float, zeros: list[tuple[float, float]], poles: list[tuple[float, float]]) -> ActuatorProfile:
    response = msgspec.structs.replace(PROFILE.response, gain=gain, zeros_rad_s=tuple(zeros), poles_rad_s=tuple(poles))
    steeper = msgspec.structs.replace(PROFILE.lowpass, order=len(poles) - len(zeros) + 1)
    return msgspec.structs.replace(PROFILE, response=response, lowpass=steeper)


def resonances(poles_hz: list[float], zeros_hz: list[float]) -> ActuatorProfile:
    """Return a profile with so many resonances and dips, felt of a full drive at most by half."""

    def pairs(corners_hz: list[float], damping: float) -> list[tuple[float, float]]:
        roots = [2.0 * np.pi * f * complex(-damping, np.sqrt(1.0 - damping**2)) for f in corners_hz]
        return [(float(root.real), float(root.imag) * side) for root in roots for side in (1, -1)]

    raw = profile(1.0, pairs(zeros_hz, 0.3), pairs(poles_hz, 0.2))
    peak = np.max(np.abs(dsp.felt_response(raw).at(np.geomspace(1.0, 3000.0, 500))))
    return profile(float(0.5 / peak), pairs(zeros_hz, 0.3), pairs(poles_hz, 0.2))


OTHERS = {
    "sharp resonance at 292 Hz": profile(3.4e6, [], [(-90.0, 1832.0), (-90.0, -1832.0)]),
    "slow and fast poles": profile(3e8, [(-20.0, 0.0)], [(-6.0, 0.0), (-1400.0, 0.0), (-1400.0, 0.0), (-5e3, 0.0)]),
    "two resonances": profile(
        2e10, [(-40.0, 0.0)], [(-60.0, 400.0), (-60.0, -400.0), (-300.0, 1800.0), (-300.0, -1800.0)]
    ),
}
MANY = {
    "four resonances": resonances([25.0, 60.0, 160.0, 420.0], [40.0, 100.0, 260.0]),
    "five resonances": resonances([20.0, 45.0, 100.0, 220.0, 480.0], [30.0, 70.0, 150.0, 330.0]),
}
"""Seats that remember so much that the solver's corners lie wide apart."""
EVERY = {**OTHERS, **MANY, "built in": PROFILE}


def shot(filters: DriveFilters, *, peak: float = 0.9, frames: int = 0) -> tuple[Samples, Samples]:
    """Return a shot in the band from its onset, and the compensator's drive there."""
    film, found = film_with_shot(KINDS[1], peak=peak, rate_hz=filters.rate_hz)
    inside = slice(found.onset, found.onset + frames if frames else len(film))
    return in_band(film, filters)[inside], compensated(film, filters)[inside]


def whole_drive(
    target: Samples, warm: Samples, filters: DriveFilters, *, start: int, quality: Quality
) -> tuple[Samples, SolveSummary]:
    """Return the drive of a single shot that may begin at `start`, and what it took."""
    drive, (effort,) = constrained_drive(
        target,
        starts=[start],
        impulse=filters.impulse,
        recursion=filters.recursion,
        rate_hz=filters.rate_hz,
        warm_start=warm,
        rules=load_rules(quality).tier.render,
    )
    return drive, effort


def dense(recursion: Recursion, frames: int) -> Samples:
    first = np.concatenate([recursion.impulse, np.zeros(frames - 1)])
    matrix: Samples = toeplitz(first, np.zeros(frames))
    return matrix


@pytest.mark.parametrize(("stride", "peak"), [(1, 0.05), (1, 0.9), (2, 0.9), (2, 5.0)])
def test_minimum_is_that_of_scipy(stride: int, peak: float) -> None:
    target, warm = shot(SLOW, peak=peak, frames=160)
    matrix = dense(SLOW.recursion, 160)
    count = len(corner_rhs(target, stride))
    lines = (
        np.stack([between_corners(unit, stride, 160) for unit in np.eye(count)], axis=1) if stride > 1 else np.eye(160)
    )
    wanted = np.concatenate([target, np.zeros(len(matrix) - 160)])
    slow = lsq_linear(matrix @ lines, wanted, bounds=(-1.0, 1.0), tol=1e-10, max_iter=60)
    rhs = lines.T @ (matrix.T @ wanted)
    found = solve_box_qp(
        SLOW.recursion, rhs, warm[stride - 1 :: stride][:count], stride=stride, iterations=60, tolerance=1e-9
    )
    cost = 0.5 * float(np.sum((matrix @ (lines @ found.drive) - wanted) ** 2))
    assert found.finished
    assert cost <= slow.cost * (1.0 + 1e-4) + 1e-7 * float(np.sum(wanted**2))
    assert np.max(np.abs(found.drive)) <= 1.0


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("rate_hz", [8_000, 44_056, 192_000])
def test_recursion_has_the_response_of_the_sections(name: str, rate_hz: int) -> None:
    """And A undoes all of its ringing, at the distance of the solver's corners, where rounding leaves room for that."""
    filters = drive_filters(EVERY[name], rate_hz, "causal")
    recursion = filters.recursion
    exact = felt(np.concatenate([[1.0], np.zeros(len(filters.impulse) - 1)]), filters)
    assert np.linalg.norm(recursion.impulse - exact) <= 1e-3 * np.linalg.norm(exact)
    stride = well_conditioned_stride(recursion, 1, rate_hz)
    undone = np.convolve(np.poly(recursion.poles**stride).real, recursion.impulse[recursion.free :][::stride])
    assert np.max(np.abs(undone[len(recursion.poles) : len(recursion.impulse) // stride])) <= 1e-9 * np.max(
        np.abs(exact)
    )


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.parametrize("rate_hz", [8_000, 48_000, 96_000])
def test_gap_to_the_minimum_is_what_was_asked_for_with_any_actuator(name: str, rate_hz: int) -> None:
    filters = drive_filters(OTHERS[name], rate_hz, "causal")
    target, warm = shot(filters, frames=rate_hz // 5)
    problem = Convolution.of(filters.recursion.impulse, len(target)).problem(target)
    stride = well_conditioned_stride(filters.recursion, 1, rate_hz)
    rhs = corner_rhs(problem.rhs, stride)
    found = solve_box_qp(
        filters.recursion, rhs, warm[stride - 1 :: stride][: len(rhs)], stride=stride, iterations=60, tolerance=1e-4
    )
    assert np.max(np.abs(found.drive)) <= 1.0
    # over the box, a convex function is nowhere lower than its tangent: a bound that knows nothing of the solver
    drive = between_corners(found.drive, stride, len(target)) if stride > 1 else found.drive
    slope = corner_rhs(problem.normal(drive) - problem.rhs, stride)
    gap = float(np.sum(slope * found.drive) + np.sum(np.abs(slope)))
    assert found.finished
    assert gap <= 1e-3 * abs(problem.objective(drive))  # the bound is looser than the solver's own, of 1e-4


@pytest.mark.parametrize("name", [*OTHERS, "built in"])
def test_steps_are_few_however_far_over_the_limit_the_target_is(name: str) -> None:
    """Without Mehrotra's corrector they are 19 to 21."""
    filters = drive_filters(OTHERS.get(name, PROFILE), 48_000, "causal")
    target, warm = shot(filters, peak=5.0, frames=9600)
    stride = well_conditioned_stride(filters.recursion, 4, 48_000)
    rhs = corner_rhs(Convolution.of(filters.recursion.impulse, len(target)).problem(target).rhs, stride)
    found = solve_box_qp(
        filters.recursion, rhs, warm[stride - 1 :: stride][: len(rhs)], stride=stride, iterations=60, tolerance=1e-4
    )
    assert found.finished
    assert found.steps <= 17


def test_stride_is_kept_where_rounding_allows_it() -> None:
    assert well_conditioned_stride(CAUSAL.recursion, 1, 48_000) == 1
    assert well_conditioned_stride(CAUSAL.recursion, 6, 48_000) == 6
    slow = drive_filters(OTHERS["slow and fast poles"], 192_000, "causal").recursion
    assert 4 < well_conditioned_stride(slow, 1, 192_000) == well_conditioned_stride(slow, 4, 192_000) < 24


@pytest.mark.parametrize("name", MANY)
def test_stride_is_a_time_at_high_rates(name: str) -> None:
    """Poles are as slow there: what was counted in samples ended too soon, and the solver in rounding."""
    strides_ms = [
        1e3 / rate_hz * well_conditioned_stride(drive_filters(MANY[name], rate_hz, "causal").recursion, 1, rate_hz)
        for rate_hz in (48_000, 192_000, 384_000)
    ]
    assert strides_ms == pytest.approx([strides_ms[0]] * 3, rel=0.1)


@given(st.floats(-30.0, 30.0), st.integers(0, 1000), st.integers(1, 4))
@settings(max_examples=25)
def test_scale_of_the_actuator_changes_nothing_but_numbers(level: float, seed: int, stride: int) -> None:
    """With H and t a thousand times as large the best drive is the same, and the objective scales by the square."""
    random = np.random.default_rng(seed)
    rhs = random.standard_normal(200)
    factor = 10.0 ** (level / 10.0)
    larger = Recursion(SLOW.recursion.poles, factor * SLOW.recursion.impulse, SLOW.recursion.free)
    one, other = (
        solve_box_qp(recursion, right, np.zeros(200), stride=stride, iterations=60, tolerance=1e-6)
        for recursion, right in ((SLOW.recursion, rhs), (larger, factor**2 * rhs))
    )
    problem = Convolution.of(SLOW.recursion.impulse, 200 * stride).problem(np.zeros(200 * stride))

    def objective(corners: Samples) -> float:
        straight = between_corners(corners, stride, 200 * stride + stride)[: 200 * stride] if stride > 1 else corners
        return 0.5 * float(np.sum(straight * problem.normal(straight))) - float(np.sum(rhs * corners))

    assert objective(one.drive) == pytest.approx(objective(other.drive), rel=1e-4)


@pytest.mark.parametrize("frames", [SHORTEST, SHORTEST + 1, 3 * SHORTEST])
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e30])
def test_few_unknowns_and_any_size_of_target(frames: int, scale: float) -> None:
    target, _ = shot(SLOW, frames=frames)
    problem = Convolution.of(SLOW.impulse, frames).problem(scale * target)
    found = solve_box_qp(SLOW.recursion, problem.rhs, np.zeros(frames), stride=1, iterations=60, tolerance=1e-4)
    assert np.all(np.isfinite(found.drive))
    assert np.max(np.abs(found.drive)) <= 1.0
    if scale == 1e30:
        np.testing.assert_allclose(found.drive, np.sign(problem.rhs), atol=0.05)


def test_larger_limit_is_never_worse_and_costs_no_more_steps_than_it_may() -> None:
    """A limit twice as high is the same problem with H twice as large, and its minimum is no higher."""
    target, warm = shot(CAUSAL)
    values = []
    for limit in (0.5, 1.0, 2.0, 8.0, 100.0):
        problem = Convolution.of(limit * CAUSAL.recursion.impulse, len(target)).problem(target)
        higher = Recursion(CAUSAL.recursion.poles, limit * CAUSAL.recursion.impulse, CAUSAL.recursion.free)
        found = solve_box_qp(higher, problem.rhs, warm / limit, stride=1, iterations=60, tolerance=1e-6)
        values.append(problem.objective(found.drive))
    assert values == sorted(values, reverse=True)
    assert values[-1] == pytest.approx(-0.5 * float(np.sum(target**2)), rel=1e-3)


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize(
    ("rate_hz", "quality"), [(8_000, "draft"), (8_000, "standard"), (22_050, "standard"), (96_000, "draft")]
)
def test_whole_drive_beats_clipping_at_any_rate_with_any_actuator(name: str, rate_hz: int, quality: Quality) -> None:
    filters = drive_filters(EVERY[name], rate_hz, "causal")
    target, warm = shot(filters, frames=rate_hz // 8)
    drive, effort = whole_drive(target, warm, filters, start=7, quality=quality)
    assert not np.any(drive[:7])
    assert np.max(np.abs(drive)) <= 1.0
    clipped = np.clip(np.where(np.arange(len(warm)) < 7, 0.0, warm), -1.0, 1.0)
    missed, missed_clipped = (float(np.linalg.norm(felt(u, filters) - target)) for u in (drive, clipped))
    assert missed <= 1.001 * missed_clipped
    assert 0.0 <= effort.explained <= 1.0
    assert effort.steps < load_rules(quality).tier.render.iterations


@pytest.mark.parametrize("count", [5, 8, 12])
def test_a_seat_of_many_resonances_has_a_drive_however_long_its_window(count: int) -> None:
    """The more poles, the more diagonals has the solver's system, and all have to be there."""
    filters = drive_filters(resonances(list(np.geomspace(18.0, 320.0, count)), []), 48_000, "causal")
    target, warm = shot(filters, frames=9600)
    stride = well_conditioned_stride(filters.recursion, 4, 48_000)
    for corners in range(60, 141, 8):
        frames = (corners + 1) * stride
        drive, effort = whole_drive(target[:frames], warm[:frames], filters, start=0, quality="draft")
        assert np.max(np.abs(drive)) <= 1.0
        assert 0.0 <= effort.explained <= 1.0


@pytest.mark.parametrize("frames", [1, 2, 300, 5000])
def test_normal_equations_are_those_of_the_convolution_however_long_the_seat_rings(frames: int) -> None:
    rng = np.random.default_rng(frames)
    impulse, drive = CAUSAL.impulse, rng.standard_normal(frames)
    wanted = rng.standard_normal(frames + len(impulse) - 1)
    problem = Convolution.of(impulse, frames).problem(wanted)
    normal = fftconvolve(fftconvolve(drive, impulse), impulse[::-1])[len(impulse) - 1 :][:frames]
    right = fftconvolve(wanted, impulse[::-1])[len(impulse) - 1 :][:frames]
    rounding = 1e-12 * float(np.linalg.norm(wanted))
    np.testing.assert_allclose(problem.normal(drive), normal, atol=rounding * problem.lipschitz)
    np.testing.assert_allclose(problem.rhs, right, atol=rounding * float(np.linalg.norm(impulse)))
    assert problem.lipschitz >= np.linalg.norm(problem.normal(drive)) / np.linalg.norm(drive)


@pytest.mark.parametrize("name", MANY)
@pytest.mark.parametrize("rate_hz", [8_000, 48_000])
def test_drive_of_a_seat_that_remembers_much_is_still_the_best_one(name: str, rate_hz: int) -> None:
    """By thousands of plain gradient steps on the problem itself: corners wide apart alone lose 2 to 4 % of energy."""
    filters = drive_filters(MANY[name], rate_hz, "causal")
    target, warm = shot(filters, frames=rate_hz // 8)
    drive, _ = whole_drive(target, warm, filters, start=0, quality="standard")
    guess = np.clip(warm, -1.0, 1.0)
    felt, rung = np.split(fftconvolve(guess, filters.impulse), [len(guess)])
    share = min(1.0, np.linalg.norm(target) / np.linalg.norm(felt))
    wanted = np.concatenate([target, share * rung])  # what it may ring on, as `constrained_drive` allows
    problem = Convolution.of(filters.impulse, len(target)).problem(wanted)
    best = restarted_fista(problem, problem.at(guess), iterations=4000, tolerance=0.0).objective
    assert problem.objective(drive) - best <= 2e-3 * 0.5 * float(np.sum(wanted**2))


@pytest.mark.parametrize("length", [0.3, 1.0])
def test_what_a_step_of_the_predictor_leaves_is_known_before_it_is_taken(length: float) -> None:
    target, warm = shot(SLOW, peak=0.9)
    by_h = Convolution.of(SLOW.impulse, len(target))
    q = banded_hessian(SLOW.recursion, 1)
    rhs = by_h.problem(np.pad(target, (0, len(SLOW.impulse) - 1))).rhs
    state = _State.first(q, rhs, warm)
    predictor = _Newton.of(q, q_diagonals(q, len(rhs)), state).predictor()
    length *= state.max_step(predictor)
    assert state.gap_after(predictor, length) == pytest.approx(state.moved(q, predictor, length).gap, rel=1e-9)
