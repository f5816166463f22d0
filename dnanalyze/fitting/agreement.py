"""A fitted model against the direct measurements of the frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.estimators.arrhenius import arrhenius_laws
from dnanalyze.fitting.level import NOISE
from dnanalyze.fitting.level_laws import beyond_laws
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State
from dnanalyze.fitting.ties import GAIN, RECORDED, digital_gain
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.loaders.thermometer import tells_slope
from dnanalyze.model.laws import value_at
from dnanalyze.significance import CLEAR, STATED
from dnanalyze.thermal import KELVIN

ENERGY_EV = 0.03  # of 1 eV, where thermometer readings are good to .2 C over 10 C: sqrt(2) .2 / 10


@dataclass(frozen=True)
class Agreement:
    """One quantity: direct measurement and model value.

    Parameters
    ----------
    quantity : str
    point : OperatingPoint, optional
        None for what holds for all.
    unit : str
    direct, error : float
        From the frames alone, or as recorded, with its standard error.
    model : float
    tolerance : float
        Difference that does not count whatever the errors.
    """

    quantity: str
    point: OperatingPoint | None
    unit: str
    direct: float
    error: float
    model: float
    tolerance: float = 0.0

    @property
    def sigma(self) -> float:
        """Difference in standard errors."""
        return (self.model - self.direct) / max(self.error, 1e-300)

    @property
    def kept(self) -> bool:
        """Whether the difference is within 3 standard errors, 10 %, or the tolerance."""
        off = abs(self.model - self.direct)
        return off <= max(STATED * self.error, RECORDED * abs(self.direct), self.tolerance)


def agreements(problem: FitProblem, state: State) -> list[Agreement]:
    """The quantities that frames determine without a model, beside the model's.

    System gain, dark signal above the measured black level at each operating point, and its
    activation energy. A quantity that the frames do not determine is left out.

    Parameters
    ----------
    problem : FitProblem
    state : State
        A fitted model.
    """
    signals = _dark_signals(problem, state)
    return [*_gains(problem, state), *signals, *_energy(signals)]


def _gains(problem: FitProblem, state: State) -> list[Agreement]:
    """System gain of the model, the digital one included."""
    effect = state.model.get(GAIN[0])
    if effect is None:
        return []
    own = digital_gain(state.model) * effect.value(GAIN[1], state.model.reference)
    return [
        Agreement(f"system gain, {known.source}", None, "DN/e-", known.value, known.error, own)
        for known in problem.direct.gains_of(state.model)
    ]


def _dark_signals(problem: FitProblem, state: State) -> list[Agreement]:
    """Median above the black level, on both halves of the field together.

    What a level is beyond all laws of black level and dark signal, such as a signal that is not
    proportional to the exposure time, is an error of it as a dark signal.
    """
    level = problem.direct.level
    if level is None:
        return []
    moved = () if problem.direct.sessions is None else problem.direct.sessions.moved
    medians = _medians(problem, state)
    points = [problem.plan.settings[s][0] for s in medians]
    measured, errors, _ = np.reshape(list(medians.values()), (-1, 3)).T
    beyond = beyond_laws(points, measured, errors, problem.direct.black)
    found = []
    for (s, (seen, own, predicted)), point, rest in zip(
        medians.items(), points, beyond, strict=True
    ):
        black = level.at(point.temperature_c)
        if black is None or not point.exposure_s or point in moved:
            continue
        signal = seen - black[0]
        error = math.hypot(own, black[1])
        if signal < -CLEAR * error:
            continue  # the black level of these frames is another one
        steady = problem.train.values[
            (problem.train.names == "temporal_noise_core") & (problem.train.setting == s)
        ]
        found.append(
            Agreement(
                "dark signal", point, "DN",
                signal,
                math.hypot(error, float(rest)),
                predicted - value_at(state.model.pedestal, point)
                - state.model.black_shift(point, problem.plan.shape),
                NOISE * float(steady.mean()) if steady.size else 0.0,
            )
        )  # fmt: skip
    return found


def _medians(problem: FitProblem, state: State) -> dict[int, tuple[float, float, float]]:
    """Measured median of each setting, its error and the model's, DN: means of both halves.

    Without those that the model does not predict.
    """
    scale = catalogue()["median"].scale
    found = {}
    for s in range(len(problem.plan.settings)):
        measured, predicted, errors = [], [], []
        for half, z in ((problem.train, state.train), (problem.test, state.test)):
            at = (half.names == "median") & (half.setting == s)
            measured += half.values[at].tolist()
            predicted += [scale.plain(c) for c in half.predicted(z)[at]]
            errors += (half.reproducibility_sd[at] / math.sqrt(2.0)).tolist()
        if measured and np.isfinite(predicted).all():
            found[s] = float(np.mean(measured)), float(np.mean(errors)), float(np.mean(predicted))
    return found


def _energy(signals: Sequence[Agreement]) -> list[Agreement]:
    """Activation energy of the dark signal over exposure, where it stands out."""
    clear = [
        a
        for a in signals
        if a.point is not None
        and a.point.temperature_c is not None
        and a.direct > CLEAR * a.error
        and a.model > 0
    ]
    celsius = np.array([a.point.temperature_c for a in clear if a.point is not None], float)
    if len({a.point.gain for a in clear if a.point}) > 1 or not tells_slope(celsius.tolist()):
        return []
    exposure = np.array([a.point.exposure_s for a in clear if a.point is not None], float)
    kelvin, relative = celsius + KELVIN, np.array([a.error / a.direct for a in clear])
    direct, model = (
        arrhenius_laws(kelvin, np.array(v) / exposure, relative)["activation_energy_ev"]
        for v in ([a.direct for a in clear], [a.model for a in clear])
    )
    return [
        Agreement(
            "activation energy of the dark signal", None, "eV",
            direct.value, direct.se, model.value, ENERGY_EV,
        )
    ]  # fmt: skip
