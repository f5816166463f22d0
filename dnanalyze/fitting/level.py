"""The mean dark level: how far a model may be off in it, and how far it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.fitting.moments import black_over_temperature, pedestal_guess
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.vectors import Target
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import Law, value_at

MEAN = "mean"
ERRORS = 3.0  # standard errors of a difference that a level may be off
SHARE = 0.01  # or of the dark signal: the mean above the measured black level
# A fit holds its own half within less, for the other may lie farther off: 2 errors and half of the
# share. Of 35 virtual sensors that were held to 3 errors one stood at 3.4 over the whole field.
FIT_ERRORS, FIT_SHARE = 2.0, 0.005


@dataclass(frozen=True)
class Level:
    """The mean dark level of a model against the measured one, where it is farthest off.

    Over both halves of the field, as it is stated for a sensor.

    Parameters
    ----------
    kept : bool
        Whether it is within 3 standard errors, or 1 % of the dark signal, at every operating point.
    point : OperatingPoint
        Where it is farthest off, in units of what is allowed there.
    plane : str
        Colour plane there, "" for the whole frame.
    difference_dn : float
        Measured less modelled, DN.
    relative : float or None
        The same over the dark signal, the mean above the measured black level; None without any.
    standard_errors : float
        The same over its standard error, that of the difference of two captures of such sensors.
    """

    kept: bool
    point: OperatingPoint
    plane: str
    difference_dn: float
    relative: float | None
    standard_errors: float


def dark_signals(statistics: Statistics, held: Target) -> np.ndarray:
    """Mean above the measured black level at each number that is a level, DN; NaN at others.

    Not above the model's pedestal: a fit that moved that down would be allowed more.
    """
    seen = Readings(statistics)
    series = seen.points, seen.value(MEAN)
    error = seen.error(MEAN)
    black: Law | None = black_over_temperature(*series, error)
    if black is None:
        black = pedestal_guess(*series, statistics.sensor.black_level, error)
    found = np.full(len(held.keys), np.nan)
    for i in np.flatnonzero(held.names == MEAN):
        point = seen.points[held.keys[i].setting]
        found[i] = max(float(held.values[i]) - value_at(black, point), 0.0)
    return found


def allowed(held: Target, signals: np.ndarray) -> np.ndarray:
    """How far each number may be off while a model is fitted, DN; inf for no level.

    Parameters
    ----------
    held : Target
        Of the fitted half.
    signals : ndarray
        Of `dark_signals`.
    """
    least = np.maximum(FIT_ERRORS * held.floor, FIT_SHARE * np.nan_to_num(signals))
    return np.where(np.isnan(signals), np.inf, least)


def level(
    points: Sequence[OperatingPoint],
    halves: Sequence[Target],
    differences: Sequence[np.ndarray],
    signals: np.ndarray,
) -> Level | None:
    """Hold the mean level of a model against the measured one; None where no level is measured.

    Parameters
    ----------
    points : sequence of OperatingPoint
    halves : sequence of Target
        The fitted and the judged half.
    differences : sequence of ndarray
        (measured - model) / floor on either.
    signals : ndarray
        Of `dark_signals`, on the fitted half.
    """
    first, other = halves
    at = {key: i for i, key in enumerate(other.keys)}
    worst: tuple[float, Level] | None = None
    for i in np.flatnonzero(first.names == MEAN):
        key = first.keys[i]
        if key not in at:
            continue
        pairs = list(zip(halves, differences, (int(i), at[key]), strict=True))
        off = float(np.mean([z[n] * half.floor[n] for half, z, n in pairs]))
        # what moves whole frames moves both halves: together they tell no more than either
        error = float(np.mean([half.floor[n] for half, _, n in pairs]))
        away = abs(off) / max(ERRORS * error, SHARE * float(signals[i]))
        relative = off / float(signals[i]) if signals[i] > 0 else None
        point = points[key.setting]
        seen = Level(away <= 1.0, point, key.plane, off, relative, abs(off) / error)
        if worst is None or away > worst[0]:
            worst = away, seen
    return None if worst is None else worst[1]
