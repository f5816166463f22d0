"""When an effect counts as missing: evidence, overdispersion, confidence.

Pure numbers; nothing is simulated here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from dnanalyze.fitting.state import State, deviance
from dnanalyze.significance import EVIDENCE_NULL, LEAST_GAIN

if TYPE_CHECKING:
    from dnanalyze.diagnosis.score_test import Guess

# Neighbouring quantiles and bands are correlated, about eight of them as one, so that the deviance
# overstates twice the log likelihood ratio.
DEFLATION = 8.0
# 62: odds of 10 against "nothing is missing"
EVIDENCE_ODDS_10 = EVIDENCE_NULL + 2.0 * DEFLATION * math.log(10.0)
EVIDENCE_DECISIVE = 300.0  # exceeds the variation between sensors of one design
# Share of the best evidence from which a competitor is reported as confounded. Two candidates that
# have no more in common than it may lack do not compete.
COMPETING_SHARE = 0.75
# Candidates, and forms of one, that are refitted at most. With two forms the sensor `corrected` of
# docs/accuracy.md takes 305 s for 217, since the third form of a dpc is the better one; five others
# take as long as with four.
REFITS = 4
# Of 160 effects that were named with a weight of 0.99 or more and left nothing, on sensors of five
# generators, 9 were wrong: nearly all reproduced an effect that is in no catalogue.
OUTSIDE = 0.05
# Of the effects named where a residual remained, 13 of 19 were present in virtual sensors with an
# effect of the catalogue, and 0 of 24 where the effect is in none.
STANDS_IN = 0.5
# Of 27 effects named with 0.9 or more on ten real cameras before the time was up, while the model
# was far from the captures, 23 are seen in the frames without a model: 0.95 becomes 0.85.
UNFINISHED = 0.9


@dataclass(frozen=True, eq=False)
class Trial:
    """The model with one more effect, refitted.

    Parameters
    ----------
    effect : str
    state : State
        After the refit.
    gain, fitted_gain : float
        Rise of twice the log density of the measurement on the held-out and on the fitted half:
        the fall of the deviance, each statistic in units of its scatter between sensors.
    error : float
        Model error on the held-out half.
    error_fall : float
        By how much that is lower, by the same predictions as the gains, in units of the scatter.
    overdispersion : float
        Of the loss.
    others : tuple of Guess
        Other guesses of the effect, not refitted.
    falls : ndarray
        Fall of the deviance of each statistic, of either half.
    formed : bool
        Whether its other forms were tried, and none is better.
    by_design : bool
        Whether the captures are compared with sensors of the design of a guess, and not with one
        sensor that is refitted.
    denied : str
        The test of the captures that excludes the effect (`filter_tests`, `classifier_tests`), in
        words; empty where none does.
    """

    effect: str
    state: State
    gain: float
    fitted_gain: float
    error: float
    error_fall: float
    overdispersion: float = 1.0
    others: tuple[Guess, ...] = ()
    falls: np.ndarray = field(default_factory=lambda: np.empty(0), repr=False)
    formed: bool = False
    by_design: bool = False
    denied: str = ""

    @property
    def evidence(self) -> float:
        """Mean gain of the halves.

        What superfluous parameters gain by chance on the fitted half they lose on the held-out
        half, so that the mean is unbiased (Akaike's criterion, with both terms computed).
        """
        return (self.gain + self.fitted_gain) / 2.0

    @property
    def log_odds(self) -> float:
        """Logarithm of the prior odds of the effect."""
        if self.denied:
            return -math.inf
        model = self.state.model
        effect = model.get(self.effect)
        return 0.0 if effect is None else math.log(effect.odds(model.names))


def _by_name(names: np.ndarray, *z: np.ndarray) -> tuple[np.ndarray, ...]:
    """Count of each statistic over the operating points, and its deviance by several misfits."""
    _, which = np.unique(names, return_inverse=True)
    return tuple(np.bincount(which, w) for w in (np.ones(names.size), *map(deviance, z)))


def falls(names: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Fall of the deviance of each named statistic, over all operating points."""
    _, was, now = _by_name(names, before, after)
    return was - now


def overdispersion(names: np.ndarray, before: np.ndarray, after: np.ndarray) -> float:
    """Deviance per statistic that remains where a candidate changes the fit, at least 1.

    While other effects are missing, a superfluous candidate reduces the deviance in proportion to
    what remains (overdispersion of a quasi-likelihood, McCullagh and Nelder 1989, section 9.2). The
    mean is weighted by the change of each statistic; it is that of all of them if that is less.
    """
    if not names.size:
        return 1.0
    count, was, now = _by_name(names, before, after)
    moved = np.abs(was - now)
    there = float(np.sum(moved * now / count) / np.sum(moved)) if moved.any() else np.inf
    return max(1.0, min(there, float(now.sum() / names.size)))


def standings(trials: Sequence[Trial]) -> np.ndarray:
    """Evidence and prior odds over a common overdispersion, by which candidates are ranked.

    The overdispersion is that of the candidate with most evidence, for all of them, as quasi-AIC
    takes it from the model that fits best (Burnham and Anderson 2002, section 2.5).
    """
    if not trials:
        return np.empty(0)
    common = max(trials, key=lambda t: t.evidence).overdispersion
    return np.array([t.evidence / common + 2.0 * DEFLATION * t.log_odds for t in trials])


def confidences(trials: Sequence[Trial]) -> np.ndarray:
    """Probability of each candidate, and of "nothing is missing" in the last place.

    A candidate that does not lower the model error gains nothing.
    """
    worse = [t.error_fall <= 0.0 for t in trials]
    known = np.append(np.where(worse, np.minimum(s := standings(trials), 0.0), s), EVIDENCE_NULL)
    weight = np.exp((known - known.max()) / (2.0 * DEFLATION))
    return weight / weight.sum()


def confidence_of(found: Trial, trials: Sequence[Trial]) -> float:
    """Probability that a candidate is missing.

    Among its competitors, "nothing is missing", and an effect that is in no catalogue.
    """
    others = [t for t in trials if t is not found and not apart(found, t)]
    return (1.0 - OUTSIDE) * float(confidences([found, *others])[0])


def significant(found: Trial, least: float = EVIDENCE_ODDS_10) -> bool:
    """Whether the evidence exceeds what a superfluous candidate reaches by chance.

    Each half must give its part, and the model error of the held-out half must fall. ``least``:
    evidence asked for, in units of the overdispersion.
    """
    enough = found.evidence > least * found.overdispersion and on_both_halves(found)
    return enough and found.error_fall > 0.0 and not found.denied


def on_both_halves(found: Trial) -> bool:
    """Whether each half gives its part of the evidence."""
    return min(found.gain, found.fitted_gain) > LEAST_GAIN * found.overdispersion


def apart(one: Trial, other: Trial) -> bool:
    """Whether two candidates explain different statistics, so that both may be missing."""
    a, b = (np.maximum(t.falls, 0.0) for t in (one, other))
    return bool(np.minimum(a, b).sum() < (1.0 - COMPETING_SHARE) * min(a.sum(), b.sum()))


def alike(gain: float, best: float, overdispersion: float) -> bool:
    """Whether a gain is nearly the best one: by its share, and within what sensors vary."""
    return (
        gain > max(COMPETING_SHARE * best, best - EVIDENCE_DECISIVE * overdispersion) and best > 0.0
    )


def competitors(best: Trial, trials: Sequence[Trial]) -> list[str]:
    """Candidates that explain nearly as much as the best, and of the same statistics."""
    near = [
        t for t in trials if t is not best and alike(t.evidence, best.evidence, best.overdispersion)
    ]
    return [t.effect for t in near if not apart(best, t)]


def beyond_doubt(best: Trial, trials: Sequence[Trial]) -> bool:
    """Whether a candidate has more evidence than sensors vary by, and no other has nearly as much.

    One refit of each is enough for that.
    """
    rivals = [t for t in trials if t is not best and not apart(best, t)]
    near = any(max(t.evidence, t.fitted_gain) > COMPETING_SHARE * best.evidence for t in rivals)
    return best.evidence > EVIDENCE_DECISIVE * best.overdispersion and not near


def contenders(best: Trial, trials: Sequence[Trial], promises: Mapping[str, float]) -> set[str]:
    """The best candidate, and those that may be better than it at their optima.

    These are its competitors, and candidates whose refit or score test (``promises``) gained nearly
    as much on the fitted half, of the same statistics. A refit that has not come to rest may gain
    more than sensors vary by.
    """
    found = {best.effect, *competitors(best, trials)}
    for t in trials:
        gain = max(t.fitted_gain, promises[t.effect])
        overdispersion = best.overdispersion if t.state.at_rest else math.inf
        if alike(gain, best.fitted_gain, overdispersion) and not apart(best, t):
            found.add(t.effect)
    return found
