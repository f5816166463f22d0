"""Pixels that give the same code in every frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter


@dataclass(frozen=True)
class StuckPixels(Effect):
    """y = code at a fixed share of pixels and on whole lines, after rounding.

    Pixels have one code for all, or any from 0 on; lines have the code itself.
    """

    name: ClassVar[str] = "stuck_pixels"
    stage: ClassVar[Stage] = Stage.DIGITAL
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "Defect pixels with the same code in every frame, without noise."
    physics: ClassVar[str] = (
        "A shorted or open pixel gives the same code in every frame, commonly the lowest or the "
        "highest, at times one between (`codes`): its temporal variance is exactly zero, which no "
        "working pixel shows unless it is clipped. It does not depend on temperature, exposure or "
        "gain. A short of a column line, of its converter or of a row driver saturates a whole "
        "line in the same way (`columns`, `rows`). Remedy: a map of defects; interpolation from "
        "the neighbours."
    )
    formula: ClassVar[str] = (
        "y = c on a share 'fraction' of the pixels; codes 'one': c = code; 'any': a third each at "
        "0, at code, and uniform between; and c = code on the columns and rows named"
    )
    references: ClassVar[tuple[str, ...]] = ("EMVA 1288 release 4.0 (defect pixels)",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "dead_count", "high_spike", "low_spike", "cold_count_8", "hot_count_128",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "dead_pixels": "at the black level, with the usual read noise",
        "hot_pixels": "noisy, and growing with temperature until they clip",
        "black_clipping": "many pixels at the lowest code, that change from frame to frame",
        "defect_lines": "whole columns or rows, still noisy; a saturated one never changes",
    }

    fraction: float = parameter(1e-4, "1", 1e-7, 0.1, "share of pixels")
    code: float = parameter(0.0, "DN", -1e5, 1e6, "their code, or the highest of them", "held")
    codes: str = choice("one", "whether all are stuck at one code", "one", "any")
    columns: tuple[float, ...] = choice((), "numbers of whole columns at the code, as measured")
    rows: tuple[float, ...] = choice((), "numbers of whole rows at the code, as measured")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Overwrite the stuck pixels."""
        rows, columns, codes = site.keep("map", lambda: self._map(site))
        signal[rows, columns] = codes
        return signal

    def _map(self, site: Site) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows and columns in the window, and codes."""
        top = self.value("code", site.point)
        rows, columns = np.nonzero(site.fixed_uniform() < self.value("fraction", site.point))
        codes = np.full(rows.size, top, np.float32)
        if self.codes == "any":
            index = (site.window.top + rows) * site.shape[1] + site.window.left + columns
            share = 3.0 * site.fixed_stream.child("code").uniform_at(index)
            drawn = np.where(share < 1.0, 0.0, np.where(share < 2.0, 1.0, share - 2.0))
            codes = np.rint(top * drawn).astype(np.float32)
        if not (self.columns or self.rows):
            return rows, columns, codes
        named = np.isin(site.row_index, self.rows)[:, None] | np.isin(
            site.column_index, self.columns
        )
        along, across = np.nonzero(named)
        free = ~named[rows, columns]
        return (
            np.concatenate([rows[free], along]),
            np.concatenate([columns[free], across]),
            np.concatenate([codes[free], np.full(along.size, top, np.float32)]),
        )
