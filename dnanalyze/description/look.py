"""What a figure shows of a structure: a map, the profile along its geometry, its law."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dnanalyze.description.found import Estimate
from dnanalyze.description.layers import Layers, together
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.thermal import arrhenius

MAX_MAP_SIDE = 128  # pixels of the map, a side
BINS = 48  # of a profile, as drawn


@dataclass(frozen=True)
class Look:
    """Arrays of the figure."""

    map: np.ndarray  # residual map, DN, means of blocks
    title: str  # of the map
    # Profile along the geometry.
    x: np.ndarray
    y: np.ndarray
    along: str  # label of ``x``
    points: list[OperatingPoint]
    # Amplitude at each of them, DN.
    sizes: np.ndarray
    errors: np.ndarray
    fitted: np.ndarray  # by the law


def look(found: Estimate, seen: Layers) -> Look:
    """The arrays for a structure."""
    e = found.effect
    sizes, errors = found.sizes.amplitudes
    grown = _fitted(found, seen)
    map_, title = _map(found, seen, grown)
    x, y, along = _profile(found, seen, map_)
    return Look(_small(map_, e.where), title, x, y, along, seen.points, sizes, errors, grown)


def _fitted(found: Estimate, seen: Layers) -> np.ndarray:
    e = found.effect
    if e.what == "gain":
        return e.gain * seen.dark
    at = seen.points[0].temperature_c
    grown = np.ones(len(seen.points))
    if e.law == "thermal" and at is not None:
        grown = np.array([arrhenius(p.temperature_c, at, e.ea_ev) for p in seen.points])
        size = found.sizes.amplitudes[0]
        return grown * float(size @ grown) / float(grown @ grown)
    return grown * e.amplitude


def _map(found: Estimate, seen: Layers, grown: np.ndarray) -> tuple[np.ndarray, str]:
    e = found.effect
    if e.what == "noise":
        made = np.mean([t.variance.map for t in seen.taken], axis=0)
        return made, "temporal variance − mean [DN²]"
    if e.when == "fixed":
        weight = np.maximum(grown, 1e-9)
        layer = together([t.fixed for t in seen.taken], weight)
        return layer.map * min(t.fixed.noise for t in seen.taken), "mean frame − median [DN]"
    best = int(np.argmax(np.abs(grown) / np.array([t.noise for t in seen.taken])))
    frames = seen.taken[best].temporal
    return np.asarray(frames[0], float), "first frame − mean frame [DN]"


def _small(map_: np.ndarray, where: str) -> np.ndarray:
    """Block means; of a structure of single pixels the corner as it is."""
    if where == "block":
        return map_[:32, :32]
    step = max(1, math.ceil(max(map_.shape) / MAX_MAP_SIDE))
    rows, columns = (n // step for n in map_.shape)
    cut = map_[: rows * step, : columns * step].reshape(rows, step, columns, step)
    return np.asarray(cut.mean(axis=(1, 3)))


def _profile(found: Estimate, seen: Layers, map_: np.ndarray) -> tuple[np.ndarray, np.ndarray, str]:
    e = found.effect
    if e.where == "rings":
        r = np.hypot(seen.row - e.centre_y, seen.column - e.centre_x)
        inside = r < r.min() + 6 * e.period
        return *_binned(r[inside], map_[inside]), "distance from the centre [pixel]"
    if e.where == "wave":
        period = 1.0 / math.hypot(e.u, e.v)
        place = ((e.u * seen.column + e.v * seen.row) % 1.0) * period
        return *_binned(place, map_), "place in the period [pixel]"
    if e.where == "diagonal":
        number = seen.row - seen.column if e.slant == "down" else seen.row + seen.column
        return *_binned(number + 0.0 * map_, map_), "diagonal"
    if e.where in ("column", "column_segments"):
        y = map_.std(axis=0) if e.where == "column_segments" else map_.mean(axis=0)
        return np.arange(y.size) + seen.window.left, y, "column"
    if e.where in ("row", "row_segments"):
        y = map_.std(axis=1) if e.where == "row_segments" else map_.mean(axis=1)
        return np.arange(y.size) + seen.window.top, y, "row"
    if e.where == "block":
        near = seen.row + 0 * seen.column
        place = (near + e.top) % (4 * e.height)
        products = map_[:-1, :-1] * map_[1:, 1:]
        return *_binned(place[:-1, :-1] + 0.0 * products, products), "row in four blocks"
    y = _small(map_, e.where).mean(axis=0)
    x = seen.window.left + (np.arange(y.size) + 0.5) * map_.shape[1] / y.size
    return x, y, "column"


def _binned(place: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means of the values over bins of the place."""
    place = np.broadcast_to(place, value.shape)
    low, high = float(place.min()), float(place.max())
    if high <= low:
        return np.array([low]), np.array([float(value.mean())])
    number = np.minimum(((place - low) / (high - low) * BINS).astype(int), BINS - 1).ravel()
    count = np.bincount(number, minlength=BINS)
    sums = np.bincount(number, value.ravel(), minlength=BINS)
    used = count > 0
    centre = low + (np.arange(BINS) + 0.5) * (high - low) / BINS
    return centre[used], sums[used] / count[used]
