"""A slow change of the dark signal over the field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import hints
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, parameter
from dnanalyze.model.evidence import SIGN, curve

TERMS = ("x", "y", "xx", "yy")


@dataclass(frozen=True)
class DarkGradient(Effect):
    """h += a low-order surface, in Legendre polynomials of unit rms over the field."""

    name: ClassVar[str] = "dark_gradient"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "dark signal that changes slowly over the field: a temperature map"
    physics: ClassVar[str] = (
        "The die is warmer near its readout and power circuits, and the dark current maps that: "
        "a difference of one degree changes it by some ten percent. The result is a smooth tilt "
        "or bowl, the same in every frame, proportional to exposure and growing with temperature "
        "like the dark current. (A leak of light is as smooth but does not grow with "
        "temperature: activation energy 0.) It raises the spectrum below .01 cycles/pixel only. "
        "Remedies: even cooling, dark-frame subtraction, row and column references."
    )
    formula: ClassVar[str] = (
        "h += t/t_ref e^(-Ea/k (1/T - 1/T_ref)) [a_x P1(x) + a_y P1(y) + a_xx P2(x) + a_yy "
        "P2(y)], x and y from -1 (left, top) to 1, P1 = sqrt(3) x, P2 = sqrt(5)(3 x^2 - 1)/2"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0",
        "Rauscher, NGHXRG (picture-frame pattern)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "shading_0_1",
        "shading_1_0",
        "shading_0_2",
        "shading_2_0",
        "pattern_psd_0_0.01",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "amp_glow": "a glow fades from one corner or edge and hardly depends on temperature",
        "flicker_fpn": "a random low-frequency field has orders above 2 as well (shading_mid)",
        "column_fpn": "column offsets vary from one column to the next",
    }

    x: float = parameter(0.0, "DN", -1e5, 1e5, "tilt along a row, rms over the field", "linear")
    y: float = parameter(0.0, "DN", -1e5, 1e5, "tilt along a column, rms over the field", "linear")
    xx: float = parameter(0.0, "DN", -1e5, 1e5, "bowl along a row, rms over the field", "linear")
    yy: float = parameter(0.0, "DN", -1e5, 1e5, "bowl along a column, rms over the field", "linear")
    ea_ev: float = parameter(0.63, "eV", 0.0, 1.6, "activation energy", "linear")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the surface."""
        signal += site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        growth = (
            site.thermal(self.value("ea_ev", site.point)) * site.exposure_ratio * site.gain_ratio
        )
        p, q = legendre(site.column_index, site.shape[1])
        along_row = self.value("x", site.point) * p + self.value("xx", site.point) * q
        p, q = legendre(site.row_index, site.shape[0])
        along_column = self.value("y", site.point) * p + self.value("yy", site.point) * q
        return (growth * (along_column[:, None] + along_row[None, :])).astype(np.float32)

    def variance(self, point: OperatingPoint) -> float:
        """Over the field, DN^2, at the reference: the sum of the squares of the coefficients."""
        return sum(self.value(n, point) ** 2 for n in TERMS)

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Least squares on the block means; their growth gives the activation energy."""
        names = ("shading_0_1", "shading_1_0", "shading_0_2", "shading_2_0", "shading_1_1")
        seen = np.array([np.abs(np.nan_to_num(clues.z(name))) for name in names])
        if not (seen > SIGN).any():
            return []
        growth = hints.exposure_and_gain(clues)
        fits = np.full((len(growth), 4), np.nan)
        for j in range(len(growth)):
            blocks = curve(clues, "block_means", j)
            if blocks is not None and min(blocks.shape) >= 3:
                fits[j] = surface(blocks) / growth[j]
        size = np.sqrt((fits**2).sum(1))
        fitted = hints.thermal_fit(clues, size, 0.63)
        if fitted is None:
            return []
        height, ea = fitted
        best = int(np.nanargmax(np.where(np.isfinite(size), (seen**2).sum(0), -1)))
        values = dict(zip(TERMS, fits[best] / size[best] * height, strict=True))
        return [cls(**hints.clip(cls, **values, ea_ev=ea))]


def legendre(index: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """First and second Legendre polynomial of unit rms at the pixel centres of ``size`` pixels."""
    x = (2.0 * np.asarray(index) + 1.0) / size - 1.0
    return np.sqrt(3.0) * x, np.sqrt(5.0) * (1.5 * x * x - 0.5)


def surface(blocks: np.ndarray) -> np.ndarray:
    """Coefficients x, y, xx, yy (DN rms) of the surface closest to the block means."""
    rows, columns = blocks.shape
    px, qx = legendre(np.arange(columns), columns)
    py, qy = legendre(np.arange(rows), rows)
    one_r, one_c = np.ones(rows), np.ones(columns)
    basis = [
        np.outer(one_r, one_c), np.outer(one_r, px), np.outer(py, one_c),
        np.outer(one_r, qx), np.outer(qy, one_c),
    ]  # fmt: skip
    design = np.stack([b.ravel() for b in basis], 1)
    return np.linalg.lstsq(design, blocks.ravel(), rcond=None)[0][1:]
