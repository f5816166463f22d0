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
from dnanalyze.fitting.least_squares import State, converge, start
from dnanalyze.fitting.photon_transfer import gain_over_field
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.noise_model import NoiseModel

SHARES = (0.2, 0.5, 0.8)  # of the temporal variance, that the charge may have
TINY = 1e-6  # DN, least level of charge
LIGHT, SHOT, READ = "convolved_lognormal", "dark_shot_noise", "read_noise"


def along_background(bench: Bench, state: State) -> State:
    """The model with another background of charge, refitted, if that is clearly better.

    Parameters
    ----------
    bench : Bench
    state : State
        Fitted model.
    """
    gain = gain_over_field(bench.measured, state.model.reference)
    others = other_backgrounds(state.model, gain)
    begun = [start(bench, other, knobs_of(other)) for other in others]
    best = min(begun, key=_deviance, default=None)
    if best is None or _deviance(best) >= _deviance(state):
        return state
    return preferred(state, converge(bench, best))


def _deviance(state: State) -> float:
    """Of both halves: the shading of one alone does not tell what is counted."""
    return deviance(state.train) + deviance(state.test)


def other_backgrounds(model: NoiseModel, gain: float | None = None) -> list[NoiseModel]:
    """Models of the same level, noise and pattern where there is least charge.

    None where the model counts no charge or has no read noise. ``gain``, DN/e-: the model's own by
    default.
    """
    light, shot, read = map(model.get, (LIGHT, SHOT, READ))
    if light is None or shot is None or read is None:
        return []
    knobs = knobs_of(model)
    plain = [k.plain(x) for k, x in zip(knobs, positions(model, knobs), strict=True)]
    k, own = (e.value(n, model.reference) for e, n in ((shot, "dn_per_e"), (read, "sigma")))
    least = min(math.exp(x) for x, knob in zip(plain, knobs, strict=True) if _is_level(knob))
    noise, gain = k * least + own**2, gain or k
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
