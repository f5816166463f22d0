"""Frames to settings: the same channel, gain and exposure, and one temperature."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from dnanalyze.loaders.captures import Frame, OperatingPoint, Setting
from dnanalyze.loaders.exposures import states
from dnanalyze.loaders.thermometer import clusters, isolated


def group(
    frames: Sequence[tuple[Frame, float | None]],
    tolerance_c: float | None = None,
    tolerance_s: float | None = None,
) -> tuple[Setting, ...]:
    """Settings, sorted by operating point.

    Temperatures are clustered over all frames (`thermometer.clusters`), whatever their channel,
    gain and exposure: a regulated sensor has one temperature for all of them. A point has the mean
    temperature of its cluster; where neighbouring clusters lie nearer than a cluster is wide, as in
    a series of cooling, that of its own frames.

    Parameters
    ----------
    frames : sequence of (Frame, float or None)
        Each with its place in time, where known; otherwise the given order stands.
    tolerance_c : float, optional
        Largest span of the temperatures in one setting, C; by default 1.5, or less where the
        readings scatter by much less than they lie apart.
    tolerance_s : float, optional
        Largest span of the exposures in one setting, s (`exposures.states`).
    """
    state, shared = _states([f.point.temperature_c for f, _ in frames], tolerance_c)
    exposure = states([f.point.exposure_s for f, _ in frames], tolerance_s)
    alike: dict[tuple, list[int]] = defaultdict(list)
    for index, (frame, _) in enumerate(frames):
        point = frame.point
        key = (point.channel, _near(point.gain), exposure[index], state[index])
        alike[key].append(index)
    settings = []
    for (*_, here), indices in alike.items():
        ordered = sorted(indices, key=lambda i: (_order(frames[i][1]), i))
        settings.append(_setting([frames[i][0] for i in ordered], shared.get(here)))
    return tuple(sorted(settings, key=lambda s: s.point.sort_key()))


def _states(
    temperatures: Sequence[float | None], tolerance_c: float | None
) -> tuple[list[int | None], dict[int | None, float]]:
    """The cluster of each frame (None: unknown), and the temperatures that clusters share."""
    known = [(t, i) for i, t in enumerate(temperatures) if t is not None]
    known.sort()
    readings = np.array([t for t, _ in known])
    state: list[int | None] = [None] * len(temperatures)
    shared: dict[int | None, float] = {}
    for number, (first, last) in enumerate(clusters(readings, tolerance_c)):
        for _, index in known[first:last]:
            state[index] = number
        if isolated(readings, first, last):
            shared[number] = _mean([t for t, _ in known[first:last]])
    return state, shared


def _setting(frames: list[Frame], temperature_c: float | None) -> Setting:
    first = frames[0].point
    if temperature_c is None and first.temperature_c is not None:
        temperature_c = _mean([f.point.temperature_c or 0.0 for f in frames])
    exposure_s = first.exposure_s
    if exposure_s is not None:
        exposure_s = _mean([f.point.exposure_s or 0.0 for f in frames], "{:.6g}")
    point = OperatingPoint(temperature_c, exposure_s, first.gain, first.channel)
    return Setting(point, tuple(frames))


def _mean(known: list[float], digits: str = "{:.6f}") -> float:
    """Equal values give exactly that value; else so many digits, free of the sum's tail."""
    if min(known) == max(known):
        return known[0]
    return float(digits.format(math.fsum(known) / len(known)))


def _near(value: float | None) -> float | None:
    """Six significant digits: 0.0499999998 s is 0.05 s."""
    return None if value is None else float(f"{value:.6g}")


def _order(place: float | None) -> float:
    return math.inf if place is None else place
