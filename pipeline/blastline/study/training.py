"""Training networks: examples in, a network out, in one of two ways that err differently.

- annealed: the learning rate rises and falls once (Smith & Topin 2017), and the last weights count: surer of what is
  like the lessons.
- averaged: the learning rate is constant, and the mean of the weights over most of the training counts (Izmailov et
  al. 2018; Cha et al. 2021): better on sources never heard.

A network can be fine-tuned: annealed once more on new lessons, at a lower learning rate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..detect.contrast import contrasts
from ..detect.network import FEATURE_LIMIT, NetworkFile
from ..detect.spectrogram import Spectrograms
from .networks import SIZES, TorchNetwork, exported, new_network, restored

if TYPE_CHECKING:
    from torch import Tensor


@dataclass(frozen=True)
class TrainingSettings:
    """How a network is trained, by AdamW.

    Where weights are averaged, the learning rate rises over the share `warm_up` of all steps and stays, and the average
    is taken from the share `averaged_from` on; else it goes one cycle. `tilt` is the spread of how much another
    microphone tilts the levels over all bands, `picture_noise` and `feature_noise` those of the noise that is added.
    """

    epochs: int = 8
    batch: int = 256
    learning_rate: float = 2e-3
    warm_up: float = 0.05
    averaged_from: float = 0.25
    weight_decay: float = 1e-2
    dropout: float = 0.3
    tilt: float = 0.4
    picture_noise: float = 0.1
    feature_noise: float = 0.05


SETTINGS = TrainingSettings()
FINE_TUNING = replace(SETTINGS, epochs=3, learning_rate=1e-3)
"""For networks that know most of it already."""

NORMALISING_BATCHES = 200
TILTED = (1.0, 0.0, 1.0, 0.0)
"""Which contrasts another microphone tilts: the levels."""


@dataclass(frozen=True, eq=False)
class Examples:
    """What networks learn from: spectrograms (half precision, to save memory), features and whether a shot.

    Of n examples: `near` and `wide`, shape (n, frames, bands), `rows`, (n, features), `shots`, (n,).
    """

    near: NDArray[np.float16]
    wide: NDArray[np.float16]
    rows: NDArray[np.float32]
    shots: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Material:
    """The examples as a network takes them: spectrograms still as levels, features in their spreads."""

    near: NDArray[np.float16]
    wide: NDArray[np.float16]
    rows: Tensor
    shots: Tensor

    @property
    def count(self) -> int:
        """Return how many there are."""
        return len(self.shots)

    def seen(self, which: Tensor) -> tuple[Tensor, Tensor]:
        """Return the contrasts of some of them, as a network takes them."""
        import torch

        near, wide = (levels[which.numpy()].astype(np.float32) for levels in (self.near, self.wide))
        seen = contrasts(Spectrograms(near, wide))
        near, wide = (torch.from_numpy(each).permute(0, 3, 1, 2) for each in (seen.near, seen.wide))
        return near, wide

    def drawn(self, which: Tensor, settings: TrainingSettings) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return some of them as a network takes them, with noise and tilts, and their truth."""
        import torch

        near, wide = (_noise_and_tilt(seen, settings) for seen in self.seen(which))
        rows = self.rows[which] + settings.feature_noise * torch.randn(len(which), self.rows.shape[1])
        return near, wide, rows, self.shots[which]


def fit_network(
    examples: Examples, seed: int, *, averaged: bool, size: str = "small", settings: TrainingSettings = SETTINGS
) -> NetworkFile:
    """Return a network trained on the examples; the same seed on the same machine gives the same network."""
    import torch

    torch.manual_seed(seed)
    means = examples.rows.mean(axis=0, dtype=np.float64)
    spreads = examples.rows.std(axis=0, dtype=np.float64) + 1e-6
    network = new_network(examples.rows.shape[1], settings.dropout, SIZES[size])
    material = _material(examples, means, spreads)
    return exported(_trained(network, material, settings, averaged=averaged), means, spreads)


def fine_tune(
    file: NetworkFile, examples: Examples, seed: int, *, settings: TrainingSettings = FINE_TUNING
) -> NetworkFile:
    """Return a network that goes on learning from the examples where it was left, annealed once more."""
    import torch

    torch.manual_seed(seed)
    means, spreads = np.array(file.means), np.array(file.spreads)
    material = _material(examples, means, spreads)
    some = torch.randperm(material.count)[: NORMALISING_BATCHES * settings.batch // 4]
    network = restored(file, *material.seen(some), material.rows[some], settings.dropout)
    return exported(_trained(network, material, settings, averaged=False), means, spreads)


def _material(examples: Examples, means: NDArray[np.float64], spreads: NDArray[np.float64]) -> Material:
    import torch

    limited = np.clip((examples.rows - means) / spreads, -FEATURE_LIMIT, FEATURE_LIMIT).astype(np.float32)
    return Material(
        near=examples.near,
        wide=examples.wide,
        rows=torch.from_numpy(limited),
        shots=torch.from_numpy(examples.shots.astype(np.float32)),
    )


def _trained(network: TorchNetwork, material: Material, settings: TrainingSettings, *, averaged: bool) -> TorchNetwork:
    """Return the network after training, or one with the mean of the weights it had from a share of the steps on."""
    import torch
    from torch import nn
    from torch.optim.swa_utils import AveragedModel

    batches = max(1, material.count // settings.batch)
    steps, rate = settings.epochs * batches, settings.learning_rate
    network.parts().to(memory_format=torch.channels_last)  # twice as fast on a processor
    optimiser = torch.optim.AdamW(network.parts().parameters(), lr=rate, weight_decay=settings.weight_decay)
    schedule: torch.optim.lr_scheduler.LRScheduler
    if averaged:
        warm_up = max(1, round(settings.warm_up * steps))
        schedule = torch.optim.lr_scheduler.LambdaLR(optimiser, lambda step: min(1.0, (step + 1) / warm_up))
    else:
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=steps + 1)
    average = AveragedModel(network.parts())
    network.parts().train()
    for step in range(steps):
        if step % batches == 0:
            order = torch.randperm(material.count)[: batches * settings.batch].chunk(batches)
        near, wide, rows, shots = material.drawn(order[step % batches], settings)
        loss = nn.functional.binary_cross_entropy_with_logits(network.log_odds(near, wide, rows), shots)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
        if averaged and step >= settings.averaged_from * steps:
            average.update_parameters(network.parts())
    if averaged:
        return _normalised(TorchNetwork(*average.module.children()), material, settings)
    network.parts().eval()
    return network


def _normalised(network: TorchNetwork, material: Material, settings: TrainingSettings) -> TorchNetwork:
    """Return a network whose normalisations know what its own layers give: only the weights were averaged."""
    import torch
    from torch import nn

    for layer in network.parts().modules():
        if isinstance(layer, nn.BatchNorm1d | nn.BatchNorm2d):
            layer.reset_running_stats()
            layer.momentum = None  # the plain mean of all batches
    network.parts().train()
    with torch.no_grad():
        for some in torch.randperm(material.count).split(settings.batch)[:NORMALISING_BATCHES]:
            network.log_odds(*material.drawn(some, settings)[:3])
    network.parts().eval()
    return network


def _noise_and_tilt(seen: Tensor, settings: TrainingSettings) -> Tensor:
    """Return contrasts with some noise, half of them as another microphone would hear them: their levels tilted.

    What a band rises or decays by, no microphone changes.
    """
    import torch

    count, contrasts, frames, bands = seen.shape
    tilt = torch.linspace(-0.5, 0.5, bands) * torch.randn(count, 1, 1, 1) * settings.tilt
    tilted = tilt * (torch.rand(count, 1, 1, 1) < 0.5) * torch.tensor(TILTED)[:, None, None]
    noise = torch.randn(count, frames, bands, contrasts).permute(0, 3, 1, 2)  # drawn as it lies: eight times as fast
    return seen + tilted + settings.picture_noise * noise
