"""What the analyzers give: named values with uncertainties, and curves to draw."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from difflib import get_close_matches
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from dnanalyze.estimate import NORMAL_95, Estimate, place, qtable
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Sensor
from dnanalyze.result import Result

if TYPE_CHECKING:
    import pandas as pd
    from astropy.table import QTable

    from dnanalyze.emva.quantity import Emva

SATURATION = "saturation"  # what is missing of a setting most of whose pixels are saturated


class Scale(StrEnum):
    """On which scale a statistic's sampling error is nearly normal, its spread nearly constant."""

    LINEAR = "linear"
    LOG = "log"  # powers, variances
    ROOT = "root"  # counts: 2 sqrt(n + 3/8), spread 1 for Poisson counts
    RATIO = "ratio"  # power of one mode over its floor: ln(1 + r), for r may be near 0 by chance

    def coordinate(self, value: float) -> float:
        """The value on this scale; NaN where it has none."""
        if self is Scale.LINEAR:
            return value
        if self is Scale.LOG:
            return math.log(value) if value > 0 else math.nan
        if self is Scale.RATIO:
            return math.log1p(value) if value > -1 else math.nan
        return 2.0 * math.sqrt(value + 0.375) if value > -0.375 else math.nan

    def plain(self, coordinate: float) -> float:
        """The value at a place on this scale."""
        if self is Scale.LINEAR:
            return coordinate
        if self is Scale.LOG:
            return math.exp(min(coordinate, 700.0))
        if self is Scale.RATIO:
            return math.expm1(min(coordinate, 700.0))
        return max((max(coordinate, 0.0) / 2.0) ** 2 - 0.375, 0.0)

    def plain_error(self, value: float, error: float) -> float:
        """A standard error on this scale in plain units, to first order; NaN without a place."""
        if self is Scale.LINEAR:
            return error
        if self is Scale.LOG:
            return value * error if value > 0 else math.nan
        if self is Scale.RATIO:
            return (1.0 + value) * error if value > -1 else math.nan
        return math.sqrt(value + 0.375) * error if value > -0.375 else math.nan

    def ends(self, value: float, error: float, reach: float) -> tuple[float, float]:
        """The value less and plus ``reach`` standard errors of this scale, in plain units."""
        here = self.coordinate(value)
        if not math.isfinite(here) or not math.isfinite(error):
            return value, value
        return self.plain(here - reach * error), self.plain(here + reach * error)


@dataclass(frozen=True)
class StatisticInfo:
    """What a statistic is, whatever its value.

    Parameters
    ----------
    name, family, unit : str
    title : str
        A few words for tables and axes.
    scale : Scale
        Scale on which ``Value.se`` is stated and differences are taken.
    high, low : str
        What it says in words when the measurement lies above, or below, the model: "the measured
        temporal dark noise is {ratio} times the model's".
    compared : bool
        Part of the error; False for values that are given for information alone (they follow
        from others, or have no stable sampling error).
    """

    name: str
    family: str
    unit: str
    title: str
    scale: Scale = Scale.LINEAR
    high: str = ""
    low: str = ""
    compared: bool = True


@dataclass(frozen=True)
class Value:
    """A statistic's value in plain units, and its errors on the scale of its info.

    Parameters
    ----------
    value : float
    se : float
        Standard error: of another sensor of the design, as far as one shows it.
    repeatability : float, optional
        Standard deviation over captures of this sensor; None where it was not asked for, or the
        frames do not determine it.
    """

    value: float
    se: float
    repeatability: float | None = None


@dataclass(frozen=True)
class SettingStatistics:
    """All statistics of one operating point and, on a mosaic, one colour plane.

    Parameters
    ----------
    point : OperatingPoint
    plane : str
        Colour plane ("R", "Gr", "Gb", "B"), or "" for the whole frame.
    frames : int
        Frames that went in.
    shape : tuple of int
        (rows, columns) of the plane.
    values : dict
        By name; a statistic that these frames cannot tell is absent.
    curves : dict
        Arrays for figures and first guesses, by name.
    missing : dict
        Statistic or family to the reason, in a sentence, why it is absent.
    """

    point: OperatingPoint
    plane: str
    frames: int
    shape: tuple[int, int]
    values: dict[str, Value]
    curves: dict[str, np.ndarray] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Estimate:
        """Return one statistic with its standard error, interval of 95 % and unit.

        Raises
        ------
        KeyError
            These frames do not determine it, or no statistic has that name.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> noise = dnanalyze.analyze(tiny()).settings[0]["temporal_noise"]
        >>> noise.unit, noise.low < noise.value < noise.high
        ('DN', True)
        """
        from dnanalyze.analyzers.catalogue import catalogue

        if name not in self.values:
            raise KeyError(self.missing.get(name) or _unknown(name, list(self.values)))
        info, found = catalogue()[name], self.values[name]
        error = info.scale.plain_error(found.value, found.se)
        ends = info.scale.ends(found.value, found.se, NORMAL_95)
        return Estimate(found.value, error, info.unit, ends)


def _unknown(name: str, known: list[str]) -> str:
    near = get_close_matches(name, known, 3) or known[:8]
    return f"{name}: not measured; such as: {', '.join(near)}"


@dataclass(frozen=True, repr=False)
class Statistics(Result):
    """Statistics of a capture set.

    Parameters
    ----------
    name : str
        Name of the captures.
    sensor : Sensor
        What the files state of the sensor.
    settings : tuple of SettingStatistics
        One an operating point and colour plane.
    trends : dict
        Quantities over temperature (activation energy, doubling temperature, ...), by name, with
        standard errors.
    captures : CaptureSet, optional
        The frames, which are not read again but for figures.
    system_gain : float, optional
        Overall system gain K, DN/e-, as the user states it.
    """

    name: str
    sensor: Sensor
    settings: tuple[SettingStatistics, ...]
    trends: dict[str, Value] = field(default_factory=dict)
    captures: CaptureSet | None = field(default=None, compare=False)
    system_gain: float | None = None

    @property
    def emva(self) -> Emva:
        """The dark quantities of EMVA 1288 Release 4.0.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> table = dnanalyze.analyze(tiny(), system_gain=0.5).emva.to_dataframe()
        >>> float(table[table["quantity"] == "system_gain_dn_e"]["value"].iloc[0])
        0.5
        """
        from dnanalyze.emva.evaluate import evaluate

        return evaluate(self, self.system_gain)

    def __getitem__(self, name: str) -> pd.DataFrame:
        """Return one statistic at every operating point.

        Parameters
        ----------
        name : str
            Name of the statistic, such as "temporal_noise".

        Returns
        -------
        pandas.DataFrame
            One row an operating point and colour plane: value, standard error and ends of the
            interval of 95 %, in the unit of the value.

        Raises
        ------
        KeyError
            These frames do not determine it, or no statistic has that name.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> noise = dnanalyze.analyze(tiny())["temporal_noise"]
        >>> bool((noise["low"] < noise["value"]).all())
        True
        """
        table = self.to_dataframe()
        own = table[table["name"] == name]
        if not len(own):
            raise KeyError(_unknown(str(name), table["name"].unique().tolist()))
        return own.drop(columns=["name", "family", "se_scaled", "scale"]).reset_index(drop=True)

    def to_qtable(self) -> QTable:
        """Return all statistics as a table of quantities with units.

        Returns
        -------
        astropy.table.QTable
            One row an operating point and colour plane; each statistic and, as ``name_se``, its
            standard error in the unit of the value.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> table = dnanalyze.analyze(tiny()).to_qtable()
        >>> len(table), table["temporal_noise"].unit, table["exposure_s"].unit
        (3, Unit("DN"), Unit("s"))
        """
        names = dict.fromkeys(name for s in self.settings for name in s.values)
        return qtable(
            [
                {**place(s.point), "plane": s.plane}
                | {name: s[name] for name in names if name in s.values}
                for s in self.settings
            ]
        )

    def _brief(self) -> str:
        points = len({s.point for s in self.settings})
        count = sum(len(s.values) for s in self.settings)
        return f"{self.name}, operating points: {points}, values: {count}"
