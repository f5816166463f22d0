"""How a parameter moves with temperature: a number, an Arrhenius law, or a table."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.loaders.physical import fault
from dnanalyze.thermal import KELVIN, arrhenius

MOST_EV = 10.0  # nine times the band gap of silicon; no thermal process comes near it


@dataclass(frozen=True)
class ArrheniusLaw:
    """``value`` at ``at_c`` times exp(-Ea/k (1/T - 1/Tref)); written {value, at_c, ea_ev}."""

    value: float
    at_c: float
    ea_ev: float

    def at(self, point: OperatingPoint) -> float:
        """Value at an operating point."""
        return self.value * arrhenius(point.temperature_c, self.at_c, self.ea_ev)

    def to_plain(self) -> object:
        """As written in YAML."""
        return {"value": self.value, "at_c": self.at_c, "ea_ev": self.ea_ev}


@dataclass(frozen=True)
class TableLaw:
    """One value an operating point; between temperatures it is interpolated along 1/T.

    Parameters
    ----------
    points : tuple of OperatingPoint
        Where the values hold; a field that is None there matches anything.
    values : tuple of float
        One a point.
    """

    points: tuple[OperatingPoint, ...]
    values: tuple[float, ...]

    def at(self, point: OperatingPoint) -> float:
        """The entry of this point; else along 1/T between the entries that match in the rest."""
        best: list[tuple[float | None, float]] = []
        distance = math.inf
        for p, v in zip(self.points, self.values, strict=True):
            d = _mismatch(p, point)
            if d < distance:
                best, distance = [], d
            if d == distance:
                best.append((p.temperature_c, v))
        known = sorted((t, v) for t, v in best if t is not None)
        if point.temperature_c is None or not known:
            return best[0][1]
        for t, v in known:
            if t == point.temperature_c:
                return v
        inverse = [-1.0 / (t + KELVIN) for t, _ in known]
        return float(
            np.interp(-1.0 / (point.temperature_c + KELVIN), inverse, [v for _, v in known])
        )

    def to_plain(self) -> object:
        """As written in YAML: a list of rows."""
        rows = []
        for p, v in zip(self.points, self.values, strict=True):
            row = {k: x for k, x in vars(p).items() if x is not None}
            rows.append({**row, "value": v})
        return {"table": rows}


def _mismatch(entry: OperatingPoint, point: OperatingPoint) -> float:
    """How badly an entry fits a point in channel, gain and exposure (0 = in all that it states)."""
    total = 0.0
    if entry.channel is not None and entry.channel != point.channel:
        total += 1e6
    for a, b in ((entry.gain, point.gain), (entry.exposure_s, point.exposure_s)):
        if a is not None and b is not None and a != b:
            total += 1.0 + abs(math.log(max(a, 1e-9) / max(b, 1e-9)))
        elif a is not None and b is None:
            total += 1.0
    return total


Law = float | ArrheniusLaw | TableLaw


def value_at(law: Law, point: OperatingPoint) -> float:
    """Value of a parameter, whatever its law, at an operating point."""
    if isinstance(law, (ArrheniusLaw, TableLaw)):
        return law.at(point)
    return float(law)


def count(law: Law) -> int:
    """How many numbers state it."""
    if isinstance(law, TableLaw):
        return len(law.values)
    return 2 if isinstance(law, ArrheniusLaw) else 1


def law_from_plain(name: str, raw: object) -> Law:
    """Read a law as written in YAML.

    Raises
    ------
    InputError
        Anything but a finite number, {value, at_c, ea_ev} or {table: [{..., value}]}.
    """
    if isinstance(raw, (int, float)) and not fault("value", raw):
        return float(raw)
    if isinstance(raw, dict):
        try:
            if set(raw) == {"value", "at_c", "ea_ev"}:
                law = ArrheniusLaw(float(raw["value"]), float(raw["at_c"]), float(raw["ea_ev"]))
                if wrong := fault("temperature_c", law.at_c):
                    raise InputError(f"at_c: {wrong}")
                if math.isfinite(law.value) and abs(law.ea_ev) <= MOST_EV:
                    return law
            if set(raw) == {"table"} and raw["table"]:
                rows = [dict(r) for r in raw["table"]]
                values = tuple(float(r.pop("value")) for r in rows)
                if all(map(math.isfinite, values)):
                    return TableLaw(tuple(OperatingPoint(**r) for r in rows), values)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        except (TypeError, ValueError, KeyError, OverflowError):
            pass
    raise InputError(
        f"{name}: {str(raw)[:60]!r} is no law; give a number, {{value, at_c, ea_ev}} "
        "or {table: [{temperature_c, value}, ...]}"
    )


def scaled(law: Law, factor: float) -> Law:
    """The law with every value multiplied."""
    if isinstance(law, ArrheniusLaw):
        return replace(law, value=law.value * factor)
    if isinstance(law, TableLaw):
        return replace(law, values=tuple(v * factor for v in law.values))
    return float(law) * factor
