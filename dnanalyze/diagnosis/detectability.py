"""Detection limits of effects in a set of captures."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.diagnosis.selection import EVIDENCE_ODDS_10, LEAST_GAIN
from dnanalyze.digits import number, unit_text
from dnanalyze.estimate import Estimated
from dnanalyze.fitting.changes import Changes
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.state import State, loss
from dnanalyze.model.bounds import bounded
from dnanalyze.model.effect import Effect, ParameterInfo, Placing
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.strength import strength_of


@dataclass(frozen=True)
class DetectionLimit(Estimated):
    """Smallest strength of an effect that the captures could show; its text is a sentence.

    Parameters
    ----------
    effect, parameter : str
        The effect, and the parameter that says how strong it is.
    value : float
        The strength; NaN where the largest one tried is not detectable.
    unit : str
        Of the value.
    """

    effect: str
    parameter: str
    value: float
    unit: str
    se: float = math.nan  # a limit has none

    def __str__(self) -> str:
        """Such as ``column_fpn is detectable from sigma = 0.02 DN``."""
        if not np.isfinite(self.value):
            return f"{self.effect} is not detectable in these captures at any usual strength"
        unit = unit_text(self.unit)
        least = f"{number(self.value, 2)}{unit}"
        return f"{self.effect} is detectable from {self.parameter} = {least}"


def detection_limits(
    problem: FitProblem, state: State, known: dict[str, type[Effect]]
) -> dict[str, DetectionLimit]:
    """Detection limit of every effect that is not in the model.

    The strength at which the effect changes the statistics, beyond what the parameters of the model
    absorb, by what `significant` asks for: at the operating point with the least noise, and for
    effects that are not stated in DN also at the one with the largest dark signal.
    """
    seen = Readings(problem.measured[0])
    noise, level = seen.value("frame_noise_core"), seen.value("mean")
    calm, warm = int(np.nanargmin(noise)), int(np.nanargmax(level))
    strengths = {}
    for name, effect in known.items():
        strength = _strength(effect, float(np.nanmin(noise)))
        if state.model.get(name) is None and strength is not None:
            strengths[name] = _Strength(effect, *strength)
    least: dict[str, float] = {}
    for readout, placing in itertools.product((True, False), Placing):
        alike = {
            n: a
            for n, a in strengths.items()
            if (a.readout, a.effect.placing) == (readout, placing)
        }
        if alike:
            where = {calm} if readout else {calm, warm}
            view = _View.of(problem, state, sorted(where), placing)
            least |= _least_shown(view, state.model, alike)
    return {
        name: DetectionLimit(name, a.parameter, least[name], a.info.unit)
        for name, a in strengths.items()
    }


@dataclass(frozen=True)
class _Strength:
    """An effect, the parameter that says how strong it is, and a strength that shows."""

    effect: type[Effect]
    parameter: str
    first: float

    @property
    def info(self) -> ParameterInfo:
        return self.effect.parameters()[self.parameter]

    @property
    def readout(self) -> bool:
        """Whether its strength is stated in DN; it is then most visible at the lowest noise."""
        return self.info.unit.startswith("DN")

    def at(self, strength: float) -> Effect:
        return replace(self.effect(), **{self.parameter: strength})

    def limit(self, strength: float, gain: float) -> float:
        """Where the gain would be what an effect must reach."""
        power = 4.0 if self.readout else 2.0
        return float(min(strength * (EVIDENCE_ODDS_10 / gain) ** (1.0 / power), self.info.upper))


def _least_shown(
    view: _View, model: NoiseModel, strengths: Mapping[str, _Strength]
) -> dict[str, float]:
    """Strengths that would be called missing, from such as show; NaN where 100 times do not."""
    least = dict.fromkeys(strengths, float("nan"))
    for times in (1.0, 10.0, 100.0):
        tried = {
            name: times * a.first
            for name, a in strengths.items()
            if np.isnan(least[name]) and times * a.first <= a.info.upper
        }
        gains = view.gains([model.with_effect(strengths[n].at(s)) for n, s in tried.items()])
        for (name, strength), gain in zip(tried.items(), gains, strict=True):
            if gain > LEAST_GAIN:
                least[name] = strengths[name].limit(strength, gain)
    return least


@dataclass(frozen=True)
class _View:
    """A few settings, with what the model's own parameters can absorb at each."""

    changes: Changes
    free: list[np.ndarray]

    @classmethod
    def of(cls, problem: FitProblem, state: State, settings: list[int], placing: Placing) -> _View:
        parts = [state.jacobian[problem.train.setting == s] for s in settings]
        usable = [part[:, np.linalg.norm(part, axis=0) > 1e-6] for part in parts]
        free = [np.linalg.qr(part)[0] for part in usable]
        return cls(Changes.of(problem.only(settings), state.model, placing), free)

    def gains(self, models: Sequence[NoiseModel]) -> list[float]:
        """Loss of the model without the effect, were each the truth; where it is largest."""
        return [self._gain(change) for change in self.changes.by(models)]

    def _gain(self, change: np.ndarray) -> float:
        parts = [change[self.changes.wanted.setting == s] for s in range(len(self.free))]
        return max(loss(z - f @ (f.T @ z)) for z, f in zip(parts, self.free, strict=True))


def _strength(effect: type[Effect], noise: float) -> tuple[str, float] | None:
    """The parameter that says how strong an effect is, and a strength that shows."""
    name = strength_of(effect)
    if name is None:
        return None
    default = getattr(effect(), name)
    value = default if isinstance(default, (int, float)) else default.value
    in_dn = effect.parameters()[name].unit.startswith("DN")
    return name, bounded(effect, name, 0.3 * noise if in_dn else float(value))
