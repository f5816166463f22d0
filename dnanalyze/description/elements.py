"""Values of elements: diagonals, blocks of pixels or a diagonal of them, quadrants and halves.

Pixels that share a value are told by one analysis of variance, whatever their geometry: the means
of the elements scatter by A^2 beyond what the pixels within an element let them scatter.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from dnanalyze.description.blocks import block_form
from dnanalyze.description.found import Estimate, Sizes, distribution, random_size, random_sizes
from dnanalyze.description.layers import GRID, Layer, Layers, coarse, together
from dnanalyze.model.composite.effect import CompositeEffect

LEAST_PIXELS = 8  # of a diagonal: shorter ones lie in the corners


@dataclass(frozen=True)
class Elements:
    """Which pixels share a value."""

    words: dict[str, Any]  # of the composite effect
    number: np.ndarray  # (rows, columns), the element of each pixel; -1 for those that have none

    @cached_property
    def used(self) -> np.ndarray:
        """Pixels that belong to an element, (rows, columns)."""
        return self.number >= 0

    @cached_property
    def count(self) -> np.ndarray:
        """Pixels of each element, (elements,)."""
        return np.bincount(self._index)

    @cached_property
    def _index(self) -> np.ndarray:
        """Elements from 0 on without a gap, one a used pixel."""
        return np.unique(self.number[self.used], return_inverse=True)[1]

    @cached_property
    def _mean(self) -> sparse.csr_array:
        """From used pixels to means of elements, (pixels, elements)."""
        pixels = np.arange(self._index.size)
        return sparse.csr_array((1.0 / self.count[self._index], (pixels, self._index)))

    def analysed(self, maps: np.ndarray) -> tuple[np.ndarray, float]:
        """Means of elements less those of the maps, and the variance of a pixel within its element.

        ``maps``: (maps, rows, columns); the means are (maps, elements).
        """
        pixels = maps[:, self.used]
        means = pixels @ self._mean - pixels.mean(axis=1, keepdims=True, dtype=float)
        apart = float(pixels.var(axis=1).mean()) * self._index.size
        apart -= float(np.mean(means**2 @ self.count))
        return means, apart / max(self._index.size - self.count.size, 1)


def fixed_elements(seen: Layers, maps: list[Layer], growth: np.ndarray) -> Iterator[Estimate]:
    """Diagonals, blocks, quadrants and halves that the maps may show."""
    layer = together(maps, growth)
    alone, *without = (replace(m, map=_without_lines(m.map)) for m in (layer, *maps))
    for slant in ("down", "up"):
        yield _fixed(_diagonals(seen, slant), without, alone, 2)
    form = block_form(seen, layer.map)
    if form is not None:
        yield _fixed(_blocks(seen, *form), maps, layer, 5)
    if min(seen.window.shape) >= 4 * GRID and seen.whole:
        for steps in ("rows", "columns", "quadrants"):
            yield _steps(seen, maps, layer, steps)


def changing_elements(seen: Layers) -> Iterator[Estimate]:
    """Blocks, diagonals of 2 x 2 pixels, quadrants and halves that draw anew in every frame."""
    form = block_form(seen, np.concatenate([t.temporal / np.float32(t.noise) for t in seen.taken]))
    if form is not None:
        yield _changing(seen, _blocks(seen, *form), 5)
    for mask in ("diagonal", "antidiagonal"):
        pairs = [_blocks(seen, 2, 2, top, left, mask) for top, left in np.ndindex(2, 2)]
        cuts = [_changing(seen, pair, 5) for pair in pairs]
        best = max(cuts, key=lambda e: e.explained)
        # what all cuts share is no pair
        yield replace(best, explained=2 * best.explained - sum(e.explained for e in cuts))
    if min(seen.window.shape) >= 4 * GRID and seen.whole:
        y, x = (_second_half(seen, axis) for axis in (0, 1))
        of_frame = {
            "rows": {"where": "halves", "axis": "rows"},
            "columns": {"where": "halves", "axis": "columns"},
            "both": {"where": "quadrants"},
        }
        numbers = {"rows": y + 0 * x, "columns": x + 0 * y, "both": 2 * y + x}
        for name, words in of_frame.items():
            yield _changing(seen, Elements(words, numbers[name]), 1 + len(seen.taken))


def _fixed(elements: Elements, maps: list[Layer], layer: Layer, numbers: int) -> Estimate:
    """A value of every element, the same in all frames and, but for the law, at all points."""
    means, _ = elements.analysed(np.stack([layer.map, *(m.map / m.kept for m in maps)]))
    *_, gain = random_size(means[0], 1.0 / elements.count)
    found = []
    for m, of_point in zip(maps, means[1:], strict=True):
        chance = m.scatter / m.kept**2 / elements.count
        size, error, _ = random_size(of_point, chance)
        # without what another draw of the values would add: they are the same at all points
        draw = 2.0 * size**2 / chance.size
        least = 2.0 * float(np.mean(chance)) ** 2 / chance.size
        found.append((size, math.sqrt(max(error**2 - draw, least))))
    sizes, errors = np.array(found).T
    count = elements.count.size
    return Estimate(
        CompositeEffect(**elements.words), {}, gain, numbers * math.log(count),
        Sizes(sizes, errors, squares=True), elements=count,
    )  # fmt: skip


def _changing(seen: Layers, elements: Elements, numbers: int) -> Estimate:
    """A value of every element, new in every frame."""
    count = elements.count.size
    free = (count - 1.0) / count  # the mean of a frame is no element's
    series, chance = [], []
    for taken in seen.taken:
        means, within = elements.analysed(taken.temporal)
        series.append(means / math.sqrt(free))
        chance.append(within * float(np.mean(1.0 / elements.count)))
    sizes, gain = random_sizes(series, chance)
    sizes = replace(sizes, errors=sizes.errors / math.sqrt(free))
    values = distribution(series) if count == 2 else "normal"
    effect = CompositeEffect(when="frame", distribution=values, **elements.words)
    price = numbers * math.log(sum(s.size for s in series))
    return Estimate(effect, {}, free * gain, price, sizes)


def _diagonals(seen: Layers, slant: str) -> Elements:
    number = seen.row - seen.column if slant == "down" else seen.row + seen.column
    number = number - number.min()
    long = np.bincount(number.ravel()) >= LEAST_PIXELS
    return Elements({"where": "diagonal", "slant": slant}, np.where(long[number], number, -1))


def _blocks(
    seen: Layers, height: int, width: int, top: int, left: int, mask: str = "all"
) -> Elements:
    """Blocks, of the first of which ``top`` rows and ``left`` columns are cut."""
    down, along = seen.row + top, seen.column + left
    rows, columns = down // height, along // width
    number = rows * (int(columns.max()) + 1) + columns
    place = width - 1 - along % width if mask == "antidiagonal" else along % width
    has = (mask == "all") | (down % height == place)
    form = {"height": height, "width": width, "top": top, "left": left, "mask": mask}
    return Elements({"where": "block"} | form, np.where(has, number, -1))


def _second_half(seen: Layers, axis: int) -> np.ndarray:
    place = (seen.row, seen.column)[axis]
    return 2 * place // seen.shape[axis]


def _without_lines(map_: np.ndarray) -> np.ndarray:
    return map_ - map_.mean(axis=1, keepdims=True) - map_.mean(axis=0) + map_.mean()


def _steps(seen: Layers, maps: list[Layer], layer: Layer, between: str) -> Estimate:
    """Steps between halves or quadrants, beyond what a surface of the second order explains."""
    pixels = math.prod(n // GRID for n in seen.window.shape)
    row, column = np.broadcast_arrays(seen.row + 0.0, seen.column + 0.0)
    y, x = (coarse(m).ravel() / n - 0.5 for m, n in zip((row, column), seen.shape, strict=True))
    smooth = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    down, along = np.sign(y), np.sign(x)
    sides = {"rows": [down], "columns": [along], "quadrants": [down, along, down * along]}[between]
    both = np.column_stack([smooth, *sides])
    solve = np.linalg.pinv(both)
    data = coarse(layer.map).ravel()
    rest, left = (data - basis @ np.linalg.pinv(basis) @ data for basis in (smooth, both))
    noise = max(float(left @ left) / (data.size - both.shape[1]), 1.0 / pixels)
    # two or four values: their signs and sizes are numbers of this sensor, no random draw
    way = (solve @ data)[6:]
    way = way / max(float(np.linalg.norm(way)), 1e-300)
    weights = way @ solve[6:]
    error = float(np.linalg.norm(weights)) / math.sqrt(pixels)
    sizes = Sizes(
        np.array([float(weights @ coarse(m.map).ravel()) / m.kept for m in maps]),
        np.array([math.sqrt(m.scatter) / m.kept * error for m in maps]),
    )
    words: dict[str, Any] = (
        {"where": "quadrants"} if between == "quadrants" else {"where": "halves", "axis": between}
    )
    effect = CompositeEffect(coefficients=tuple(round(float(c), 4) for c in way), **words)
    price = (1 + len(sides)) * math.log(data.size)
    return Estimate(effect, {}, float(rest @ rest - left @ left) / noise, price, sizes)
