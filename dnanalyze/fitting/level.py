"""The dark level: tolerance and deviation of the mean and median of a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.fitting.level_laws import beyond_laws
from dnanalyze.fitting.moments import pedestal_guess
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.vectors import Target
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import Law, value_at
from dnanalyze.significance import STATED, TOLERATED

MEAN, MEDIAN = "mean", "median"
# A level may be off by `STATED` standard errors of a difference, or by a share of
SIGNAL_SHARE = 0.01  # the dark signal: the level above the measured black level
NOISE = 0.05  # or of the temporal noise of a pixel: 400 frames then tell it from the right level
# A fit holds its own half within less, for the other may lie farther off: 2 errors (`TOLERATED`)
# and half of the shares. Of 35 virtual sensors held to 3 errors one stood at 3.4 over the field.
FIT_SHARE = 0.5
# A level that the laws of black level and dark signal cannot reach may be off by twice what is
# beyond them. Held to less, it outweighed all other statistics of one real CCD (dark signals 10 %
# off proportionality): the loss of its baseline model was 281,000, and is 80,000. So did the colour
# planes of a camera, whose levels are 0.2 DN apart: 15,000 for a loss of 640.
BEYOND = 2.0


@dataclass(frozen=True)
class Level:
    """Largest deviation of the dark level of a model from the measured one.

    Over both halves of the field, as it is stated for a sensor.

    Parameters
    ----------
    kept : bool
        Whether mean and median are within 3 standard errors, 1 % of the dark signal or 5 % of the
        temporal noise, whichever is largest, at every operating point.
    point : OperatingPoint
        Where it is farthest off, in units of what is allowed there.
    plane : str
        Colour plane there, "" for the whole frame.
    difference_dn : float
        Measured less modelled, DN.
    relative : float or None
        The same over the dark signal, the level above the measured black level; None without any.
    standard_errors : float
        The same over its standard error, that of the difference of two captures of such sensors.
    statistic : str
        "mean" or "median": which of them is farthest off.
    """

    kept: bool
    point: OperatingPoint
    plane: str
    difference_dn: float
    relative: float | None
    standard_errors: float
    statistic: str = MEAN


@dataclass(frozen=True)
class DarkSignals:
    """Dark signal and noise of each level of a target; NaN for other statistics.

    Parameters
    ----------
    signal : ndarray
        Level above the measured black level, DN.
    noise : ndarray
        Noise of a pixel there, DN: temporal, or within the frame where there is one.
    """

    signal: np.ndarray
    noise: np.ndarray

    @property
    def tolerance(self) -> np.ndarray:
        """Tolerated deviation of a level regardless of its error, DN."""
        return np.asarray(np.maximum(SIGNAL_SHARE * self.signal, NOISE * self.noise))


def dark_signals(statistics: Statistics, target: Target, black: Law | None = None) -> DarkSignals:
    """The levels above the measured black level.

    Not above the model's pedestal: a fit that moved that down would be allowed more. ``black``: the
    black level over temperature, where all operating points show that it moves.
    """
    seen = Readings(statistics)
    if black is None:
        series = seen.points, seen.value(MEAN)
        black = pedestal_guess(*series, statistics.sensor.black_level, seen.error(MEAN))
    steady = np.nan_to_num(seen.noise)
    signal, noise = np.full((2, len(target.keys)), np.nan)
    for i in np.flatnonzero(np.isin(target.names, (MEAN, MEDIAN))):
        setting = target.keys[i].setting
        signal[i] = max(float(target.values[i]) - value_at(black, seen.points[setting]), 0.0)
        noise[i] = steady[setting]
    return DarkSignals(signal, noise)


def allowed(
    target: Target, signals: DarkSignals, points: Sequence[OperatingPoint], black: Law | None = None
) -> np.ndarray:
    """Deviation of each level that a fit tolerates regardless of its error, DN.

    Infinite for all but the median: hot pixels carry a mean. ``points``: those of the settings. No
    law of black level and dark signal reaches what lies beyond it, or between colour planes.
    """
    found = np.full(len(target.keys), np.inf)
    planes = np.array([k.plane for k in target.keys])
    apart = _between_planes(target)
    for plane in np.unique(planes):
        own = np.flatnonzero((target.names == MEDIAN) & (planes == plane))
        least = FIT_SHARE * signals.tolerance[own]
        there = [points[target.keys[i].setting] for i in own]
        errors = np.maximum(least, TOLERATED * target.reproducibility_sd[own])
        rest = np.abs(beyond_laws(there, target.values[own], errors, black))
        rest = np.maximum(rest, np.where(apart[own] > errors, apart[own], 0.0))
        found[own] = np.maximum(least, BEYOND * rest)
    return found


def _between_planes(target: Target) -> np.ndarray:
    """How far the median of a colour plane is from that of all at its operating point, DN."""
    found = np.zeros(len(target.keys))
    settings = np.array([k.setting for k in target.keys])
    for setting in np.unique(settings):
        own = np.flatnonzero((target.names == MEDIAN) & (settings == setting))
        if own.size:
            found[own] = np.abs(target.values[own] - np.median(target.values[own]))
    return found


def level(
    points: Sequence[OperatingPoint],
    halves: Sequence[Target],
    differences: Sequence[np.ndarray],
    signals: DarkSignals,
) -> Level | None:
    """Compare the level of a model with the measured one; None where no level is measured.

    Parameters
    ----------
    points : sequence of OperatingPoint
    halves : sequence of Target
        The fitted and the held-out half.
    differences : sequence of ndarray
        (measured - model) / reproducibility SD on either.
    signals : DarkSignals
        Of the fitted half.
    """
    first, other = halves
    at = {key: i for i, key in enumerate(other.keys)}
    worst: tuple[float, Level] | None = None
    for i in np.flatnonzero(np.isin(first.names, (MEAN, MEDIAN))):
        key = first.keys[i]
        if key not in at:
            continue
        pairs = list(zip(halves, differences, (int(i), at[key]), strict=True))
        off = float(np.mean([z[n] * half.reproducibility_sd[n] for half, z, n in pairs]))
        # what moves whole frames moves both halves: together they tell no more than either
        error = float(np.mean([half.reproducibility_sd[n] for half, _, n in pairs]))
        signal = float(signals.signal[i])
        away = abs(off) / max(STATED * error, float(signals.tolerance[i]))
        relative = off / signal if signal > 0 else None
        point = points[key.setting]
        seen = Level(away <= 1.0, point, key.plane, off, relative, abs(off) / error, key.name)
        if worst is None or away > worst[0]:
            worst = away, seen
    return None if worst is None else worst[1]
