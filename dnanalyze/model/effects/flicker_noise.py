"""1/f noise of the readout chain, in the order in which pixels are read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model import pink
from dnanalyze.model.effect import Site, Stage, choice, parameter
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect


@dataclass(frozen=True)
class FlickerNoise(ReadoutEffect):
    """Temporal noise with power f^-alpha, f counted along the raster scan."""

    name: ClassVar[str] = "flicker_noise"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "temporal"
    summary: ClassVar[str] = (
        "1/f noise of the amplifier chain: smooth along the scan, new in every frame."
    )
    physics: ClassVar[str] = (
        "Traps in transistors of the output amplifier capture and release carriers with a "
        "wide range of time constants, which gives noise whose power falls as 1/f^alpha in "
        "time, alpha near 1. Pixels are read row after row, so time runs along the row: "
        "neighbours in a row are correlated, and successive rows drift together as soft "
        "horizontal bands. It depends on the readout, not on exposure, follows the analog "
        "gain and hardly the temperature. Correlated double sampling or a clamp removes the "
        "slow part (`cutoff`); chains for odd and even columns have noise of their own "
        "(`chains`). Remedy: faster double sampling, reference pixels read along with the "
        "image, subtraction of row means of black pixels for the part slower than a row."
    )
    formula: ClassVar[str] = (
        "S(f) = C f^-alpha, f = k/(rows x columns) of the raster; sum of S over f = rms^2; "
        "S = C f_c^-alpha below f_c; with several chains so for each, in its own pixel periods"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Rauscher, Teledyne H1RG, H2RG and H4RG noise generator (NGHXRG), PASP 127, 1144 (2015)",
        "Janesick, Photon Transfer, SPIE Press (2007)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_u_first", "temporal_rows_0_0.02", "temporal_rows_0.02_0.1", "temporal_row_lag1",
        "temporal_u_0_0.03", "temporal_u_0.03_0.1", "temporal_rows_0.1_0.3", "temporal_corr_10",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "row_noise": "rows are independent of each other, and pixels within a row are white",
        "flicker_fpn": "the same in every frame, and as smooth across rows as along them",
        "serial_noise": "rows are independent of each other, whatever the spectrum along them",
        "offset_drift": "whole frames move, nothing within a frame",
        "dark_gradient": "fixed, grows with exposure",
    }

    rms: float = parameter(0.5, "DN", 1e-4, 1e3, "standard deviation over a frame")
    alpha: float = parameter(1.0, "1", 0.3, 2.5, "exponent of the power spectrum", "linear")
    overhead: int = choice(0, "pixel periods between two rows")
    cutoff: float = parameter(
        0.0, "c/px", 0.0, 0.5, "frequency f_c along the raster below which it is white", "linear"
    )
    chains: int = choice(1, "chains that read every so many columns, each with its noise", 1, 2, 4)
    added: str = choice("before", ADDED, "before", "after")

    def inactive_parameters(self) -> tuple[str, ...]:
        """A cutoff that is not there."""
        return ("cutoff",) if self.cutoff == 0.0 else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the noise of this frame."""
        period = site.shape[1] + max(0, int(self.overhead))
        whole = Window(0, site.shape[0], 0, period)
        alpha, cutoff = self.value("alpha", site.point), self.value("cutoff", site.point)

        def made(white: np.ndarray, level: float) -> np.ndarray:
            weights = site.share(
                f"weights {white.size}", lambda: pink.raster_weights(white.size, alpha, cutoff)
            )
            return pink.raster(white, weights, level)

        def make() -> np.ndarray:
            if site.window == whole:
                white = site.normal("raster")
            else:
                white = site.frame_stream.child("raster").normal(whole, period)
            count = self.chains
            levels = site.frame_stream.child("level").normal(Window(0, 1, 0, count), count)[0]
            if count == 1:
                return made(white, float(levels[0]))
            white = np.asarray(white)
            frame = np.empty(white.shape, np.float32)
            for chain in range(count):
                columns = np.s_[:, chain::count]
                frame[columns] = made(white[columns], float(levels[chain]))
            return frame

        rms = np.float32(self.value("rms", site.point) * self.amplified(site))
        signal += rms * site.share(f"raster {site.frame}", make)[site.window.slices]
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """rms^2, DN^2."""
        return self.value("rms", point) ** 2
