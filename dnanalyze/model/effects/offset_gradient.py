"""A slow change of the offset over the field, without charge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Site, Stage, choice, parameter
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect
from dnanalyze.model.surface import TERMS, low_order, median_of


@dataclass(frozen=True)
class OffsetGradient(ReadoutEffect):
    """y += a low-order surface in Legendre polynomials of unit rms, in every frame."""

    name: ClassVar[str] = "offset_gradient"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "Offset that changes slowly over the field, the same in every frame."
    physics: ClassVar[str] = (
        "Supply and reference voltages drop along their lines over the chip, clocks are "
        "delayed with the distance from their drivers, and amplifiers settle over a line or a "
        "frame. The black level then has a linear or quadratic component over the field. It "
        "arises in the readout: it is the same at every temperature and exposure, has no shot "
        "noise, and is proportional to the analog gain. A gradient of the dark current grows "
        "with temperature and exposure and has shot noise. The offset gradient raises the "
        "spectrum below 0.01 cycles/pixel only. Remedies: subtract a bias frame, or row and "
        "column references of optically black pixels."
    )
    formula: ClassVar[str] = (
        "y += a_x P1(x) + a_y P1(y) + a_xx P2(x) + a_yy P2(y) + a_xy P1(x) P1(y), x and y from -1 "
        "(left, top) to 1, P1 = sqrt(3) x, P2 = sqrt(5)(3 x^2 - 1)/2"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Janesick, Scientific Charge-Coupled Devices, SPIE Press (2001) (bias structure)",
        "EMVA Standard 1288, release 4.0",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "shading_0_1",
        "shading_1_0",
        "shading_0_2",
        "shading_2_0",
        "shading_1_1",
        "pattern_psd_0_0.01",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "dark_gradient": "a surface of charge grows with temperature or exposure and has shot "
        "noise",
        "flicker_fpn": "a random low-frequency field has orders above 2 as well (shading_mid)",
        "amp_glow": "fades from one corner or edge, and grows with exposure",
    }

    x: float = parameter(0.0, "DN", -1e5, 1e5, "tilt along a row, rms over the field", "linear")
    y: float = parameter(0.0, "DN", -1e5, 1e5, "tilt along a column, rms over the field", "linear")
    xx: float = parameter(0.0, "DN", -1e5, 1e5, "bowl along a row, rms over the field", "linear")
    yy: float = parameter(0.0, "DN", -1e5, 1e5, "bowl along a column, rms over the field", "linear")
    xy: float = parameter(
        0.0, "DN", -1e5, 1e5, "twist of the corners, rms over the field", "linear"
    )
    added: str = choice("before", ADDED, "before", "after")

    def inactive_parameters(self) -> tuple[str, ...]:
        """Terms that are 0 beside others: half a field does not hold them apart."""
        unused = tuple(n for n in TERMS if getattr(self, n) == 0.0)
        return unused if len(unused) < len(TERMS) else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the surface."""
        signal += site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        surface = low_order([self.value(name, site.point) for name in TERMS], site)
        return (self.amplified(site) * surface).astype(np.float32)

    def black_shift(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> float:
        """Median of the surface; a bowl has more of its area below its mean, or above."""
        terms = [self.value(name, point) for name in TERMS]
        return self.amplification(point, reference) * median_of(terms)

    def variance(self, point: OperatingPoint) -> float:
        """Over the field, DN^2: the sum of the squares of the coefficients."""
        return sum(self.value(n, point) ** 2 for n in TERMS)
