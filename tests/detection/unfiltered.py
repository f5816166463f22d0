"""Fresh unfiltered series for counts of false alarms: clustered, saturated and ordinary sensors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage
from virtual_sensor import Stack, Traits, VirtualSensor, from_stacks, random_traits

from dnanalyze.loaders.captures import CaptureSet

KINDS = ("clustered", "saturated", "ordinary")
SIZES = (128, 160, 192, 256, 384, 512)
TEMPERATURES_C = (25.0, 45.0, 65.0, 85.0, 105.0)


@dataclass(frozen=True)
class Clusters:
    """Hot pixels that come in clusters.

    Parameters
    ----------
    density : float
        Hot pixels per pixel.
    size : float
        Mean number of hot pixels of a cluster; 1: single ones.
    radius : int
        Pixels; members lie within a square of this reach about the first.
    law : str
        Of the amplitudes: "exponential", "lognormal", "power" (Pareto of index 1.5) or "constant"
        (the same in a cluster, exponential over clusters).
    """

    density: float
    size: float
    radius: int
    law: str

    def draw(self, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
        """Amplitudes, of unit scale; 0 for pixels that are not hot."""
        field = np.zeros(shape, np.float32)
        parents = rng.poisson(self.density * field.size / self.size)
        members = 1 + rng.poisson(self.size - 1, parents)
        own = np.repeat(np.arange(parents), members)
        first = np.r_[0, np.cumsum(members)[:-1]] if parents else np.empty(0, int)
        away = rng.integers(-self.radius, self.radius + 1, (own.size, 2))
        away[first] = 0
        at = (rng.integers(0, shape, (parents, 2))[own] + away) % shape
        np.add.at(field, (at[:, 0], at[:, 1]), self._amplitudes(own, parents, rng))
        return field

    def _amplitudes(self, own: np.ndarray, parents: int, rng: np.random.Generator) -> np.ndarray:
        draws: dict[str, Callable[[], np.ndarray]] = {
            "exponential": lambda: rng.exponential(1.0, own.size),
            "lognormal": lambda: rng.lognormal(-0.5, 1.0, own.size),
            "power": lambda: 0.3 * (1 + rng.pareto(1.5, own.size)),
            "constant": lambda: rng.exponential(1.0, parents)[own],
        }
        return draws[self.law]().astype(np.float32)


def random_clusters(rng: np.random.Generator) -> Clusters:
    """Wide laws of density, size, reach and amplitude."""
    return Clusters(
        float(np.exp(rng.uniform(np.log(1e-5), np.log(3e-3)))),
        float(rng.uniform(1.0, 8.0)),
        int(rng.integers(1, 4)),
        str(rng.choice(["exponential", "lognormal", "power", "constant"])),
    )


def clustered_sensor(
    traits: Traits, clusters: Clusters, shape: tuple[int, int], seed: int
) -> VirtualSensor:
    """A virtual sensor whose hot pixels are these clusters."""
    sensor = VirtualSensor(replace(traits, hot=0.0), shape, seed)
    hot = clusters.draw(shape, np.random.default_rng([seed, 2]))
    sensor._hot = (traits.dark * traits.hot_scale * hot).astype(np.float32)
    return sensor


class FullWell(VirtualSensor):
    """Pixels that hold no more charge than their full well; the rest blooms or drains."""

    well: np.ndarray
    bloom: float = 0.0  # share of the excess that goes to neighbours of the column

    def held(self, arrived: np.ndarray) -> np.ndarray:
        """What stays in the pixels."""
        held = np.minimum(arrived, self.well)
        excess = self.bloom * (arrived - held)
        for _ in range(32 if self.bloom else 0):
            if not excess.any():
                break
            spilled = ndimage.convolve1d(excess, [0.5, 0.0, 0.5], axis=0, mode="constant")
            filled = held + spilled
            held = np.minimum(filled, self.well)
            excess = filled - held
        return held


def full_well_sensor(
    traits: Traits, well_e: float, spread: float, smooth: float, bloom: float,
    shape: tuple[int, int], seed: int,
) -> FullWell:  # fmt: skip
    """``spread``: relative, over pixels; ``smooth``: its correlation length, pixels."""
    sensor = FullWell(traits, shape, seed)
    field = np.random.default_rng([seed, 3]).standard_normal(shape)
    if smooth:
        field = ndimage.gaussian_filter(field, smooth)
        field /= field.std()
    sensor.well = (well_e * (1 + spread * field)).astype(np.float32)
    sensor.bloom = bloom
    return sensor


def series(kind: str, seed: int, largest: int = 512) -> tuple[CaptureSet, str]:
    """A random unfiltered series of a kind, with what it is in words."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    side = int(rng.choice([s for s in SIZES if s <= largest]))
    shape = (side, side)
    count = int(rng.integers(1, len(TEMPERATURES_C) + 1))
    temperatures = tuple(sorted(rng.choice(TEMPERATURES_C, count, replace=False).tolist()))
    frames = int(rng.integers(2, 9))
    traits = random_traits(rng)
    said = f"{side} px, {frames} frames, {temperatures}"
    change: dict[float, Callable[[Stack], Stack]] = {}
    if kind == "clustered":
        if rng.random() < 0.5:  # little else that could hide what clusters do
            traits = Traits(
                gain=float(rng.uniform(0.5, 3.0)), dark=traits.dark, hot_scale=traits.hot_scale,
                white=65535.0,
            )  # fmt: skip
        clusters = random_clusters(rng)
        sensor: VirtualSensor = clustered_sensor(traits, clusters, shape, seed)
        said += f", {clusters}"
    elif kind == "saturated":
        sensor, change, how = _saturated(traits, shape, temperatures, seed, rng)
        said += f", {how}"
    else:
        sensor = VirtualSensor(traits, shape, seed)
    return _captures(sensor, temperatures, frames, change), said


def _saturated(
    traits: Traits, shape: tuple[int, int], temperatures: tuple[float, ...], seed: int,
    rng: np.random.Generator,
) -> tuple[VirtualSensor, dict[float, Callable[[Stack], Stack]], str]:  # fmt: skip
    how = str(rng.choice(["top", "well", "bottom"]))
    some = [t for t in temperatures if rng.random() < 0.6] or [temperatures[-1]]
    if how == "well":
        traits = replace(traits, white=65535.0, gain=max(traits.gain, 1.0 / traits.read))
        spread = float(rng.choice([0.0, 1.0]) * np.exp(rng.uniform(np.log(1e-4), np.log(1e-2))))
        smooth = float(rng.choice([0.0, rng.uniform(1.0, 20.0)]))
        bloom = float(rng.choice([0.0, rng.uniform(0.3, 1.0)]))
        plain = VirtualSensor(traits, shape, seed)
        hottest = plain.charge(some[0])
        beyond = float(np.exp(rng.uniform(np.log(1e-3), np.log(0.999))))
        if rng.random() < 0.5:
            beyond = 1 - beyond
        well = max(float(np.quantile(hottest, 1 - beyond)), 20.0)
        sensor = full_well_sensor(traits, well, spread, smooth, bloom, shape, seed)
        return sensor, {}, (
            f"well {well:.4g} e- ({beyond:.2%} at {some[0]} C), spread {spread:.2g} over "
            f"{smooth:.2g} px, bloom {bloom:.2g}"
        )  # fmt: skip
    share = float(np.exp(rng.uniform(np.log(0.01), np.log(0.999))))
    if rng.random() < 0.5:
        share = min(1 - share + 1e-3, 0.999)

    def cut(stack: Stack) -> Stack:
        level = np.quantile(stack, share if how == "bottom" else 1 - share, method="nearest")
        if how == "bottom":
            return np.maximum(stack, level) - np.uint16(level)
        return np.minimum(stack, level)

    sensor = VirtualSensor(traits, shape, seed)
    return sensor, dict.fromkeys(some, cut), f"{how} cuts {share:.2%} at {some} C"


def _captures(
    sensor: VirtualSensor, temperatures: tuple[float, ...], frames: int,
    change: dict[float, Callable[[Stack], Stack]],
) -> CaptureSet:  # fmt: skip
    held: dict[float, Stack] = {}

    def stack(t: float) -> Stack:
        if t not in held:
            made = sensor.stack(t, frames)
            held[t] = change[t](made) if t in change else made
        return held[t]

    return from_stacks({t: lambda t=t: stack(t) for t in temperatures}, sensor.shape, frames)
