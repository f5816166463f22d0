"""The numbers of a model as sliders: what can be moved, within which limits."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass

from dnanalyze.errors import InputError
from dnanalyze.fitting.knobs import Knob, knobs_of, positions, turned
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.report.words import point_label, varied


@dataclass
class Slider:
    """A parameter of the model as the user moves it.

    Parameters
    ----------
    knob : Knob
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

    knob: Knob
    value: float
    pinned: bool
    label: str = ""
    se: float | None = None


def sliders(
    model: NoiseModel, standard_errors: Mapping[str, float], pinned: Set[str]
) -> list[Slider]:
    """Every number of a model that can be moved, in the model's order."""
    knobs = knobs_of(model)
    return [
        Slider(
            k, k.plain(x), parameter_of(k) in pinned, _label(model, k), standard_errors.get(k.name)
        )
        for k, x in zip(knobs, positions(model, knobs), strict=True)
    ]


def with_value(model: NoiseModel, name: str, value: float) -> NoiseModel:
    """A model with one number changed.

    Parameters
    ----------
    model : NoiseModel
    name : str
        As `Slider.knob.name`, such as "read_noise.sigma" or "convolved_lognormal.mu[2]".
    value : float
        In plain units; it is moved within its bounds.

    Raises
    ------
    InputError
        There is no such number; the valid names are given.
    """
    knobs = knobs_of(model)
    names = [k.name for k in knobs]
    if name not in names:
        raise InputError(f"no parameter {name!r} in the model; valid: {', '.join(names)}")
    where = positions(model, knobs)
    place = names.index(name)
    where[place] = knobs[place].position(value)
    return turned(model, knobs, where)


def parameter_of(knob: Knob) -> str:
    """Name of the parameter that a number belongs to, as a fit keeps it."""
    return knob.effect if not knob.parameter else f"{knob.effect}.{knob.parameter}"


def _label(model: NoiseModel, knob: Knob) -> str:
    """Parameter, with the operating point of a table's row or the kind of a law's number."""
    name = knob.parameter or knob.effect
    effect = model.get(knob.effect)
    law = getattr(effect, knob.parameter) if effect is not None else model.pedestal
    if not isinstance(law, TableLaw):
        return name if knob.part == "value" else f"{name}, activation energy"
    here = law.points[int(knob.part)]
    differ = varied([vars(point) for point in law.points])
    return f"{name}, {point_label(here, differ)}" if differ else name
