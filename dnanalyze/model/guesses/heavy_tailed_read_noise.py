"""First guesses of heavy_tailed_read_noise: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.heavy_tailed_read_noise import (
    HeavyTailedReadNoise,
    robust_scale,
    student_quantile,
    student_scale,
)
from dnanalyze.model.guesses.evidence import shows, typical_positive


def guess(effect: type[HeavyTailedReadNoise], clues: Clues) -> list[Effect]:
    """The 99.9 % quantile over the core gives the tail if all of the noise is of this kind;
    else a heavier tail beside Gaussian noise makes it. Student's t with the same quantile last.

    Of the quietest setting, for there dark current has least noise of its own; and of all.
    """
    high = ("temporal_kurtosis", "temporal_q0.999", "temporal_q0.99")
    low = ("temporal_q0.001", "temporal_q0.01")
    # a fit may have taken the tails for noise that differs from pixel to pixel, which repeats
    if not (shows(clues, high) or shows(clues, low, -1) or shows(clues, ["blink_repeat"], -1)):
        return []
    core = clues.measured("temporal_noise_core")
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = clues.measured("temporal_q0.999") / core
    tail = _tail_of(typical_positive(ratio) or 4.5)
    noise = typical_positive(core) or 1.0
    whole, part = (bounded(effect, "sigma", share * noise) for share in (0.9, 0.5))
    guesses: list[Effect] = [effect(whole, tail), effect(part, bounded(effect, "tail", tail - 0.2))]
    freedom, size = _freedom_of(typical_positive(ratio) or 4.5), whole
    good = np.isfinite(ratio) & (core > 0)
    if good.any():
        i = int(np.argmin(np.where(good, core, np.inf)))
        size, freedom = bounded(effect, "sigma", 0.9 * core[i]), _freedom_of(ratio[i])
        guesses.insert(0, effect(size, _tail_of(ratio[i])))
    guesses.append(effect(size, form="student", freedom=freedom))
    return list(dict.fromkeys(guesses))


def _tail_of(ratio: float) -> float:
    """The tail whose 99.9 % quantile is so many robust standard deviations."""
    tails = np.linspace(-0.4, 0.1, 101)
    reach = [(0.999**t - 0.001**t) / t / robust_scale(t) if t else 0.0 for t in tails + 1e-9]
    return float(tails[int(np.argmin(np.abs(np.array(reach) - ratio)))])


def _freedom_of(ratio: float) -> float:
    """Degrees of freedom whose 99.9 % quantile is so many robust standard deviations."""
    freedoms = np.geomspace(2.1, 30.0, 60)
    reach = [student_quantile(0.999, nu) / student_scale(nu) for nu in freedoms]
    return float(freedoms[int(np.argmin(np.abs(np.array(reach) - ratio)))])
