"""Deviation of the levels of the captures from black level plus activated dark signal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from dnanalyze.fitting.moments import temperature_knots
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import Law, TableLaw, value_at

LARGEST = 50.0  # |ln(DN/s)| of a dark signal
# Of the dark signal: .2 C of a thermometer move it by 2 % at .8 eV, three errors by 6 %, and a
# converter is linear to some percent. A level that is off by less may be due to either.
IRREGULAR = 0.1


def beyond_laws(
    points: Sequence[OperatingPoint],
    levels: np.ndarray,
    tolerance: np.ndarray,
    black: Law | None = None,
) -> np.ndarray:
    """Residual of each level after the best fit of black level plus activated dark signal.

    Level = black + exp(mu) t, with mu a line in 1/T between rows as far apart as a model's, which
    does not fall as the sensor warms, for every gain and channel of its own. Sessions of different
    black levels, a signal that is not proportional to the exposure time and wrong temperatures
    remain.

    Parameters
    ----------
    points : sequence of OperatingPoint
    levels : ndarray
        DN, one a point.
    tolerance : ndarray
        Error of each that does not matter, DN.
    black : Law, optional
        Black level where it is measured to move; else one number is fitted.

    Returns
    -------
    ndarray
        DN, level less law, one a point.

    Examples
    --------
    Dark signals of 10 DN/s at a black level of 100 DN, and one of 30 DN too much:

    >>> points = [OperatingPoint(20.0, float(t)) for t in range(6)]
    >>> levels = np.array([100.0, 110.0, 120.0, 130.0, 140.0, 150.0])
    >>> bool(np.abs(beyond_laws(points, levels, np.ones(6))).max() < 1e-6)
    True
    >>> beyond_laws(points, levels + [0, 0, 0, 30, 0, 0], np.ones(6)).round() + 0.0
    array([ 0.,  0.,  0., 30.,  0.,  0.])
    """
    return _split(points, levels, tolerance, black)[1]


def session_levels(
    points: Sequence[OperatingPoint],
    levels: np.ndarray,
    noise: np.ndarray,
    tolerance: np.ndarray,
    black: Law | None = None,
) -> tuple[TableLaw, np.ndarray] | None:
    """Black level of each operating point where it differs from one to the next.

    A level that is off its laws by more than the noise of a pixel shows in every statistic of a
    frame; one that is off by more than a tenth of the dark signal too is that of no dark signal.

    Parameters
    ----------
    points, levels, tolerance, black
        As for `beyond_laws`.
    noise : ndarray
        Temporal noise of a pixel, DN, one a point.

    Returns
    -------
    (TableLaw, ndarray of bool) or None
        The black level, DN, with a row for each operating point, and which of them differ; None
        where none does.
    """
    base, rest = _split(points, levels, tolerance, black)
    moved = np.abs(rest) > np.maximum(noise, IRREGULAR * (levels - rest - base))
    if not moved.any() or not np.isfinite(base).all():
        return None
    return TableLaw(tuple(points), tuple(np.where(moved, base + rest, base).tolist())), moved


def _split(
    points: Sequence[OperatingPoint],
    levels: np.ndarray,
    tolerance: np.ndarray,
    black: Law | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Black level by its law, NaN where it is not determined, and the residual levels."""
    base, rest = np.full(len(points), np.nan), np.zeros(len(points))
    for kind in dict.fromkeys((p.gain, p.channel) for p in points):
        own = [i for i, p in enumerate(points) if (p.gain, p.channel) == kind]
        laws = _Laws.of([points[i] for i in own], black)
        if len(own) > laws.free:
            base[own], rest[own] = laws.split(levels[own], tolerance[own])
    return base, rest


@dataclass(frozen=True)
class _Laws:
    """Laws of the levels of one gain and channel: their points, exposures and rows of mu."""

    points: list[OperatingPoint]
    exposure: np.ndarray
    rows: tuple[OperatingPoint, ...]
    black: np.ndarray | None

    @classmethod
    def of(cls, points: list[OperatingPoint], black: Law | None) -> _Laws:
        exposure = np.array([1.0 if p.exposure_s is None else p.exposure_s for p in points])
        lit = [p.temperature_c for p in points if p.exposure_s is None or p.exposure_s > 0]
        knots = temperature_knots([t for t in lit if t is not None])
        rows = tuple(OperatingPoint(t) for t in knots) or (OperatingPoint(),)
        known = None if black is None else np.array([value_at(black, p) for p in points])
        return cls(points, exposure, rows, known)

    @property
    def free(self) -> int:
        """Number of free parameters."""
        return len(self.rows) + (self.black is None)

    def at(self, free: np.ndarray) -> np.ndarray:
        """Levels, DN. ``free``: the first row of mu, what each row adds to it, black level."""
        mu = TableLaw(self.rows, tuple(np.cumsum(free[: len(self.rows)])))
        rate = np.exp([np.clip(mu.at(p), -LARGEST, LARGEST) for p in self.points])
        return np.asarray((free[-1] if self.black is None else self.black) + rate * self.exposure)

    def split(self, levels: np.ndarray, tolerance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Black level of the best laws, and levels less these laws, DN."""
        foot = np.min(levels) if self.black is None else self.black
        bright = np.argsort(self.exposure)
        rate = np.maximum(levels - foot, tolerance) / np.maximum(self.exposure, 1e-9)
        mu = np.full(len(self.rows), np.log(np.median(rate[bright[len(bright) // 2 :]])))
        for n, row in enumerate(self.rows):
            at = [i for i in bright if self.points[i].temperature_c == row.temperature_c]
            if at and self.exposure[at[-1]] > 0:
                mu[n] = np.log(rate[at[-1]])
        mu = np.clip(mu, -LARGEST, LARGEST)
        rises = np.maximum(np.diff(mu), 0.0)
        level = [float(foot)] if self.black is None else []
        least = [-np.inf, *np.zeros(len(rises)), *([-np.inf] if self.black is None else [])]
        found = np.array([mu[0], *rises, *level])
        # One session of another black level is not to move all others. Of laws with the same sum
        # of absolute deviations, which the first loss does not tell apart, the second takes that
        # with fewer levels off.
        for loss in ("soft_l1", "cauchy"):
            found = least_squares(
                lambda x: (levels - self.at(x)) / tolerance,
                found,
                bounds=(least, np.inf),  # no dark signal falls as the sensor warms
                loss=loss,
                x_scale="jac",
                max_nfev=200,
            ).x
        black = np.full(len(levels), found[-1]) if self.black is None else self.black
        return black, np.asarray(levels - self.at(found))
