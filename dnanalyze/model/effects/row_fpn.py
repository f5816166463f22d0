"""Fixed offsets of the rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Site, Stage, choice, parameter
from dnanalyze.model.fingerprints import LINE_BANDS, named
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect


@dataclass(frozen=True)
class RowFpn(ReadoutEffect):
    """y += r_i, the same in every frame."""

    name: ClassVar[str] = "row_fpn"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "Fixed horizontal stripes: every row has its own offset."
    physics: ClassVar[str] = (
        "Rows are addressed one after the other. A row whose drivers, supply or timing differ a "
        "little from those of the others gets the same offset in every frame. Being made at "
        "readout, it does not grow with temperature or exposure; it follows the analog gain. "
        "Remedy: subtract the mean of the row's optically black pixels (which also removes row "
        "noise), or a master dark."
    )
    formula: ClassVar[str] = "y_ij += r_i;  r_i ~ N(0, sigma^2), once for the sensor"
    references: ClassVar[tuple[str, ...]] = ("EMVA 1288 release 4.0 (DSNU1288.row)",)
    fingerprint: ClassVar[tuple[str, ...]] = named("pattern_rows", reversed(LINE_BANDS))
    confused_with: ClassVar[dict[str, str]] = {
        "row_noise": "new in every frame: it shows in differences of frames, and a mean over K "
        "frames keeps only 1/K of its power",
        "dark_gradient": "power below 0.02 cycles/pixel alone, that grows with exposure or, of "
        "rows that wait to be read, with temperature",
        "defect_lines": "a few rows far off the others",
    }

    sigma: float = parameter(0.3, "DN", 1e-4, 1e3, "standard deviation of the row offsets")
    added: str = choice("before", ADDED, "before", "after")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets."""
        sigma = self.value("sigma", site.point) * self.amplified(site)
        signal += np.float32(sigma) * site.rows(site.fixed_stream.child("rows"))[:, None]
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2."""
        return self.value("sigma", point) ** 2
