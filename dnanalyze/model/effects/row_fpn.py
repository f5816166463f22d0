"""Fixed offsets of the rows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import hints
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, parameter
from dnanalyze.model.evidence import (
    LINE_BANDS,
    bounded,
    excess,
    line_sigma,
    named,
    shows,
    typical,
)

SHORT = 0.1  # share of the longest exposure up to which a ramp is not that of the dark current
CLEAR = 8.0  # standard errors of a slope


@dataclass(frozen=True)
class RowFpn(Effect):
    """y += r_i + a ramp from the first row to the last, the same in every frame."""

    name: ClassVar[str] = "row_fpn"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "Fixed horizontal stripes: every row has its own offset."
    physics: ClassVar[str] = (
        "Rows are addressed one after the other. A row whose drivers, supply or timing differ a "
        "little from those of the others gets the same offset in every frame. Being made at "
        "readout, it does not grow with temperature or exposure; it follows the analogue gain. "
        "In a full-frame CCD the rows that are read last have waited longest, and collected dark "
        "current meanwhile: a ramp (`ramp`) that is there without any exposure and grows with "
        "temperature alone. Cure: subtract the mean of the row's optically black pixels (which "
        "also removes row noise), or a master dark."
    )
    formula: ClassVar[str] = (
        "y_ij += r_i + a e^(-Ea/k (1/T - 1/T_ref)) i / rows;  r_i ~ N(0, sigma^2), once for the "
        "sensor"
    )
    references: ClassVar[tuple[str, ...]] = ("EMVA 1288 release 4.0 (DSNU1288.row)",)
    fingerprint: ClassVar[tuple[str, ...]] = named("pattern_rows", reversed(LINE_BANDS))
    confused_with: ClassVar[dict[str, str]] = {
        "row_noise": "new in every frame: it shows in differences of frames, and a mean over K "
        "frames keeps only 1/K of its power",
        "dark_gradient": "power below .02 cycles/pixel alone, that grows with exposure",
        "defect_lines": "a few rows far off the others",
    }

    sigma: float = parameter(0.3, "DN", 1e-4, 1e3, "standard deviation of the row offsets")
    ramp: float = parameter(
        0.0, "DN", -1e4, 1e4, "level a of the last row over the first", "linear"
    )
    ea_ev: float = parameter(0.63, "eV", 0.0, 1.6, "activation energy of the ramp", "linear")

    def idle(self) -> tuple[str, ...]:
        """The ramp where there is none."""
        return ("ramp", "ea_ev") if self.ramp == 0.0 else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets."""
        sigma = self.value("sigma", site.point) * site.gain_ratio
        signal += np.float32(sigma) * site.rows(site.silicon.child("rows"))[:, None]
        if self.ramp != 0.0:
            height = self.value("ramp", site.point) * site.thermal(self.value("ea_ev", site.point))
            share = (site.row_index / site.shape[0]).astype(np.float32)
            signal += (np.float32(height * site.gain_ratio) * share)[:, None]
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2; a ramp adds a^2 / 12."""
        return self.value("sigma", point) ** 2

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Sigma from the unexplained power of the u = 0 axis of the pattern; a ramp from the slope
        of the row means at the shortest exposures.
        """
        if not shows(clues, cls.fingerprint):
            return []
        found: list[Effect] = [
            cls(bounded(cls, "sigma", line_sigma(clues, "pattern_rows", clues.shape[1])))
        ]
        ramp = _ramp(clues)
        if ramp is not None:
            high = excess(clues, "pattern_rows_0.3_0.5")
            sigma = math.sqrt(max(typical(high), 0.0) / clues.shape[1])
            found.append(cls(bounded(cls, "sigma", sigma), *ramp))
        return found


def _ramp(clues: Clues) -> tuple[float, float] | None:
    """Height (DN at the reference) and activation energy of a ramp; None where none stands out."""
    known = [p.exposure_s for p in clues.points if p.exposure_s is not None]
    limit = SHORT * max(known) if known else math.inf
    if known and min(known) > limit:
        limit = min(known)
    heights = np.full(len(clues.points), np.nan)
    for i, point in enumerate(clues.points):
        places, means = clues.lines("rows", i)
        if means.size < 16 or (point.exposure_s or 0.0) > limit:
            continue
        x = places - places.mean()
        slope = float(x @ means / (x @ x))
        rest = means - means.mean() - slope * x
        error = math.sqrt(float(rest @ rest) / means.size / float(x @ x))
        if abs(slope) > CLEAR * error:
            heights[i] = slope * clues.field[0]
    if not np.isfinite(heights).any():
        return None
    sign = math.copysign(1.0, float(np.nansum(heights)))
    fitted = hints.thermal_fit(clues, sign * heights / hints.gains(clues), 0.63)
    if fitted is None:
        return None
    return sign * bounded(RowFpn, "ramp", fitted[0]), fitted[1]
