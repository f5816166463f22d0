"""Frames of known structure, made without the package's own simulator."""

from __future__ import annotations

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.families.family import Family
from dnanalyze.analyzers.statistics import Scale, StatisticInfo, Value
from dnanalyze.analyzers.streaming.accumulation import accumulate

Frames = list[np.ndarray]


def accumulated(frames: Frames) -> Accumulated:
    return accumulate(frames).finish()


def values(family: Family, frames: Frames) -> dict[str, Value]:
    return family.finish(accumulated(frames)).values


def white(rng: np.random.Generator, shape: tuple[int, int], count: int, sd: float = 1.0) -> Frames:
    """Independent Gaussian frames, float32."""
    return [rng.normal(100, sd, shape).astype(np.float32) for _ in range(count)]


def sensor(
    rng: np.random.Generator,
    shape: tuple[int, int] = (192, 160),
    count: int = 4,
    hot: float = 1e-3,
) -> Frames:
    """Log-normal pattern, hot pixels, line offsets, Gaussian temporal noise; whole codes."""
    delta = 0.5
    q = np.exp(delta**2)
    pattern = (rng.lognormal(0, delta, shape) - np.sqrt(q)) / np.sqrt(q * (q - 1)) * 3
    pattern += (rng.random(shape) < hot) * rng.exponential(60, shape)
    pattern += 0.3 * rng.normal(size=(1, shape[1])) + 0.3 * rng.normal(size=(shape[0], 1))
    frames = (100 + pattern + 3 * rng.normal(size=shape) for _ in range(count))
    return [np.rint(f).astype(np.uint16) for f in frames]


def scatter_over_error(
    family: Family, captures: list[Frames], rare: tuple[str, ...] = ()
) -> dict[str, float]:
    """Scatter of each compared statistic over captures, over its stated standard error.

    ``rare`` are counts that are nearly always 0, whose error is an upper limit.
    """
    infos: dict[str, StatisticInfo] = {i.name: i for i in family.INFOS}
    seen: dict[str, list[tuple[float, float]]] = {}
    for frames in captures:
        for name, value in values(family, frames).items():
            assert np.isfinite(value.value), name
            assert np.isfinite(value.se), name
            assert value.se > 0, name
            if infos[name].compared and name not in rare:
                coordinate = infos[name].scale.coordinate(value.value)
                seen.setdefault(name, []).append((coordinate, value.se))
    out = {}
    for name, pairs in seen.items():
        x, se = np.array(pairs).T
        assert len(x) == len(captures), name
        out[name] = float(x.std(ddof=1) / np.sqrt(np.mean(se**2)))
    return out


def log_pull(value: Value, expected: float) -> float:
    """Standard errors between the logs of a value and of what is expected."""
    return float((Scale.LOG.coordinate(value.value) - np.log(expected)) / value.se)
