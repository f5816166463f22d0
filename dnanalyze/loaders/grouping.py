"""Frames to settings: the same channel, gain and exposure, and nearly the same temperature."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence

from dnanalyze.loaders.captures import Frame, OperatingPoint, Setting


def group(frames: Sequence[tuple[Frame, float | None]], tolerance_c: float) -> tuple[Setting, ...]:
    """Settings, sorted by operating point.

    Within one channel, gain and exposure the frames are sorted by temperature, and a group takes
    the next frame while its span stays within the tolerance. Its point has the mean temperature.

    Parameters
    ----------
    frames : sequence of (Frame, float or None)
        Each with its place in time, where known; otherwise the given order stands.
    tolerance_c : float
        Largest span of the temperatures in one setting, C.
    """
    alike: dict[tuple, list[int]] = defaultdict(list)
    for index, (frame, _) in enumerate(frames):
        point = frame.point
        known = point.temperature_c is not None
        alike[(point.channel, _near(point.gain), _near(point.exposure_s), known)].append(index)
    settings = []
    for indices in alike.values():
        for span in _spans(indices, [f.point.temperature_c for f, _ in frames], tolerance_c):
            ordered = sorted(span, key=lambda i: (_order(frames[i][1]), i))
            settings.append(_setting([frames[i][0] for i in ordered]))
    return tuple(sorted(settings, key=lambda s: s.point.sort_key()))


def _spans(
    indices: list[int], temperatures: Sequence[float | None], tolerance_c: float
) -> Iterable[list[int]]:
    span: list[int] = []
    start = 0.0
    for index in sorted(indices, key=lambda i: temperatures[i] or 0.0):
        here = temperatures[index] or 0.0
        if span and here - start > tolerance_c + 1e-9:
            yield span
            span = []
        if not span:
            start = here
        span.append(index)
    yield span


def _setting(frames: list[Frame]) -> Setting:
    first = frames[0].point
    known = [f.point.temperature_c for f in frames if f.point.temperature_c is not None]
    mean = None
    if known:
        # equal temperatures must give exactly that temperature, not a rounded sum
        mean = known[0] if min(known) == max(known) else math.fsum(known) / len(known)
    point = OperatingPoint(mean, first.exposure_s, first.gain, first.channel)
    return Setting(point, tuple(frames))


def _near(value: float | None) -> float | None:
    """Six significant digits: 0.0499999998 s is 0.05 s."""
    return None if value is None else float(f"{value:.6g}")


def _order(place: float | None) -> float:
    return math.inf if place is None else place
