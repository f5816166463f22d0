"""Repeatability of the statistics: what a second capture of the same sensor would change.

From the frames alone, by the jackknife (Efron and Stein, Ann. Stat. 9, 586 (1981)): the statistics
are taken again without each of the frames. The fixed pattern of the sensor is in all of them and
does not count. What products of two frames add to a statistic, such as a variance over few frames,
counts twice in the variances of the delete-one jackknife; it is measured by leaving out pairs of
frames, and taken off.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.loaders.captures import CaptureSet, Setting, Window

GROUPS = 6  # of frames, at most, that are left out in turn, alone and in 15 pairs
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
    left_out: list[tuple[int, ...]] = [(g,) for g in range(groups)]
    if len(frames) > FEWEST:
        left_out += combinations(range(groups), 2)
    without = {}
    for out in left_out:
        left = tuple(f for n, f in enumerate(frames) if n % groups not in out)
        part = replace(captures, settings=(replace(setting, frames=left),), source=None)
        (taken,) = analyze_windows(part, [window], workers=workers, errors=False)
        without[out] = taken.settings
    return [
        replace(
            plane, values=_with_spread(plane.values, {g: s[k].values for g, s in without.items()})
        )
        for k, plane in enumerate(found)
    ]


def _with_spread(
    whole: dict[str, Value], without: dict[tuple[int, ...], dict[str, Value]]
) -> dict[str, Value]:
    infos = catalogue()
    out = {}
    for name, value in whole.items():
        out[name] = value
        if name not in infos or not all(name in each for each in without.values()):
            continue
        scale = infos[name].scale
        seen = {g: scale.coordinate(each[name].value) for g, each in without.items()}
        variance = jackknife_variance(scale.coordinate(value.value), seen)
        if math.isfinite(variance):
            out[name] = replace(value, repeatability=math.sqrt(variance))
    return out


def jackknife_variance(whole: float, without: dict[tuple[int, ...], float]) -> float:
    """Variance of a statistic of n groups from its values without one or two of them.

    The delete-one estimate doubles, about, what products of two groups add to the variance. With
    the second differences Q of Efron and Stein (1981), of which a product has the coefficients
    2 / (n - 1) where both of its groups are left out, and less elsewhere, that part is known and
    the excess taken off. Where nothing but products is in a statistic the excess is n / (2 (n - 1))
    of the estimate, the most that is taken off.

    Parameters
    ----------
    whole : float
    without : dict
        By the groups that are left out: each alone, and all pairs or none.
    """
    one = np.array([v for out, v in without.items() if len(out) == 1])
    n = len(one)
    variance = float(np.sum((one - one.mean()) ** 2)) * (n - 1) / n
    pairs = [out for out in without if len(out) == 2]
    if not pairs:
        return variance
    second = np.array(
        [n * whole - (n - 1) * (one[i] + one[j]) + (n - 2) * without[i, j] for i, j in pairs]
    )
    both = 2.0 / (n - 1)
    either = both / (n - 2)
    neither = 2.0 * either / (n - 3)
    weight = both**2 + 2 * (n - 2) * either**2 + math.comb(n - 2, 2) * neither**2
    product = float(np.mean((second - second.mean()) ** 2)) / weight
    excess = 2.0 * product / ((n - 1) * (n - 2))
    return variance - min(excess, variance * n / (2 * (n - 1)))
