"""Charge that is left behind on its way through a CCD and comes with later pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter

TAIL_LENGTHS = 5.0  # tail lengths after which the rest of a tail, 0.7 %, is put into its last pixel
TOWARDS = {"down": (0, 1), "up": (0, -1), "right": (1, 1), "left": (1, -1)}  # axis, sign


@dataclass(frozen=True)
class TransferTails(Effect):
    """y_n = (1 - l_n) x_n + (1 - a) sum over k of a^(k-1) l_(n-k) x_(n-k), a = e^(-1/tau)."""

    name: ClassVar[str] = "transfer_tails"
    stage: ClassVar[Stage] = Stage.COUPLING
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.SOMEWHERE
    summary: ClassVar[str] = "tails of deferred charge behind bright pixels of a CCD"
    physics: ClassVar[str] = (
        "In a CCD the charge packets are transferred from pixel to pixel to the output. "
        "Traps, which radiation damage multiplies, capture a share of each packet and release "
        "it some transfers later. This deferred charge is read with the following pixels. "
        "Hot pixels, tracks and sources then have a tail on one side, along the columns "
        "(parallel transfer) or the rows (serial transfer), which fades exponentially. The "
        "shot noise is deferred with the charge, so the temporal noise of neighbours along "
        "this axis is correlated; read noise is not. Charge far from the output takes more "
        "transfers: its share is proportional to their number (`growth`), unless the charge is "
        "left behind in the output register or its amplifier. Remedies: a "
        "background of charge that keeps the traps full, slower or faster clocks, annealing, "
        "a correction by the known tail."
    )
    formula: ClassVar[str] = (
        "y_n = (1 - l_n) x_n + (1 - a) (l_(n-1) x_(n-1) + a l_(n-2) x_(n-2) + ...), "
        "a = e^(-1/tau), n from 0 to N - 1 in the direction of the tail; l_n = l, or "
        "2 l (n + 1/2) / N, at most 1; no charge comes from outside of the field"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Janesick, Scientific Charge-Coupled Devices, SPIE Press (2001)",
        "Massey et al., Pixel-based correction for charge transfer inefficiency, MNRAS 401 (2010)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_corr_01",
        "temporal_corr_10",
        "pattern_corr_01",
        "pattern_corr_10",
        "temporal_row_lag1",
        "temporal_column_lag1",
        "hot_halo",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "crosstalk": "crosstalk goes to all four sides, deferred charge to one",
        "read_noise": (
            "correlated read noise occurs in frames without dark charge as well, and does not "
            "change the fixed pattern"
        ),
        "hot_clusters": "clusters have no preferred direction, and their noise is uncorrelated",
    }

    loss: float = parameter(
        0.05, "1", 1e-4, 0.6, "share l of a pixel's charge that is deferred, mean over the field"
    )
    tau: float = parameter(1.0, "pixel", 0.1, 12.0, "length of the tail: a = e^(-1/tau)")
    towards: str = choice("down", "side of a pixel on which its tail lies", *TOWARDS)
    growth: str = choice(
        "none", "of the share: none, or with the number of transfers", "none", "transfers"
    )

    def margin(self) -> int:
        """Pixels of a tail."""
        longest = max(getattr(self.tau, "values", None) or (getattr(self.tau, "value", self.tau),))
        return math.ceil(TAIL_LENGTHS * longest)

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Defer the charge; the sum runs in one order everywhere, so windows agree."""
        loss, tau = (self.value(name, site.point) for name in ("loss", "tau"))
        axis, sign = TOWARDS[self.towards]
        # the tail runs along the first axis, from first to last
        source = np.moveaxis(signal, axis, 0)[::sign]
        lost = self._share(loss, site)[::sign, None] * source
        moved = source - lost
        weights = deferred(tau, math.ceil(TAIL_LENGTHS * tau))
        for lag, weight in enumerate(weights[: len(source) - 1], start=1):
            moved[lag:] += np.float32(weight) * lost[:-lag]
        return np.ascontiguousarray(np.moveaxis(moved[::sign], 0, axis))

    def _share(self, loss: float, site: Site) -> np.ndarray:
        """Share of the charge of each row, or column, of the window that is deferred."""
        axis, sign = TOWARDS[self.towards]
        index = (site.row_index, site.column_index)[axis]
        count = site.shape[axis]
        transfers = index + 0.5 if sign > 0 else count - 0.5 - index
        growing = 2.0 * transfers / count if self.growth == "transfers" else np.ones(index.size)
        return np.minimum(loss * growing, 1.0).astype(np.float32)


def deferred(tau: float, count: int) -> np.ndarray:
    """Shares of the deferred charge in the ``count`` pixels behind; their sum is 1."""
    fade = math.exp(-1.0 / tau)
    shares: np.ndarray = (1.0 - fade) * fade ** np.arange(count)
    shares[-1] += fade**count
    return shares
