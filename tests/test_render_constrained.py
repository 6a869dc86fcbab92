"""The constrained drive: its problem as matrices, its corners, and that its minimum is scipy's."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import toeplitz
from scipy.optimize import lsq_linear

from blastline.model import Quality
from blastline.render import DriveFilters
from blastline.render.constrained import _is_unsettled, between_corners, constrained_drive, corner_rhs
from blastline.render.descent import Convolution, restarted_fista
from blastline.render.filters import compensated, felt, in_band
from blastline.ruleset import RenderRules, load_rules
from render_signals import CAUSAL, KINDS, RATE_HZ, RENDER, altered, film_with_shot

Samples = NDArray[np.float64]

SLOW = 6_000.0  # a rate at which small problems hold a whole shot
IMPULSE = CAUSAL.impulse[::8].copy() * 8.0


def convolution(impulse: Samples, frames: int) -> Samples:
    """Return H as a matrix, (frames + len(impulse) - 1, frames)."""
    matrix: Samples = toeplitz(np.concatenate([impulse, np.zeros(frames - 1)]), np.zeros(frames))
    return matrix


@pytest.mark.parametrize(("share", "is_unsettled"), [(0.005, False), (0.02, True)])
@pytest.mark.parametrize("peak", [1e-3, 0.5])
def test_a_drive_is_settled_where_a_step_moves_it_by_less_than_a_hundredth(
    share: float, peak: float, *, is_unsettled: bool
) -> None:
    drive = peak * np.sin(np.arange(200) / 3.0)
    problem = Convolution.of(IMPULSE, 200).problem(blast_target(200, peak=peak))
    moved = replace(problem, rhs=problem.normal(drive) + problem.lipschitz * share * drive)
    assert _is_unsettled(moved, moved.at(drive)) == is_unsettled


def blast_target(frames: int, *, peak: float) -> Samples:
    late = np.arange(frames) / SLOW / 2e-3
    return peak * (1.0 - late) * np.exp(-late)


def shot_target(kind: tuple[float, float, float], seed: int = 0) -> tuple[Samples, Samples]:
    """Return a shot in the band from 1 ms before its onset, and the compensator's drive there."""
    film, shot = film_with_shot(kind, seed=seed)
    first = shot.onset - RATE_HZ // 1000
    return in_band(film, CAUSAL)[first:], compensated(film, CAUSAL)[first:]


def solved(
    target: Samples,
    warm: Samples,
    *,
    starts: Sequence[int] = (0,),
    rules: RenderRules = RENDER,
    filters: DriveFilters = CAUSAL,
) -> Samples:
    return constrained_drive(
        target,
        starts=starts,
        impulse=filters.impulse,
        recursion=filters.recursion,
        rate_hz=filters.rate_hz,
        warm_start=warm,
        rules=rules,
    )[0]


@pytest.mark.parametrize("frames", [1, 2, 7, 100, 333])
def test_normal_operator_and_right_side_are_those_of_the_matrix(frames: int) -> None:
    random = np.random.default_rng(frames)
    target, u = random.standard_normal(frames), random.standard_normal(frames)
    matrix = convolution(IMPULSE, frames)
    problem = Convolution.of(IMPULSE, frames).problem(target)
    np.testing.assert_allclose(problem.normal(u), matrix.T @ matrix @ u, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(problem.rhs, matrix[:frames].T @ target, rtol=1e-9, atol=1e-12)


@given(st.integers(1, 400), st.integers(0, 1000))
@settings(max_examples=40)
def test_adjoint(frames: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    u, v = random.standard_normal(frames), random.standard_normal(frames)
    forwards = float(np.sum(felt(u, CAUSAL) * v))
    backwards = float(np.sum(u * Convolution.of(CAUSAL.impulse, frames).problem(v).rhs))
    assert forwards == pytest.approx(backwards, rel=1e-8, abs=1e-10)


@pytest.mark.parametrize(("frames", "stride"), [(40, 5), (101, 6), (64, 2), (300, 11), (30, 1)])
def test_right_side_of_the_corners_is_that_of_their_straight_lines(frames: int, stride: int) -> None:
    random = np.random.default_rng(stride)
    rhs = random.standard_normal(frames)
    inner = corner_rhs(rhs, stride)
    corners = random.uniform(-1, 1, len(inner))
    straight = between_corners(corners, stride, frames)
    assert np.sum(inner * corners) == pytest.approx(np.sum(rhs * straight), rel=1e-9)


@pytest.mark.parametrize(("frames", "stride"), [(4, 5), (9, 5), (10, 5), (14, 5), (1, 1), (0, 1)])
def test_corners_end_where_there_is_no_room(frames: int, stride: int) -> None:
    assert len(corner_rhs(np.ones(frames), stride)) == max(0, (frames - 2 * stride + 1) // stride + 1)


def test_corners_lie_exactly_on_their_samples() -> None:
    corners = np.array([1.0, -1.0, 0.5])
    straight = between_corners(corners, 4, 20)
    assert np.array_equal(straight[3:12:4], corners)
    assert np.array_equal(straight[:4], [0.25, 0.5, 0.75, 1.0])
    assert not np.any(straight[15:])


@pytest.mark.parametrize("peak", [0.05, 0.5, 3.0])
def test_minimum_is_that_of_scipy(peak: float) -> None:
    frames = 240
    target = blast_target(frames, peak=peak)
    matrix = convolution(IMPULSE, frames)
    whole = np.concatenate([target, np.zeros(len(matrix) - frames)])
    reference = lsq_linear(matrix, whole, bounds=(-1.0, 1.0), tol=1e-12)
    problem = Convolution.of(IMPULSE, frames).problem(target)
    found = restarted_fista(problem, problem.at(np.zeros(frames)), iterations=4000, tolerance=0.0).drive
    residual = 0.5 * float(np.sum((matrix @ found - whole) ** 2))
    assert residual <= 1.001 * reference.cost + 1e-9 * float(np.sum(whole**2))


@given(st.integers(0, 10_000), st.integers(0, 40), st.floats(0.01, 100.0))
@settings(max_examples=40)
def test_solver_is_never_worse_than_its_start_and_stays_in_the_box(seed: int, iterations: int, scale: float) -> None:
    random = np.random.default_rng(seed)
    problem = Convolution.of(IMPULSE, 200).problem(scale * random.standard_normal(200))
    start = random.uniform(-1, 1, 200)
    found = restarted_fista(problem, problem.at(start), iterations=iterations, tolerance=0.0).drive
    assert problem.objective(found) <= problem.objective(start)
    assert np.max(np.abs(found)) <= 1.0


@pytest.mark.parametrize("peak", [0.05, 3.0])
def test_more_iterations_are_never_worse(peak: float) -> None:
    problem = Convolution.of(IMPULSE, 200).problem(blast_target(200, peak=peak))
    values = [
        restarted_fista(problem, problem.at(np.zeros(200)), iterations=count, tolerance=0.0).objective
        for count in range(80)
    ]
    assert np.all(np.diff(values) <= 1e-12 * abs(values[-1]))


def textbook_fista(matrix: Samples, whole: Samples, *, iterations: int) -> Samples:
    """Return the best point of Beck and Teboulle's FISTA over |u| <= 1, begun anew whenever the objective rises."""
    lipschitz = Convolution.of(IMPULSE, matrix.shape[1]).problem(whole).lipschitz
    best = y = np.zeros(matrix.shape[1])
    t, lowest = 1.0, 0.5 * float(np.sum(whole**2))
    for _ in range(iterations):
        step = np.clip(y - matrix.T @ (matrix @ y - whole) / lipschitz, -1.0, 1.0)
        objective = 0.5 * float(np.sum((matrix @ step - whole) ** 2))
        if objective > lowest:
            y, t = best, 1.0
            continue
        t_next = (1.0 + np.sqrt(1.0 + 4.0 * t * t)) / 2.0
        y, t = step + (t - 1.0) / t_next * (step - best), t_next
        best, lowest = step, objective
    return best


@pytest.mark.parametrize("iterations", [3, 21, 60, 450])
def test_iterates_are_those_of_the_textbook(iterations: int) -> None:
    frames = 240
    target = blast_target(frames, peak=3.0)  # it begins anew after 21
    matrix = convolution(IMPULSE, frames)
    whole = np.concatenate([target, np.zeros(len(matrix) - frames)])
    problem = Convolution.of(IMPULSE, frames).problem(target)
    found = restarted_fista(problem, problem.at(np.zeros(frames)), iterations=iterations, tolerance=0.0).drive
    np.testing.assert_allclose(found, textbook_fista(matrix, whole, iterations=iterations), atol=1e-6)


def test_tolerance_stops_early_and_near_the_minimum() -> None:
    target, warm = shot_target(KINDS[0])
    problem = Convolution.of(CAUSAL.impulse, len(target)).problem(target)
    start = np.clip(warm, -1.0, 1.0)
    best = restarted_fista(problem, problem.at(start), iterations=300, tolerance=0.0).objective
    loose = restarted_fista(problem, problem.at(start), iterations=300, tolerance=1e-3).objective
    assert best <= loose <= 0.98 * best  # both negative


@pytest.mark.parametrize("kind", KINDS)
def test_target_that_the_actuator_can_follow_is_felt_exactly(kind: tuple[float, float, float]) -> None:
    target, warm = shot_target(kind)
    scale = 0.99 / float(np.max(np.abs(warm)))
    drive = solved(scale * target, scale * warm)
    error = np.linalg.norm(felt(drive, CAUSAL) - scale * target) / np.linalg.norm(scale * target)
    assert error < 0.005


def test_limit_binds_under_a_target_far_beyond_it() -> None:
    target, warm = shot_target(KINDS[1])
    drive = solved(1e30 * target, 1e30 * warm)
    assert np.max(np.abs(drive)) == 1.0
    aligned = Convolution.of(CAUSAL.impulse, len(target)).problem(target).rhs
    assert np.array_equal(np.sign(drive[drive != 0.0]), np.sign(aligned[drive != 0.0]))


def ring_over_boom(frequency_hz: float, peak: float, boom_hz: float) -> tuple[Samples, Samples]:
    """Return the target and first guess of something that rings high and dies away, over a soft boom."""
    time_s = np.arange(round(0.15 * RATE_HZ)) / RATE_HZ
    ring = peak * np.sin(2.0 * np.pi * frequency_hz * time_s) * np.exp(-time_s / 0.02)
    boom = 0.03 * np.sin(2.0 * np.pi * boom_hz * time_s) * np.exp(-time_s / 0.05)
    sound = np.concatenate([np.zeros(RATE_HZ // 1000), ring + boom])
    return in_band(sound, CAUSAL), compensated(sound, CAUSAL)


@pytest.mark.parametrize(
    ("tier", "share"), [("draft", 0.99), ("standard", 0.998), ("reference", 0.998)], ids=lambda each: str(each)
)
@pytest.mark.parametrize("ring", [(2000.0, 0.8, 80.0), (2500.0, 0.8, 200.0), (1500.0, 0.2, 40.0), (1200.0, 0.4, 80.0)])
def test_what_straight_lines_cannot_follow_is_solved_all_the_same(
    ring: tuple[float, float, float], tier: Quality, share: float
) -> None:
    target, warm = ring_over_boom(*ring)
    found, finest = (
        constrained_drive(
            target,
            starts=[0],
            impulse=CAUSAL.impulse,
            recursion=CAUSAL.recursion,
            rate_hz=RATE_HZ,
            warm_start=warm,
            rules=rules,
        )[1][0].explained
        for rules in (
            load_rules(tier).tier.render,
            altered(solver_rate_hz=RATE_HZ, polish_iterations=300, tolerance=1e-7),
        )
    )
    assert found > share * finest


@pytest.mark.parametrize("peak", [0.05, 0.3, 3.0])
def test_no_drive_gains_more_than_is_said_to_be_left(peak: float) -> None:
    problem = Convolution.of(IMPULSE, 200).problem(blast_target(200, peak=peak))
    rest = problem.at(np.zeros(200))
    best = restarted_fista(problem, rest, iterations=5000, tolerance=0.0)
    for steps in (0, 1, 10, 100):
        found = restarted_fista(problem, rest, iterations=steps, tolerance=0.0)
        assert found.objective - best.objective <= problem.to_gain(found) + 1e-9 * abs(best.objective)
    assert 0.0 <= problem.to_gain(best) < 1e-3 * abs(best.objective)


def test_zero_target_needs_no_drive() -> None:
    drive = solved(np.zeros(500), np.zeros(500))
    assert not np.any(drive)


@pytest.mark.parametrize("frames", [1, 2, 5, 23, 24, 25])
def test_windows_of_few_samples(frames: int) -> None:
    target = np.full(frames, 0.9)
    drive = solved(target, target)
    assert drive.shape == (frames,)
    assert np.max(np.abs(drive)) <= 1.0


def two_shots(gap: int) -> tuple[Samples, Samples]:
    """Return target and first guess of a quiet shot and a loud one `gap` samples later."""
    quiet, quiet_warm = shot_target(KINDS[0])
    loud, loud_warm = shot_target(KINDS[1])
    size = gap + len(loud)
    target, warm = np.zeros(size), np.zeros(size)
    for start, level, (sound, drive) in ((0, 0.2, (quiet, quiet_warm)), (gap, 1.0, (loud, loud_warm))):
        length = min(len(sound), size - start)
        target[start : start + length] += level * sound[:length]
        warm[start : start + length] += level * drive[:length]
    return target, warm


@pytest.mark.parametrize("gap", [1, 30, 700, 4800])
def test_drive_does_not_know_the_next_shot(gap: int) -> None:
    target, warm = two_shots(gap)
    other = np.concatenate([target[:gap], np.zeros(len(target) - gap)])
    with_next, without = (solved(sound, warm, starts=[0, gap]) for sound in (target, other))
    assert np.array_equal(with_next[:gap], without[:gap])
    assert np.max(np.abs(with_next[gap:])) == 1.0


@pytest.mark.parametrize("frequency_hz", [1500.0, 1800.0, 2200.0])
def test_a_first_guess_that_is_wrong_where_a_shot_begins_is_not_kept_as_it_is(frequency_hz: float) -> None:
    """The compensator does not know what the shot before rings, nor that its own drive is cut off before the lead."""
    sound = 0.03 * np.sin(2.0 * np.pi * frequency_hz * np.arange(RATE_HZ) / RATE_HZ)
    target, warm = in_band(sound, CAUSAL), compensated(sound, CAUSAL)
    cut, first = slice(0, RATE_HZ // 500), slice(0, RATE_HZ // 250)
    warm[cut] = 0.0
    drive = solved(target, warm, rules=load_rules("draft").tier.render)
    assert np.linalg.norm((felt(drive, CAUSAL) - target)[first]) < 0.5 * np.linalg.norm(target[first])


@pytest.mark.parametrize("frequency_hz", [40.0, 200.0, 600.0])
def test_pieces_join_where_the_limit_is_not_met(frequency_hz: float) -> None:
    sound = 0.05 * np.sin(2.0 * np.pi * frequency_hz / RATE_HZ * np.arange(6000)) * np.linspace(0.0, 1.0, 6000)
    target, warm = in_band(sound, CAUSAL), compensated(sound, CAUSAL)
    drive = solved(target, warm, starts=[0, 3000])
    assert np.max(np.abs(felt(drive, CAUSAL) - target)) < 1e-3 * np.max(np.abs(target))


@pytest.mark.parametrize("starts", [[40], [40, 40], [40, 41, 900]])
def test_drive_is_0_before_the_first_start(starts: list[int]) -> None:
    target, warm = shot_target(KINDS[0])
    drive = solved(target, warm, starts=starts)
    assert not np.any(drive[:40])
    assert np.any(drive[40:])


@pytest.mark.parametrize("solver_rate_hz", [4000, 8000, 16_000, 48_000])
def test_coarse_solve_shifts_nothing_in_time(solver_rate_hz: int) -> None:
    target, warm = shot_target(KINDS[2])
    drive = solved(target, warm, rules=altered(solver_rate_hz=solver_rate_hz))
    found = felt(drive, CAUSAL)
    lags = range(-20, 21)
    inner = slice(100, len(target) - 100)
    products = [float(np.sum(np.roll(found, -lag)[inner] * target[inner])) for lag in lags]
    # the felt shot is where its target is, although the limit bends its shape: parabola through the best three lags
    best = int(np.argmax(products))
    before, peak, after = products[best - 1 : best + 2]
    shift = lags[best] + 0.5 * (before - after) / (before - 2.0 * peak + after)
    assert abs(shift) <= 3.0
