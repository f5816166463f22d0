"""Sensors side by side: figures at common temperatures, and a ranking per criterion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

from dnanalyze.benchmarking.benchmark_value import ABSENT, BenchmarkValue
from dnanalyze.benchmarking.criteria import CRITERIA, ERRORS, SINGLE, Criterion
from dnanalyze.benchmarking.sensor_record import ELECTRON, SensorRecord, record, record_alone
from dnanalyze.benchmarking.temperature_laws import common_temperatures, estimate
from dnanalyze.errors import InputError
from dnanalyze.executors import in_order
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.progress import Progress, reporter
from dnanalyze.result import Result

EXTRAPOLATION = 3.0  # measured spans of temperature, as far outside which a law is still read
DISTINCT_ERRORS = 2.0  # standard errors of a difference, from which two sensors are told apart


@dataclass(frozen=True)
class RankingPlace:
    """A sensor's place under a criterion.

    Without a rank are figures that are not to be believed, or compared: those of a filtered output,
    and those of single frames beside others that tell noise from pattern.

    Parameters
    ----------
    sensor : str
    figure : BenchmarkValue
    rank : int or None
        1 + the number of sensors that are better by more than two standard errors.
    alike : tuple of str
        Sensors that are not distinguishable from it, of those with a rank.
    """

    sensor: str
    figure: BenchmarkValue
    rank: int | None
    alike: tuple[str, ...] = ()


@dataclass(frozen=True)
class Ranking:
    """All sensors under one criterion.

    Parameters
    ----------
    criterion : str
    title, unit : str
    temperature_c : float or None
        Where they are compared; None where the figure does not run with temperature.
    better : str
        "low", "high" or "".
    places : list of RankingPlace
        Best first; then those without a rank, without a figure last.
    """

    criterion: str
    title: str
    unit: str
    temperature_c: float | None
    better: str
    places: list[RankingPlace]

    @property
    def base(self) -> str:
        """The criterion, whatever the unit."""
        return self.criterion.removesuffix("_e").removesuffix("_area")

    def of(self, sensor: str) -> BenchmarkValue:
        """A sensor's figure."""
        return next((p.figure for p in self.places if p.sensor == sensor), ABSENT)


@dataclass(frozen=True, repr=False)
class BenchmarkResult(Result):
    """Sensors side by side.

    Parameters
    ----------
    sensors : list of SensorRecord
        In the order given.
    temperatures : list of float
        Where they are compared, C.
    rankings : list of Ranking
        One a criterion and temperature.
    notes : list of str
        Notes that affect the interpretation.
    """

    sensors: list[SensorRecord]
    temperatures: list[float]
    rankings: list[Ranking]
    notes: list[str]

    def _brief(self) -> str:
        return ", ".join(s.name for s in self.sensors)


def benchmark(
    captures: Sequence[CaptureSet],
    *,
    at: Sequence[float] = (),
    quick: bool = False,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> BenchmarkResult:
    """Compare several sensors.

    Parameters
    ----------
    captures : sequence of CaptureSet
        Two or more; the readout channels of one count as sensors of their own.
    at : sequence of float
        Temperatures at which to compare, C; by default within the range that all have measured.
    quick : bool
        Leave the refinement out.
    progress : callable, optional
        Called with (steps done, None, what is under way); see `dnanalyze.progress.Progress`.
    executor : concurrent.futures.Executor, optional
        Measures several sensors at a time, one a task: processes, or those of a Dask client
        (``client.get_executor()``). By default this process measures one after the other.

    Returns
    -------
    BenchmarkResult
        The figures of every sensor, ranked by criterion.

    Raises
    ------
    InputError
        Fewer than two capture sets.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> found = dnanalyze.benchmark([tiny(seed=1), tiny(seed=2)], at=[45.0], quick=True)
    >>> len(found.sensors)
    2
    """
    parts = [part for c in captures for part in by_channel(c)]
    if len(parts) < 2:
        raise InputError("benchmark: name two capture folders or more, or one of several channels")
    names = unique_names([c.name for c in parts])
    on_progress = reporter(progress)
    if executor is None:
        return side_by_side(list(_one_by_one(names, parts, quick, on_progress)), at)
    tasks = [(name, c.name, c, quick) for name, c in zip(names, parts, strict=True)]
    made: list[SensorRecord] = []
    on_progress(f"{len(parts)} sensors")
    for found in in_order(executor, record_alone, tasks):
        made.append(replace(found, captures=parts[len(made)]))
        on_progress(f"Sensor {len(made)} of {len(parts)}, {found.name}: measured")
    return side_by_side(made, at)


def _one_by_one(
    names: Sequence[str],
    parts: Sequence[CaptureSet],
    quick: bool,
    on_progress: Callable[[object], None],
) -> Iterator[SensorRecord]:
    for n, (name, c) in enumerate(zip(names, parts, strict=True), 1):

        def of_this(what: str, n: int = n) -> None:
            on_progress(f"Sensor {n} of {len(parts)}, {what}")

        yield record(name, c.name, c, quick=quick, on_progress=of_this)


def by_channel(captures: CaptureSet) -> list[CaptureSet]:
    """Each readout channel, named after it; captures without channels as they are."""
    if not captures.channels:
        return [captures]
    return [replace(captures.channel(c), name=f"{captures.name} {c}") for c in captures.channels]


def unique_names(folders: Sequence[str]) -> list[str]:
    """The last part of each folder's path, or as many parts as tell them apart; else numbered."""
    parts = [Path(f.rstrip("/")).parts or (f,) for f in folders]
    for count in range(1, max(map(len, parts)) + 1):
        names = [str(Path(*p[-count:])) for p in parts]
        if len(set(names)) == len(names):
            return names
    return [f"{p[-1]} ({i})" for i, p in enumerate(parts, 1)]


def side_by_side(
    sensors: Sequence[SensorRecord], temperatures: Sequence[float] = ()
) -> BenchmarkResult:
    """Compare what was recorded of each sensor; see `benchmark`."""
    ranges = [(s.temperatures[0], s.temperatures[-1]) for s in sensors if s.temperatures]
    common = list(temperatures) or common_temperatures(ranges)
    rankings = []
    for criterion in CRITERIA:
        for form, unit, of in _forms(criterion, sensors):
            for celsius in common:
                figures = [of(s, _at(s, criterion, celsius)) for s in sensors]
                rankings.append(
                    _rank(replace(criterion, name=form, unit=unit), celsius, sensors, figures)
                )
    for criterion in SINGLE:
        for form, unit, of in _forms(criterion, sensors):
            figures = [of(s, s.single[criterion.name]) for s in sensors]
            rankings.append(_rank(replace(criterion, name=form, unit=unit), None, sensors, figures))
    for criterion in ERRORS:
        kind = criterion.name.removeprefix("error_")
        figures = [
            BenchmarkValue(s.errors[kind], 0.0) if kind in s.errors else ABSENT for s in sensors
        ]
        rankings.append(_rank(criterion, None, sensors, figures))
    told = [r for r in rankings if any(p.figure.known for p in r.places)]
    return BenchmarkResult(list(sensors), common, told, _notes(sensors, common, ranges))


def _at(sensor: SensorRecord, criterion: Criterion, celsius: float) -> BenchmarkValue:
    """Measured there, else by the sensor's own law."""
    readings = sensor.readings[criterion.name]
    one_frame = any(r.statistic in criterion.statistics[1:] for r in readings)
    there = [r for r in readings if abs(r.temperature_c - celsius) < 0.5 and r.value > 0]
    if there:
        nearest = min(there, key=lambda r: abs(r.temperature_c - celsius))
        return BenchmarkValue(nearest.value, nearest.se, "measured there", one_frame)
    estimated = estimate(readings, celsius, criterion.floor)
    if estimated is None:
        why = (
            "one temperature determines no law"
            if readings
            else "not determined from these captures"
        )
        return BenchmarkValue(math.nan, math.nan, why)
    low, high = readings[0].temperature_c, readings[-1].temperature_c
    if estimated.outside_c > EXTRAPOLATION * (high - low):
        why = f"measured from {low:g} to {high:g} C alone, too far away for its law"
        return BenchmarkValue(math.nan, math.nan, why)
    note = "by its law"
    if estimated.outside_c > 0.5:
        note = f"extrapolated by {estimated.outside_c:.0f} C"
    if estimated.cost > 1.5:
        note += f"; the error is {estimated.cost:.1f} times that of its own nearest measurement"
    return BenchmarkValue(estimated.value, estimated.se, note, one_frame)


def _forms(
    criterion: Criterion, sensors: Sequence[SensorRecord]
) -> Iterator[tuple[str, str, Callable[[SensorRecord, BenchmarkValue], BenchmarkValue]]]:
    """The figure in DN, in electrons, and per area: (name, unit, conversion)."""
    yield criterion.name, criterion.unit, lambda s, f: f
    if criterion.electrons and any(s.dn_per_e.known for s in sensors):
        yield f"{criterion.name}_e", criterion.unit.replace("DN", "e-"), _electrons
    if criterion.per_area and any(s.dn_per_e.known and s.pixel_area_cm2 for s in sensors):
        yield f"{criterion.name}_area", "pA/cm^2", _per_area


def _electrons(sensor: SensorRecord, figure: BenchmarkValue) -> BenchmarkValue:
    """DN over the conversion gain, its error included."""
    k = sensor.dn_per_e
    if not k.known or not figure.known:
        why = figure.note if k.known else "its conversion gain is not known"
        return BenchmarkValue(math.nan, math.nan, why)
    value = figure.value / k.value
    se = math.hypot(figure.se / k.value, value * k.se / k.value)
    return replace(figure, value=value, se=se)


def _per_area(sensor: SensorRecord, figure: BenchmarkValue) -> BenchmarkValue:
    """Current density, pA/cm^2."""
    electrons, area = _electrons(sensor, figure), sensor.pixel_area_cm2
    if area is None:
        return BenchmarkValue(math.nan, math.nan, "its pixel pitch is not known")
    factor = ELECTRON / area * 1e12
    return replace(electrons, value=electrons.value * factor, se=electrons.se * factor)


def _rank(
    criterion: Criterion,
    celsius: float | None,
    sensors: Sequence[SensorRecord],
    figures: Sequence[BenchmarkValue],
) -> Ranking:
    """Best first; what the printed errors do not tell apart shares a rank."""
    doubts = [
        _doubt(s, f, figures) if criterion.better else ""
        for s, f in zip(sensors, figures, strict=True)
    ]
    entries = list(zip([s.name for s in sensors], figures, doubts, strict=True))
    sign = -1.0 if criterion.better == "high" else 1.0
    known = [(name, figure) for name, figure, doubt in entries if figure.known and not doubt]
    known.sort(key=lambda p: sign * p[1].value)
    places = [RankingPlace(name, figure, None) for name, figure in known]
    if criterion.better:
        places = [
            RankingPlace(
                name,
                figure,
                1 + sum(_told_apart(other, figure) for _, other in known[:i]),
                tuple(n for n, other in known if n != name and not _told_apart(other, figure)),
            )
            for i, (name, figure) in enumerate(known)
        ]
    for name, figure, doubt in entries:
        if figure.known and doubt:
            places.append(RankingPlace(name, replace(figure, note=f"{figure.note}; {doubt}"), None))
    places += [RankingPlace(n, f, None) for n, f, _ in entries if not f.known]
    return Ranking(
        criterion.name, criterion.title, criterion.unit, celsius, criterion.better, places
    )


def _doubt(sensor: SensorRecord, figure: BenchmarkValue, figures: Sequence[BenchmarkValue]) -> str:
    """Why a figure has no rank; nothing where it has one."""
    if sensor.filtered:
        return "of a filtered output, so not ranked"
    if figure.one_frame and any(f.known and not f.one_frame for f in figures):
        return "of single frames, the fixed pattern in it, so not ranked"
    return ""


def _told_apart(a: BenchmarkValue, b: BenchmarkValue) -> bool:
    """By more than two standard errors of the difference, on the scale of the figures."""
    return abs(a.value - b.value) > DISTINCT_ERRORS * math.hypot(a.se, b.se)


def _notes(
    sensors: Sequence[SensorRecord], common: Sequence[float], ranges: Sequence[tuple[float, float]]
) -> list[str]:
    made = []
    for s in sensors:
        if s.filtered:
            kind = s.filter_kind.replace("_", " ")
            made.append(
                f"the frames of {s.name} were filtered ({kind}), so that its noise, hot pixels and "
                "spectrum are not the sensor's; it is not ranked"
            )
        if not s.temperatures:
            made.append(
                f"the temperatures of {s.name} are not known, so that it has no place in what "
                "runs with them"
            )
    if ranges and max(a for a, _ in ranges) > min(b for _, b in ranges):
        apart = [
            s.name
            for s in sensors
            if s.temperatures
            and not any(s.temperatures[0] <= t <= s.temperatures[-1] for t in common)
        ]
        made.append(
            f"the sensors share no temperature: the laws of {', '.join(apart)} are extrapolated, "
            "with a larger standard error; beyond three times the measured span there is no value"
        )
    points = [t.point for s in sensors for t in s.captures.settings]
    exposures = {p.exposure_s for p in points if p.exposure_s}
    if len(exposures) > 1:
        made.append(
            "exposures differ: dark current is per second; noise, DSNU and hot pixels are those "
            "of the longest exposure of each sensor"
        )
    gains = [s.name for s in sensors if not s.dn_per_e.known]
    if gains:
        made.append(
            f"the conversion gain of {', '.join(gains)} is not known: DN of different sensors are "
            "not comparable"
        )
    return made
