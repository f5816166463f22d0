"""The targets file: what a simulation has to keep to, as a CI check reads it."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import Annotated, Any

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from dnanalyze.analyzers.catalogue import FAMILIES
from dnanalyze.analyzers.catalogue import find as find_statistic
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.loaders.text import read_yaml

SCHEMA = "dnanalyze/targets/1"
POOLED = "pooled"
ERRORS = (POOLED, *dict.fromkeys(info.family for family in FAMILIES for info in family.INFOS))

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
_STRICT = ConfigDict(extra="forbid", frozen=True)


class At(BaseModel):
    """Operating points that a target holds at; what is left out matches all."""

    model_config = _STRICT
    temperature_c: Number | None = None
    exposure_s: Number | None = None
    gain: Number | None = None
    channel: str | None = None
    plane: str | None = None

    @model_validator(mode="after")
    def _physical(self) -> At:
        _ = self.point  # an operating point refuses what cannot be
        return self

    def matches(self, point: OperatingPoint, plane: str = "") -> bool:
        """Whether the target holds at this operating point and colour plane."""
        for key in ("temperature_c", "exposure_s", "gain"):
            own, there = getattr(self, key), getattr(point, key)
            if own is None:
                continue
            # two digits more than manifests carry; a set of thermometers differs by more
            if there is None or not math.isclose(own, there, rel_tol=1e-4, abs_tol=1e-9):
                return False
        if self.channel is not None and self.channel != point.channel:
            return False
        return self.plane is None or self.plane == plane

    @property
    def label(self) -> str:
        """Such as ``hcg, 65 °C``; empty where it matches all."""
        point = OperatingPoint(self.temperature_c, self.exposure_s, self.gain, self.channel)
        parts = [] if point == OperatingPoint() else [point.label()]
        return ", ".join([*parts, *([self.plane] if self.plane else [])])

    @property
    def point(self) -> OperatingPoint:
        """As an operating point."""
        return OperatingPoint(self.temperature_c, self.exposure_s, self.gain, self.channel)


class Target(BaseModel):
    """One limit on a statistic, an error or a parameter of the simulation.

    ``min`` and ``max`` are absolute, in the statistic's unit; ``relative`` is a share of the
    measured value to either side; ``floors`` counts what two captures of one sensor would differ
    by. Where several are given the narrowest holds. ``measured`` and ``floor`` are what the last
    two refer to; left out, they are read from the measured captures. ``enforced: false`` reports
    without failing.
    """

    model_config = _STRICT
    statistic: str | None = None
    error: str | None = None
    parameter: str | None = None
    at: At = At()
    min: Number | None = None
    max: Number | None = None
    relative: Positive | None = None
    floors: Positive | None = None
    measured: Number | None = None
    floor: Positive | None = None
    enforced: bool = True
    note: str = ""

    @model_validator(mode="after")
    def _sound(self) -> Target:
        kinds = [k for k in ("statistic", "error", "parameter") if getattr(self, k) is not None]
        if len(kinds) != 1:
            raise ValueError("needs exactly one of statistic, error, parameter")
        limits = [k for k in ("min", "max", "relative", "floors") if getattr(self, k) is not None]
        if not limits:
            raise ValueError("sets no limit; give min, max, relative or floors")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min {self.min:g} is above max {self.max:g}")
        if self.statistic is not None:
            try:
                find_statistic(self.statistic)
            except InputError as error:
                raise ValueError(str(error)) from None
        if self.error is not None and self.error not in ERRORS:
            raise ValueError(f"no error is called {self.error!r}; valid: {', '.join(ERRORS)}")
        if self.statistic is None and self.floors is not None:
            raise ValueError("floors are for statistics; give min or max")
        if self.error is not None and (self.relative is not None or self.at != At()):
            raise ValueError("an error is over all operating points; give min or max, without at")
        if self.parameter is not None and self.relative is not None and self.measured is None:
            raise ValueError("relative needs measured, the parameter's nominal value")
        return self

    @property
    def needs_measured(self) -> bool:
        """Whether the limits refer to a measured value that the target does not state."""
        return self.measured is None and (self.relative is not None or self.floors is not None)

    @property
    def kind(self) -> str:
        """ "statistic", "error" or "parameter"."""
        return next(k for k in ("statistic", "error", "parameter") if getattr(self, k) is not None)

    @property
    def subject(self) -> str:
        """Name of what is limited."""
        return str(self.statistic or self.error or self.parameter)


class Origin(BaseModel):
    """The captures that the margins were made for: they hold for as many frames of that shape."""

    model_config = _STRICT
    name: str = ""
    shape: tuple[int, int] | None = None
    frames: int | None = None


class Targets(BaseModel):
    """A targets file.

    ``false_failures`` says how often a correct simulation with a new seed may fail it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)
    schema_: str = Field(SCHEMA, alias="schema")
    description: str = ""
    captures: Origin = Origin()
    false_failures: Annotated[float, Field(gt=0, lt=1)] | None = None
    targets: tuple[Target, ...] = Field(min_length=1)

    def of_channel(self, name: str) -> Targets:
        """Those that hold at one readout channel; errors over several channels are left out.

        Raises
        ------
        InputError
            None does.
        """
        named = {t.at.channel for t in self.targets} - {None}
        kept = tuple(
            t for t in self.targets
            if t.at.channel == name or (t.at.channel is None and not (t.error and named - {name}))
        )  # fmt: skip
        if not kept:
            valid = ", ".join(sorted(str(n) for n in named))
            raise InputError(f"no target applies to channel {name!r}; they name {valid}")
        return self.model_copy(update={"targets": kept})


def load_targets(path: str | PathLike[str]) -> Targets:
    """Read a targets file (YAML).

    Parameters
    ----------
    path : str or PathLike
        The file.

    Returns
    -------
    Targets
        The limits.

    Raises
    ------
    InputError
        Not YAML, unknown keys or statistics, no limits: one line that names the target.

    Examples
    --------
    >>> import dnanalyze
    >>> limits = dnanalyze.load_targets("sample_configs/targets.yaml")
    >>> limits.targets[0].statistic
    'temporal_noise'
    """
    return targets_from_plain(read_yaml(Path(path)), str(path))


def targets_from_plain(raw: Any, where: str) -> Targets:
    """Build targets from what a YAML file holds; see `load_targets`."""
    if not isinstance(raw, dict) or not isinstance(raw.get("targets"), list):
        raise InputError(f"{where}: not a targets file; it needs 'targets', a list")
    schema = raw.get("schema", SCHEMA)
    if schema != SCHEMA:
        raise InputError(f"{where}: schema {schema!r} is not {SCHEMA!r}")
    try:
        return Targets.model_validate(raw)
    except ValidationError as error:
        raise InputError(f"{where}: {_one_line(error, raw)}") from None


_PLAINER = {
    "model_type": "not a mapping, such as {statistic: mean, max: 70}",
    "too_short": "the list is empty",
    "invalid_key": "keys are words",
}


def _one_line(error: ValidationError, raw: dict[str, Any]) -> str:
    first = error.errors(include_url=False)[0]
    place = [str(p) for p in first["loc"]]
    text = str(first["msg"]).removeprefix("Value error, ")
    text = _PLAINER.get(str(first["type"]), text)
    if first["type"] == "extra_forbidden":
        fields = _fields_at(place[:-1])
        near = difflib.get_close_matches(place[-1], fields, 1, 0.5)
        hint = f"did you mean {near[0]!r}? " if near else ""
        text = f"unknown key {place[-1]!r}; {hint}valid: {', '.join(fields)}"
        place = place[:-1]
    if len(place) >= 2 and place[0] == "targets" and place[1].isdigit():
        target = raw["targets"][int(place[1])]
        named = (
            [target.get(k) for k in ("statistic", "error", "parameter")]
            if isinstance(target, dict)
            else []
        )
        called = next((str(n) for n in named if n), "")
        head = f"target {int(place[1]) + 1}" + (f" ({called})" if called else "")
        return f"{head}: {'.'.join([*place[2:], '']).rstrip('.')}{': ' if place[2:] else ''}{text}"
    return f"{'.'.join(place)}: {text}" if place else text


def _fields_at(place: list[str]) -> list[str]:
    model: type[BaseModel] = Targets
    if place[:1] == ["targets"]:
        model = At if place[-1] == "at" else Target
    elif place[:1] == ["captures"]:
        model = Origin
    return [field.alias or name for name, field in model.model_fields.items()]


def dump_targets(targets: Targets) -> str:
    """The targets as YAML text, one target a line where it fits."""
    head = targets.model_dump(
        mode="json", by_alias=True, exclude_defaults=True, exclude={"targets"}
    )
    text = yaml.safe_dump(
        {"schema": SCHEMA, **head}, sort_keys=False, width=100, allow_unicode=True
    )
    return text + "targets:\n" + "".join(_lines(targets.targets))


def _lines(targets: Iterable[Target]) -> Iterable[str]:
    for target in targets:
        plain = target.model_dump(mode="json", exclude_defaults=True)
        inline = yaml.safe_dump(
            plain, sort_keys=False, default_flow_style=True, width=1 << 20, allow_unicode=True
        )
        yield f"- {inline}"
