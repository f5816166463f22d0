"""A fixed Gaussian offset of each pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter


@dataclass(frozen=True)
class PixelFpn(Effect):
    """y += sigma n_i, the same in every frame."""

    name: ClassVar[str] = "pixel_fpn"
    stage: ClassVar[Stage] = Stage.PIXEL_READ
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "fixed offset of each pixel, the same in every frame"
    physics: ClassVar[str] = (
        "Transistor thresholds differ from pixel to pixel, and correlated double sampling "
        "leaves a part of the difference: an offset that is the same in every frame. It is "
        "white over the field and symmetric and does not grow with exposure or temperature; "
        "averaging frames does not reduce it. It scales with the analog gain, but for what is "
        "added after it (`converter`), which captures of two gains tell apart. It dominates the "
        "fixed pattern at the lowest temperature and the shortest exposure. Subtracting a "
        "master bias frame removes it."
    )
    formula: ClassVar[str] = (
        "y_i += G sigma n_i + c m_i, G the analog gain over that of the reference; n_i, m_i ~ "
        "N(0,1) fixed in the silicon"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0",
        "El Gamal et al., SPIE 3301 (1998)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "pattern_noise_core",
        "pattern_q0.01",
        "pattern_q0.1",
        "pattern_psd_0.25_0.35",
        "frame_noise_core",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "convolved_lognormal": (
            "the standard deviation of the dark current grows with temperature and exposure and is "
            "skewed"
        ),
        "storage_dark_current": "the charge of storage nodes scatters more from row to row, and is "
        "skewed",
        "column_fpn": "column offsets put their power on the v = 0 axis",
        "read_noise": "read noise is new in every frame",
    }

    sigma: float = parameter(1.0, "DN", 1e-3, 1e4, "standard deviation at the reference gain")

    converter: float = parameter(
        0.0, "DN", 0.0, 1e4, "standard deviation of what is added after the analog gain", "linear"
    )

    def inactive_parameters(self) -> tuple[str, ...]:
        """What is added after the gain, where captures of one gain do not tell it."""
        return ("converter",) if self.converter == 0 else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets."""
        sigma = np.float32(self.value("sigma", site.point) * site.gain_ratio)
        converter = np.float32(self.value("converter", site.point))

        def offsets() -> np.ndarray:
            own = sigma * site.fixed_normal()
            return own + converter * site.fixed_normal("converter") if converter else own

        signal += site.keep("map", offsets)
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """Of both sources, DN^2, at the reference gain."""
        return self.value("sigma", point) ** 2 + self.value("converter", point) ** 2

    def adds(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> tuple[float, float]:
        """The variance at the gain of a point."""
        own = self.value("sigma", point) * point.gain_over(reference)
        return 0.0, own**2 + self.value("converter", point) ** 2
