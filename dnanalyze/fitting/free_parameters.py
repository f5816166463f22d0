"""Free parameters of a model as one vector."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import ArrheniusLaw, Law, TableLaw
from dnanalyze.model.noise_model import NoiseModel

PEDESTAL = "pedestal"
LENGTHS = "column", "line", "pixel", "frame", "s"  # units of what is no amplitude


@dataclass(frozen=True)
class FreeParameter:
    """One free parameter.

    Parameters
    ----------
    effect : str
        Effect, or "pedestal".
    parameter : str
    part : str
        "value", "ea_ev" of an Arrhenius law, or the number of a table's row.
    log : bool
        Moved on a log scale.
    lower, upper : float
        Bounds in plain units.
    unit : str
    """

    effect: str
    parameter: str
    part: str
    log: bool
    lower: float
    upper: float
    unit: str

    @property
    def name(self) -> str:
        """Such as ``read_noise.sigma`` or ``convolved_lognormal.mu[2]``."""
        base = self.effect if self.effect == PEDESTAL else f"{self.effect}.{self.parameter}"
        if self.part == "value":
            return base
        return f"{base}[{self.part}]" if self.part.isdigit() else f"{base}.{self.part}"

    @property
    def group(self) -> str:
        """Rows of a table form a group: each moves other settings, so one simulation serves."""
        return f"{self.effect}.{self.parameter}[]" if self.part.isdigit() else self.name

    @property
    def energy(self) -> bool:
        """Whether it is an activation energy: a slope over temperature."""
        return "ea_ev" in (self.part, self.parameter)

    @property
    def logarithmic(self) -> bool:
        """Whether its position is the logarithm of an amplitude, a level or a share."""
        return self.log or self.unit.startswith("ln ")

    def change(self, before: float, after: float) -> float:
        """Difference of two positions; of far ones, that by which an amplitude moves linearly.

        A logarithmic step of more than a factor e is none of a derivative: what is proportional to
        the amplitude has grown by exp(step) - 1 times what it is.
        """
        step = after - before
        return math.expm1(step) if self.logarithmic and abs(step) > 1.0 else step

    def inside(self, position: float) -> float:
        """A position on the parameter's scale, moved within its bounds."""
        low, high = (self.position(b) for b in (self.lower, self.upper))
        return min(max(position, low), high)

    def position(self, value: float) -> float:
        """Plain value to the parameter's scale."""
        if not self.log:
            return value
        return math.log(max(value, self.lower, 1e-30))

    def plain(self, position: float) -> float:
        """The parameter's scale to the plain value, within bounds."""
        value = math.exp(min(position, 700.0)) if self.log else position
        return min(max(value, self.lower), self.upper)


def free_parameters(model: NoiseModel, frozen: Sequence[str] = ()) -> list[FreeParameter]:
    """Free parameters of a model, in its order.

    Parameters
    ----------
    model : NoiseModel
    frozen : sequence of str
        Names to hold, as ``effect.parameter`` or ``pedestal``.
    """
    found = []
    if PEDESTAL not in frozen:
        found += _of_law(PEDESTAL, "", model.pedestal, False, -1e6, 1e6, "DN")
    for effect in model.effects:
        for name, info in effect.parameters().items():
            if info.scale in ("choice", "held") or f"{effect.name}.{name}" in frozen:
                continue
            if name in effect.inactive_parameters():
                continue
            law = getattr(effect, name)
            log, ends = info.scale == "log", (info.lower, info.upper)
            free = _of_law(effect.name, name, law, log, *ends, info.unit)
            found += [_one_sided(k, law) for k in free] if info.scale == "signed" else free
    return found


def _one_sided(parameter: FreeParameter, law: Law) -> FreeParameter:
    """The parameter kept on its side of 0, where it is on one."""
    value = _read(law, parameter.part)
    if parameter.part == "ea_ev" or value == 0.0:
        return parameter
    return replace(parameter, lower=0.0) if value > 0.0 else replace(parameter, upper=0.0)


def _of_law(
    effect: str, name: str, law: Law, log: bool, lower: float, upper: float, unit: str
) -> list[FreeParameter]:
    amplitude = log and unit not in LENGTHS
    if amplitude and not isinstance(law, (TableLaw, ArrheniusLaw)) and law <= lower:
        return []  # at its lower bound it is switched off
    if isinstance(law, TableLaw):
        rows = range(len(law.values))
        return [FreeParameter(effect, name, str(i), log, lower, upper, unit) for i in rows]
    free = [FreeParameter(effect, name, "value", log, lower, upper, unit)]
    if isinstance(law, ArrheniusLaw):
        # below 0 for what falls as it warms, such as the relative spread of dark current
        free.append(FreeParameter(effect, name, "ea_ev", False, -2.0, 2.0, "eV"))
    return free


def grouped(free: Sequence[FreeParameter], members: Iterable[int]) -> list[list[int]]:
    """Parameters that one simulation can vary together: rows of a table act on other settings."""
    groups: dict[str, list[int]] = {}
    for i in members:
        groups.setdefault(free[i].group, []).append(i)
    return list(groups.values())


def positions(model: NoiseModel, free: Sequence[FreeParameter]) -> np.ndarray:
    """Positions of the free parameters of a model."""
    return np.array([k.position(_read(_law(model, k), k.part)) for k in free])


def with_values(model: NoiseModel, free: Sequence[FreeParameter], where: np.ndarray) -> NoiseModel:
    """The model with its free parameters at ``where``."""
    changed: dict[tuple[str, str], Law] = {}
    for parameter, position in zip(free, where, strict=True):
        address = parameter.effect, parameter.parameter
        law = changed.get(address, _law(model, parameter))
        changed[address] = _write(law, parameter.part, parameter.plain(float(position)))
    if (PEDESTAL, "") in changed:
        model = replace(model, pedestal=changed.pop((PEDESTAL, "")))
    effects = []
    for effect in model.effects:
        new = {p: law for (e, p), law in changed.items() if e == effect.name}
        effects.append(replace(effect, **new) if new else effect)
    return replace(model, effects=tuple(effects))


def settings_of(
    parameter: FreeParameter, model: NoiseModel, settings: Sequence[tuple[OperatingPoint, int]]
) -> np.ndarray:
    """Which settings a row of a table moves (all, for other free parameters)."""
    law = _law(model, parameter)
    if not isinstance(law, TableLaw):
        return np.ones(len(settings), bool)
    row = int(parameter.part)
    marks = TableLaw(law.points, tuple(float(i == row) for i in range(len(law.values))))
    return np.array([marks.at(point) > 0 for point, _ in settings])


def _law(model: NoiseModel, parameter: FreeParameter) -> Law:
    if parameter.effect == PEDESTAL:
        return model.pedestal
    effect = model.get(parameter.effect)
    assert effect is not None
    return getattr(effect, parameter.parameter)


def _read(law: Law, part: str) -> float:
    if isinstance(law, TableLaw):
        return law.values[int(part)]
    if isinstance(law, ArrheniusLaw):
        return law.ea_ev if part == "ea_ev" else law.value
    return float(law)


def _write(law: Law, part: str, value: float) -> Law:
    if isinstance(law, TableLaw):
        row = int(part)
        return replace(law, values=(*law.values[:row], value, *law.values[row + 1 :]))
    if isinstance(law, ArrheniusLaw):
        return replace(law, ea_ev=value) if part == "ea_ev" else replace(law, value=value)
    return value
