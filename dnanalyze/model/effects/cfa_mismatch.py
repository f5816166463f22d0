"""Offsets of the four pixels of the 2x2 block of a mosaic."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Site, Stage, parameter
from dnanalyze.model.laws import scaled


@dataclass(frozen=True)
class CfaMismatch(Effect):
    """y += u (-1)^j + v (-1)^i + uv (-1)^(i+j)."""

    name: ClassVar[str] = "cfa_mismatch"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "The four colours of a mosaic have different black levels."
    physics: ClassVar[str] = (
        "In a mosaic sensor, pixels of the 2x2 block often go through different circuits (two "
        "or four share an amplifier, greens of even and odd rows go to different outputs), "
        "or a camera subtracts a slightly wrong black level for each colour. Analysed as one "
        "plane, the four offsets are three exact lines in the spectrum at (1/2,0), (0,1/2) "
        "and (1/2,1/2). They are fixed, do not grow with exposure, and follow the analog "
        "gain. Remedy: a black level for each colour; analyse the planes apart by stating the "
        "colour filter."
    )
    formula: ClassVar[str] = "y_ij += u (-1)^j + v (-1)^i + w (-1)^(i+j);  variance u^2 + v^2 + w^2"
    references: ClassVar[tuple[str, ...]] = ()
    fingerprint: ClassVar[tuple[str, ...]] = (
        "pattern_nyquist_11", "pattern_nyquist_10", "pattern_nyquist_01", "column_periodic_2",
        "row_periodic_2",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "column_taps": "odd and even columns alone have a line at (1/2,0) and none at (1/2,1/2)",
        "periodic_pattern": "a line at any other frequency, or with a new phase in every frame",
        "row_fpn": "rows without a period of two",
    }

    u: float = parameter(0.3, "DN", -1e3, 1e3, "half the step from odd to even columns", "signed")
    v: float = parameter(0.3, "DN", -1e3, 1e3, "half the step from odd to even rows", "signed")
    uv: float = parameter(0.3, "DN", -1e3, 1e3, "half the step between the diagonals", "signed")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets of the block."""
        signal += site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        u, v, uv = (
            np.float32(self.value(n, site.point) * site.gain_ratio) for n in ("u", "v", "uv")
        )
        column = (1 - 2 * (site.column_index % 2)).astype(np.float32)
        row = (1 - 2 * (site.row_index % 2)).astype(np.float32)
        return (u * column)[None, :] + np.outer(row, v + uv * column)

    def variance(self, point: OperatingPoint) -> float:
        """u^2 + v^2 + uv^2, DN^2."""
        return sum(self.value(n, point) ** 2 for n in ("u", "v", "uv"))

    def relatives(self) -> list[Effect]:
        """The other diagonal: the sign of uv shows in ranks among neighbours alone."""
        return [replace(self, uv=scaled(self.uv, -1.0))]  # type: ignore[arg-type]
