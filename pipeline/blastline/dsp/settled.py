"""The state in which a filter arrives at a sample, without running it up to there.

In state-space form a filter's state is a sum over the sound before, so it takes products of matrices, which cost a
tenth of running:

    state = sum_k A^(k n) G x_k     x_k the k-th last block of n samples, G from input to state, A the transition matrix
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .digital import run_filter

_BLOCK = 1024
_SILENT = 16  # so many zeros are no chance
_LEVEL_BLOCK_S, _FEWEST_BLOCKS = 0.05, 5
_CLEAR = 4.0  # a constant is this many times what the means of blocks differ by; less is lost in the film's own start
_OPENING_S = 1.0

_AT_ONCE = 60_000  # products in a matrix product: larger ones start threads, which cost more than they save


@dataclass(frozen=True, eq=False)
class Settling:
    """What the state of sections is made of that have run over `lead` samples.

    `input_to_state` is G, shape (1024, state), of a block; `transition_powers` is A^(k n), what becomes of that by the
    end, shape (blocks, state, state), the oldest block first.
    """

    lead: int
    input_to_state: NDArray[np.float64]
    transition_powers: NDArray[np.float64]


def settling(sections: NDArray[np.float64], lead: int) -> Settling:
    """Return what gives the state of sections that have run over `lead` samples, from rest."""
    arriving = np.zeros(_BLOCK)
    arriving[0] = 1.0
    responses = []
    for section in sections:
        leaving = run_filter(section[None, :], arriving)
        _, b1, b2, _, a1, a2 = section
        second = b2 * arriving - a2 * leaving
        first = b1 * arriving - a1 * leaving
        first[1:] += second[:-1]
        responses += [first, second]
        arriving = leaving
    transition = _transition(sections)
    powers = [np.eye(len(transition))]
    for _ in range(1, -(-lead // _BLOCK)):
        powers.append(transition @ powers[-1])
    return Settling(lead, np.stack(responses, axis=1)[::-1].copy(), np.stack(powers[::-1]))


def settled_state(settling: Settling, before: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the state after the sound `before`, shape (sections, 2); what it lacks of the lead was silence."""
    heard = np.zeros(len(settling.transition_powers) * _BLOCK)
    last = before[max(0, len(before) - settling.lead) :]
    heard[len(heard) - len(last) :] = last
    blocks = heard.reshape(-1, _BLOCK)
    rows = max(1, _AT_ONCE // settling.input_to_state.size)
    left = [blocks[start : start + rows] @ settling.input_to_state for start in range(0, len(blocks), rows)]
    state = np.einsum("kij,kj->i", settling.transition_powers, np.concatenate(left))
    return np.asarray(state.reshape(-1, 2), dtype=np.float64)


def opening_frames(frames: int, rate_hz: int) -> int:
    """Return how much of a film's beginning tells what it stands on, where nothing before a window does."""
    return min(frames, round(_OPENING_S * rate_hz))


def opening_level(opening: NDArray[np.floating], rate_hz: int) -> float:
    """Return what a film stands on, of its first `opening_frames`: the median of the means of blocks of 50 ms.

    A shot is over in a few blocks, and hardly moves it. A film that begins in silence stands on 0; so does one where
    those means differ by as much, and one of less than five blocks: there, sound cannot be told from a constant.
    """
    if not opening[:_SILENT].any():
        return 0.0
    block = _level_block(rate_hz)
    means = opening[: len(opening) // block * block].reshape(-1, block).mean(axis=1, dtype=np.float64)
    if len(means) < _FEWEST_BLOCKS:
        return 0.0
    level = float(np.median(means))
    return level if abs(level) > _CLEAR * float(np.median(np.abs(means - level))) else 0.0


def _level_block(rate_hz: int) -> int:
    return max(1, round(_LEVEL_BLOCK_S * rate_hz))


def _transition(sections: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return A^n: what a block of silence leaves of each state, one column for each."""
    from scipy.signal import sosfilt

    silence = np.zeros(_BLOCK)
    units = np.eye(2 * len(sections)).reshape(-1, len(sections), 2)
    return np.stack([sosfilt(sections, silence, zi=unit)[1].ravel() for unit in units], axis=1)


def without_offset(samples: NDArray[np.float64], before: int, rate_hz: int) -> NDArray[np.float64]:
    """Return samples less what they stand on, as the first `before` tell, in which filters settle.

    From rest, a filter hears a constant as a step, and rings with that still when its pre-roll is over. A mean would
    take a shot in there for one, and leave a step of that where the film ends. Less than five blocks tell no more.
    """
    told = samples[:before]
    if len(told) < _FEWEST_BLOCKS * _level_block(rate_hz):
        return samples - told.mean() if told[:_SILENT].any() else samples
    return samples - opening_level(told, rate_hz)
