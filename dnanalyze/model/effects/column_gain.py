"""Gain that differs from column to column."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter
from dnanalyze.model.fingerprints import LINE_BANDS, named


@dataclass(frozen=True)
class ColumnGain(Effect):
    """y -> y (1 + g_j) on the signal above black, the same in every frame."""

    name: ClassVar[str] = "column_gain"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = (
        "Vertical stripes that grow with the signal: column amplifiers differ in gain."
    )
    physics: ClassVar[str] = (
        "The capacitor ratios and ramp slopes of column amplifiers and converters differ by parts "
        "per thousand. In a dark frame the signal is the dark current, so the stripes are nearly "
        "absent when cold or short and grow in proportion to the dark signal, with its temperature "
        "and exposure law. Remedy: a flat-field correction by column; an offset correction alone "
        "does not help."
    )
    formula: ClassVar[str] = "y_ij -> y_ij (1 + g_j);  g_j ~ N(0, sigma^2), once for the sensor"
    references: ClassVar[tuple[str, ...]] = (
        "El Gamal, Fowler, Min, Liu, Modeling and estimation of FPN components in CMOS image "
        "sensors, SPIE 3301 (1998)",
        "EMVA 1288 release 4.0 (PRNU1288.col)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = named("pattern_columns", reversed(LINE_BANDS))
    confused_with: ClassVar[dict[str, str]] = {
        "scaled_lines": "a few lines far off the others, not a normal distribution of all",
        "column_fpn": "stripes of the same strength at every temperature and exposure",
        "dark_gradient": "also grows with the signal, but is smooth: power below 0.02 cycles/pixel",
    }

    sigma: float = parameter(2e-3, "1", 1e-6, 0.5, "standard deviation of the relative gain")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Multiply every column."""
        gain = site.columns(site.fixed_stream.child("columns"))
        signal *= 1 + np.float32(self.value("sigma", site.point)) * gain
        return signal
