"""Fixed values of elements: diagonals, blocks of pixels, quadrants and halves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from dnanalyze.description.blocks import block_form, block_means
from dnanalyze.description.found import Estimate, Sizes, random_size
from dnanalyze.description.layers import GRID, Layer, Layers, coarse, together
from dnanalyze.model.composite.effect import CompositeEffect


def fixed_elements(seen: Layers, maps: list[Layer], growth: np.ndarray) -> list[Estimate]:
    """Diagonals, blocks, quadrants and halves that the maps may show."""
    layer = together(maps, growth)
    found = [_diagonals(seen, maps, layer, slant) for slant in ("down", "up")]
    form = block_form(seen, layer.map)
    if form is not None:
        found.append(_blocks(seen, maps, layer, form))
    return found + _seams(seen, maps, growth)


def _diagonals(seen: Layers, maps: list[Layer], layer: Layer, slant: str) -> Estimate:
    """A value of every diagonal."""
    number = seen.row - seen.column if slant == "down" else seen.row + seen.column
    number = number - number.min()
    count = np.bincount(number.ravel())
    used = count >= 8

    def means(m: Layer) -> np.ndarray:
        rest = m.map - m.map.mean(axis=1, keepdims=True) - m.map.mean(axis=0) + m.map.mean()
        return np.bincount(number.ravel(), rest.ravel())[used] / count[used]

    *_, gain = random_size(means(layer), 1.0 / count[used])
    sizes = [_realised(means(m) / m.kept, m.scatter / m.kept**2 / count[used]) for m in maps]
    effect = CompositeEffect(where="diagonal", slant=slant)
    price = 2.0 * math.log(int(used.sum()))
    return Estimate(effect, {}, gain, price, _squares(sizes), elements=int(used.sum()))


def _blocks(
    seen: Layers, maps: list[Layer], layer: Layer, form: tuple[int, int, int, int]
) -> Estimate:
    """A value of every block."""
    height, width, top, left = form
    means, count = block_means(seen, layer.map, form)
    *_, gain = random_size(means, 1.0 / count)
    sizes = []
    for m in maps:
        value, number = block_means(seen, m.map, form)
        sizes.append(_realised(value / m.kept, m.scatter / m.kept**2 / number))
    effect = CompositeEffect(where="block", height=height, width=width, top=top, left=left)
    price = 5.0 * math.log(means.size)
    return Estimate(effect, {}, gain, price, _squares(sizes), elements=means.size)


def _seams(seen: Layers, maps: list[Layer], growth: np.ndarray) -> list[Estimate]:
    """Steps between quadrants or halves, beyond what a surface of the second order explains."""
    if min(maps[0].map.shape) < 4 * GRID or min(seen.window.shape) < 0.9 * min(seen.shape):
        return []
    pixels = math.prod(n // GRID for n in maps[0].map.shape)
    row, column = np.broadcast_arrays(seen.row + 0.0, seen.column + 0.0)
    y, x = (coarse(m).ravel() / n - 0.5 for m, n in zip((row, column), seen.shape, strict=True))
    smooth = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    side_y, side_x = np.sign(y), np.sign(x)
    steps = {
        "rows": side_y[:, None],
        "columns": side_x[:, None],
        "quadrants": np.stack([side_y, side_x, side_y * side_x], axis=1),
    }
    found = []
    layer = together(maps, growth)
    for name, step in steps.items():
        both = np.hstack([smooth, step])
        data = coarse(layer.map).ravel()
        rest = data - smooth @ np.linalg.lstsq(smooth, data, rcond=None)[0]
        left = data - both @ np.linalg.lstsq(both, data, rcond=None)[0]
        noise = max(float(left @ left) / (data.size - both.shape[1]), 1.0 / pixels)
        gain = float(rest @ rest - left @ left) / noise
        # two or four values: their signs and sizes are numbers of this sensor, no random draw
        way = np.linalg.lstsq(both, data, rcond=None)[0][6:]
        way = way / max(float(np.linalg.norm(way)), 1e-300)
        inverse = np.linalg.pinv(both.T @ both)[6:, 6:]
        error = math.sqrt(float(way @ inverse @ way) / pixels)
        parts = [
            np.linalg.lstsq(both, coarse(m.map).ravel() / m.kept, rcond=None)[0][6:] for m in maps
        ]
        errors = np.array([math.sqrt(m.scatter) / m.kept * error for m in maps])
        sizes = Sizes(np.array([float(way @ p) for p in parts]), errors)
        given: dict[str, Any] = (
            {"where": "quadrants"} if name == "quadrants" else {"where": "halves", "axis": name}
        )
        price = (1 + step.shape[1]) * math.log(data.size)
        effect = CompositeEffect(coefficients=tuple(round(float(c), 4) for c in way), **given)
        found.append(Estimate(effect, {}, gain, price, sizes))
    return found


def _realised(values: np.ndarray, chance: np.ndarray) -> tuple[float, float]:
    """A^2 of these values with the error of measuring it.

    Without what another draw of the values would add, 2 A^4 / n: they are the same at all
    operating points.
    """
    size, error, _ = random_size(values, chance)
    draw = 2.0 * size**2 / values.size
    least = 2.0 * float(np.mean(chance)) ** 2 / values.size
    return size, math.sqrt(max(error**2 - draw, least))


def _squares(sizes: list[tuple[float, float]]) -> Sizes:
    return Sizes(np.array([s for s, _ in sizes]), np.array([e for _, e in sizes]), squares=True)
