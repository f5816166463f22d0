"""Hold a simulation against its targets: what a CI job asks, answered with the reason."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

from dnanalyze.analyzers.catalogue import find as find_statistic
from dnanalyze.analyzers.statistics import Scale, SettingStatistics, Value
from dnanalyze.checking.check_data import CheckData
from dnanalyze.checking.targets import POOLED, Target, Targets, load_targets
from dnanalyze.errors import InputError
from dnanalyze.fitting.design import Design
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.progress import Progress
from dnanalyze.result import Result

NOT_DETERMINED = "not determined from these frames"


@dataclass(frozen=True)
class Check:
    """One limit, held.

    Parameters
    ----------
    name : str
        What and where, such as ``column_noise at 65 C``.
    kind : str
        "statistic", "error" or "parameter".
    subject : str
        Statistic, error or parameter.
    point : OperatingPoint
    plane : str
    lower, upper : float
        The limit, plain units; infinite where open.
    value : float
        Of the simulation; NaN where it has none.
    measured : float or None
    unit : str
    passed : bool
        Within the limit.
    enforced : bool
        Whether it counts.
    reason : str
        Why there is no value, or the target's own note.
    floor : float or None
        What two captures differ by, on the statistic's scale.
    """

    name: str
    kind: str
    subject: str
    point: OperatingPoint
    plane: str
    lower: float
    upper: float
    value: float
    measured: float | None
    unit: str
    passed: bool
    enforced: bool = True
    reason: str = ""
    floor: float | None = None

    @property
    def failed(self) -> bool:
        """Outside its limit, and it counts."""
        return self.enforced and not self.passed

    @property
    def beyond(self) -> float:
        """By how much the value lies outside, plain units; 0 inside, NaN without a value."""
        if math.isnan(self.value):
            return math.nan
        return max(0.0, self.value - self.upper) - max(0.0, self.lower - self.value)

    @property
    def floors_beyond(self) -> float | None:
        """The same in floors, signed; None where the floor is not known."""
        if self.kind != "statistic" or not self.floor or not self.beyond:
            return None
        scale = find_statistic(self.subject).scale
        edge = self.upper if self.beyond > 0 else self.lower
        gap = (scale.coordinate(self.value) - scale.coordinate(edge)) / self.floor
        return gap if math.isfinite(gap) else None

    @property
    def family(self) -> str:
        """Whose figure shows it: a family of statistics, "error" or "model"."""
        if self.kind == "statistic":
            return find_statistic(self.subject).family
        if self.kind == "parameter":
            return "model"
        return "error" if self.subject == POOLED else self.subject


@dataclass(frozen=True, repr=False)
class CheckResult(Result):
    """The outcome of all targets of a check.

    Parameters
    ----------
    captures : CaptureSet
        The frames that were checked, or that the model is compared with.
    simulation : str
        What was checked: the model file or the folder of simulated frames.
    checks : list of Check
        In the order of the targets.
    false_failures : float or None
        How often a correct simulation with a new seed fails, as the targets state it.
    """

    captures: CaptureSet = field(compare=False)
    simulation: str
    checks: list[Check]
    false_failures: float | None = None

    def _brief(self) -> str:
        count = f"{len(self.checks)} targets, {len(self.failures)} violated"
        return f"{self.captures.name}, {'passed' if self.passed else 'failed'}, {count}"

    @property
    def passed(self) -> bool:
        """Every limit that counts is kept."""
        return not self.failures

    @property
    def failures(self) -> list[Check]:
        """Limits that are broken and count, worst first."""
        broken = [c for c in self.checks if c.failed]
        return sorted(broken, key=lambda c: -abs(c.floors_beyond or 0.0))

    @property
    def known_misses(self) -> list[Check]:
        """Limits that are broken, but not enforced."""
        return [c for c in self.checks if not c.passed and not c.enforced]


def check(
    captures: CaptureSet,
    targets: Targets | str | PathLike[str],
    model: NoiseModel | None = None,
    *,
    seed: int | None = None,
    measured: CaptureSet | None = None,
    progress: Progress | None = None,
) -> CheckResult:
    """Check a simulation with the limits of a targets file.

    What is checked is the simulation: with a model, its frames, drawn at the operating points of
    ``captures``, which
    are the measurement; without one, ``captures`` are the simulated frames themselves.

    Parameters
    ----------
    captures : CaptureSet
        The measured frames, with a model; else the simulated ones.
    targets : Targets, str or PathLike
        The limits, or the file that holds them.
    model : NoiseModel, optional
        The model to simulate.
    seed : int, optional
        Seed of the simulated sensor; by default the model's.
    measured : CaptureSet, optional
        Without a model: the measurement, for targets that state no measured value and for errors.
    progress : callable, optional
        Called with (frames done, frames in all).

    Returns
    -------
    CheckResult
        Every target with the value of the simulation, and whether it is met.

    Raises
    ------
    InputError
        A target at an operating point that the captures lack, or that asks for a parameter
        without a model, or for a measurement where there is none; frames of another shape or
        number than the margins were made for.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> from dnanalyze.checking.targets import targets_from_plain
    >>> limit = {"statistic": "temporal_noise", "max": 50.0}
    >>> limits = targets_from_plain({"targets": [limit]}, "limits")
    >>> dnanalyze.check(captures, limits).passed
    True
    """
    if not isinstance(targets, Targets):
        targets = load_targets(Path(targets))
    if model is not None and seed is not None:
        model = replace(model, seed=seed)
    data = CheckData(captures, captures if model is not None else measured, model, progress)
    _same_make(captures, targets, data.plan)
    made: list[Check] = []
    for number, item in enumerate(targets.targets, 1):
        where = f"target {number} ({item.subject})"
        made += {"statistic": _statistic, "error": _error, "parameter": _parameter}[item.kind](
            item, data, where
        )
    return CheckResult(captures, data.name, made, targets.false_failures)


def _same_make(captures: CaptureSet, targets: Targets, plan: Design) -> None:
    """Sampling errors, and with them the margins, hold for as many pixels and frames."""
    origin = targets.captures
    if origin.shape is not None and tuple(origin.shape) != captures.sensor.shape:
        rows, columns = captures.sensor.shape
        raise InputError(
            f"{captures.name}: frames of {rows} x {columns}, but the targets were made for "
            f"{origin.shape[0]} x {origin.shape[1]}; "
            "simulate that shape, or make new targets with --init"
        )
    least = min(len(s.frames) for s in plan.captures.settings)
    if origin.frames is not None and least < origin.frames:
        raise InputError(
            f"{captures.name}: {least} frames at a setting, but the targets were made for "
            f"{origin.frames}; simulate as many, or make new targets with --init"
        )


def _statistic(item: Target, data: CheckData, where: str) -> Iterator[Check]:
    assert item.statistic is not None
    info = find_statistic(item.statistic)
    simulated = data.simulated[2]
    if info.family == "trends" and not any(item.statistic in s.values for s in simulated.settings):
        yield _trend(item, data, where)
        return
    here = [s for s in simulated.settings if item.at.matches(s.point, s.plane)]
    if not here:
        has = dict.fromkeys(f"{s.point.label(6)} {s.plane}".strip() for s in simulated.settings)
        raise InputError(
            f"{where}: no frames at {item.at.label}; the captures have {'; '.join(has)}"
        )
    if not any(item.statistic in s.values for s in here) and len(here) > 1:
        reason = here[0].missing.get(item.statistic, NOT_DETERMINED)
        yield _made(item, here[0], math.nan, None, (-math.inf, math.inf), reason)
        return
    for setting in here:
        own = setting.values.get(item.statistic)
        needs = item.needs_measured
        stated = data.value(data.measured, setting, item.statistic) if needs else None
        if needs and stated is None:
            if data.measurement is None:
                raise InputError(
                    f"{where}: relative and floors need the measured value; give measured in the "
                    "target, or the measured captures with --measured"
                )
            continue  # not measured there: nothing to hold against
        if item.floors is not None and item.floor is None and stated is None:
            raise InputError(f"{where}: floors needs floor, the reproducibility standard deviation")
        reason = setting.missing.get(item.statistic, NOT_DETERMINED)
        yield _compared(item, setting, own, stated, info.scale, reason)


def _compared(
    item: Target,
    setting: SettingStatistics | None,
    own: Value | None,
    stated: Value | None,
    scale: Scale,
    reason: str,
) -> Check:
    """The simulated value beside the measured one: the target's, else ``stated``.

    ``reason``: why there is no simulated value, where there is none.
    """
    measured, floor = item.measured, item.floor
    if stated is not None:
        measured = stated.value if measured is None else measured
        floor = floor or math.sqrt(2.0) * stated.se
    limits = _limits(item, scale, measured, floor)
    if own is None:
        return _made(item, setting, math.nan, measured, limits, reason, floor)
    return _made(item, setting, own.value, measured, limits, floor=floor)


def _limits(
    item: Target, scale: Scale, measured: float | None, floor: float | None
) -> tuple[float, float]:
    """The narrowest of all that the target states, plain units."""
    lower = -math.inf if item.min is None else item.min
    upper = math.inf if item.max is None else item.max
    if item.relative is not None and measured is not None:
        reach = item.relative * abs(measured)
        lower, upper = max(lower, measured - reach), min(upper, measured + reach)
    if item.floors is not None and measured is not None and floor is not None:
        middle, reach = scale.coordinate(measured), item.floors * floor
        if math.isfinite(middle):
            lower = max(lower, scale.plain(middle - reach))
            upper = min(upper, scale.plain(middle + reach))
    return lower, upper


def _made(
    item: Target,
    setting: SettingStatistics | None,
    value: float,
    measured: float | None,
    limits: tuple[float, float],
    reason: str = "",
    floor: float | None = None,
    unit: str | None = None,
) -> Check:
    point = setting.point if setting is not None else item.at.point
    plane = setting.plane if setting is not None else item.at.plane or ""
    spot = "" if point == OperatingPoint() else f" at {point.label()}"
    name = f"{item.subject}{spot}{f' {plane}' if plane else ''}"
    if item.kind == "error":
        name = f"error ({item.subject})"
    if unit is None:
        unit = find_statistic(item.subject).unit if item.kind == "statistic" else ""
    lower, upper = limits
    return Check(
        name, item.kind, item.subject, point, plane, lower, upper, value, measured, unit,
        bool(lower <= value <= upper), item.enforced, reason or item.note, floor,
    )  # fmt: skip


def _trend(item: Target, data: CheckData, where: str) -> Check:
    """A statistic over temperature, such as the activation energy."""
    assert item.statistic is not None
    if item.at.label:
        raise InputError(f"{where}: holds over all temperatures; leave out at")
    own = data.simulated[2].trends.get(item.statistic)
    needs = item.needs_measured
    stated = data.measured[2].trends.get(item.statistic) if needs and data.measured else None
    if needs and stated is None:
        raise InputError(f"{where}: relative and floors need measured, and no captures give it")
    reason = "these operating points do not determine it"
    return _compared(item, None, own, stated, Scale.LINEAR, reason)


def _error(item: Target, data: CheckData, where: str) -> Iterator[Check]:
    if data.measurement is None:
        raise InputError(
            f"{where}: an error needs the measured captures; give --model or --measured"
        )
    value = data.own_errors.get(str(item.error), math.nan)
    reason = "" if math.isfinite(value) else "the measured frames have no statistic of that family"
    limits = _limits(item, Scale.LINEAR, item.measured, None)
    yield _made(item, None, value, item.measured, limits, reason)


def _parameter(item: Target, data: CheckData, where: str) -> Iterator[Check]:
    """A number of the model file; at an operating point, by its law."""
    assert item.parameter is not None
    if data.model is None:
        raise InputError(f"{where}: a parameter needs the model; give --model")
    value, unit = parameter_of(data.model, item.parameter, where)
    limits = _limits(item, Scale.LINEAR, item.measured, None)
    reads = value(item.at.point if item.at.label else data.model.reference)
    yield _made(item, None, reads, item.measured, limits, unit=unit)


def parameter_of(
    model: NoiseModel, name: str, where: str
) -> tuple[Callable[[OperatingPoint], float], str]:
    """A parameter as a function of the operating point, and its unit; ``effect.parameter``."""
    from dnanalyze.model.laws import value_at

    effects = {e.name: e for e in model.effects}
    numbers: dict[str, tuple[Any, str]] = {"pedestal": (model.pedestal, "DN")}
    for effect in effects.values():
        for key, info in effect.parameters().items():
            if info.scale != "choice":
                numbers[f"{effect.name}.{key}"] = (getattr(effect, key), info.unit)
    if name not in numbers:
        raise InputError(
            f"{where}: the model has no parameter {name!r}; valid: {', '.join(numbers)}"
        )
    law, unit = numbers[name]
    return lambda point: value_at(law, point), unit
