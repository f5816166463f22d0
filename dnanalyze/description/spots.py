"""A Gaussian spot elsewhere in every frame, by a matched filter on coarse frames."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import optimize
from scipy.signal import fftconvolve

from dnanalyze.description.found import Estimate, Sizes
from dnanalyze.description.layers import GRID, Layers
from dnanalyze.model.composite.effect import CompositeEffect

FINE = np.linspace(-0.16, 0.16, 9)  # logarithms of radii about the best of the first pass


def spot(seen: Layers, coarse: list[np.ndarray], noise: list[float]) -> Estimate:
    """The spot of most likelihood; its radius is told by every operating point by itself too."""
    step = math.sqrt(math.prod(n / GRID for n in seen.window.shape))
    frames = np.concatenate([c / math.sqrt(n) for c, n in zip(coarse, noise, strict=True)])
    first = np.geomspace(0.6, GRID / 4, 12)
    rough = first[int(np.argmax([np.sum(_peaks(frames, r)[0] ** 2) for r in first]))]
    radii = rough * np.exp(FINE)
    found = [_peaks(frames, r) for r in radii]
    gains = np.array([peaks**2 for peaks, _ in found])  # (radii, frames)
    place, error = _top_of(gains.sum(axis=1))
    best = int(np.argmin(np.abs(FINE - place)))
    ends = np.cumsum([len(c) for c in coarse])[:-1]
    own = [_top_of(part.sum(axis=1))[0] for part in np.split(gains, ends, axis=1)]
    if len(own) > 1:
        error = math.hypot(error, float(np.std(own, ddof=1)) / math.sqrt(len(own)))
    # blocks widen a spot by their own variance; a template of another width sees another height
    wide, used = (rough * math.exp(place)) ** 2, radii[best] ** 2
    true = max(wide - 1.0 / 12.0, 0.25 * wide)
    taller = (wide + used) / (2.0 * wide) * wide / true
    values, errors = [], []
    for c, n, heights in zip(coarse, noise, np.split(found[best][1], ends), strict=True):
        # less the mean of the frames, which holds 1 / frames of every spot
        height = heights * math.sqrt(n) * taller * math.sqrt(len(c) / (len(c) - 1.0))
        values.append(float(height.mean()))
        errors.append(float(height.std(ddof=1)) / math.sqrt(len(c)))
    radius = math.sqrt(true) * step
    effect = CompositeEffect(when="frame", where="blob", radius=min(max(radius, 0.3), 1e6))
    # a place and a height a frame; dark spots are no effect
    price = 3 * len(frames) * math.log(GRID * GRID) if np.sum(values) > 0 else math.inf
    sizes = Sizes(np.array(values), np.maximum(errors, 1e-9))
    return Estimate(effect, {"radius": radius * error}, float(gains[best].sum()), price, sizes)


@dataclass(frozen=True)
class Standing:
    """A spot that stays in its place and changes its height from frame to frame.

    Parameters
    ----------
    centre : tuple of float
        Row and column in the frame.
    radius : float
        Pixels.
    errors : dict
        Standard errors by parameter.
    heights : list of ndarray
        Of every frame less the mean of its operating point, DN.
    chance : list of float
        Variance of such a height by chance, DN^2.
    """

    centre: tuple[float, float]
    radius: float
    errors: dict[str, float]
    heights: list[np.ndarray]
    chance: list[float]


def standing(seen: Layers, coarse: list[np.ndarray], noise: list[float]) -> Standing | None:
    """The strongest pattern of the coarse frames, where it is a Gaussian spot."""
    white = np.concatenate([c.reshape(len(c), -1) / math.sqrt(n)
                            for c, n in zip(coarse, noise, strict=True)])  # fmt: skip
    _, strength, shapes = np.linalg.svd(white, full_matrices=False)
    shape = shapes[0] * np.sign(shapes[0][np.abs(shapes[0]).argmax()])
    y, x = (p.ravel().astype(float) for p in np.indices((GRID, GRID)))
    place = int(shape.argmax())

    def made(_: np.ndarray, *p: float) -> np.ndarray:
        return p[0] * np.exp(-((y - p[1]) ** 2 + (x - p[2]) ** 2) / (2.0 * p[3] ** 2))

    begun = (float(shape.max()), y[place], x[place], GRID / 8.0)
    bounds = ([0.0, -0.5, -0.5, 0.4], [10.0, GRID - 0.5, GRID - 0.5, GRID / 4.0])
    error = np.full(shape.size, 1.0 / strength[0])
    try:
        best, covariance = optimize.curve_fit(
            made, y, shape, begun, error, absolute_sigma=True, bounds=bounds
        )
    except RuntimeError:
        return None
    template = made(y, 1.0, *best[1:])
    amount = float(template @ template)
    # blocks widen a spot by their own variance and lower it by as much
    wide, true = best[3] ** 2, max(best[3] ** 2 - 1.0 / 12.0, 0.25 * best[3] ** 2)
    taller = wide / true
    steps = [n // GRID for n in seen.window.shape]
    step = math.sqrt(math.prod(steps))
    off = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    radius = math.sqrt(true)
    errors = {
        "radius": float(off[3]) * best[3] / radius * step,
        "centre_y": float(off[1]) * steps[0],
        "centre_x": float(off[2]) * steps[1],
    }
    centre = [first + (best[n] + 0.5) * steps[n - 1] - 0.5
              for n, first in ((1, seen.window.top), (2, seen.window.left))]  # fmt: skip
    heights = [c.reshape(len(c), -1) @ template / amount * taller for c in coarse]
    chance = [n / amount * taller**2 for n in noise]
    return Standing((float(centre[0]), float(centre[1])), radius * step, errors, heights, chance)


def _peaks(frames: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Highest signal to noise of a spot in every frame, and its height in units of the noise."""
    reach = np.arange(-GRID + 1, GRID)
    line = np.exp(-0.5 * (reach / radius) ** 2)
    template = np.outer(line, line)
    weight = np.sqrt(fftconvolve(np.ones((GRID, GRID)), template**2, mode="same"))
    size = np.stack([fftconvolve(f, template, mode="same") for f in frames]) / weight
    bright = np.sum(size.max(axis=(1, 2))) > -np.sum(size.min(axis=(1, 2)))
    sign = 1.0 if bright else -1.0
    at = (sign * size).reshape(len(frames), -1).argmax(axis=1)
    peaks = np.array([_between(sign * s, int(n)) for s, n in zip(size, at, strict=True)])
    return peaks, sign * peaks / weight.ravel()[at]


def _top_of(gains: np.ndarray) -> tuple[float, float]:
    """Logarithm of the radius, from the first pass's, where a parabola has its top; its error."""
    bend, slope, _ = np.polyfit(FINE, gains, 2)
    if bend >= 0:
        return float(FINE[int(np.argmax(gains))]), math.inf
    place = min(max(-slope / (2.0 * bend), FINE[0]), FINE[-1])
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
