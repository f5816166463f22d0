"""Parameters that statistics of the captures determine directly."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.readings import Readings
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import MeasuredParameter
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.wave import Wave


@dataclass(frozen=True)
class Measured:
    """Measured statistics of both halves of the field (implements `MeasuredLines`).

    Parameters
    ----------
    problem : FitProblem
    reference : OperatingPoint
        Where the model's numbers are stated.
    """

    problem: FitProblem
    reference: OperatingPoint

    @property
    def shape(self) -> tuple[int, int]:
        """The part of the frame that the statistics of a half cover."""
        return self.problem.plan.train.shape

    def waves(self, part: str) -> Sequence[Wave]:
        """Lines of a spectrum, of both halves and all settings."""
        found = []
        for half in map(Readings, self.problem.measured):
            for setting, point in enumerate(half.points):
                gain = point.gain_over(self.reference)
                seen = half.waves(part, setting)
                found += [replace(w, amplitude=w.amplitude / gain) for w in seen]
        return found


def measured_parameters(problem: FitProblem, model: NoiseModel) -> dict[str, MeasuredParameter]:
    """Parameters that the statistics determine directly, by ``effect.parameter``."""
    measured = Measured(problem, model.reference)
    return {
        f"{effect.name}.{name}": number
        for effect in model.effects
        for name, number in effect.measured_parameters(measured).items()
    }


def at_measured_parameters(
    problem: FitProblem, model: NoiseModel, frozen: Collection[str] = ()
) -> NoiseModel:
    """The model with directly determined parameters at their measured values.

    ``frozen``: names to hold, as ``effect.parameter``.
    """
    for name, number in measured_parameters(problem, model).items():
        effect, _, parameter = name.partition(".")
        bearer = model.get(effect)
        if bearer is not None and name not in frozen:
            model = model.with_effect(replace(bearer, **{parameter: number.value}))
    return model
