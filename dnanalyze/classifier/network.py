"""A small convolutional network as the classifier (extra ``torch``)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from dnanalyze.classifier.training import Score
from dnanalyze.classifier.views import Samples
from dnanalyze.errors import InputError

WIDTH, EPOCHS, BATCH = 16, 12, 64  # channels, passes, patches a step


def convolutional(measured: Samples, simulated: Samples, seed: int) -> Score:
    """Three convolutions, the mean and the maximum over the patch; higher scores look measured.

    Raises
    ------
    InputError
        torch is not installed.
    """
    try:
        import torch
    except ImportError:
        raise InputError("network=True needs torch: pip install torch") from None
    scales = [float(np.std(p)) or 1.0 for p in simulated.patches.values()]

    def tensor(samples: Samples) -> Any:
        parts = [p / s for p, s in zip(samples.patches.values(), scales, strict=True)]
        # A hot pixel is as told at 5 standard deviations as at 500, which would rule the weights.
        return torch.from_numpy(np.arcsinh(np.stack(parts, axis=1)).astype(np.float32))

    draw = torch.Generator().manual_seed(seed)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = _network(torch, len(scales))
    inputs = torch.cat((tensor(measured), tensor(simulated)))
    labels = torch.cat((torch.ones(len(measured.regular)), torch.zeros(len(simulated.regular))))
    steps = torch.optim.AdamW(network.parameters(), lr=3e-3, weight_decay=1e-2)
    loss = torch.nn.BCEWithLogitsLoss()
    for _ in range(EPOCHS):
        for chosen in torch.randperm(len(inputs), generator=draw).split(BATCH):
            steps.zero_grad()
            loss(network(inputs[chosen]), labels[chosen]).backward()
            steps.step()
    network.eval()

    def score(samples: Samples) -> np.ndarray:
        with torch.no_grad():
            return np.asarray(network(tensor(samples)).numpy(), float)

    return score


def _network(torch: Any, channels: int) -> Any:
    """The layers; the sign of a patch and its position in it do not matter to the pooling."""
    nn = torch.nn

    class Network(nn.Module):  # type: ignore[name-defined]
        """Convolutions, pooling, one linear layer."""

        def __init__(self) -> None:
            super().__init__()
            widths = (channels, WIDTH, WIDTH, WIDTH)
            layers: list[Any] = []
            for before, after in pairwise(widths):
                layers += [nn.Conv2d(before, after, 3, padding=1), nn.BatchNorm2d(after), nn.SiLU()]
            self.layers = nn.Sequential(*layers)
            self.last = nn.Linear(3 * WIDTH, 1)

        def forward(self, patches: Any) -> Any:
            """Logit of each patch."""
            made = self.layers(patches)
            square = (made**2).mean(dim=(2, 3))
            pooled = torch.cat((made.mean(dim=(2, 3)), made.amax(dim=(2, 3)), square), dim=1)
            return self.last(pooled)[:, 0]

    return Network()
