"""Statistics as vectors, each on its scale and with its reproducibility standard deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import (
    Scale,
    SettingStatistics,
    StatisticInfo,
    Statistics,
    Value,
)
from dnanalyze.fitting.shading import shading_values
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.significance import CERTAIN, TOLERATED

SCALE = CERTAIN  # of the loss: a difference beyond it counts in proportion, not squared
MISSING = SCALE  # misfit of a statistic that the simulation lacks
Place = tuple[int, str]  # number of the operating point, colour plane


@dataclass(frozen=True)
class Key:
    """Address of a number: setting, colour plane, statistic."""

    setting: int
    plane: str
    name: str


@dataclass(frozen=True)
class Target:
    """Measured statistics with which a model is compared.

    Parameters
    ----------
    keys : tuple of Key
    values : ndarray
        Plain units.
    coordinates : ndarray
        On the statistic's own scale.
    stated : ndarray
        What two independent captures would differ by, on that scale, as the frames tell it: sqrt(2)
        times the standard error.
    families : ndarray of str
    allowed : ndarray, optional
        How far a level may be off while a model is fitted whatever its error, on that scale; inf:
        left to the loss.
    scale : ndarray, optional
        Factor of ``stated`` by the yardstick of a model; 1 by default.
    misfit : float
        Share of the loss that is misfit of a model, not noise, see `weight`; 1 before a model is
        known.
    """

    keys: tuple[Key, ...]
    values: np.ndarray
    coordinates: np.ndarray
    stated: np.ndarray
    families: np.ndarray
    allowed: np.ndarray | None = None
    scale: np.ndarray | None = None
    misfit: float = 1.0

    @cached_property
    def reproducibility_sd(self) -> np.ndarray:
        """Standard deviation of the difference of two sensors of one design, on its scale."""
        return self.stated if self.scale is None else self.stated * self.scale

    def scaled(self, scale: np.ndarray) -> Target:
        """The same numbers by another yardstick."""
        return replace(self, scale=scale)

    def scale_of(self, other: Target) -> np.ndarray:
        """The yardstick of another target for the numbers of this one; 1 where it lacks them."""
        if other.scale is None:
            return np.ones(len(self.keys))
        rows = other.rows_of(self)
        return np.where(rows >= 0, other.scale[rows], 1.0)

    def expressed(self, z: np.ndarray, other: Target) -> np.ndarray:
        """Differences by this yardstick as they are by another."""
        return np.where(
            z == MISSING, MISSING, z * (self.reproducibility_sd / other.reproducibility_sd)
        )

    @cached_property
    def addresses(self) -> list[tuple[Place, str, Scale]]:
        """Of each number its place, its statistic and the scale of that."""
        known = infos()
        return [((k.setting, k.plane), k.name, known[k.name].scale) for k in self.keys]

    def coordinates_of(self, seen: Mapping[Place, Mapping[str, Value]]) -> np.ndarray:
        """Those of other statistics, by place and name, in my order; NaN where one is lacking."""
        return np.array(
            [
                scale.coordinate(seen[place][name].value) if name in seen.get(place, ()) else np.nan
                for place, name, scale in self.addresses
            ]
        )

    def bounds(self, overdispersion: float = 1.0) -> np.ndarray | None:
        """Tolerance of each number in a fit, in reproducibility SDs; inf: none, the loss decides.

        ``overdispersion``: loss a statistic. What is wrong with a model pulls at its levels by as
        much more; the share of the bounds that is due to errors is divided by its root.
        """
        if self.allowed is None:
            return None
        errors = TOLERATED / max(overdispersion, 1.0) ** 0.5
        return np.where(
            np.isinf(self.allowed),
            np.inf,
            np.maximum(errors, self.allowed / self.reproducibility_sd),
        )

    @cached_property
    def names(self) -> np.ndarray:
        """Statistic of each number."""
        return np.array([k.name for k in self.keys])

    @cached_property
    def weight(self) -> np.ndarray:
        """Weight of each number in the loss, 1 in the mean.

        Noise is independent from number to number: each counts once (maximum likelihood). A misfit
        is common to the numbers of a family: families count equally, as in the model error.
        """
        _, which, count = np.unique(self.families, return_inverse=True, return_counts=True)
        balanced = np.asarray(which.size / (count.size * count))[which]
        return np.asarray(1.0 - self.misfit + self.misfit * balanced)

    @cached_property
    def setting(self) -> np.ndarray:
        """Setting of each number."""
        return np.array([k.setting for k in self.keys])

    def only(self, settings: list[int]) -> Target:
        """The numbers of some settings, renumbered."""
        here = np.flatnonzero(np.isin(self.setting, settings))
        keys = tuple(
            Key(settings.index(self.keys[i].setting), self.keys[i].plane, self.keys[i].name)
            for i in here
        )
        arrays = ("values", "coordinates", "stated", "families", "allowed", "scale")
        own = {name: of[here] for name in arrays if (of := getattr(self, name)) is not None}
        return replace(self, keys=keys, **own)

    def rows_of(self, other: Target) -> np.ndarray:
        """Row of each number of another target in this one; -1 where it is not in it."""
        row = {key: i for i, key in enumerate(self.keys)}
        return np.array([row.get(key, -1) for key in other.keys], int)

    def derivatives_of(self, other: Target, jacobian: np.ndarray) -> np.ndarray:
        """Derivatives of this target as those of another; 0 where this one lacks a number.

        A statistic changes alike in every part of the field.
        """
        rows = self.rows_of(other)
        known = rows >= 0
        scale = self.reproducibility_sd[rows[known]] / other.reproducibility_sd[known]
        there = np.zeros((len(other.keys), jacobian.shape[1]))
        there[known] = jacobian[rows[known]] * scale[:, None]
        return there

    def predicted(self, z: np.ndarray) -> np.ndarray:
        """The predictions with these differences; NaN where one is missing."""
        return np.where(z == MISSING, np.nan, self.coordinates - z * self.reproducibility_sd)

    def z(self, predicted: np.ndarray) -> np.ndarray:
        """(measured - predicted) / reproducibility SD; `MISSING` where there is no prediction."""
        return np.nan_to_num((self.coordinates - predicted) / self.reproducibility_sd, nan=MISSING)


def target(statistics: list[Statistics], part: int) -> Target:
    """Measured statistics of one half.

    Parameters
    ----------
    statistics : list of Statistics
        Of the upper and the lower half, in this order.
    part : int
        0 train, 1 test.
    """
    known = infos()
    rows = [
        (key, value, c, np.sqrt(2.0) * se, info.family)
        for key, (value, se, info) in _numbers(statistics, part, known).items()
        if np.isfinite(c := info.scale.coordinate(value)) and np.isfinite(se) and se > 0
    ]
    keys, *columns = zip(*rows, strict=True) if rows else [()] * 5
    values, coordinates, stated, families = map(np.array, columns)
    return Target(tuple(keys), values, coordinates, stated, families)


def places(statistics: Statistics) -> list[Place]:
    """Of each of the settings; colour planes of one operating point share its number."""
    numbers: dict[OperatingPoint, int] = {}
    return [(numbers.setdefault(s.point, len(numbers)), s.plane) for s in statistics.settings]


def prediction(statistics: list[Statistics], part: int, wanted: Target) -> np.ndarray:
    """Simulated coordinates in the order of ``wanted``; NaN where the simulation lacks one."""
    upper, lower = (s.settings for s in statistics)
    triples = zip(places(statistics[part]), upper, lower, strict=True)
    return wanted.coordinates_of(
        {
            place: (above, below)[part].values | shading_values(above, below, part)
            for place, above, below in triples
        }
    )


def _numbers(
    statistics: list[Statistics], part: int, known: dict[str, StatisticInfo]
) -> dict[Key, tuple[float, float, StatisticInfo]]:
    found = {}
    of_upper, of_lower = (s.settings for s in statistics)
    for where, upper, lower in zip(places(statistics[part]), of_upper, of_lower, strict=True):
        halves = [upper, lower]
        setting = halves[part]
        for name, v in setting.values.items():
            info = known.get(name)
            if info is not None and _compared(info, setting):
                found[Key(*where, name)] = (v.value, _shared_error(halves, name, v.se), info)
        colours = [shading_values(upper, lower, colour) for colour in (0, 1)]
        for name, v in colours[part].items():
            key = Key(*where, name)
            se = _together([c[name].se for c in colours])
            if key in found:
                se = max(se, found[key][1])
            found[key] = (v.value, se, known[name])
    return found


def _shared_error(halves: list[SettingStatistics], name: str, own: float) -> float:
    """Standard error from both halves: that of one may be small by chance, as with few codes."""
    return max(own, _together([h.values[name].se for h in halves if name in h.values]))


def _together(errors: Sequence[float]) -> float:
    """Of either of several that are alike, told by all of them."""
    return float(np.sqrt(np.mean(np.square(errors))))


def _compared(info: StatisticInfo, setting: SettingStatistics) -> bool:
    if not info.compared or (info.family == "shading" and info.name[-1].isdigit()):
        return False  # low-order shading is taken over the whole field, see shading.py
    if info.family in ("distribution", "spectrum", "level") and info.name.startswith("frame_"):
        return setting.frames == 1
    return True
