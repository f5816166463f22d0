"""Margins that a correct simulation keeps: targets from a measurement, with a model or without.

A limit is k spreads wide, k the quantile of Student's t for the wanted rate of false failures
shared out over all limits (Bonferroni: safe whatever their correlations). The spread comes from the
statistic's own standard error and, with a model, from its scatter over simulated sensors: a new
seed draws a new silicon, and what CI sees is exactly that scatter. On a log scale, where a wide
spread means a variance of few degrees of freedom, such as that of four frames' means, the limit is
at least the quantile of chi square (of F, for two captures): its low tail is heavy.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from dnanalyze.analyzers.catalogue import find as find_statistic
from dnanalyze.analyzers.statistics import Scale, Statistics
from dnanalyze.checking.check_data import CheckData
from dnanalyze.checking.targets import SCHEMA, At, Origin, Target, Targets
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.progress import ignored

RATE = 1e-3
REPLICATES = 16
BLOCK_FREEDOM = 8  # degrees of freedom that a standard error from blocks is trusted with
VAGUE = math.log(30.0)  # half width on a log scale from which a limit says nothing
LEAST_SPREAD = 0.02  # on a log scale; below it a chi square is as good as normal
SMALLEST_ERROR = 0.03  # relative spread of an error over seeds, at least
HEADLINE = (
    "mean", "median", "temporal_noise", "temporal_noise_core", "pattern_noise",
    "pattern_noise_core", "frame_noise_core", "pattern_q0.01", "pattern_q0.99", "pattern_q0.999",
    "temporal_kurtosis", "hot_count_8", "hot_count_32", "pattern_psd_0.02_0.04",
    "pattern_psd_0.25_0.35", "temporal_psd_0.02_0.04", "temporal_psd_0.25_0.35",
    "pattern_columns_0.1_0.3", "pattern_rows_0.1_0.3", "temporal_columns_0.1_0.3",
    "temporal_rows_0.1_0.3", "pattern_corr_10", "pattern_corr_01", "temporal_pmax8",
    "noise_at_50", "noise_at_99", "drift",
)  # fmt: skip


@dataclass(frozen=True)
class _Reading:
    """A statistic at a setting, on its own scale: measured, its error, and simulated anew."""

    point: OperatingPoint
    plane: str
    name: str
    measured: float
    se: float
    drawn: np.ndarray

    @property
    def scale(self) -> Scale:
        return find_statistic(self.name).scale

    @property
    def spread(self) -> float:
        """Standard deviation of one capture, from both sources; never below the scatter seen."""
        freedom = self.drawn.size - 1
        if freedom < 2:
            return self.se
        scatter = float(np.var(self.drawn, ddof=1))
        pooled = (BLOCK_FREEDOM * self.se**2 + freedom * scatter) / (BLOCK_FREEDOM + freedom)
        return math.sqrt(max(pooled, scatter))


def propose(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    statistics: Sequence[str] = HEADLINE,
    rate: float = RATE,
    replicates: int = REPLICATES,
    on_progress: Callable[[str], None] = ignored,
) -> Targets:
    """Targets with margins that a correct simulation breaks no more often than ``rate``.

    Parameters
    ----------
    captures : CaptureSet
        The measurement.
    model : NoiseModel, optional
        Its scatter over seeds enters the margins, errors are limited to what it reaches now, and
        statistics that it misses are written down, but not enforced.
    statistics : sequence of str
        Which to limit, wherever they were measured.
    rate : float
        Share of correct simulations with a new seed that may fail.
    replicates : int
        Simulated sensors.
    on_progress : callable
        Called with a line of progress.
    """
    data = CheckData(captures, captures, model)
    drawn = []
    for number in range(replicates if model is not None else 0):
        assert model is not None
        on_progress(f"Simulated sensor {number + 1} of {replicates}")
        drawn.append(data.drawn(replace(model, seed=model.seed + 1 + number)))
    readings = list(_readings(data, drawn, statistics))
    errors = [data.errors(d) for d in drawn]
    families = sorted(errors[0], key=lambda f: f != "pooled") if errors else []
    limits = len(readings) + len(families)
    width = _width(rate, limits, replicates if drawn else 0)
    made = [_error(f, np.array([e[f] for e in errors]), rate, limits) for f in families]
    sides = [(r, _Width(width, rate / (2 * max(limits, 1)), r)) for r in readings]
    told = [(r, w) for r, w in sides if not (r.scale is Scale.LOG and w.down > VAGUE)]
    made += [_target(r, w, bool(drawn)) for r, w in told]
    least = min(len(s.frames) for s in data.plan.captures.settings)
    return Targets(
        schema=SCHEMA,
        description="Made by `dnanalyze check --init`; edit freely.",
        captures=Origin(name=captures.name, shape=captures.sensor.shape, frames=least),
        false_failures=rate,
        targets=tuple(made),
    )


def _readings(
    data: CheckData, drawn: list[list[Statistics]], statistics: Sequence[str]
) -> Iterator[_Reading]:
    assert data.measured is not None
    for setting in data.measured[2].settings:
        for name in statistics:
            value, scale = setting.values.get(name), find_statistic(name).scale
            if (
                value is None
                or not value.se > 0
                or not math.isfinite(scale.coordinate(value.value))
            ):
                continue
            others = [data.value(d, setting, name) for d in drawn]
            if any(o is None for o in others):
                continue
            coordinates = np.array([scale.coordinate(o.value) for o in others if o is not None])
            if not np.isfinite(coordinates).all():
                continue
            yield _Reading(
                setting.point,
                setting.plane,
                name,
                scale.coordinate(value.value),
                value.se,
                coordinates,
            )


def _width(rate: float, limits: int, replicates: int) -> float:
    """Half width of a limit in spreads: Student's t, two-sided, the rate shared out."""
    from scipy.stats import t

    freedom = BLOCK_FREEDOM + max(replicates - 1, 0)
    return float(t.isf(rate / (2 * max(limits, 1)), freedom))


@dataclass(frozen=True)
class _Width:
    """How far a reading may lie off: ``width`` spreads, or what ``share`` of the draws exceed."""

    width: float
    share: float
    reading: _Reading

    @cached_property
    def freedom(self) -> float:
        """Degrees of freedom of a variance whose logarithm scatters as much; infinite elsewhere."""
        from scipy.optimize import brentq
        from scipy.special import polygamma

        spread = max(self.reading.spread, self.reading.se)
        if self.reading.scale is not Scale.LOG or spread < LEAST_SPREAD:
            return math.inf
        return float(brentq(lambda v: 0.5 * math.sqrt(polygamma(1, v / 2)) - spread, 1e-3, 1e6))

    @property
    def up(self) -> float:
        """Above what is expected."""
        return self.width * self.reading.spread

    @property
    def down(self) -> float:
        """Below what is expected."""
        from scipy.stats import chi2

        v = self.freedom
        heavy = 0.0 if math.isinf(v) else 0.5 * math.log(v / max(chi2.ppf(self.share, v), 1e-300))
        return max(self.up, heavy)

    @property
    def apart(self) -> float:
        """Between two captures."""
        from scipy.stats import f

        v = self.freedom
        heavy = 0.0 if math.isinf(v) else 0.5 * math.log(min(f.isf(self.share, v, v), 1e300))
        return max(math.sqrt(2.0) * self.up, heavy)


def _target(r: _Reading, width: _Width, simulated: bool) -> Target:
    """As wide as two captures differ; wide enough for the model's seeds where it agrees."""
    reach = width.apart
    low, high = r.measured - reach, r.measured + reach
    note, enforced = "", True
    if simulated:
        middle = float(np.mean(r.drawn))
        more = math.sqrt(1 + 1 / r.drawn.size)  # the middle is not known better
        if abs(middle - r.measured) <= reach:
            low = min(low, middle - width.down * more)
            high = max(high, middle + width.up * more)
        else:
            off = abs(middle - r.measured) / (math.sqrt(2.0) * r.spread)
            note, enforced = f"the model violates it by {off:.0f} sigma", False
    lower = r.scale.plain(low)
    if r.scale is Scale.ROOT and lower < 0:
        lower = -math.inf  # no count lies below 0
    return Target(
        statistic=r.name,
        at=_at(r.point, r.plane),
        min=_outward(lower, -1) if math.isfinite(lower) else None,
        max=_outward(r.scale.plain(high), +1),
        measured=max(_short(r.scale.plain(r.measured), 6), 0.0)
        if r.scale is Scale.ROOT
        else _short(r.scale.plain(r.measured), 6),
        floor=_short(math.sqrt(2.0) * r.spread, 3),
        enforced=enforced,
        note=note,
    )


def _at(point: OperatingPoint, plane: str) -> At:
    return At(**{k: v for k, v in vars(point).items() if v is not None}, plane=plane or None)


def _error(name: str, values: np.ndarray, rate: float, limits: int) -> Target:
    """What the model reaches now, with the scatter over seeds on the log scale."""
    from scipy.stats import t

    logs = np.log(np.maximum(values, 1e-6))
    spread = max(float(np.std(logs, ddof=1)), SMALLEST_ERROR)
    reach = t.isf(rate / limits, values.size - 1) * spread * math.sqrt(1 + 1 / values.size)
    return Target(error=name, max=_outward(math.exp(float(np.mean(logs)) + reach), +1))


def _short(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def _outward(value: float, side: int, digits: int = 5) -> float:
    """Rounded to a few digits, away from what it limits."""
    if value == 0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - digits + 1)
    rounded = (math.ceil(value / unit) if side > 0 else math.floor(value / unit)) * unit
    return float(f"{rounded:.{digits + 1}g}")
