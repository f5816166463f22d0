"""Pixels without dark charge that are read like all others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter


@dataclass(frozen=True)
class DeadPixels(Effect):
    """h = 0 at a fixed share of the pixels, independent of each other."""

    name: ClassVar[str] = "dead_pixels"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "single pixels without dark charge, with the usual read noise"
    physics: ClassVar[str] = (
        "A pixel whose photodiode or transfer gate is disconnected delivers no charge: neither "
        "dark signal nor its shot noise. Its readout works, so that it has the offset and the read "
        "noise of the others. It lies below the median by the whole dark signal, hence is "
        "invisible at low temperature and short exposure, and stands out the more the larger "
        "the dark signal is over its own spread. Remedy: a map of defect pixels, made from warm "
        "or illuminated frames; interpolation from the neighbours."
    )
    formula: ClassVar[str] = "h_ij = 0 on a share 'fraction' of the pixels, fixed in the silicon"
    references: ClassVar[tuple[str, ...]] = (
        "EMVA 1288 release 4.0 (defect pixels)",
        "Janesick, Scientific Charge-Coupled Devices, SPIE Press (2001)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "cold_count_5", "cold_count_8", "pattern_q0.001", "pattern_q0.01",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "stuck_pixels": "the same code in every frame, without read noise, cold or warm",
        "scaled_lines": "whole lines without dark charge, not single pixels",
        "dark_current_fpn": "a normal distribution of all pixels, not a separate population",
    }

    fraction: float = parameter(1e-3, "1", 1e-7, 0.1, "share of pixels")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Take the dark charge of these pixels away."""
        signal *= site.keep("map", lambda: self._alive(site))
        return signal

    def _alive(self, site: Site) -> np.ndarray:
        return site.fixed_uniform() >= np.float32(self.value("fraction", site.point))

    def variance(self, point: OperatingPoint) -> float | None:
        """None: a share of a signal that is not known here."""
        return None
