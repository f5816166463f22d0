"""The numbers of a model as sliders: what can be moved, within which limits."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass

from dnanalyze.errors import InputError
from dnanalyze.fitting.free_parameters import FreeParameter, free_parameters, positions, with_values
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.report.words import point_label, varied

NAMES = {"": "black level", "ea_ev": "activation energy", "dn_per_e": "gain K"}


@dataclass
class Slider:
    """A parameter of the model as the user moves it.

    Parameters
    ----------
    parameter : FreeParameter
        Name, bounds, unit and scale.
    value : float
        In plain units.
    pinned : bool
        Whether a fit keeps the value.
    label : str
        Name within the effect, with the operating point where the number is of one.
    se : float or None
        Standard error in plain units; None: not computed for this model.
    """

    parameter: FreeParameter
    value: float
    pinned: bool
    label: str = ""
    se: float | None = None


def sliders(
    model: NoiseModel, standard_errors: Mapping[str, float], pinned: Set[str]
) -> list[Slider]:
    """Every number of a model that can be moved, in the model's order."""
    free = free_parameters(model)
    return [
        Slider(
            k, k.plain(x), parameter_of(k) in pinned, _label(model, k), standard_errors.get(k.name)
        )
        for k, x in zip(free, positions(model, free), strict=True)
    ]


def with_value(model: NoiseModel, name: str, value: float) -> NoiseModel:
    """A model with one number changed.

    Parameters
    ----------
    model : NoiseModel
    name : str
        As `Slider.parameter.name`, such as "read_noise.sigma" or "convolved_lognormal.mu[2]".
    value : float
        In plain units; it is moved within its bounds.

    Raises
    ------
    InputError
        There is no such number; the valid names are given.
    """
    free = free_parameters(model)
    names = [k.name for k in free]
    if name not in names:
        raise InputError(f"no parameter {name!r} in the model; valid: {', '.join(names)}")
    where = positions(model, free)
    place = names.index(name)
    where[place] = free[place].position(value)
    return with_values(model, free, where)


def parameter_of(parameter: FreeParameter) -> str:
    """Name of the parameter that a number belongs to, as a fit keeps it."""
    return (
        parameter.effect if not parameter.parameter else f"{parameter.effect}.{parameter.parameter}"
    )


def slider_name(parameter: FreeParameter) -> str:
    """A parameter in words, without its operating point."""
    name = parameter.parameter
    return NAMES.get(name, name.replace("_", " "))


def _label(model: NoiseModel, parameter: FreeParameter) -> str:
    """Parameter, with the operating point of a table's row or the kind of a law's number."""
    name = slider_name(parameter)
    effect = model.get(parameter.effect)
    law = getattr(effect, parameter.parameter) if effect is not None else model.pedestal
    if not isinstance(law, TableLaw):
        return name if parameter.part == "value" else f"{name}, activation energy"
    here = law.points[int(parameter.part)]
    differ = varied([vars(point) for point in law.points])
    return f"{name}, {point_label(here, differ)}" if differ else name
