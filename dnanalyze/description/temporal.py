"""Structure that is new in every frame: surfaces, quadrants, spots, pairs and jumping lines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from dnanalyze.description.blocks import block_form
from dnanalyze.description.changing import row_before, standing_spot
from dnanalyze.description.found import Estimate, Sizes, random_sizes
from dnanalyze.description.layers import GRID, Layers, coarse
from dnanalyze.description.lines import changing_lines, segments
from dnanalyze.description.spots import spot
from dnanalyze.model.composite.effect import CompositeEffect

TWO_LEVEL = 1.5  # fourth moment over the square of the second: 1 of two levels, 3 of a normal
ENOUGH = 16  # values from which that ratio tells (sqrt(24 / 16) = 1.2 of a normal)


def temporal(seen: Layers) -> list[Estimate]:
    """All that the temporal layer may show."""
    if not seen.several:
        return []
    found = [*_pairs(seen), *segments(seen), *changing_lines(seen), *row_before(seen)]
    if min(seen.window.shape) >= 4 * GRID:
        blocks = [coarse(t.unclipped) for t in seen.taken]
        pixels = math.prod(n // GRID for n in seen.window.shape)
        noise = [t.noise**2 / pixels for t in seen.taken]
        found += [_surface(seen, blocks, noise), *_parts(seen, blocks, noise)]
        found.append(spot(seen, blocks, noise))
        found += standing_spot(seen, blocks, noise)
    return found


def _places(seen: Layers) -> tuple[np.ndarray, np.ndarray]:
    """(y, x) of the blocks, from -1/2 to 1/2 over the frame."""
    rows, columns = (n // GRID for n in seen.window.shape)
    y = seen.window.top + (np.arange(GRID) + 0.5) * rows - 0.5
    x = seen.window.left + (np.arange(GRID) + 0.5) * columns - 0.5
    return np.meshgrid(y / seen.shape[0] - 0.5, x / seen.shape[1] - 0.5, indexing="ij")


def _distribution(
    series: list[np.ndarray], sizes: Sizes, chance: list[float], unit: float = 1.0
) -> str:
    """Normal, or two levels, by the fourth moment of all values over their spread."""
    spread = np.sqrt(np.maximum(sizes.values / unit**2 + chance, 1e-300))
    values = np.concatenate([(s / a).ravel() for s, a in zip(series, spread, strict=True)])
    if values.size < ENOUGH:
        return "normal"
    ratio = float(np.mean(values**4) / np.mean(values**2) ** 2)
    return "two_level" if ratio < TWO_LEVEL else "normal"


def _surface(seen: Layers, blocks: list[np.ndarray], noise: list[float]) -> Estimate:
    """One low-order surface whose sign and size are new in every frame."""
    flat = [c.reshape(len(c), -1) - c.mean(axis=(1, 2))[:, None] for c in blocks]
    white = np.concatenate([f / math.sqrt(n) for f, n in zip(flat, noise, strict=True)])
    shape = np.linalg.svd(white, full_matrices=False)[2][0]
    y, x = (p.ravel() for p in _places(seen))
    basis = np.stack([x, y, x * x, x * y, y * y], axis=1)
    numbers = np.linalg.lstsq(basis - basis.mean(axis=0), shape, rcond=None)[0]
    numbers = numbers / numbers[np.abs(numbers).argmax()]
    # what is within its error of 0 is 0: a coefficient of the shape has that of its values
    numbers = np.where(np.abs(numbers) < 0.05, 0.0, np.round(numbers, 3))
    made = (basis - basis.mean(axis=0)) @ numbers
    made = made / made.std()
    series = [f @ made / made.size for f in flat]
    chance = [n / made.size for n in noise]
    sizes, gain = random_sizes(series, chance)
    effect = CompositeEffect(
        when="frame", where="surface", coefficients=tuple(float(v) for v in numbers),
        distribution=_distribution(series, sizes, chance),
    )  # fmt: skip
    return Estimate(effect, {}, gain, (5 + len(series)) * math.log(white.size), sizes)


def _parts(seen: Layers, blocks: list[np.ndarray], noise: list[float]) -> list[Estimate]:
    """Quadrants or halves that have a value each in every frame."""
    if min(seen.window.shape) < 0.9 * min(seen.shape):
        return []
    y, x = _places(seen)
    signs = {"rows": np.sign(y), "columns": np.sign(x), "both": np.sign(y * x)}
    found = []
    forms: list[tuple[dict[str, Any], list[str]]] = [
        ({"where": "halves", "axis": "rows"}, ["rows"]),
        ({"where": "halves", "axis": "columns"}, ["columns"]),
        ({"where": "quadrants"}, ["rows", "columns", "both"]),
    ]
    for words, names in forms:
        series = [
            np.stack([(c * signs[n]).mean(axis=(1, 2)) for n in names], axis=1) for c in blocks
        ]
        # a contrast of k independent values of spread A has A / sqrt(k)
        unit = math.sqrt(len(names) + 1)
        chance = [n / GRID**2 for n in noise]
        sizes, gain = random_sizes(series, chance, unit)
        distribution = _distribution(series, sizes, chance, unit) if len(names) == 1 else "normal"
        effect = CompositeEffect(when="frame", distribution=distribution, **words)
        count = sum(s.size for s in series)
        found.append(Estimate(effect, {}, gain, (1 + len(series)) * math.log(count * GRID), sizes))
    return found


def _pairs(seen: Layers) -> list[Estimate]:
    """Pixels of a block that share a noise: all of them, or a diagonal of 2 x 2."""
    stacks = [t.temporal / np.float32(t.noise) for t in seen.taken]
    found = []
    for mask, right in (("diagonal", 1), ("antidiagonal", -1)):
        best: tuple[float, int, int] = (0.0, 0, 0)
        tables = []
        for stack in stacks:
            one = stack[:, :-1, 1:] if right < 0 else stack[:, :-1, :-1]
            other = stack[:, 1:, :-1] if right < 0 else stack[:, 1:, 1:]
            product = np.einsum("fij,fij->ij", one, other) / len(stack)
            tables.append([[float(product[a::2, b::2].mean()) for b in (0, 1)] for a in (0, 1)])
        count = stacks[0][0, ::2, ::2].size
        frames = np.array([len(s) - 1.0 for s in stacks])
        weight = frames * count
        table = np.tensordot(weight, np.array(tables), 1) / weight.sum()
        error = 1.0 / math.sqrt(float(weight.sum()))
        for a in (0, 1):
            for b in (0, 1):
                gain = (table[a, b] / error) ** 2 if table[a, b] > 0 else 0.0
                rest = (np.sum(table**2) - table[a, b] ** 2) / error**2 - 3.0
                if gain - max(rest, 0.0) > best[0]:
                    best = gain - max(rest, 0.0), a, b
        gain, a, b = best
        if gain <= 0:
            continue
        sizes = Sizes(
            np.array([t[a][b] * s.noise**2 for t, s in zip(tables, seen.taken, strict=True)]),
            np.array([s.noise**2 / math.sqrt(w) for s, w in zip(seen.taken, weight, strict=True)]),
            squares=True,
        )
        column = seen.window.left + b
        effect = CompositeEffect(
            when="frame", where="block", mask=mask, height=2, width=2,
            top=(seen.window.top + a) % 2, left=column % 2,
        )  # fmt: skip
        price = 5.0 * math.log(float(weight.sum()))
        found.append(Estimate(effect, {}, gain, price, sizes))
    return found + _blocks(seen, stacks)


def _blocks(seen: Layers, stacks: list[np.ndarray]) -> list[Estimate]:
    """Whole blocks that share a noise."""
    form = block_form(seen, np.concatenate(stacks))
    if form is None:
        return []
    height, width, top, left = form
    number = np.arange(stacks[0].shape[2] - 1) + seen.window.left + left
    inner = number % width != width - 1
    line = np.arange(stacks[0].shape[1] - 1) + seen.window.top + top
    below = line % height != height - 1
    values, errors, gain = [], [], 0.0
    for stack, taken in zip(stacks, seen.taken, strict=True):
        if width > 1:
            products = (stack[:, :, 1:] * stack[:, :, :-1])[:, :, inner]
        else:
            products = (stack[:, 1:] * stack[:, :-1])[:, below]
        count = products.size * (len(stack) - 1.0) / len(stack)
        mean = float(products.mean())
        gain += mean**2 * count
        values.append(mean * taken.noise**2)
        errors.append(taken.noise**2 / math.sqrt(count))
    effect = CompositeEffect(
        when="frame", where="block", height=height, width=width, top=top, left=left
    )
    sizes = Sizes(np.array(values), np.array(errors), squares=True)
    return [Estimate(effect, {}, gain, 5.0 * math.log(stacks[0].size * len(stacks)), sizes)]
