"""One sensor's figures: what its own captures tell, before it is held beside others."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.benchmarking.benchmark_value import ABSENT, BenchmarkValue
from dnanalyze.benchmarking.criteria import CRITERIA, SINGLE, Criterion
from dnanalyze.benchmarking.model_findings import Strength, model_findings
from dnanalyze.benchmarking.temperature_laws import Reading
from dnanalyze.emva.quantity import Group
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Sensor
from dnanalyze.progress import ignored

ELECTRON = 1.602176634e-19  # C


@dataclass(frozen=True)
class SensorRecord:
    """What is known of one sensor.

    Parameters
    ----------
    name, folder : str
    captures : CaptureSet
    statistics : Statistics
    readings : dict
        Criterion to its readings over temperature, of the longest exposure.
    single : dict
        Criterion to its one figure.
    dn_per_e : BenchmarkValue
        Conversion gain.
    errors : dict
        "gaussian", "paper", "refined".
    effects : list of Strength
        Of the refined model; empty with --quick.
    verdict : str
        Of the refinement.
    filtered : bool or None
    filter_kind : str
    notes : list of str
    reference : str
        Operating point at which the strengths of the effects are told.
    """

    name: str
    folder: str
    captures: CaptureSet
    statistics: Statistics
    readings: dict[str, list[Reading]]
    single: dict[str, BenchmarkValue]
    dn_per_e: BenchmarkValue
    errors: dict[str, float]
    effects: list[Strength] = field(default_factory=list)
    verdict: str = ""
    filtered: bool | None = None
    filter_kind: str = ""
    notes: list[str] = field(default_factory=list)
    reference: str = ""

    @property
    def sensor(self) -> Sensor:
        """What its files tell."""
        return self.captures.sensor

    @property
    def temperatures(self) -> list[float]:
        """Measured, C."""
        known = {s.point.temperature_c for s in self.captures.settings}
        return sorted(t for t in known if t is not None)

    @property
    def pixel_area_cm2(self) -> float | None:
        """cm^2, where the pitch is known."""
        pitch = self.sensor.pixel_pitch_um
        return (pitch * 1e-4) ** 2 if pitch else None


def record(
    name: str,
    folder: str,
    captures: CaptureSet,
    *,
    quick: bool = False,
    on_progress: Callable[[str], None] = ignored,
    processes: bool = True,
) -> SensorRecord:
    """Analyze, compare, refine and detect one sensor.

    Parameters
    ----------
    name : str
        For tables.
    folder : str
        Where its frames are.
    captures : CaptureSet
    quick : bool
        Leave the refinement out.
    on_progress : callable
        Called with a line of progress.
    processes : bool
        Whether other processes may be started.
    """
    from dnanalyze.analyzers.analyze import analyze
    from dnanalyze.analyzers.families.trends import law_doubts

    on_progress(f"{name}: statistics")
    statistics = analyze(captures)
    found = model_findings(captures, quick, lambda what: on_progress(f"{name}: {what}"), processes)
    return SensorRecord(
        name, folder, captures, statistics, readings_of(statistics), single_of(statistics),
        found.gain if found.gain.known else gain_of(statistics), found.errors, found.effects,
        found.verdict, found.filtered, found.filter_kind,
        [*captures.notes, *law_doubts(statistics), *found.notes], found.reference,
    )  # fmt: skip


def record_alone(name: str, folder: str, captures: CaptureSet, quick: bool) -> SensorRecord:
    """`record` by one of several workers."""
    return record(name, folder, captures, quick=quick, processes=False)


def _longest(statistics: Statistics) -> list[SettingStatistics]:
    """Of each temperature, the settings of the longest exposure; one channel, one gain."""
    points = list(dict.fromkeys(s.point for s in statistics.settings))
    if not points:
        return []
    groups: dict[tuple[float | None, str | None], list[OperatingPoint]] = {}
    for p in points:
        groups.setdefault((p.gain, p.channel), []).append(p)
    main = max(groups.values(), key=len)
    best: dict[float | None, OperatingPoint] = {}
    for p in main:
        have = best.get(p.temperature_c)
        if have is None or (p.exposure_s or 0) > (have.exposure_s or 0):
            best[p.temperature_c] = p
    longest = max((p.exposure_s or 0) for p in best.values())
    kept = {p for p in best.values() if (p.exposure_s or 0) >= 0.5 * longest}
    return [s for s in statistics.settings if s.point in kept]


def _value(settings: list[SettingStatistics], names: tuple[str, ...]) -> BenchmarkValue:
    """Mean over colour planes of the first statistic that they tell; error in plain units.

    Of a variance, DN^2, its root.
    """
    for name in names:
        values = [s.values[name] for s in settings if name in s.values]
        if not values:
            continue
        scale = infos()[name].scale
        plain = [scale.plain(scale.coordinate(v.value) + v.se) - v.value for v in values]
        mean = float(np.mean([v.value for v in values]))
        se = float(np.sqrt(np.sum(np.square(plain)))) / len(values)
        if infos()[name].unit == "DN^2":
            root = math.sqrt(max(mean, 0.0))
            return BenchmarkValue(root, se / (2.0 * root) if root else 0.0, name)
        return BenchmarkValue(mean, se, name)
    return ABSENT


def readings_of(statistics: Statistics) -> dict[str, list[Reading]]:
    """Every thermal criterion over the temperatures, at the longest exposure."""
    longest = [s for s in _longest(statistics) if s.point.temperature_c is not None]
    made: dict[str, list[Reading]] = {}
    for criterion in CRITERIA:
        series = [_series(longest, name) for name in criterion.statistics]
        made[criterion.name] = next((s for s in series if len(s) > 1), max(series, key=len))
    return made


def _series(settings: list[SettingStatistics], name: str) -> list[Reading]:
    """One statistic over the temperatures, where it is told."""
    known = {s.point.temperature_c for s in settings} - {None}
    rows = []
    for celsius in sorted(float(t) for t in known if t is not None):
        figure = _value([s for s in settings if s.point.temperature_c == celsius], (name,))
        if figure.known:
            rows.append(Reading(celsius, figure.value, figure.se, name))
    return rows


def single_of(statistics: Statistics) -> dict[str, BenchmarkValue]:
    """The criteria of which a sensor has one."""
    return {criterion.name: _single(statistics, criterion) for criterion in SINGLE}


def _single(statistics: Statistics, criterion: Criterion) -> BenchmarkValue:
    for name in criterion.statistics:
        if name in statistics.trends:
            value = statistics.trends[name]
            return BenchmarkValue(value.value, value.se, name)
    points = list(dict.fromkeys(s.point for s in statistics.settings))
    if not points or all(n in _TRENDS for n in criterion.statistics):
        return ABSENT

    def heat(p: OperatingPoint) -> tuple[float, float]:
        return (p.temperature_c if p.temperature_c is not None else 0.0, p.exposure_s or 0.0)

    chosen = min(points, key=heat) if criterion.name == "read_noise" else max(points, key=heat)
    figure = _value([s for s in statistics.settings if s.point == chosen], criterion.statistics)
    if not figure.known:
        return ABSENT
    one_frame = figure.note in criterion.statistics[1:]
    return BenchmarkValue(figure.value, figure.se, f"at {chosen.label()}", one_frame)


_TRENDS = {"pedestal", "activation_energy_ev", "doubling_step_c"}


def gain_of(statistics: Statistics) -> BenchmarkValue:
    """Conversion gain, DN/e-, as `analyze` states it: recorded, or by photon transfer in the dark.

    Of the colour plane, gain and channel with the most operating points that determine it.
    """
    gains = [next(iter(g.quantities)) for g in sorted(statistics.emva.groups, key=_size)]
    for gain in gains:
        if gain.value is not None and gain.se is not None:
            return BenchmarkValue(gain.value, gain.se, gain.note)
    return BenchmarkValue(math.nan, math.nan, gains[0].reason) if gains else ABSENT


def _size(group: Group) -> int:
    return -len(group.points)
