"""The networks that judge candidates, as PyTorch trains them, and their export for `detect.network`.

Every convolution and the first dense layer are batch-normalised while training; the export folds that into the weights.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..detect.contrast import CONTRASTS
from ..detect.network import KERNEL, LayerFile, NetworkFile
from ..detect.spectrogram import NEAR, WIDE, SpectrogramLayout

if TYPE_CHECKING:
    from torch import Tensor, nn


@dataclass(frozen=True)
class Size:
    """Output channels and stride of each convolution over either spectrogram, and the width of the dense layers."""

    near: tuple[tuple[int, int], ...]
    wide: tuple[tuple[int, int], ...]
    hidden: int


SIZES = {
    "small": Size(((16, 1), (24, 2), (48, 2), (48, 2)), ((16, 2), (32, 2), (48, 2), (64, 2)), 96),
    "large": Size(((32, 1), (48, 2), (96, 2), (96, 2)), ((32, 2), (64, 2), (96, 2), (128, 2)), 192),
}


@dataclass(frozen=True, eq=False)
class TorchNetwork:
    """The network while it is trained: the layers over each spectrogram, and those over what comes out of them."""

    near: nn.Sequential
    wide: nn.Sequential
    head: nn.Sequential

    def log_odds(self, near: Tensor, wide: Tensor, rows: Tensor) -> Tensor:
        """Return the log-odds of a shot, shape (n,), of contrasts (n, CONTRASTS, frames, bands) and scaled features."""
        import torch

        seen = [part(contrasts) for part, contrasts in ((self.near, near), (self.wide, wide))]
        flat = [values.permute(0, 2, 3, 1).flatten(1) for values in seen]
        return self.head(torch.cat([*flat, rows], dim=1))[:, 0]

    def parts(self) -> nn.ModuleList:
        """Return everything that is trained."""
        from torch import nn

        return nn.ModuleList([self.near, self.wide, self.head])


def new_network(features: int, dropout: float, size: Size) -> TorchNetwork:
    """Return a network of a size with random weights."""
    from torch import nn

    near, near_values = _convolutions(NEAR, size.near)
    wide, wide_values = _convolutions(WIDE, size.wide)
    head = nn.Sequential(
        nn.Dropout(dropout),
        nn.Linear(near_values + wide_values + features, size.hidden),
        nn.BatchNorm1d(size.hidden),
        nn.ReLU(),
        nn.Dropout(dropout),
        nn.Linear(size.hidden, size.hidden),
        nn.ReLU(),
        nn.Dropout(dropout),
        nn.Linear(size.hidden, 1),
    )
    return TorchNetwork(near, wide, head)


def exported(network: TorchNetwork, means: NDArray[np.float64], spreads: NDArray[np.float64]) -> NetworkFile:
    """Return a trained network as `detect.network` reads it, its numbers to five digits."""
    from torch import nn

    dense = [layer for layer in network.head if isinstance(layer, nn.Linear)]
    norm = next(layer for layer in network.head if isinstance(layer, nn.BatchNorm1d))
    head = [(dense[0].weight, dense[0].bias, norm), (dense[1].weight, dense[1].bias, None)]
    head.append((dense[2].weight, dense[2].bias, None))
    return NetworkFile(
        means=_short(means),
        spreads=_short(spreads),
        near=_convolution_files(network.near),
        wide=_convolution_files(network.wide),
        head=[_layer(0, weight, bias, norm) for weight, bias, norm in head],
    )


def size_of(file: NetworkFile) -> Size:
    """Return the size of a network."""
    near, wide = (tuple((len(layer.biases), layer.stride) for layer in part) for part in (file.near, file.wide))
    return Size(near, wide, len(file.head[0].biases))


def named_size(file: NetworkFile) -> str:
    """Return the name of a network's size; ValueError for one without."""
    size = size_of(file)
    for name, named in SIZES.items():
        if named == size:
            return name
    raise ValueError(f"{size} has no name: expected one of {', '.join(SIZES)}")


def between(before: NetworkFile, after: NetworkFile, share: float) -> NetworkFile:
    """Return the network with a share of the weights after and the rest of those before (Wortsman et al. 2022).

    Both take their features in the same spreads: the one was fine-tuned to become the other.
    """
    parts = ((before.near, after.near), (before.wide, after.wide), (before.head, after.head))
    near, wide, head = ([_layer_between(*pair, share) for pair in zip(*part, strict=True)] for part in parts)
    return NetworkFile(after.means, after.spreads, near, wide, head)


def restored(file: NetworkFile, near: Tensor, wide: Tensor, rows: Tensor, dropout: float) -> TorchNetwork:
    """Return the network that was exported, ready to be fine-tuned: it says what the file's network says.

    What its normalisations take off and give back is what its layers answer to these contrasts and features.
    """
    import torch
    from torch import nn

    size = size_of(file)
    network = new_network(len(file.means), dropout, size)
    network.parts().eval()
    with torch.no_grad():
        seen = []
        for part, layers, shown in ((network.near, file.near, near), (network.wide, file.wide, wide)):
            answers = shown
            for conv, norm, layer in zip(part[::3], part[1::3], layers, strict=True):
                assert isinstance(conv, nn.Conv2d)
                assert isinstance(norm, nn.BatchNorm2d)
                conv.weight.copy_(_weights(layer).view_as(conv.weight))
                answers = torch.relu(_centred(norm, conv(answers), torch.tensor(layer.biases)))
            seen.append(answers.permute(0, 2, 3, 1).flatten(1))
        dense = [layer for layer in network.head if isinstance(layer, nn.Linear)]
        for linear, layer in zip(dense, file.head, strict=True):
            linear.weight.copy_(_weights(layer))
            linear.bias.copy_(torch.tensor(layer.biases))
        norm = next(layer for layer in network.head if isinstance(layer, nn.BatchNorm1d))
        _centred(norm, dense[0](torch.cat([*seen, rows], dim=1)), torch.zeros(size.hidden))
    return network


def _layer_between(before: LayerFile, after: LayerFile, share: float) -> LayerFile:
    weights = (1.0 - share) * np.array(before.weights) + share * np.array(after.weights)
    biases = (1.0 - share) * np.array(before.biases) + share * np.array(after.biases)
    return LayerFile(after.stride, [_short(row) for row in weights], _short(biases))


def _weights(layer: LayerFile) -> Tensor:
    """Return a layer's weights with its outputs first."""
    import torch

    return torch.tensor(layer.weights).T


def _centred(norm: nn.BatchNorm1d | nn.BatchNorm2d, answers: Tensor, biases: Tensor) -> Tensor:
    """Let a normalisation take off and give back what the answers have, then add the biases; return what it says."""
    import torch

    assert norm.running_mean is not None
    assert norm.running_var is not None
    over = (0, 2, 3) if answers.dim() == 4 else (0,)
    norm.running_mean.copy_(answers.mean(over))
    norm.running_var.copy_(answers.var(over))
    norm.weight.copy_(torch.sqrt(norm.running_var + norm.eps))
    norm.bias.copy_(norm.running_mean + biases)
    said: Tensor = norm(answers)
    return said


def _convolutions(layout: SpectrogramLayout, layers: tuple[tuple[int, int], ...]) -> tuple[nn.Sequential, int]:
    """Return the convolutions over a spectrogram's contrasts, and how many values come out of them."""
    from torch import nn

    parts: list[nn.Module] = []
    channels, height, width = CONTRASTS, layout.frames, layout.bands
    for outputs, stride in layers:
        parts += [
            nn.Conv2d(channels, outputs, KERNEL, stride=stride, padding=1, bias=False),
            nn.BatchNorm2d(outputs),
            nn.ReLU(),
        ]
        channels, height, width = outputs, -(-height // stride), -(-width // stride)
    return nn.Sequential(*parts), channels * height * width


def _convolution_files(part: nn.Sequential) -> list[LayerFile]:
    from torch import nn

    layers = list(part)
    return [
        _layer(_stride(conv), conv.weight, None, norm)
        for conv, norm in zip(layers[::3], layers[1::3], strict=True)
        if isinstance(conv, nn.Conv2d) and isinstance(norm, nn.BatchNorm2d)
    ]


def _stride(conv: nn.Conv2d) -> int:
    return int(conv.stride[0])


def _layer(stride: int, weight: Tensor, bias: Tensor | None, norm: nn.BatchNorm1d | nn.BatchNorm2d | None) -> LayerFile:
    """Return a layer with its normalisation folded in: y = g (w x + b - m) / s + c."""
    import torch

    weights = weight.detach().double().flatten(1)
    biases = bias.detach().double() if bias is not None else torch.zeros(weights.shape[0], dtype=torch.float64)
    if norm is not None:
        assert norm.running_var is not None
        assert norm.running_mean is not None
        gain = norm.weight.detach().double() / torch.sqrt(norm.running_var.double() + norm.eps)
        weights = weights * gain[:, None]
        biases = (biases - norm.running_mean.double()) * gain + norm.bias.detach().double()
    rows: list[NDArray[np.float64]] = list(weights.T.numpy())
    return LayerFile(stride, [_short(row) for row in rows], _short(biases.numpy()))


def _short(values: NDArray[np.float64]) -> list[float]:
    return [float(f"{value:.5g}") for value in values.tolist()]
