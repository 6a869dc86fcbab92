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


def _transition(sections: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return A^n: what a block of silence leaves of each state, one column for each."""
    from scipy.signal import sosfilt

    silence = np.zeros(_BLOCK)
    units = np.eye(2 * len(sections)).reshape(-1, len(sections), 2)
    return np.stack([sosfilt(sections, silence, zi=unit)[1].ravel() for unit in units], axis=1)
