"""Plane waves and rings in a map: frequency by periodogram, geometry by least squares."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy import fft, optimize

from dnanalyze.description.found import Estimate, Sizes
from dnanalyze.description.layers import Layer, Layers, together
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.significance import CERTAIN

TILES = 4  # a side, in which rings about a far centre are plane waves
LEAST_TILE = 16  # pixels a side, in which a wave has a frequency
ENOUGH = 16_384  # pixels of the map from which the first steps look for a geometry
LEAST_CYCLES = 2.5  # over the field: below that a wave is shading
PERIOD_SCATTER = 0.2  # relative scatter of the period over tiles that are of one wave
NEAR_TILES = 5  # that must agree: a chance peak agrees in none
# Powers of 4 x 4 tiles are a chi square of 32 by chance: mean 32, standard deviation 8
PLAIN = 2.0 * TILES**2 + CERTAIN * 2.0 * TILES
ENVELOPES = ("flat", "down", "up", "right", "left")
# Parts of the field, a side, whose phases are free, first steps over those of the begin, and
# simulations of three searches.
SEARCHES = ((4, 1.0, 120), (2, 0.3, 120), (1, 0.1, 60))


@dataclass(frozen=True)
class Front:
    """A geometry of wave fronts: its word, its numbers, and the angle of every n-th pixel."""

    where: str
    names: tuple[str, ...]
    angle: Callable[..., np.ndarray]


def waves(seen: Layers, maps: list[Layer], growth: np.ndarray, what: str) -> Iterator[Estimate]:
    """The best plane wave and the best rings of maps whose pattern grows so over the points."""
    layer = together(maps, growth)
    map_, shape = layer.map, np.array(layer.map.shape)
    wave, rings = _fronts(seen)
    begun, power = _peak(map_ - map_.mean())
    if power < map_.size * math.log(map_.size):  # below that a strongest line is chance
        return
    plane = _polished(wave, begun, map_, 0.1 / shape)
    planes = [
        _estimate(seen, maps, layer, what, wave, values)
        for values in (plane, _exact(plane, shape))
        if np.hypot(*(values * shape)) >= LEAST_CYCLES
    ]
    if not planes:
        return
    yield max(planes, key=lambda e: e.explained)
    centre = _centre(seen, map_)
    if centre is None or _power(map_, rings.angle(centre), TILES) < PLAIN:
        return
    step = np.array([0.05 * min(shape), 0.05 * min(shape), 0.01 * centre[2]])
    values = _polished(rings, centre, map_, step)
    if values[2] >= CompositeEffect.parameters()["period"].lower:
        yield _estimate(seen, maps, layer, what, rings, values)


def _fronts(seen: Layers) -> tuple[Front, Front]:
    """Plane waves of frequencies (v, u); rings about (row, column) of a period."""

    def plane(p: np.ndarray, n: int = 1) -> np.ndarray:
        return 2 * math.pi * (p[0] * seen.row[::n] + p[1] * seen.column[:, ::n])

    def rings(p: np.ndarray, n: int = 1) -> np.ndarray:
        away = np.hypot(seen.row[::n] - p[0], seen.column[:, ::n] - p[1])
        return np.asarray(2 * math.pi * away / p[2])

    names = ("centre_y", "centre_x", "period")
    return Front("wave", ("v", "u"), plane), Front("rings", names, rings)


def _power(map_: np.ndarray, angle: np.ndarray, tiles: int) -> float:
    """Twice the gain of the log likelihood, phases free in each of tiles x tiles parts."""
    turned = map_ * np.exp(-1j * angle)
    rows, columns = (n // tiles for n in map_.shape)
    cut = turned[: rows * tiles, : columns * tiles].reshape(tiles, rows, tiles, columns)
    sums = cut.sum(axis=(1, 3))
    return float(2.0 * np.sum(np.abs(sums) ** 2) / (rows * columns))


def _polished(front: Front, begun: np.ndarray, map_: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Geometry of most power: first where parts of the field keep a phase of their own."""
    here = begun
    for tiles, share, most in SEARCHES:
        # any pixels tell the geometry
        n = 1 if tiles == 1 else max(1, math.ceil(math.sqrt(map_.size / ENOUGH)))
        part = map_[::n, ::n]
        here = optimize.minimize(
            lambda p, n=n, part=part, tiles=tiles: -_power(part, front.angle(p, n), tiles),
            here,
            method="Nelder-Mead",
            options={
                "initial_simplex": np.vstack([here, here + share * np.diag(step)]),
                "maxfev": most,
                "xatol": 1e-7,
                "fatol": 1e-3,
            },
        ).x
    return np.asarray(here)


def _peak(map_: np.ndarray, padded: int = 1) -> tuple[np.ndarray, float]:
    """Frequencies (v, u) and power of the strongest line, not below `LEAST_CYCLES` over the field.

    ``padded``: times the field, with zeros, over which the spectrum is taken.
    """
    rows, columns = (padded * n for n in map_.shape)
    v, u = fft.fftfreq(rows)[:, None], fft.rfftfreq(columns)[None, :]
    slow = np.hypot(v * map_.shape[0], u * map_.shape[1]) < LEAST_CYCLES
    power = np.where(slow, 0.0, np.abs(fft.rfft2(map_, s=(rows, columns))) ** 2)
    i, j = np.unravel_index(int(power.argmax()), power.shape)
    return np.array([v[i, 0], u[0, j]]), float(power.max())


def _exact(values: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Frequencies of 0 and 1/2 where they lie within a third of a mode of these."""
    near = np.round(2.0 * values) / 2.0
    return np.where(np.abs(near - values) * shape < 1 / 3, np.abs(near), values)


def _centre(seen: Layers, map_: np.ndarray) -> np.ndarray | None:
    """Centre and period of rings from the waves of tiles; None where these do not agree.

    The centre lies on the lines through the tiles along their waves' directions.
    """
    rows, columns = (n // TILES for n in map_.shape)
    if min(rows, columns) < LEAST_TILE:
        return None
    window = np.outer(np.hanning(rows), np.hanning(columns))
    first = seen.window.top, seen.window.left
    found = []
    for a, b in np.ndindex(TILES, TILES):
        tile = map_[a * rows : (a + 1) * rows, b * columns : (b + 1) * columns]
        wave, power = _peak((tile - tile.mean()) * window, 2)
        place = np.array([first[0] + (a + 0.5) * rows, first[1] + (b + 0.5) * columns])
        found.append((power, float(np.linalg.norm(wave)), wave, place))
    strongest = sorted(found, key=lambda of: -of[0])[: len(found) // 2]
    middle = float(np.median([size for _, size, _, _ in strongest]))
    near = [of for of in found if abs(of[1] / middle - 1.0) < PERIOD_SCATTER]
    if len(near) < NEAR_TILES:
        return None
    matrix, side = np.zeros((2, 2)), np.zeros(2)
    for power, size, wave, place in near:
        across = power * (np.eye(2) - np.outer(wave, wave) / size**2)
        matrix += across
        side += across @ place
    if np.linalg.cond(matrix) > 1e5:
        return None
    return np.array([*np.linalg.solve(matrix, side), 1.0 / middle])


def _estimate(
    seen: Layers, maps: list[Layer], layer: Layer, what: str, front: Front, values: np.ndarray
) -> Estimate:
    """A wave or rings of a geometry: phase, envelope, errors, sizes over the points."""
    if front.where == "wave":  # whole cycles a pixel are none
        values = values - np.where(np.abs(values) > 0.5, np.round(values), 0.0)
    angle = front.angle(values)
    basis = np.stack([np.cos(angle).ravel(), -np.sin(angle).ravel()])
    size = np.linalg.lstsq(basis @ basis.T, basis @ layer.map.ravel(), rcond=1e-6)[0]
    phase = math.atan2(size[1], size[0])
    if front.where == "wave" and all(abs(x) in (0.0, 0.5) for x in values):
        phase = math.pi / 4.0 if size[0] > 0 else 3.0 * math.pi / 4.0  # values of -1 and 1
    patterns = {
        name: math.sqrt(2.0) * np.cos(angle + phase) * _ramp(name, seen)
        for name in (ENVELOPES if what == "level" else ENVELOPES[:1])
    }
    gains = {
        name: float(np.sum(layer.map * p)) ** 2 / float(np.sum(p**2))
        for name, p in patterns.items()
    }
    envelope = max(gains, key=lambda name: gains[name])
    pattern, numbers = patterns[envelope], dict(zip(front.names, map(float, values), strict=True))
    amount = float(np.sum(pattern**2))
    peak = math.sqrt(2.0) if what == "noise" else 1.0  # a variance A^2 (1 + p / sqrt2)
    sizes = Sizes(
        np.array([peak * float(np.sum(m.map * pattern)) / amount / m.kept for m in maps]),
        np.array([peak * math.sqrt(m.scatter / amount) / m.kept for m in maps]),
        squares=what == "noise",
    )
    effect = CompositeEffect(
        what=what, where=front.where, phase=phase, envelope=envelope,
        **numbers,  # type: ignore[arg-type]
    )  # fmt: skip
    price = (2 + len(values)) * math.log(layer.map.size)
    errors = dict(zip(front.names, _errors(front, values, layer.map), strict=True))
    return Estimate(effect, errors, gains[envelope], price, sizes)


def _ramp(name: str, seen: Layers) -> np.ndarray | float:
    """An envelope of mean square 1 over the frame, as the composite effect has it."""
    if name == "flat":
        return 1.0
    by_row = name in ("down", "up")
    line = seen.row / (seen.shape[0] - 1.0) if by_row else seen.column / (seen.shape[1] - 1.0)
    return math.sqrt(3.0) * (line if name in ("down", "right") else 1.0 - line)


def _errors(front: Front, values: np.ndarray, map_: np.ndarray) -> list[float]:
    """Standard errors of the geometry from the curvature of the log likelihood at its top."""
    size = 2.0 * abs(np.sum(map_ * np.exp(-1j * front.angle(values)))) / map_.size
    if size <= 0:
        return [math.inf] * len(values)
    slopes = []
    for step in np.diag(1e-5 * np.maximum(np.abs(values), 1.0)):
        slope = (front.angle(values + step) - front.angle(values - step)) / (2.0 * step.sum())
        slopes.append((slope - slope.mean()).ravel())
    # information of a cosine of size a in unit noise: a^2 / 2 sum of slope products, phase free
    information = size**2 / 2.0 * np.array(slopes) @ np.array(slopes).T
    return [math.sqrt(max(x, 0.0)) for x in np.diag(np.linalg.pinv(information))]
