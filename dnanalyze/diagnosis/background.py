"""How much of the level is charge: the same level and noise, with another share of both counted.

Charge that is there at every setting (clock-induced, a glow, a leak of light) is told from the
pedestal neither by its level nor, from read noise, by its variance: only by the skewness of what is
counted, whose third cumulant is K times its variance. A fit that began with little charge follows
that skewness by too high a gain K, and steps along K do not lead to more charge. What shading the
charge has tells K by itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dnanalyze.diagnosis.deviance import deviance
from dnanalyze.diagnosis.trial import preferred
from dnanalyze.fitting.knobs import PEDESTAL, Knob, knobs_of, positions, turned
from dnanalyze.fitting.least_squares import State, converge, minimise, start
from dnanalyze.fitting.photon_transfer import gain_over_field
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.noise_model import NoiseModel

SHARES = (0.2, 0.5, 0.8)  # of the temporal variance, that the charge may have
TINY = 1e-6  # DN, least level of charge
ALIKE = 1.25  # ratio of gains up to which they agree
LIGHT, SHOT, READ = "convolved_lognormal", "dark_shot_noise", "read_noise"


def along_background(bench: Bench, state: State) -> State:
    """The model with another background of charge, refitted, if that is clearly better.

    Only where the shading of the noise tells another gain than the model has.

    Parameters
    ----------
    bench : Bench
    state : State
        Fitted model.
    """
    model = state.model
    gain, shot = gain_over_field(bench.measured, model.reference), model.get(SHOT)
    if gain is None or shot is None:
        return state
    if 1.0 / ALIKE < gain / shot.value("dn_per_e", model.reference) < ALIKE:
        return state
    begun = [_level_and_noise(bench, other) for other in other_backgrounds(model, gain)]
    best = min(begun, key=_deviance, default=None)
    if best is None or _deviance(best) > _deviance(state):
        return state
    return preferred(state, converge(bench, start(bench, best.model, knobs_of(best.model))))


def _level_and_noise(bench: Bench, model: NoiseModel) -> State:
    """The model with its level and its noise set right, and nothing else."""
    free = [k for k in knobs_of(model) if k.effect == PEDESTAL or k.name == f"{READ}.sigma"]
    return minimise(bench, start(bench, model, free), 3)


def _deviance(state: State) -> float:
    """Of both halves: the shading of one alone does not tell what is counted."""
    return deviance(state.train) + deviance(state.test)


def other_backgrounds(model: NoiseModel, gain: float) -> list[NoiseModel]:
    """Models of the same level, noise and pattern where there is least charge.

    With this conversion gain, DN/e-. None where the model counts no charge or has no read noise.
    """
    light, shot, read = map(model.get, (LIGHT, SHOT, READ))
    if light is None or shot is None or read is None:
        return []
    knobs = knobs_of(model)
    plain = [k.plain(x) for k, x in zip(knobs, positions(model, knobs), strict=True)]
    k, own = (e.value(n, model.reference) for e, n in ((shot, "dn_per_e"), (read, "sigma")))
    least = min(math.exp(x) for x, knob in zip(plain, knobs, strict=True) if _is_level(knob))
    noise = k * least + own**2
    others = [
        _Background(least, share * noise / gain, gain / k, (1.0 - share) * noise / own**2)
        for share in SHARES
    ]
    found = []
    for other in others:
        right = [other.of(k, x) for k, x in zip(knobs, plain, strict=True)]
        where = [k.inside(k.position(x)) for k, x in zip(knobs, right, strict=True)]
        found.append(turned(model, knobs, np.array(where)))
    return found


def _is_level(knob: Knob) -> bool:
    return (knob.effect, knob.parameter) == (LIGHT, "mu") and knob.part != "ea_ev"


@dataclass(frozen=True)
class _Background:
    """Charge where there is least, before and after, DN; factors of gain and read variance."""

    before: float
    after: float
    gain: float
    read: float

    def of(self, knob: Knob, x: float) -> float:
        """A number of the model, with the other background."""
        if knob.part == "ea_ev":
            return x
        if knob.effect == PEDESTAL:
            return x - (self.after - self.before)
        if _is_level(knob):
            return math.log(max(math.exp(x) + self.after - self.before, TINY))
        factors = {
            (LIGHT, "delta"): self.before / self.after,
            (LIGHT, "sigma"): self.before / self.after,
            (SHOT, "dn_per_e"): self.gain,
            (READ, "sigma"): self.read**0.5,
            (READ, "serial"): 1.0 / self.read,
            (READ, "serial2"): 1.0 / self.read,
        }
        return x * factors.get((knob.effect, knob.parameter), 1.0)
