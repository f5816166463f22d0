"""A fitted model against what the frames alone tell of the sensor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.estimators.arrhenius import KELVIN, arrhenius_laws
from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.ties import AFTER, GAIN
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.loaders.thermometer import tells_slope
from dnanalyze.model.laws import value_at

SIGMA, SHARE = 3.0, 0.1  # a difference within either is none
NOISE = 0.05  # of the temporal noise of a pixel: as much of a level, see `fitting.level`
ENERGY_EV = 0.03  # eV: a thermometer that is off by .2 C over 10 C
SEEN = 5.0  # standard errors from which a dark signal tells its growth


@dataclass(frozen=True)
class Agreement:
    """One quantity, measured directly and as the model has it.

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
        return off <= max(SIGMA * self.error, SHARE * abs(self.direct), self.tolerance)


def agreements(held: Bench, state: State) -> list[Agreement]:
    """The quantities that frames determine without a model, beside the model's.

    System gain, dark signal above the measured black level at each operating point, and its
    activation energy. A quantity that the frames do not determine is left out.

    Parameters
    ----------
    held : Bench
    state : State
        A fitted model.
    """
    signals = _dark_signals(held, state)
    return [*_gains(held, state), *signals, *_energy(signals)]


def _gains(held: Bench, state: State) -> list[Agreement]:
    """System gain of the model, the digital one included."""
    effect = state.model.get(GAIN[0])
    if effect is None or any(state.model.get(name) is not None for name in AFTER):
        return []
    reference = state.model.reference
    digital = state.model.get("digital_gain")
    times = 1.0 if digital is None else digital.value("gain", reference)
    own = times * effect.value(GAIN[1], reference)
    return [
        Agreement(f"system gain, {known.source}", None, "DN/e-", known.value, known.error, own)
        for setting, known in held.direct.gains
        if setting in (None, reference.gain)
    ]


def _dark_signals(held: Bench, state: State) -> list[Agreement]:
    """Median above the black level, on both halves of the field together."""
    level = held.direct.level
    if level is None:
        return []
    halves = (held.train, state.train), (held.test, state.test)
    scale = catalogue()["median"].scale
    found = []
    for s, (point, _) in enumerate(held.plan.settings):
        black, error = _black(held, point)
        if black is None or not point.exposure_s:
            continue
        measured, predicted, errors = [], [], []
        for half, z in halves:
            at = (half.names == "median") & (half.setting == s)
            measured += half.values[at].tolist()
            predicted += [scale.plain(c) for c in half.predicted(z)[at]]
            errors += (half.floor[at] / math.sqrt(2.0)).tolist()
        if not measured or not np.isfinite(predicted).all():
            continue
        signal = float(np.mean(measured)) - black
        spread = math.hypot(float(np.mean(errors)), error)
        if signal < -SEEN * spread:
            continue  # the black level of these frames is another one
        steady = held.train.values[
            (held.train.names == "temporal_noise_core") & (held.train.setting == s)
        ]
        found.append(
            Agreement(
                "dark signal", point, "DN",
                signal,
                spread,
                float(np.mean(predicted)) - value_at(state.model.pedestal, point),
                NOISE * float(steady.mean()) if steady.size else 0.0,
            )
        )  # fmt: skip
    return found


def _black(held: Bench, point: OperatingPoint) -> tuple[float | None, float]:
    """Measured black level at an operating point and its standard error."""
    level = held.direct.level
    assert level is not None
    if not level.moves:
        return level.mean, float(np.sum(level.errors**-2.0) ** -0.5)
    celsius = point.temperature_c
    if celsius is None:
        return None, 0.0
    near = [
        (v, e)
        for p, v, e in zip(level.law.points, level.law.values, level.errors, strict=True)
        if p.temperature_c is not None and abs(p.temperature_c - celsius) < 1.0
    ]
    return (near[0][0], float(near[0][1])) if near else (None, 0.0)


def _energy(signals: Sequence[Agreement]) -> list[Agreement]:
    """Activation energy of the dark signal over exposure, where it stands out."""
    clear = [
        a
        for a in signals
        if a.point is not None
        and a.point.temperature_c is not None
        and a.direct > SEEN * a.error
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
