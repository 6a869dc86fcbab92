"""A small convolutional network over a candidate's contrasts and features, evaluated in numpy.

    near spectrogram --conv--conv--conv--conv--+
    wide spectrogram --conv--conv--conv--conv--+--dense--dense--dense--> log-odds of a shot
    features ----------------------------------+

Trained offline (`study.train`); what normalises while training is folded into the weights.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from .contrast import CONTRASTS, Contrasts
from .spectrogram import NEAR, WIDE

Values = NDArray[np.float32]

KERNEL = 3
_AT_ONCE = 24  # candidates that are judged together: their windows stay in the cache
FEATURE_LIMIT = 4.0
"""Features enter as deviations in spreads, no further out than this."""


class LayerFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A layer's weights, row after row, and biases; `stride` 0 for a dense layer, else of a 3 x 3 convolution.

    A dense layer's weights are (inputs, outputs), a convolution's (input channels * 9, outputs).
    """

    stride: int
    weights: list[list[float]]
    biases: list[float]


class NetworkFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The layers of a network in order, and the mean and spread of each feature."""

    means: list[float]
    spreads: list[float]
    near: list[LayerFile]
    wide: list[LayerFile]
    head: list[LayerFile]


@dataclass(frozen=True, eq=False)
class Layer:
    """A layer as arrays: `weights`, shape (inputs, outputs), `biases`, shape (outputs,), `stride` as in `LayerFile`.

    A convolution's inputs are (9 * input channels), place by place, so that windows copy in runs.
    """

    stride: int
    weights: Values
    biases: Values


@dataclass(frozen=True, eq=False)
class Network:
    """A network as arrays; `means` and `spreads` are those of its features, shape (features,)."""

    means: NDArray[np.float64]
    spreads: NDArray[np.float64]
    near: tuple[Layer, ...]
    wide: tuple[Layer, ...]
    head: tuple[Layer, ...]


def network_from(file: NetworkFile) -> Network:
    """Return the network that a file describes."""
    return Network(
        np.array(file.means), np.array(file.spreads), *(_layers(part) for part in (file.near, file.wide, file.head))
    )


def is_compatible(file: NetworkFile, features: int) -> bool:
    """Return whether a network is whole and takes that many features and the spectrograms of this version."""
    if not len(file.means) == len(file.spreads) == features:
        return False
    inputs = features
    for layout, layers in ((NEAR, file.near), (WIDE, file.wide)):
        frames, bands, channels = layout.frames, layout.bands, CONTRASTS
        for layer in layers:
            if layer.stride < 1 or not _takes(layer, KERNEL * KERNEL * channels):
                return False
            frames, bands, channels = -(-frames // layer.stride), -(-bands // layer.stride), len(layer.biases)
        inputs += frames * bands * channels
    for layer in file.head:
        if layer.stride or not _takes(layer, inputs):
            return False
        inputs = len(layer.biases)
    return inputs == 1


def network_log_odds(network: Network, rows: NDArray[np.float64], shown: Contrasts) -> NDArray[np.float64]:
    """Return the logarithm of the odds that each candidate is a shot, shape (n,)."""
    log_odds = np.zeros(rows.shape[0])
    for first in range(0, rows.shape[0], _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        log_odds[some] = _log_odds(network, rows[some], Contrasts(shown.near[some], shown.wide[some]))
    return log_odds


def _log_odds(network: Network, rows: NDArray[np.float64], shown: Contrasts) -> NDArray[np.float64]:
    """Return the log-odds of a few candidates, whose windows fit into memory side by side."""
    parts = [_convolved(seen, layers) for seen, layers in ((shown.near, network.near), (shown.wide, network.wide))]
    known = np.clip((rows - network.means) / network.spreads, -FEATURE_LIMIT, FEATURE_LIMIT).astype(np.float32)
    values = np.concatenate([*parts, known], axis=1)
    for layer in network.head[:-1]:
        values = np.maximum(values @ layer.weights + layer.biases, 0.0)
    last = network.head[-1]
    return np.asarray((values @ last.weights + last.biases)[:, 0], np.float64)


def _layers(files: Sequence[LayerFile]) -> tuple[Layer, ...]:
    layers = []
    for file in files:
        weights = np.array(file.weights, np.float32)
        if file.stride:
            places = KERNEL * KERNEL
            weights = np.moveaxis(weights.reshape(-1, places, weights.shape[1]), 0, 1).reshape(weights.shape)
        layers.append(Layer(file.stride, weights, np.array(file.biases, np.float32)))
    return tuple(layers)


def _takes(layer: LayerFile, inputs: int) -> bool:
    return len(layer.weights) == inputs and all(len(row) == len(layer.biases) for row in layer.weights)


def _convolved(values: Values, layers: Sequence[Layer]) -> Values:
    """Return what comes out of the layers for (n, frames, bands, channels), laid flat: (n, values)."""
    for layer in layers:
        values = _convolve(values, layer)
    return values.reshape(values.shape[0], -1)


def _convolve(values: Values, layer: Layer) -> Values:
    """Return what is positive of a 3 x 3 convolution of (n, frames, bands, channels), and 0 for the rest (ReLU).

    It is taken every `stride` places, over zeros at the edges.
    """
    count, frames, bands, channels = values.shape
    padded = np.zeros((count, frames + KERNEL - 1, bands + KERNEL - 1, channels), np.float32)
    padded[:, 1:-1, 1:-1] = values
    frames, bands = -(-frames // layer.stride), -(-bands // layer.stride)
    per_candidate, per_frame, per_band, per_channel = padded.strides
    windows = np.ndarray(
        (count, frames, bands, KERNEL, KERNEL, channels),
        np.float32,
        padded,
        strides=(per_candidate, layer.stride * per_frame, layer.stride * per_band, per_frame, per_band, per_channel),
    )
    convolved = windows.reshape(count * frames * bands, -1) @ layer.weights
    convolved += layer.biases
    return np.maximum(convolved, 0.0, out=convolved).reshape(count, frames, bands, -1)
