"""Pixels that give the same code in every frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, parameter
from dnanalyze.model.evidence import bounded, curve, excess, shows, strongest, typical_positive


@dataclass(frozen=True)
class StuckPixels(Effect):
    """y = code at a fixed share of pixels, after rounding."""

    name: ClassVar[str] = "stuck_pixels"
    stage: ClassVar[Stage] = Stage.DIGITAL
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "Dead pixels: one code, always, with no noise at all."
    physics: ClassVar[str] = (
        "A shorted or open pixel gives the same code, commonly the lowest or the highest, in every "
        "frame: its temporal variance is exactly zero, which no working pixel shows unless it is "
        "clipped. It does not depend on temperature, exposure or gain. Cure: a map of defects; "
        "interpolation from the neighbours."
    )
    formula: ClassVar[str] = "y = code on a share 'fraction' of the pixels"
    references: ClassVar[tuple[str, ...]] = ("EMVA 1288 release 4.0 (defect pixels)",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "dead_count", "high_spike", "low_spike", "cold_count_8", "hot_count_128",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "hot_pixels": "noisy, and growing with temperature until they clip",
        "black_clipping": "many pixels at the lowest code, that change from frame to frame",
        "defect_lines": "whole columns or rows, still noisy",
    }

    fraction: float = parameter(1e-4, "1", 1e-7, 0.1, "share of pixels")
    code: float = parameter(0.0, "DN", -1e5, 1e6, "their code", "linear")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Overwrite the stuck pixels."""
        fraction = self.value("fraction", site.point)
        stuck = site.keep("map", lambda: site.fixed_uniform() < fraction)
        signal[stuck] = np.float32(self.value("code", site.point))
        return signal

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """The share from pixels without temporal variance; as code, both ends of what occurs."""
        if not shows(clues, ["dead_count"]):
            return []
        count = typical_positive(excess(clues, "dead_count"))
        fraction = bounded(cls, "fraction", count / (clues.shape[0] * clues.shape[1]))
        codes = curve(clues, "histogram_codes", strongest(clues, ["dead_count"]) or 0)
        ends = (0.0, 4095.0) if codes is None else (float(np.min(codes)), float(np.max(codes)))
        return [cls(fraction, bounded(cls, "code", end)) for end in ends]
