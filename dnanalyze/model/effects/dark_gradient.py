"""A slow change of the dark signal over the field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.model.surface import TERMS, low_order
from dnanalyze.thermal import arrhenius


@dataclass(frozen=True)
class DarkGradient(Effect):
    """h += a low-order surface, or h (1 + surface), in Legendre polynomials of unit rms.

    And a ramp over the rows, of charge collected while they wait to be read.
    """

    name: ClassVar[str] = "dark_gradient"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "dark signal that changes slowly over the field: a temperature map"
    physics: ClassVar[str] = (
        "The die is warmer near its readout and power circuits, and the dark current follows "
        "the temperature: a difference of one degree changes it by some ten percent. The "
        "result is a smooth tilt or bowl, the same in every frame, proportional to exposure "
        "and growing with temperature like the dark current. (A leak of light is as smooth "
        "but does not grow with temperature: activation energy 0.) It raises the spectrum "
        "below 0.01 cycles/pixel only, and where it scales the dark current of every pixel "
        "(`form`: scaled), the scatter of the pixels and the shot noise as well. In a CCD the "
        "rows that are read last wait longest and collect dark charge meanwhile (`wait`): a "
        "ramp that is there without any exposure and grows with temperature alone, with the "
        "shot noise of its charge. Remedies: even cooling, dark-frame subtraction, row and "
        "column references."
    )
    formula: ClassVar[str] = (
        "h += t/t_ref e^(-Ea/k (1/T - 1/T_ref)) [a_x P1(x) + a_y P1(y) + a_xx P2(x) + a_yy "
        "P2(y) + a_xy P1(x) P1(y)], x and y from -1 (left, top) to 1, P1 = sqrt(3) x, P2 = "
        "sqrt(5)(3 x^2 - 1)/2; scaled: h (1 + a_x P1(x) + ...); h += w e^(-Ea/k (1/T - 1/T_ref)) "
        "i / rows, for w < 0 from the last row up"
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
        "dark_shading": "random shading has orders above 2 as well (shading_mid)",
        "flicker_fpn": "a random low-frequency field has orders above 2 as well (shading_mid)",
        "column_fpn": "column offsets vary from one column to the next",
        "row_fpn": "row offsets vary from one row to the next, and have no shot noise",
        "storage_dark_current": "the charge of storage nodes differs from pixel to pixel, and is "
        "there without any exposure",
        "offset_gradient": "an offset surface does not grow with temperature or exposure, and has "
        "no shot noise",
    }

    x: float = parameter(0.0, "DN", -1e5, 1e5, "tilt along a row, rms over the field", "linear")
    y: float = parameter(0.0, "DN", -1e5, 1e5, "tilt along a column, rms over the field", "linear")
    xx: float = parameter(0.0, "DN", -1e5, 1e5, "bowl along a row, rms over the field", "linear")
    yy: float = parameter(0.0, "DN", -1e5, 1e5, "bowl along a column, rms over the field", "linear")
    ea_ev: float = parameter(0.63, "eV", 0.0, 1.6, "activation energy", "linear")
    xy: float = parameter(
        0.0, "DN", -1e5, 1e5, "twist of the corners, rms over the field", "linear"
    )
    form: str = choice(
        "added",
        ("added to the dark signal, or a share of it (dimensionless coefficients)"),
        "added",
        "scaled",
    )
    wait: float = parameter(
        0.0, "DN", -1e5, 1e5, "dark signal of the row that is read last, at any exposure", "linear"
    )

    def inactive_parameters(self) -> tuple[str, ...]:
        """What is 0 beside others: half a field does not hold them apart. And the energy of a share
        of the dark signal, which grows as that does.
        """
        used = [n for n in (*TERMS, "wait") if getattr(self, n) != 0.0] or list(TERMS)
        grows = self.form == "added" or "wait" in used
        return tuple(n for n in (*TERMS, "wait") if n not in used) + (() if grows else ("ea_ev",))

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the surface, or scale by it."""
        surface = site.keep("map", lambda: self._map(site))
        if self.form == "scaled":
            signal *= surface
        else:
            signal += surface
        if self.wait != 0.0:
            signal += site.keep("waiting", lambda: self._waiting(site))[:, None]
        return signal

    def _waiting(self, site: Site) -> np.ndarray:
        height = self.value("wait", site.point) * site.thermal(self.value("ea_ev", site.point))
        share = site.row_index / site.shape[0] - (height < 0)
        return (height * site.gain_ratio * share).astype(np.float32)

    def _map(self, site: Site) -> np.ndarray:
        surface = low_order([self.value(name, site.point) for name in TERMS], site)
        if self.form == "scaled":
            return np.maximum(1.0 + surface, 0.0).astype(np.float32)
        growth = site.thermal(self.value("ea_ev", site.point))
        return (growth * site.exposure_ratio * site.gain_ratio * surface).astype(np.float32)

    def black_shift(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> float:
        """Charge of the middle row of the ramp."""
        energy = self.value("ea_ev", point)
        growth = arrhenius(point.temperature_c, reference.temperature_c, energy)
        return abs(self.value("wait", point)) / 2.0 * growth * point.gain_over(reference)

    def variance(self, point: OperatingPoint) -> float | None:
        """Over the field, DN^2, at the reference: the sum of the squares of the coefficients."""
        if self.form == "scaled" or self.wait != 0.0:
            return None  # a share of a signal that is not known here; a ramp beside a tilt
        return sum(self.value(n, point) ** 2 for n in TERMS)
