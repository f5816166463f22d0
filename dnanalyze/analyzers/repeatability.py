"""Repeatability of the statistics: what a second capture of the same sensor would change.

From the frames alone, by the delete-one jackknife (Efron and Stein, Ann. Stat. 9, 586 (1981)): the
statistics are taken again without each of the frames. The fixed pattern of the sensor is in all of
them and does not count.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.loaders.captures import CaptureSet, Setting, Window

GROUPS = 8  # of frames, at most, that are left out in turn
FEWEST = 3  # frames, without one of which there still are two


def repeatability(
    captures: CaptureSet,
    statistics: Statistics,
    *,
    window: Window | None = None,
    workers: int | None = None,
) -> Statistics:
    """The same statistics, each value with its standard deviation over captures of the sensor.

    Parameters
    ----------
    captures : CaptureSet
        Frames of one sensor; those of an operating point are taken for independent.
    statistics : Statistics
        Of all frames of ``captures``.
    window : Window, optional
        Part of the frame that ``statistics`` covers.
    workers : int, optional
        Threads; the number of processors by default.

    Returns
    -------
    Statistics
        `Value.repeatability` on the scale of each statistic; None at operating points of fewer than
        three frames, and for statistics that some of the frames do not determine.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.analyzers.repeatability import repeatability
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> statistics = repeatability(captures, dnanalyze.analyze(captures))
    >>> mean = statistics.settings[0].values["mean"]
    >>> mean.repeatability < mean.se
    True
    """
    settings = []
    for setting in captures.settings:
        found = [s for s in statistics.settings if s.point == setting.point]
        enough = len(setting.frames) >= FEWEST
        settings += _jackknife(captures, setting, found, window, workers) if enough else found
    return replace(statistics, settings=tuple(settings))


def _jackknife(
    captures: CaptureSet,
    setting: Setting,
    found: list[SettingStatistics],
    window: Window | None,
    workers: int | None,
) -> list[SettingStatistics]:
    """One setting, by colour plane."""
    frames = setting.frames
    groups = min(GROUPS, len(frames))
    without = []
    for group in range(groups):
        left = tuple(f for n, f in enumerate(frames) if n % groups != group)
        part = replace(captures, settings=(replace(setting, frames=left),), source=None)
        (taken,) = analyze_windows(part, [window], workers=workers, errors=False)
        without.append(taken.settings)
    return [
        replace(plane, values=_with_spread(plane.values, [each[k].values for each in without]))
        for k, plane in enumerate(found)
    ]


def _with_spread(whole: dict[str, Value], without: list[dict[str, Value]]) -> dict[str, Value]:
    infos, count = catalogue(), len(without)
    out = {}
    for name, value in whole.items():
        out[name] = value
        if name not in infos or not all(name in each for each in without):
            continue
        seen = np.array([infos[name].scale.coordinate(each[name].value) for each in without])
        if np.isfinite(seen).all():
            variance = float(np.sum((seen - seen.mean()) ** 2)) * (count - 1) / count
            out[name] = replace(value, repeatability=math.sqrt(variance))
    return out
