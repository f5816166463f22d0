"""Residual layers over the operating points: fixed, temporal and variance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dnanalyze.fitting.design import Design
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Window
from dnanalyze.model.laws import value_at
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate
from dnanalyze.robust import QUARTILES, core_deviation
from dnanalyze.significance import CERTAIN, NOTICEABLE

GRID = 16  # blocks a side of coarse maps, over which steps and spots are told from shading
# Robust standard deviations at which pixels are cut: of white noise .006 % lie beyond, hot pixels
# all. A variance is cut at `CERTAIN`: of six frames .06 % lie beyond.
CLIP = NOTICEABLE
LEAST_GROWTH = 0.1  # of the dark signal, over its largest, that tells a law
MOST = 0.9  # of a side of the frame, in which its middle is that of the window, nearly


@dataclass(frozen=True)
class Layer:
    """A residual map at an operating point."""

    map: np.ndarray  # (rows, columns), DN, of mean about 0, hot pixels cut
    noise: float  # standard deviation of a pixel, DN, robust
    # Share of the pixels that were not cut: a pattern is lost in the others, and its size in the
    # map is smaller by this factor.
    kept: float = 1.0

    @cached_property
    def scatter(self) -> float:
        """Variance of the map, its tails included, DN^2: what a mean of pixels scatters by."""
        return float(self.map.var())


@dataclass(frozen=True)
class Taken:
    """The frames of one operating point over a window."""

    point: OperatingPoint
    frames: np.ndarray  # (frames, rows, columns), float32, DN

    @cached_property
    def mean(self) -> np.ndarray:
        """Mean frame, DN."""
        return self.frames.mean(axis=0)

    @property
    def unclipped(self) -> np.ndarray:
        """Frames less their pixel means, scaled to the variance of a frame."""
        count = len(self.frames)
        rest = self.frames - self.mean
        rest *= np.float32(math.sqrt(count / (count - 1.0)))
        return rest

    @cached_property
    def temporal(self) -> np.ndarray:
        """The same with hot pixels cut."""
        rest = self.unclipped
        limit = np.float32(CLIP * robust(rest))
        return np.clip(rest, -limit, limit, out=rest)

    @cached_property
    def noise(self) -> float:
        """Temporal standard deviation of a pixel, DN, robust."""
        return robust(self.temporal)

    @cached_property
    def fixed(self) -> Layer:
        """The mean frame less its median."""
        rest = (self.mean - np.median(self.mean)).astype(float)
        noise = robust(rest)
        kept = float(np.mean(np.abs(rest) < CLIP * noise))
        return Layer(np.clip(rest, -CLIP * noise, CLIP * noise), noise, kept)

    def line_variances(self, axis: int) -> np.ndarray:
        """Mean temporal variance of the rows (axis 1) or columns (0), DN^2.

        Hot pixels are cut by the spread within their own line: a noisy line is not cut more than
        another.
        """
        found = self.frames.var(axis=0, ddof=1, dtype=float)
        low, middle, high = np.percentile(found, (25, 50, 75), axis=axis, keepdims=True)
        cut = np.minimum(found, middle + CERTAIN * (high - low) / QUARTILES)
        return np.asarray(cut.mean(axis=axis))

    @cached_property
    def variance(self) -> Layer:
        """The temporal variance of the pixels less its mean, DN^2."""
        found = self.frames.var(axis=0, ddof=1, dtype=float)
        middle, noise = float(np.median(found)), robust(found)
        cut = np.minimum(found, middle + CERTAIN * noise)
        return Layer(cut - cut.mean(), float(cut.std()))


@dataclass(frozen=True)
class Layers:
    """All operating points, and where they lie in the frame."""

    taken: tuple[Taken, ...]
    window: Window  # of the frame
    shape: tuple[int, int]  # full frame
    dark: np.ndarray  # mean dark signal of the model, DN, one an operating point

    @property
    def points(self) -> list[OperatingPoint]:
        """Operating points in order."""
        return [t.point for t in self.taken]

    @property
    def several(self) -> bool:
        """Whether there are frames to compare."""
        return all(len(t.frames) > 1 for t in self.taken)

    @property
    def grows(self) -> bool:
        """Whether the dark signal differs between the points by enough to tell a law."""
        return float(np.ptp(self.dark)) > LEAST_GROWTH * max(float(self.dark.max()), 1e-9)

    @property
    def whole(self) -> bool:
        """Whether the window is most of the frame: its halves are those of the frame."""
        return min(self.window.shape) >= MOST * min(self.shape)

    @cached_property
    def lost_gain(self) -> np.ndarray:
        """By how much a fixed pattern of the gain is larger than its map shows, one a point.

        Beside what any pattern loses in cut pixels (`Layer.kept`): these hold more than their share
        of the dark signal.
        """
        found = []
        for taken, dark in zip(self.taken, self.dark, strict=True):
            rest = taken.mean - np.median(taken.mean)
            charge = np.maximum(rest - rest.mean() + dark, 0.0)
            cut = np.abs(rest) >= CLIP * taken.fixed.noise
            share = 1.0 - float(charge[cut].sum()) / max(float(charge.sum()), 1e-9)
            found.append(taken.fixed.kept / max(share, 0.5))
        return np.array(found)

    @cached_property
    def row(self) -> np.ndarray:
        """Row numbers in the full frame, a column vector."""
        return np.arange(self.window.top, self.window.bottom)[:, None]

    @cached_property
    def column(self) -> np.ndarray:
        """Column numbers in the full frame, a row vector."""
        return np.arange(self.window.left, self.window.right)[None, :]


def robust(values: np.ndarray) -> float:
    """Standard deviation of the core of a sample of the values, never 0."""
    flat = values.reshape(-1)
    return max(core_deviation(flat[:: max(1, flat.size // 200_000)]), 1e-6)


def coarse(maps: np.ndarray) -> np.ndarray:
    """Means of GRID x GRID blocks of maps, (..., GRID, GRID)."""
    rows, columns = (n // GRID for n in maps.shape[-2:])
    cut = maps[..., : rows * GRID, : columns * GRID]
    parts = cut.reshape(*maps.shape[:-2], GRID, rows, GRID, columns)
    return np.asarray(parts.mean(axis=(-3, -1), dtype=float))


def layers(plan: Design, model: NoiseModel, captures: CaptureSet | None = None) -> Layers:
    """The layers of the captures of a plan, or of others of the same design."""
    settings = (captures or plan.captures).settings
    taken = tuple(
        Taken(s.point, np.stack([f.read(plan.window) for f in s.frames]).astype(np.float32))
        for s in settings
    )
    dark = [float(t.mean.mean()) - value_at(model.pedestal, t.point) for t in taken]
    return Layers(taken, plan.window, plan.shape, np.maximum(dark, 0.0))


def simulated_layers(plan: Design, model: NoiseModel) -> Layers:
    """The same of a simulated sensor of the model: what an estimator finds there is chance."""
    made = simulate(model.in_codes, plan.shape, plan.settings, sensor=plan.captures.sensor)
    return layers(plan, model, made)


def together(maps: Sequence[Layer], growth: np.ndarray) -> Layer:
    """The map that tells most of a pattern whose size grows so over the operating points."""
    weight = [g / m.noise**2 for g, m in zip(growth, maps, strict=True)]
    total = math.fsum(g * w for g, w in zip(growth, weight, strict=True))
    made = sum(w * m.map for w, m in zip(weight, maps, strict=True)) / max(total, 1e-300)
    assert isinstance(made, np.ndarray)
    noise = robust(made)
    return Layer(np.clip(made, -CLIP * noise, CLIP * noise) / noise, 1.0)
