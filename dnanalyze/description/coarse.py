"""Structure of coarse frames that is new in each: surfaces and spots, in their place or moving."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import optimize
from scipy.signal import fftconvolve

from dnanalyze.description.found import Estimate, Sizes, distribution, random_sizes
from dnanalyze.description.layers import GRID, Layers, coarse
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.significance import STATED, TOLERATED

BLOCK_VARIANCE = 1.0 / 12.0  # of places in a block, by which block means widen a spot
# Variance within the two groups, above and below 0, over the whole: 0 of two levels without noise,
# 1 - 2 / pi = .36 of a normal distribution; the middle.
TWO_GROUPS = (1.0 - 2.0 / math.pi) / 2.0
AT_ONCE = CompositeEffect.parameters()["tau"].lower  # frames: what draws anew in every frame
ROUND_OFF = 0.05  # of the largest coefficient of a surface, within which another is 0
RADII = np.linspace(math.log(0.6), math.log(GRID / 4), 49)  # blocks, logarithms


@dataclass(frozen=True)
class CoarseFrames:
    """Means of GRID x GRID blocks of all frames."""

    # Of each operating point, (frames, GRID, GRID), DN, less the mean of the frames.
    frames: tuple[np.ndarray, ...]
    chance: tuple[float, ...]  # variance of each value by chance, DN^2

    @property
    def white(self) -> np.ndarray:
        """All frames in units of their noise, (frames, GRID, GRID)."""
        pairs = zip(self.frames, self.chance, strict=True)
        return np.concatenate([f / math.sqrt(c) for f, c in pairs])

    def beyond_levels(self, gain: float) -> float:
        """Gain of a spot beyond that of a level of each frame: a step of all pixels is no spot."""
        return max(gain - float(GRID**2 * np.sum(self.white.mean(axis=(1, 2)) ** 2)), 0.0)

    def along(self, pattern: np.ndarray) -> tuple[list[np.ndarray], list[float]]:
        """Size of a pattern (GRID, GRID) in every frame, and its variance by chance."""
        amount = float(np.sum(pattern**2))
        series = [np.tensordot(f, pattern, 2) / amount for f in self.frames]
        return series, [c / amount for c in self.chance]


def coarse_patterns(seen: Layers) -> Iterator[Estimate]:
    """Surfaces, spots in their place and moving spots that the frames may show."""
    if min(seen.window.shape) < 4 * GRID:
        return
    pixels = math.prod(n // GRID for n in seen.window.shape)
    frames = CoarseFrames(
        tuple(coarse(t.unclipped) for t in seen.taken),
        tuple(t.noise**2 / pixels for t in seen.taken),
    )
    white = frames.white.reshape(-1, GRID**2)
    level = white.mean(axis=1, keepdims=True)
    yield _surface(seen, frames, np.linalg.svd(white - level, full_matrices=False)[2][0])
    _, strength, shapes = np.linalg.svd(white, full_matrices=False)
    standing = _standing_spot(seen, frames, shapes[0].reshape(GRID, GRID), 1.0 / strength[0])
    if standing is not None:
        yield standing
    yield _moving_spot(seen, frames)


def _surface(seen: Layers, frames: CoarseFrames, shape: np.ndarray) -> Estimate:
    """One low-order surface whose sign and size are new in every frame."""
    rows, columns = (n // GRID for n in seen.window.shape)
    y = (seen.window.top + (np.arange(GRID) + 0.5) * rows - 0.5) / seen.shape[0] - 0.5
    x = (seen.window.left + (np.arange(GRID) + 0.5) * columns - 0.5) / seen.shape[1] - 0.5
    y, x = (p.ravel() for p in np.meshgrid(y, x, indexing="ij"))
    basis = np.stack([x, y, x * x, x * y, y * y], axis=1)
    basis = basis - basis.mean(axis=0)
    numbers = np.linalg.lstsq(basis, shape, rcond=None)[0]
    numbers = numbers / numbers[np.abs(numbers).argmax()]
    # what is within its error of 0 is 0: a coefficient of the shape has that of its values
    numbers = np.where(np.abs(numbers) < ROUND_OFF, 0.0, np.round(numbers, 3))
    made = basis @ numbers
    series, chance = frames.along((made / made.std()).reshape(GRID, GRID))
    sizes, gain = random_sizes(series, chance)
    effect = CompositeEffect(
        when="frame", where="surface", coefficients=tuple(float(v) for v in numbers),
        distribution=distribution(series),
    )  # fmt: skip
    price = (numbers.size + len(series)) * math.log(frames.white.size)
    return Estimate(effect, {}, gain, price, sizes)


def _standing_spot(
    seen: Layers, frames: CoarseFrames, shape: np.ndarray, error: float
) -> Estimate | None:
    """A spot in its place that is there in some frames and not in others, or changes its height.

    ``shape``: the strongest pattern of the frames, each value with this error.
    """
    y, x = np.indices(shape.shape).astype(float)
    shape = shape * np.sign(shape.flat[np.abs(shape).argmax()])
    place = np.unravel_index(int(shape.argmax()), shape.shape)

    def made(_: Any, height: float, row: float, column: float, radius: float) -> np.ndarray:
        return (height * np.exp(-((y - row) ** 2 + (x - column) ** 2) / (2.0 * radius**2))).ravel()

    begun = (float(shape.max()), *map(float, place), GRID / 8.0)
    bounds = ([0.0, -0.5, -0.5, 0.4], [10.0, GRID - 0.5, GRID - 0.5, GRID / 4.0])
    try:
        best, covariance = optimize.curve_fit(
            made, None, shape.ravel(), begun, np.full(shape.size, error),
            absolute_sigma=True, bounds=bounds,
        )  # fmt: skip
    except RuntimeError:
        return None
    off = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    rows, columns = (n // GRID for n in seen.window.shape)
    radius, lowered = _without_blocks(best[3])
    step = math.sqrt(rows * columns)
    words: dict[str, Any] = {
        "where": "blob",
        "centre_y": float(seen.window.top + (best[1] + 0.5) * rows - 0.5),
        "centre_x": float(seen.window.left + (best[2] + 0.5) * columns - 0.5),
        "radius": _in_bounds(radius * step),
    }
    errors = {
        "radius": float(off[3]) * best[3] / radius * step,
        "centre_y": float(off[1]) * rows,
        "centre_x": float(off[2]) * columns,
    }
    series, chance = frames.along(made(None, lowered, *best[1:]).reshape(shape.shape))
    sizes, gain = random_sizes(series, chance)
    price = (4.0 + len(series)) * math.log(frames.white.size)
    if _two_groups(series, chance):
        sizes, tau = _switched(series, chance)
        effect = CompositeEffect(when="switching", distribution="on_off", tau=tau, **words)
    else:
        effect = CompositeEffect(when="persisting", tau=AT_ONCE, **words)
    return Estimate(effect, errors, frames.beyond_levels(gain), price, sizes)


def _two_groups(series: list[np.ndarray], chance: list[float]) -> bool:
    """Whether heights are of two levels: on and off.

    What chance adds within the groups is no sign of a third level.
    """
    groups = [g for s in series for g in (s[s > 0], s[s <= 0]) if g.size]
    within = sum(float(np.sum((g - g.mean()) ** 2)) for g in groups)
    whole = sum(float(np.sum(s**2)) for s in series)
    by_chance = sum((len(s) - 2.0) * c for s, c in zip(series, chance, strict=True))
    return within - by_chance < TWO_GROUPS * max(whole - by_chance, 1e-300)


def _switched(series: list[np.ndarray], chance: list[float]) -> tuple[Sizes, float]:
    """Heights between off and on at every point, and the time constant of the changes."""
    values, errors, changes, steps = [], [], 0, 0
    for s, c in zip(series, chance, strict=True):
        on = s > 0
        if not on.any() or on.all() or float(np.sum(s**2)) <= STATED**2 * s.size * c:
            values.append(0.0)
            errors.append(1e6)
            continue
        # frames are scaled to a frame's variance
        back = math.sqrt((s.size - 1.0) / s.size)
        values.append(float(s[on].mean() - s[~on].mean()) * back)
        errors.append(math.sqrt(c * (1.0 / on.sum() + 1.0 / (~on).sum())))
        changes += int(np.sum(on[1:] != on[:-1]))
        steps += s.size - 1
    # a state that draws anew with probability 1 - rho changes with (1 - rho) / 2
    rho = 1.0 - 2.0 * changes / max(steps, 1)
    persists = TOLERATED / math.sqrt(max(steps, 1)) < rho < 1
    return Sizes(np.array(values), np.array(errors)), -1.0 / math.log(rho) if persists else AT_ONCE


def _moving_spot(seen: Layers, frames: CoarseFrames) -> Estimate:
    """A spot elsewhere in every frame, by a matched filter of most likelihood.

    Its radius is told by every operating point by itself too.
    """
    ends = np.cumsum([len(f) for f in frames.frames])[:-1]
    white = frames.white
    found = [_peaks(white, math.exp(r)) for r in RADII]
    gains = np.array([peaks**2 for peaks, _ in found])  # (radii, frames)
    place, error = _top(gains.sum(axis=1))
    own = [_top(part.sum(axis=1))[0] for part in np.split(gains, ends, axis=1)]
    if len(own) > 1:
        error = math.hypot(error, float(np.std(own, ddof=1)) / math.sqrt(len(own)))
    best = int(np.argmin(np.abs(RADII - place)))
    radius, lowered = _without_blocks(math.exp(place))
    values, errors, gain = [], [], 0.0
    signals = np.split(found[best][0], ends)
    for c, z, heights in zip(frames.chance, signals, np.split(found[best][1], ends), strict=True):
        gain += z.size * max(float(z.mean()), 0.0) ** 2  # of one height in all frames
        # less the mean of the frames, which holds 1 / frames of every spot
        back = math.sqrt(heights.size / (heights.size - 1.0))
        height = heights * math.sqrt(c) / lowered * back
        values.append(float(height.mean()))
        errors.append(float(height.std(ddof=1)) / math.sqrt(heights.size))
    radius *= math.sqrt(math.prod(n / GRID for n in seen.window.shape))
    effect = CompositeEffect(when="frame", where="blob", radius=_in_bounds(radius))
    # a place and a height a frame; dark spots are no effect
    price = 3 * gains.shape[1] * math.log(GRID**2) if np.sum(values) > 0 else math.inf
    sizes = Sizes(np.array(values), np.maximum(errors, 1e-9))
    return Estimate(effect, {"radius": radius * error}, frames.beyond_levels(gain), price, sizes)


def _without_blocks(radius: float) -> tuple[float, float]:
    """Radius of a spot before the means of blocks widened it, and its height over the true one."""
    true = max(radius**2 - BLOCK_VARIANCE, radius**2 / 4.0)
    return math.sqrt(true), true / radius**2


def _in_bounds(radius: float) -> float:
    info = CompositeEffect.parameters()["radius"]
    return min(max(radius, info.lower), info.upper)


def _peaks(frames: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Highest signal to noise of a spot in every frame, and its height in units of the noise."""
    line = np.exp(-0.5 * (np.arange(-GRID + 1, GRID) / radius) ** 2)
    template = np.outer(line, line)
    weight = np.sqrt(fftconvolve(np.ones((GRID, GRID)), template**2, mode="same"))
    size = fftconvolve(frames, template[None], mode="same", axes=(1, 2)) / weight
    bright = np.sum(size.max(axis=(1, 2))) > -np.sum(size.min(axis=(1, 2)))
    sign = 1.0 if bright else -1.0
    at = (sign * size).reshape(len(frames), -1).argmax(axis=1)
    peaks = np.array([_between(sign * s, int(n)) for s, n in zip(size, at, strict=True)])
    return peaks, sign * peaks / weight.ravel()[at]


def _top(gains: np.ndarray) -> tuple[float, float]:
    """Logarithm of the radius where a parabola about the largest gain has its top; its error."""
    best = int(np.argmax(gains))
    near = slice(max(best - 4, 0), best + 5)
    bend, slope, _ = np.polyfit(RADII[near], gains[near], 2)
    if bend >= 0:
        return float(RADII[best]), math.inf
    place = min(max(-slope / (2.0 * bend), RADII[near][0]), RADII[near][-1])
    return float(place), math.sqrt(-1.0 / bend)


def _between(field: np.ndarray, at: int) -> float:
    """Height of a peak between the places of a lattice, by parabolas through its neighbours."""
    i, j = divmod(at, field.shape[1])
    height = float(field[i, j])
    for line, n in ((field[:, j], i), (field[i], j)):
        if 0 < n < line.size - 1:
            slope = float(line[n + 1] - line[n - 1])
            bend = float(2 * line[n] - line[n + 1] - line[n - 1])
            height += slope**2 / (8.0 * bend) if bend > 0 else 0.0
    return height
