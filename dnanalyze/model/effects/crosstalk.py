"""Charge or voltage shared with the neighbouring pixels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model import draws
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter


@dataclass(frozen=True)
class Crosstalk(Effect):
    """Each pixel gives a share alpha to each edge neighbour and beta to each diagonal one.

    Along rows and columns the share may differ.
    """

    name: ClassVar[str] = "crosstalk"
    stage: ClassVar[Stage] = Stage.COUPLING
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = (
        "each pixel passes a share of its signal to its neighbours (IPC, diffusion)"
    )
    physics: ClassVar[str] = (
        "Neighbouring pixels are coupled by stray capacitance (interpixel capacitance, IPC) or "
        "by diffusion of charge, so a fixed share of each pixel's signal appears in its "
        "neighbours, before the readout adds its noise. Along rows and columns it may differ, as "
        "the wiring does. The share does not depend on amplitude, "
        "temperature or exposure. Dark current and its shot noise become correlated (correlation "
        "about 2 alpha), each hot pixel gains a halo of the same relative height, and the "
        "spectrum falls towards high frequency, down to a plateau when all noise is dark noise; "
        "read noise, added later, stays white. It lowers the apparent shot noise, so gain from "
        "photon transfer comes out too small unless the covariances of neighbours count."
    )
    formula: ClassVar[str] = (
        "y = k * h, k = alpha (1 + a) on the neighbours in the row, alpha (1 - a) on those in the "
        "column, a = anisotropy, beta = diagonal x alpha on the 4 diagonal ones, centre 1 - 4 "
        "alpha - 4 beta; K(u,v) = 1 - 4(alpha+beta) + 2 alpha ((1 + a) cos 2 pi u + (1 - a) cos 2 "
        "pi v) + 4 beta cos 2 pi u cos 2 pi v"
    )
    references: ClassVar[tuple[str, ...]] = ("EMVA Standard 1288, release 4.0",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_corr_10",
        "temporal_corr_01",
        "hot_halo",
        "pattern_corr_10",
        "pattern_corr_01",
        "temporal_corr_11",
        "pattern_corr_11",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "transfer_tails": "deferred charge goes to one side alone",
        "convolved_lognormal": (
            "the kernel of Wang 2025 distributes the fixed pattern only; crosstalk the shot noise "
            "too"
        ),
        "denoise": (
            "a filter after the readout correlates the read noise too, and the most when cold"
        ),
        "dpc": "a correction changes only pixels that stand out",
    }
    reach: ClassVar[int] = 1

    alpha: float = parameter(2e-3, "1", 1e-6, 0.12, "mean share given to each edge neighbour")
    diagonal: float = parameter(0.25, "1", 0.0, 1.0, "diagonal share over alpha", "linear")
    anisotropy: float = parameter(
        0.0, "1", -1.0, 1.0, "shares in the row less those in the column, over their sum", "linear"
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Convolve with the 3x3 kernel; the frame's outer rows and columns are repeated."""
        alpha, point = self.value("alpha", site.point), site.point
        return draws.share_with_neighbours(
            signal,
            alpha,
            alpha * self.value("diagonal", point),
            alpha * self.value("anisotropy", point),
        )
