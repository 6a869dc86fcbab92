"""Teaching networks: examples in, a network out, in one of two ways that err differently.

- annealed: the pace rises and falls once (Smith & Topin 2017), and the last weights count: surer of what is like the
  lessons.
- averaged: at a constant pace, and the average of the weights over most of the training counts (Izmailov et al. 2018;
  Cha et al. 2021): better on sources never heard.

An annealed network can be taught further, by new lessons at a slower pace.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..detect.contrast import contrasts
from ..detect.network import FEATURE_LIMIT, NetworkFile
from ..detect.spectrogram import Spectrograms
from .networks import SIZES, Judge, exported, new_judge, restored

if TYPE_CHECKING:
    from torch import Tensor

SETTINGS: dict[str, Any] = {
    "epochs": 8,
    "batch": 256,
    "learning_rate": 2e-3,
    "warm_up": 0.05,
    "averaged_from": 0.25,
    "weight_decay": 1e-2,
    "dropout": 0.3,
    "tilt": 0.4,
    "picture_noise": 0.1,
    "feature_noise": 0.05,
}
FURTHER: dict[str, Any] = SETTINGS | {"epochs": 3, "learning_rate": 1e-3}
"""For networks that know most of it already."""

NORMALISING_BATCHES = 200
TILTED = (1.0, 0.0, 1.0, 0.0)
"""Which contrasts another microphone tilts: the levels."""


@dataclass(frozen=True, eq=False)
class Examples:
    """What networks learn from: spectrograms (half precision, to save memory), features and whether a shot."""

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
        """Return the contrasts of some of them, as a judge takes them."""
        import torch

        near, wide = (levels[which.numpy()].astype(np.float32) for levels in (self.near, self.wide))
        seen = contrasts(Spectrograms(near, wide))
        near, wide = (torch.from_numpy(each).permute(0, 3, 1, 2) for each in (seen.near, seen.wide))
        return near, wide

    def drawn(self, which: Tensor, settings: dict[str, Any]) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return some of them as a judge takes them, coloured, and their truth."""
        import torch

        near, wide = (_coloured(seen, settings) for seen in self.seen(which))
        rows = self.rows[which] + settings["feature_noise"] * torch.randn(len(which), self.rows.shape[1])
        return near, wide, rows, self.shots[which]


def fit_network(
    examples: Examples, seed: int, *, averaged: bool, size: str = "small", settings: dict[str, Any] = SETTINGS
) -> NetworkFile:
    """Return a network trained on the examples; the same seed on the same machine gives the same network."""
    import torch

    torch.manual_seed(seed)
    means = examples.rows.mean(axis=0, dtype=np.float64)
    spreads = examples.rows.std(axis=0, dtype=np.float64) + 1e-6
    judge = new_judge(examples.rows.shape[1], settings["dropout"], SIZES[size])
    material = _material(examples, means, spreads)
    return exported(_taught(judge, material, settings, averaged=averaged), means, spreads)


def teach_further(
    network: NetworkFile, examples: Examples, seed: int, *, settings: dict[str, Any] = FURTHER
) -> NetworkFile:
    """Return a network that goes on learning from the examples, where it was left, annealed once more."""
    import torch

    torch.manual_seed(seed)
    means, spreads = np.array(network.means), np.array(network.spreads)
    material = _material(examples, means, spreads)
    some = torch.randperm(material.count)[: NORMALISING_BATCHES * settings["batch"] // 4]
    judge = restored(network, *material.seen(some), material.rows[some], settings["dropout"])
    return exported(_taught(judge, material, settings, averaged=False), means, spreads)


def _material(examples: Examples, means: NDArray[np.float64], spreads: NDArray[np.float64]) -> Material:
    import torch

    limited = np.clip((examples.rows - means) / spreads, -FEATURE_LIMIT, FEATURE_LIMIT).astype(np.float32)
    return Material(
        near=examples.near,
        wide=examples.wide,
        rows=torch.from_numpy(limited),
        shots=torch.from_numpy(examples.shots.astype(np.float32)),
    )


def _taught(judge: Judge, material: Material, settings: dict[str, Any], *, averaged: bool) -> Judge:
    """Return the judge after its lessons, or one with the average of the weights it had from a share of them on."""
    import torch
    from torch import nn
    from torch.optim.swa_utils import AveragedModel

    batches = max(1, material.count // settings["batch"])
    steps, rate = settings["epochs"] * batches, settings["learning_rate"]
    judge.parts().to(memory_format=torch.channels_last)  # twice as fast on a processor
    optimiser = torch.optim.AdamW(judge.parts().parameters(), lr=rate, weight_decay=settings["weight_decay"])
    pace: torch.optim.lr_scheduler.LRScheduler
    if averaged:
        warm_up = max(1, round(settings["warm_up"] * steps))
        pace = torch.optim.lr_scheduler.LambdaLR(optimiser, lambda step: min(1.0, (step + 1) / warm_up))
    else:
        pace = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=steps + 1)
    average = AveragedModel(judge.parts())
    judge.parts().train()
    for step in range(steps):
        if step % batches == 0:
            order = torch.randperm(material.count)[: batches * settings["batch"]].chunk(batches)
        near, wide, rows, shots = material.drawn(order[step % batches], settings)
        loss = nn.functional.binary_cross_entropy_with_logits(judge.odds(near, wide, rows), shots)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        pace.step()
        if averaged and step >= settings["averaged_from"] * steps:
            average.update_parameters(judge.parts())
    if averaged:
        return _normalised(Judge(*average.module.children()), material, settings)
    judge.parts().eval()
    return judge


def _normalised(judge: Judge, material: Material, settings: dict[str, Any]) -> Judge:
    """Return a judge whose normalisations know what its own layers give: weights were averaged, not what they see."""
    import torch
    from torch import nn

    for layer in judge.parts().modules():
        if isinstance(layer, nn.BatchNorm1d | nn.BatchNorm2d):
            layer.reset_running_stats()
            layer.momentum = None  # the plain mean of all batches
    judge.parts().train()
    with torch.no_grad():
        for some in torch.randperm(material.count).split(settings["batch"])[:NORMALISING_BATCHES]:
            judge.odds(*material.drawn(some, settings)[:3])
    judge.parts().eval()
    return judge


def _coloured(seen: Tensor, settings: dict[str, Any]) -> Tensor:
    """Return contrasts with some noise, half of them as another microphone would hear them: their levels tilted.

    What a band rises or decays by, no microphone changes.
    """
    import torch

    count, contrasts, frames, bands = seen.shape
    tilt = torch.linspace(-0.5, 0.5, bands) * torch.randn(count, 1, 1, 1) * settings["tilt"]
    tilted = tilt * (torch.rand(count, 1, 1, 1) < 0.5) * torch.tensor(TILTED)[:, None, None]
    noise = torch.randn(count, frames, bands, contrasts).permute(0, 3, 1, 2)  # drawn as it lies: eight times as fast
    return seen + tilted + settings["picture_noise"] * noise
