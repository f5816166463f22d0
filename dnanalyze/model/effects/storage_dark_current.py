"""Dark charge that the storage nodes collect while rows wait to be read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import ndtri

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.model.gamma import gamma_deviates
from dnanalyze.model.laws import TableLaw
from dnanalyze.thermal import arrhenius

GRID = 64  # points over the rows and over the pixels of a row
HALF = 0.5  # of the pixel offsets of a fit without this effect: where one with it begins


@dataclass(frozen=True)
class StorageDarkCurrent(Effect):
    """h += w (b + u) x; u from 0, the row read first, to 1; x over the pixels, with mean 1."""

    name: ClassVar[str] = "storage_dark_current"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "dark charge of the storage nodes, growing until the row is read"
    physics: ClassVar[str] = (
        "The pixels of a global-shutter CMOS sensor end their exposure together and hold their "
        "charge in a storage node until their row is read. The node has a dark current of its "
        "own, which differs from pixel to pixel (log-normal, or with the gamma law of few "
        "generation centers): level, scatter of the pixels and shot noise grow "
        "from the row read first to the row read last, the level and the standard deviation in "
        "proportion to the wait. The charge does not depend on the exposure; it grows with "
        "temperature, and with the readout time, such as by a slower pixel clock. In the shortest "
        "frames it is most of the fixed pattern, skewed to the bright side. Remedies: faster "
        "readout, cooling, subtraction of a dark frame of the same clock."
    )
    formula: ClassVar[str] = (
        "h_i += w e^(-Ea/k (1/T - 1/T_ref)) (b + u_i) e^(s n_i - s^2/2), u = i / rows from the row "
        "read first, n ~ N(0,1) fixed in the silicon; law gamma: Gamma deviates of the same mean "
        "and variance in place of e^(s n_i - s^2/2)"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0 (DSNU, row profiles)",
        "Meynants et al., IISW (2011) (storage nodes of global-shutter pixels)",
        "Janesick, Photon Transfer, SPIE Press (2007) (dark charge during readout)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "scatter_shading_0_1",
        "shading_0_1",
        "pattern_q0.99",
        "pattern_q0.999",
        "pattern_rows_0_0.02",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "dark_gradient": "a gradient of the dark current grows in proportion to the exposure; the "
        "ramp of a CCD's readout is the same in all pixels of a row",
        "pixel_fpn": "offsets scatter alike in all rows, and symmetrically",
        "row_fpn": "row offsets vary from one row to the next and are the same in all pixels",
        "offset_gradient": "an offset surface has no scatter from pixel to pixel",
    }

    amplitude: float = parameter(
        1.0, "DN", 1e-3, 1e5, "mean signal from the readout of the first row to that of the last"
    )
    spread: float = parameter(
        0.8, "1", 0.0, 2.0, "standard deviation s over the pixels of ln(signal)", "linear"
    )
    before: float = parameter(
        0.0, "1", 0.0, 50.0, "wait of the row read first, over that from the first to the last",
        "linear",
    )  # fmt: skip
    ea_ev: float = parameter(0.63, "eV", 0.0, 1.6, "activation energy", "linear")
    first: str = choice("top", "row that is read first", "top", "bottom")

    law: str = choice("log-normal", "distribution over the pixels", "log-normal", "gamma")

    def inactive_parameters(self) -> tuple[str, ...]:
        """The energy of an amplitude that is stated for each operating point."""
        return ("ea_ev",) if isinstance(self.amplitude, TableLaw) else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the charge."""
        signal += site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        rows = site.shape[0]
        read = site.row_index if self.first == "top" else rows - 1 - site.row_index
        growth = site.thermal(self.value("ea_ev", site.point)) * site.gain_ratio
        height = self.value("amplitude", site.point) * growth
        wait = (height * (self.value("before", site.point) + read / rows)).astype(np.float32)
        return wait[:, None] * self._uneven(site)

    def _uneven(self, site: Site) -> np.ndarray:
        """Charge of each pixel over the mean of its row, float32."""
        return self._relative(site.fixed_normal(), self.value("spread", site.point))

    def _relative(self, normal: np.ndarray, spread: float) -> np.ndarray:
        """Charge over its mean from standard normal deviates, float32."""
        if self.law == "gamma" and spread > 0.0:
            return gamma_deviates(normal, math.sqrt(math.expm1(spread**2)))
        single = np.float32(spread)
        return np.asarray(np.exp(single * (normal - single / 2)), np.float32)

    def variance(self, point: OperatingPoint) -> float:
        """w^2 (e^(s^2) (b^2 + b + 1/3) - (b + 1/2)^2), DN^2, at the reference temperature and gain;
        that of many rows.
        """
        w, s, b = (self.value(name, point) for name in ("amplitude", "spread", "before"))
        return w * w * (math.exp(s * s) * (b * b + b + 1.0 / 3.0) - (b + 0.5) ** 2)

    def black_shift(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> float:
        """Median of the charge, from `GRID` rows with as many pixels each."""
        w, s, b, energy = (
            self.value(name, point) for name in ("amplitude", "spread", "before", "ea_ev")
        )
        growth = arrhenius(point.temperature_c, reference.temperature_c, energy)
        share = (np.arange(GRID) + 0.5) / GRID
        charge = np.multiply.outer(b + share, self._relative(np.asarray(ndtri(share)), s))
        return w * growth * point.gain_over(reference) * float(np.median(charge))

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """The black level holds the median of the charge, the pixel offsets part of its scatter."""
        numbers = (self.amplitude, self.spread, self.before)
        w, s, b = (x if isinstance(x, (int, float)) else 0.0 for x in numbers)
        if name == "pedestal":
            return 1.0, -w * (b + 0.5) * math.exp(-s * s / 2)
        return (HALF if name == "pixel_fpn.sigma" else 1.0), 0.0
