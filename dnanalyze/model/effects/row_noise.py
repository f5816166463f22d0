"""Offsets of the rows, new in every frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.fingerprints import LINE_BANDS, named
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect
from dnanalyze.model.serial import averaged, groups, moving_average

# Forms tried where rows are white and level, and columns alike
RELATED = ("serial", 0.2), ("serial", -0.2), ("serial2", 0.2), ("alternating", 0.3), ("tilt", 0.3)
TOGETHER = "1x1", "2x1", "4x1", "8x1", "2x2", "4x2"  # rows of a group x interleaved banks


@dataclass(frozen=True)
class RowNoise(ReadoutEffect):
    """y += r_i of the frame."""

    name: ClassVar[str] = "row_noise"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "Horizontal stripes that change in every frame (banding)."
    physics: ClassVar[str] = (
        "All pixels of a row are sampled at the same instant. A disturbance of the supply, "
        "the ramp or the reference at that instant shifts the whole row; the next row has "
        "another value. Sensors that convert several rows at a time shift these alike "
        "(`together`): neighbours, or every other row where two banks of converters take the rows "
        "in turn. Where even and odd columns have converters of their own, above and below "
        "the field, as they have in many CMOS sensors, a part of it has either sign in turn along "
        "the row (`alternating`). What changes while the row is read tilts it (`tilt`). Rows that "
        "follow each other may share some of a slow disturbance "
        "(`serial`), and rows of the same field of an interlaced readout, or of the same bank of "
        "converters, some of theirs (`serial2`). It is visible to the eye at a tenth of the pixel "
        "noise. It does not grow with temperature or exposure and follows the analog gain. "
        "Averaging K frames lowers its power K times. Remedy: subtract the mean of the row's n "
        "optically black pixels, which leaves 1/n of their noise; quieter supplies."
    )
    formula: ClassVar[str] = (
        "y_ij += sqrt(1 - a) r_i + sqrt(a) (-1)^j s_i + tilt sqrt(3) x_j q_i, x_j from -1 to 1 "
        "along the row;  r_i, s_i, q_i ~ N(0, sigma^2), new in every frame; correlation r_1 with "
        "the row before, r_2 with the one before that, none farther; of n x m rows that are "
        "converted together, i is the number of the group, m floor(i / (n m)) + i mod m"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Wei, Fu, Yang, Huang, A physics-based noise formation model for extreme low-light raw "
        "denoising (ELD), CVPR 2020",
    )
    fingerprint: ClassVar[tuple[str, ...]] = named("temporal_rows", reversed(LINE_BANDS))
    confused_with: ClassVar[dict[str, str]] = {
        "row_fpn": "the same stripes in every frame: they cancel in differences of frames",
        "flicker_noise": "neighbouring rows are correlated (temporal_row_lag1 > 0), and the noise "
        "is also smooth along the row",
        "periodic_pattern": "one line in the spectrum, not all frequencies",
    }

    sigma: float = parameter(0.3, "DN", 1e-4, 1e3, "standard deviation of the row offsets")

    serial: float = parameter(0.0, "1", -0.45, 0.45, "correlation with the row before", "linear")
    serial2: float = parameter(
        0.0, "1", -0.45, 0.45, "correlation with the row before that one", "linear"
    )
    alternating: float = parameter(
        0.0, "1", 0.0, 1.0, "share of the variance with a sign that alternates along the row",
        "linear",
    )  # fmt: skip
    tilt: float = parameter(
        0.0, "1", 0.0, 2.0, "rms of a linear change along the row, over sigma", "linear"
    )
    together: str = choice(
        "1x1", "rows that are converted at a time and share an offset x banks that take rows in "
        "turn: of 4x2 rows 0, 2, 4 and 6 share one, rows 1, 3, 5 and 7 another",
        *TOGETHER,
    )  # fmt: skip
    added: str = choice("before", ADDED, "before", "after")

    def inactive_parameters(self) -> tuple[str, ...]:
        """What is not there: correlations, a sign that alternates, a tilt."""
        names = ("serial", "serial2", "alternating", "tilt")
        return tuple(name for name in names if getattr(self, name) == 0)

    def relatives(self) -> list[Effect]:
        """Rows that are correlated with either neighbour, alternate along the row, or tilt."""
        correlated = self.serial != 0 or self.serial2 != 0
        changes: list[dict[str, Any]] = [
            {n: r}
            for n, r in RELATED
            if getattr(self, n) == 0 and not (correlated and n.startswith("serial"))
        ]
        return [replace(self, **change) for change in changes]

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets."""
        sigma = self.value("sigma", site.point) * self.amplified(site)
        share, tilt = self.value("alternating", site.point), self.value("tilt", site.point)
        signal += np.float32(sigma * math.sqrt(1.0 - share)) * self._offsets("rows", site)
        if share:
            sign = 1 - 2 * (site.column_index % 2).astype(np.float32)
            each = np.float32(sigma * math.sqrt(share)) * self._offsets("alternating", site)
            signal += each * sign
        if tilt:
            place = (2.0 * site.column_index + 1.0) / site.shape[1] - 1.0
            ramp = (sigma * tilt * math.sqrt(3.0) * place).astype(np.float32)
            signal += self._offsets("tilt", site) * ramp
        return signal

    def _offsets(self, name: str, site: Site) -> np.ndarray:
        """Unit offsets of the window's rows, float32, (rows, 1)."""
        stream = site.frame_stream.child(name)
        serial = self.value("serial", site.point), self.value("serial2", site.point)
        if not any(serial) and self.together == TOGETHER[0]:
            return site.rows(stream)[:, None]
        weights = moving_average(*serial) if any(serial) else np.ones(1)
        number = groups(np.arange(site.window.top, site.window.bottom), self.together)
        first = max(0, int(number.min()) - weights.size + 1)
        white = stream.normal(Window(0, 1, first, int(number.max()) + 1), site.shape[0])[0]
        return averaged(white, weights, first == 0)[number - first, None]

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2 (1 + tilt^2), DN^2."""
        return self.value("sigma", point) ** 2 * (1.0 + self.value("tilt", point) ** 2)
