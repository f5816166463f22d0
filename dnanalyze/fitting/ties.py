"""Direct measurements of parameters as normal constraints of a fit.

A photon transfer, a gain recorded by the camera or given by the user, and the black level that bias
frames show say more of a parameter than the statistics of single operating points, and say it of
settings that are not simulated too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.emva import evaluate, kinds
from dnanalyze.fitting.free_parameters import PEDESTAL, FreeParameter
from dnanalyze.fitting.level import NOISE, SIGNAL_SHARE
from dnanalyze.fitting.level_laws import session_levels
from dnanalyze.fitting.moments import BlackLevel, black_level
from dnanalyze.fitting.readings import Readings
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.significance import STATED, TOLERATED

# Relative error of a gain that the camera states, or the user. A quantity of a model that is off by
# less agrees.
RECORDED = 0.1
GAIN_TOLERANCE = 0.03  # of a photon transfer: levels of a few pixels within, and nonlinearity
LEAST_ERROR = 1e-3  # DN, of a level: frames of one code all over state none
TRANSFER = "photon transfer"
GAIN = ("dark_shot_noise", "dn_per_e")
# Effects by which the temporal noise over the level is not that of shot noise.
AFTER = ("denoise", "temporal_denoise", "electron_multiplication")


@dataclass(frozen=True)
class Known:
    """A quantity of the sensor, measured directly or recorded in the files.

    Parameters
    ----------
    value, error : float
        In its unit.
    source : str
        Such as "photon transfer", "recorded".
    """

    value: float
    error: float
    source: str


@dataclass(frozen=True)
class SessionLevels:
    """Black level of each operating point, where it differs from one to the next.

    Parameters
    ----------
    law : TableLaw
        DN, a row for each operating point.
    errors : ndarray
        Standard errors of its rows, DN.
    moved : tuple of OperatingPoint
        Those whose level is off the others' laws; their dark signal is not told from it.
    """

    law: TableLaw
    errors: np.ndarray
    moved: tuple[OperatingPoint, ...]


@dataclass(frozen=True)
class Direct:
    """Direct measurements that constrain a fit.

    Parameters
    ----------
    gains : tuple of (float or None, Known)
        Setting of the gain, and system gain there, DN/e-.
    level : BlackLevel, optional
        Where bias frames or exposures show it.
    sessions : SessionLevels, optional
        Where the black level differs from one operating point to the next.
    """

    gains: tuple[tuple[float | None, Known], ...] = ()
    level: BlackLevel | None = None
    sessions: SessionLevels | None = None

    @property
    def black(self) -> TableLaw | None:
        """The black level where it moves, DN: by session, or over temperature."""
        if self.sessions is not None:
            return self.sessions.law
        return self.level.law if self.level is not None and self.level.moves else None

    def black_at(self, points: Sequence[OperatingPoint]) -> TableLaw | None:
        """`black`, of sessions with rows for these operating points alone; None where it is one."""
        own = self.sessions
        if own is None:
            return self.black
        if not set(points) & set(own.moved):
            return replace(self, sessions=None).black
        return TableLaw(tuple(points), tuple(own.law.at(p) for p in points))

    def gains_at(self, setting: float | None) -> list[Known]:
        """System gains at a setting of the gain, DN/e-; that of photon transfer first.

        Photon transfers at other settings count in proportion to these, if they agree.
        """
        found = [known for at, known in self.gains if at in (None, setting)]
        other = [k for at, k in self._transfers(setting) if at != setting]
        own = next((k for k in found if k.source == TRANSFER), None)
        if not other or any(own and not _agree(own, k) for k in other):
            return found
        rest = [k for k in found if k is not own]
        return [_mean([*([own] if own else []), *other]), *rest]

    def _transfers(self, setting: float | None) -> list[tuple[float, Known]]:
        """Photon transfers at each setting that is known, in proportion at this one."""
        return [
            (at, replace(k, value=k.value * setting / at, error=k.error * setting / at))
            for at, k in self.gains
            if setting and at and k.source == TRANSFER
        ]

    def gains_of(self, model: NoiseModel) -> list[Known]:
        """System gains that constrain a model; none where a filter follows the shot noise."""
        if any(model.get(name) is not None for name in AFTER):
            return []
        return self.gains_at(model.reference.gain)

    def ties(
        self,
        model: NoiseModel,
        free: Sequence[FreeParameter],
        shape: tuple[int, int],
        overdispersion: float = 1.0,
    ) -> tuple[Tie, ...]:
        """Constraints of the free parameters of a model.

        The level of frames without exposure is that of the model with its fixed offsets
        (`black_shift`). ``shape``: full frame.

        ``overdispersion``: loss a statistic. What is wrong with a model pulls at its parameters by
        as much more; the errors of the constraints are divided by its root.
        """
        found = []
        for i, parameter in enumerate(free):
            if (parameter.effect, parameter.parameter) == GAIN and parameter.part == "value":
                found += self._of_gain(i, parameter, model)
            elif parameter.effect == PEDESTAL:
                found += self._of_black(i, parameter, model, shape)
        sharper = max(overdispersion, 1.0) ** 0.5
        return tuple(replace(t, error=t.error / sharper) for t in found)

    def _of_gain(self, at: int, parameter: FreeParameter, model: NoiseModel) -> list[Tie]:
        times = digital_gain(model)
        return [
            Tie(
                at,
                parameter.position(g.value / times),
                g.error / (g.value if parameter.log else 1.0),
            )
            for g in self.gains_of(model)
        ]

    def _of_black(
        self, at: int, parameter: FreeParameter, model: NoiseModel, shape: tuple[int, int]
    ) -> list[Tie]:
        law, level = model.pedestal, self.level
        if not isinstance(law, TableLaw):
            if level is None or level.moves:
                return []
            shift = model.black_shift(model.reference, shape)
            return [Tie(at, level.mean - shift, level.error)]
        point, rows = law.points[int(parameter.part)], self.sessions or self.level
        if rows is None or point not in rows.law.points:
            return []
        row = rows.law.points.index(point)
        black = rows.law.values[row] - model.black_shift(point, shape)
        return [Tie(at, black, float(rows.errors[row]))]


def _agree(one: Known, other: Known) -> bool:
    return abs(one.value - other.value) <= STATED * float(np.hypot(one.error, other.error))


def _mean(found: Sequence[Known]) -> Known:
    """Weighted mean of gains, good to `GAIN_TOLERANCE`, or half of their range, at best."""
    value, error = np.array([(k.value, k.error) for k in found]).T
    mean = float(np.average(value, weights=error**-2.0))
    least = max(GAIN_TOLERANCE * mean, float(np.ptp(value)) / 2)
    return Known(mean, max(float(np.sum(error**-2.0) ** -0.5), least), found[0].source)


def digital_gain(model: NoiseModel) -> float:
    """Factor of the codes after the converter; 1 without one."""
    effect = model.get("digital_gain")
    return 1.0 if effect is None else float(effect.value("gain", model.reference))


def direct(statistics: Statistics) -> Direct:
    """The direct measurements of all operating points.

    Parameters
    ----------
    statistics : Statistics
        The level, time and neighbours families at least, with errors.
    """
    seen = Readings(statistics)
    level = black_level(seen.points, seen.value("median"), seen.error("median"))
    gains: list[tuple[float | None, Known]] = []
    groups = [g for g in evaluate(statistics).groups if g.channel is None]
    for setting in dict.fromkeys(g.gain for g in groups):
        own = [g.quantities for g in groups if g.gain == setting]
        found = [q[kinds.TRANSFER.key] for q in own if kinds.TRANSFER.key in q]
        transfers = [
            Known(q.value, q.se, TRANSFER)
            for q in found
            if q.value is not None and q.se is not None
        ]
        if transfers and len(transfers) == len(found):
            gains.append((setting, _mean(transfers)))
        recorded = own[0][kinds.GAIN.key].value if kinds.GAIN.key in own[0] else None
        if recorded is not None:
            gains.append((setting, Known(recorded, RECORDED * recorded, "recorded")))
    return Direct(tuple(gains), level, _sessions(seen, level))


def _sessions(seen: Readings, level: BlackLevel | None) -> SessionLevels | None:
    """The black levels of operating points that do not follow the laws of the others."""
    medians, errors = seen.value("median"), seen.error("median")
    noise = seen.noise
    signal = np.maximum(medians - np.nanmin(medians), 0.0)
    off = np.maximum.reduce([TOLERATED * errors, NOISE * noise, SIGNAL_SHARE * signal])
    off = np.maximum(off, LEAST_ERROR)
    if not (np.isfinite(medians).all() and np.isfinite(off).all()):
        return None
    black = level.law if level is not None and level.moves else None
    found = session_levels(seen.points, medians, noise, off, black)
    if found is None:
        return None
    law, moved = found
    return SessionLevels(law, off, tuple(p for p, m in zip(seen.points, moved, strict=True) if m))


@dataclass(frozen=True)
class Tie:
    """A normal constraint of one free parameter.

    Parameters
    ----------
    at : int
        Its number among the free parameters.
    position, error : float
        Mean and standard deviation on the parameter's scale.
    """

    at: int
    position: float
    error: float


def misfits(ties: Sequence[Tie], here: np.ndarray) -> np.ndarray:
    """Deviations of parameters from their constraints, in standard deviations."""
    return np.array([(here[t.at] - t.position) / t.error for t in ties])
