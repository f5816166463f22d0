"""A smooth random shading of the dark current."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import Window
from dnanalyze.model import pink
from dnanalyze.model.effect import Effect, Site, Stage, parameter

# Points of the grid along the longer side. Of 6,000 pixels what is finer than the grid has 1/1000
# of the variance at alpha 3, and 1/5 at alpha 2.
CELLS = 1024


@dataclass(frozen=True)
class DarkShading(Effect):
    """h (1 + rms f), f a random field of the silicon of power rho^-alpha, zero mean, unit rms."""

    name: ClassVar[str] = "dark_shading"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "dark current that varies slowly and at random over the field"
    physics: ClassVar[str] = (
        "Doping, implant dose, thickness after thinning, stress and passivation vary slowly "
        "and irregularly over a die, and the dark current of every pixel varies with them by "
        "some percent. The result is a smooth random factor of the dark charge, the same in "
        "every frame. The shading is proportional to the dark signal at every exposure and "
        "temperature. Shot noise and the standard deviation over the pixels are larger where "
        "the signal is larger. The power falls steeply with spatial frequency (exponent 2 to "
        "4), so block means show the shading and differences of neighbouring pixels hardly "
        "do. The mean dark signal does not change. Remedies: subtract a dark frame scaled to "
        "exposure and temperature; a map of the dark current."
    )
    formula: ClassVar[str] = (
        "h (1 + rms f); power of f over twice the field C rho^-alpha, rho in cycles/pixel; over "
        "the field mean of f 0, mean of f^2 1; 1 + rms f not below 0; fields of more than 1024 "
        "pixels a side: on a grid of so many points, linear between them"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0 (DSNU)",
        "Baer, A model for dark current characterization and simulation, SPIE 6068 (2006)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "pattern_psd_0_0.01",
        "pattern_psd_0.01_0.02",
        "shading_mid",
        "shading_0_1",
        "shading_1_0",
        "shading_1_1",
        "noise_shading_1_0",
        "noise_shading_0_1",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "dark_gradient": "a temperature map has the orders 1 and 2 alone (shading_mid)",
        "flicker_fpn": "a low-frequency offset does not grow with the dark signal",
        "amp_glow": "fades from one corner or edge, and hardly grows with temperature",
    }

    rms: float = parameter(
        0.1, "1", 1e-3, 0.5, "standard deviation over the field, as a share of the dark signal"
    )
    alpha: float = parameter(3.0, "1", 1.0, 4.0, "exponent of the power spectrum", "linear")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Scale the dark charge."""
        signal *= site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        grid, cell = site.share("field", lambda: self._grid(site)), _cell(site.shape)
        field = _between(grid, site.window, cell) if cell > 1 else grid[site.window.slices]
        factor = 1.0 + self.value("rms", site.point) * field
        return np.maximum(factor, 0.0).astype(np.float32)

    def _grid(self, site: Site) -> np.ndarray:
        """Cut from twice the field: opposite borders of a die have nothing to do with each other,
        those of a periodic field meet.
        """
        cell = _cell(site.shape)
        rows, columns = (math.ceil(n / cell) + int(cell > 1) for n in site.shape)
        whole = Window.whole((2 * rows, 2 * columns))
        white = site.fixed_stream.child("field").normal(whole, 2 * columns)
        clouds = pink.field(white, self.value("alpha", site.point))[:rows, :columns]
        clouds = clouds.astype(np.float64)
        clouds -= clouds.mean()
        clouds /= clouds.std()
        return clouds.astype(np.float32)


def _cell(shape: tuple[int, int]) -> int:
    """Pixels between two points of the grid."""
    return math.ceil(max(shape) / CELLS)


def _between(grid: np.ndarray, window: Window, cell: int) -> np.ndarray:
    """The grid at the pixels of a window, linear between its points."""
    found = grid
    for first, end in ((window.top, window.bottom), (window.left, window.right)):
        below, share = np.divmod(np.arange(first, end), cell)
        weight = (share / cell).astype(np.float32)[:, None]
        found = ((1.0 - weight) * found[below] + weight * found[below + 1]).T
    return found
