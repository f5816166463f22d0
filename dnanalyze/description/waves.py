"""Plane waves and rings in a map: frequency by periodogram, geometry by least squares."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import fft, optimize

from dnanalyze.description.found import Estimate, Sizes
from dnanalyze.description.layers import Layer, Layers, together
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.significance import CERTAIN

TILES = 4  # a side, in which rings about a far centre are plane waves
ENOUGH = 16_384  # pixels of the map from which the first steps look for a geometry
LEAST_CYCLES = 2.5  # over the field: below that a wave is shading
PERIOD_SCATTER = 0.2  # relative scatter of the period over tiles that are of one wave
NEAR_TILES = 5  # that must agree: a chance peak agrees in none
# Powers of 4 x 4 tiles are a chi square of 32 by chance: mean 32, standard deviation 8
PLAIN = 2.0 * TILES**2 + CERTAIN * 2.0 * TILES
ENVELOPES = ("flat", "down", "up", "right", "left")
Maps = list[Layer]
Angle = Callable[..., np.ndarray]  # of the geometry, of every n-th pixel


def waves(seen: Layers, maps: Maps, growth: np.ndarray, what: str) -> list[Estimate]:
    """The best plane wave and the best rings of maps whose pattern grows so over the points."""
    layer = together(maps, growth)
    found = []
    u, v, power = _peak(layer.map - layer.map.mean())
    if power < layer.map.size * math.log(layer.map.size):  # below that a strongest line is chance
        return []
    plane = _polished(_plane(seen), np.array([v, u]), layer.map, 0.1 / np.array(layer.map.shape))
    for values in (plane, _exact(plane, layer.map.shape)):
        cycles = np.hypot(*(values * layer.map.shape))
        if cycles >= LEAST_CYCLES:
            found.append(_estimate(seen, maps, growth, layer, what, "wave", values))
    best = max(found, key=lambda e: e.explained, default=None)
    if best is None:
        return []
    begun = _centre(seen, layer.map)
    if begun is None or _power(layer.map, _rings(seen)(begun), TILES) < PLAIN:
        return [best]
    step = np.array([0.05 * min(layer.map.shape), 0.05 * min(layer.map.shape), 0.01 * begun[2]])
    ringed = _polished(_rings(seen), begun, layer.map, step)
    return [best, _estimate(seen, maps, growth, layer, what, "rings", ringed)]


def _plane(seen: Layers) -> Angle:
    """Angle of a plane wave of frequencies (v, u)."""
    return lambda p, n=1: 2 * math.pi * (p[0] * seen.row[::n] + p[1] * seen.column[:, ::n])


def _rings(seen: Layers) -> Angle:
    """Angle of rings about (row, column) of a period."""
    return lambda p, n=1: (
        2 * math.pi * np.hypot(seen.row[::n] - p[0], seen.column[:, ::n] - p[1]) / p[2]
    )


def _power(map_: np.ndarray, angle: np.ndarray, tiles: int) -> float:
    """Twice the gain of the log likelihood, phases free in each of tiles x tiles parts."""
    turned = map_ * np.exp(-1j * angle)
    rows, columns = (n // tiles for n in map_.shape)
    cut = turned[: rows * tiles, : columns * tiles].reshape(tiles, rows, tiles, columns)
    sums = cut.sum(axis=(1, 3))
    return float(2.0 * np.sum(np.abs(sums) ** 2) / (rows * columns))


def _polished(angle: Angle, begun: np.ndarray, map_: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Geometry of most power: first where parts of the field keep a phase of their own."""
    here = begun
    coarse = max(1, math.ceil(math.sqrt(map_.size / ENOUGH)))  # any pixels tell the geometry
    for tiles, share, step_over in ((4, 1.0, coarse), (2, 0.3, coarse), (1, 0.1, 1)):
        part = map_[::step_over, ::step_over]
        most = 60 if tiles == 1 else 120
        corner = np.vstack([here, here + share * step * np.eye(len(here))])
        ended = optimize.minimize(
            lambda p, n=step_over, part=part, tiles=tiles: -_power(part, angle(p, n), tiles),
            here,
            method="Nelder-Mead",
            options={
                "initial_simplex": corner,
                "maxfev": most,
                "xatol": 1e-7,
                "fatol": 1e-3,
            },
        )
        here = ended.x
    return np.asarray(here)


def _peak(map_: np.ndarray, padded: int = 1) -> tuple[float, float, float]:
    """Frequencies (u, v) and power of the strongest line, not below `LEAST_CYCLES` over the field.

    ``padded``: times the field, with zeros, over which the spectrum is taken.
    """
    shape = (padded * map_.shape[0], padded * map_.shape[1])
    power = np.abs(fft.rfft2(map_, s=shape)) ** 2
    v, u = fft.fftfreq(shape[0])[:, None], fft.rfftfreq(shape[1])[None, :]
    slow = np.hypot(v * map_.shape[0], u * map_.shape[1]) < LEAST_CYCLES
    power = np.where(slow, 0.0, power)
    i, j = np.unravel_index(int(power.argmax()), power.shape)
    return float(u[0, j]), float(v[i, 0]), float(power.max())


def _exact(values: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Frequencies of 0 and 1/2 where they lie within a third of a mode of these."""
    exact = []
    for value, lines in zip(values, shape, strict=True):
        near = min((0.0, 0.5, -0.5), key=lambda x: abs(x - value))
        exact.append(abs(near) if abs(near - value) * lines < 1 / 3 else value)
    return np.array(exact)


def _centre(seen: Layers, map_: np.ndarray) -> np.ndarray | None:
    """Centre and period of rings from the waves of tiles; None where these do not agree."""
    rows, columns = (n // TILES for n in map_.shape)
    if min(rows, columns) < 16:
        return None
    window = np.outer(np.hanning(rows), np.hanning(columns))
    places, directions, sizes, strength = [], [], [], []
    for a in range(TILES):
        for b in range(TILES):
            tile = map_[a * rows : (a + 1) * rows, b * columns : (b + 1) * columns]
            u, v, power = _peak((tile - tile.mean()) * window, 2)
            wave = np.array([v, u])
            places.append(
                [seen.window.top + (a + 0.5) * rows, seen.window.left + (b + 0.5) * columns]
            )
            directions.append(wave / np.linalg.norm(wave))
            sizes.append(float(np.linalg.norm(wave)))
            strength.append(power)
    order = np.argsort(strength)[::-1][: TILES * TILES // 2]
    middle = float(np.median(np.array(sizes)[order]))
    near = [t for t in range(len(sizes)) if abs(sizes[t] / middle - 1.0) < PERIOD_SCATTER]
    if len(near) < NEAR_TILES:
        return None
    matrix, side = np.zeros((2, 2)), np.zeros(2)
    for t in near:
        across = np.eye(2) - np.outer(directions[t], directions[t])
        matrix += strength[t] * across
        side += strength[t] * across @ np.array(places[t])
    if np.linalg.cond(matrix) > 1e5:
        return None
    centre = np.linalg.solve(matrix, side)
    return np.array([*centre, 1.0 / middle])


def _estimate(
    seen: Layers,
    maps: Maps,
    growth: np.ndarray,
    layer: Layer,
    what: str,
    where: str,
    values: np.ndarray,
) -> Estimate:
    """A wave or rings of a geometry: phase, envelope, errors, sizes over the points."""
    if where == "wave":  # whole cycles a pixel are none
        values = values - np.where(np.abs(values) > 0.5, np.round(values), 0.0)
    angle = (_plane(seen) if where == "wave" else _rings(seen))(values)
    basis = np.stack([np.cos(angle).ravel(), -np.sin(angle).ravel()])
    size = np.linalg.lstsq(basis @ basis.T, basis @ layer.map.ravel(), rcond=1e-6)[0]
    phase = math.atan2(size[1], size[0])
    if where == "wave" and all(abs(x) in (0.0, 0.5) for x in values):
        phase = math.pi / 4.0 if size[0] > 0 else 3.0 * math.pi / 4.0  # values of -1 and 1
    ramps = {name: _ramp(name, seen) for name in ENVELOPES}
    best, envelope, pattern = -1.0, "flat", np.zeros(layer.map.shape)
    for name in ENVELOPES if what == "level" else ("flat",):
        shape = math.sqrt(2.0) * np.cos(angle + phase) * ramps[name]
        gain = float(np.sum(layer.map * shape)) ** 2 / float(np.sum(shape**2))
        if gain > best:
            best, envelope, pattern = gain, name, shape
    given: dict[str, Any] = {"phase": phase, "envelope": envelope, "what": what, "where": where}
    names = ("v", "u") if where == "wave" else ("centre_y", "centre_x", "period")
    if where == "rings" and values[2] < 2.0:
        best = 0.0
        values = np.array([values[0], values[1], 2.0])
    given |= {name: float(x) for name, x in zip(names, values, strict=True)}
    make = _plane(seen) if where == "wave" else _rings(seen)
    errors = _errors(make, values, layer.map)
    amount = float(np.sum(pattern**2))
    peak = math.sqrt(2.0) if what == "noise" else 1.0  # a variance A^2 (1 + p / sqrt2)
    sizes = Sizes(
        np.array([peak * float(np.sum(m.map * pattern)) / amount / m.kept for m in maps]),
        np.array([peak * math.sqrt(m.scatter / amount) / m.kept for m in maps]),
        squares=what == "noise",
    )
    price = (2 + len(values)) * math.log(layer.map.size)
    own = dict(zip(names, errors, strict=True))
    return Estimate(CompositeEffect(**given), own, best, price, sizes)


def _ramp(name: str, seen: Layers) -> np.ndarray | float:
    """An envelope of mean square 1 over the frame, as the composite effect has it."""
    if name == "flat":
        return 1.0
    by_row = name in ("down", "up")
    line = seen.row / (seen.shape[0] - 1.0) if by_row else seen.column / (seen.shape[1] - 1.0)
    return math.sqrt(3.0) * (line if name in ("down", "right") else 1.0 - line)


def _errors(angle: Angle, values: np.ndarray, map_: np.ndarray) -> list[float]:
    """Standard errors of the geometry from the curvature of the log likelihood at its top."""
    turned = map_ * np.exp(-1j * angle(values))
    total = turned.sum()
    size = 2.0 * abs(total) / map_.size
    if size <= 0:
        return [math.inf] * len(values)
    slopes = []
    for n, value in enumerate(values):
        step = np.zeros(len(values))
        step[n] = 1e-5 * max(abs(float(value)), 1.0)
        slope = (angle(values + step) - angle(values - step)) / (2.0 * step[n])
        slopes.append((slope - slope.mean()).ravel())
    # information of a cosine of size a in unit noise: a^2 / 2 sum of slope products, phase free
    slopes_ = np.array(slopes)
    information = size**2 / 2.0 * slopes_ @ slopes_.T
    covariance = np.linalg.pinv(information)
    return [math.sqrt(max(x, 0.0)) for x in np.diag(covariance)]
