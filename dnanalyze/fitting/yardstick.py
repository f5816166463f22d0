"""Reproducibility standard deviations of a design, from replicates of the model.

The standard error of a statistic comes from the measured frames (see
`dnanalyze.analyzers.estimators.uncertainty`). What a model places, such as a glow, makes no scatter
there only as far as it is smooth; what it draws once a sensor, such as a cloud or a few defects,
shows in one measured sensor as structure. Simulated sensors of the model tell both apart.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.special import digamma, polygamma
from scipy.stats import chi2

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import Scale
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State, loss
from dnanalyze.fitting.vectors import Target
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.robust import robust_deviation

REPLICATES = 8  # their standard deviation is good to a quarter, 1 / sqrt(2 (8 - 1))
# Families of extremes, of shares of few pixels, lines or codes, and of tolerances (whole codes);
# counts are skewed too. Their stated errors grow with the value: a few replicates with small ones
# say nothing of a large one. Without this the scatter of row_periodic_2 is up to 3.9 times the
# yardstick (benchmarks/yardstick.py), and values that are no codes are off by 200 sigma.
SKEWED = ("codes", "lines", "tails")
LEAST_RATIO = 0.05  # of the stated error: less is none, of values that all replicates share


def by_design(problem: FitProblem, model: NoiseModel) -> FitProblem:
    """The fit problem with the reproducibility standard deviations of a model, and its weights."""
    drawn = [problem.replicate(model, r) for r in range(REPLICATES)]
    train, test = (np.array(half) for half in zip(*drawn, strict=True))
    there = problem.scaled(*scales((problem.train, problem.test), (train, test)))
    return there.weighted(misfit_share(there.fitted_z(model)))


def misfit_share(z: np.ndarray) -> float:
    """Share of the loss that is misfit, not noise: of noise alone a number has a loss of 1."""
    return 1.0 - 1.0 / max(1.0, loss(z) / len(z))


def measured_by(problem: FitProblem, state: State) -> tuple[FitProblem, State]:
    """Fit problem and state with the reproducibility standard deviations of the model.

    ``state`` is by the yardstick of ``problem``.
    """
    there = by_design(problem, state.model)
    return there, expressed(state, problem, there)


def fitted_by_design(
    problem: FitProblem, state: State, fit: Callable[[FitProblem, State], State]
) -> State:
    """A fit by the yardstick of the model with which it begins.

    The model error is stated by that of a model, and so a fit lowers what is reported. ``state``,
    and what is returned, are by the yardstick of ``problem``.
    """
    return fitted_in(by_design(problem, state.model), problem, state, fit)


def fitted_in(
    there: FitProblem, problem: FitProblem, state: State, fit: Callable[[FitProblem, State], State]
) -> State:
    """A fit by another yardstick than that of ``problem``, by which the state is stated."""
    return expressed(fit(there, expressed(state, problem, there)), there, problem)


Pair = tuple[np.ndarray, np.ndarray]  # of the fitted and of the held-out half


def scales(halves: tuple[Target, Target], drawn: Pair) -> Pair:
    """Factors by which stated errors are off, for each statistic.

    The scatter of the replicates over what is stated, both halves together, drawn to that of the
    statistic at all operating points, and this to that of its family (see `_drawn_together`). Below
    1 the stated errors hold structure that every sensor of the design has; above 1 the model draws
    few defects, tracks or phases a sensor, which one sensor does not show as scatter.

    Parameters
    ----------
    halves : (Target, Target)
        The fitted and the held-out half.
    drawn : (ndarray, ndarray)
        Coordinates of replicates on either, (replicates, statistics); NaN where one lacks it.
    """
    ratio = np.concatenate([_ratio(half, z) for half, z in zip(halves, drawn, strict=True)])
    keys = [str(k) for half in halves for k in half.keys]
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    own = np.sqrt(np.bincount(which, ratio) / np.bincount(which))
    own = np.where(own > LEAST_RATIO, own, 1.0)
    names, families = (
        np.concatenate([getattr(half, of) for half in halves]) for of in ("names", "families")
    )
    found = _drawn_together(own, names[first], families[first], 2 * (len(drawn[0]) - 1))[which]
    known = infos()
    counts = np.array([known[str(n)].scale is Scale.ROOT for n in names])
    found = np.maximum(found, np.where(np.isin(families, SKEWED) | counts, 1.0, LEAST_RATIO))
    count = len(halves[0].keys)
    return found[:count], found[count:]


def _drawn_together(
    ratio: np.ndarray, names: np.ndarray, families: np.ndarray, freedom: int
) -> np.ndarray:
    """Ratios of standard deviations by empirical Bayes: operating points, statistics, family.

    The logarithm of a sample's standard deviation has the variance psi'(n / 2) / 4 and the bias
    (psi(n / 2) - ln(n / 2)) / 2 at n degrees of freedom. What the ratios vary by beyond that, from
    one operating point to the next and from one statistic to the next, is how far they may differ
    (Efron and Morris, J. Am. Stat. Assoc. 70, 311 (1975)). Medians, since a few differ far; these
    are left within one standard deviation of their own value (limited translation, Efron and
    Morris, J. Am. Stat. Assoc. 67, 130 (1972)).
    """
    chance = float(polygamma(1, freedom / 2)) / 4.0
    logs = np.log(ratio) - (float(digamma(freedom / 2)) - math.log(freedom / 2)) / 2.0
    found = np.empty_like(logs)
    for family in np.unique(families):
        here = families == family
        _, which, count = np.unique(names[here], return_inverse=True, return_counts=True)
        mean = np.bincount(which, logs[here]) / count
        apart = logs[here] - mean[which]
        squares = np.bincount(which, apart**2)[count > 1]
        between = squares / chi2.median(count[count > 1] - 1)
        real = max(float(np.median(between)) - chance, 0.0) if between.size else 0.0
        error = (real + chance) / count
        middle = float(np.median(mean))
        spread = robust_deviation(mean, middle) ** 2
        other = max(spread - float(np.median(error)), 0.0)
        likely = _drawn(mean, middle, other, error)[which]
        likely = likely + apart * real / (real + chance)
        found[here] = np.clip(likely, logs[here] - chance**0.5, logs[here] + chance**0.5)
    return np.exp(found)


def _drawn(mean: np.ndarray, middle: float, real: float, error: np.ndarray) -> np.ndarray:
    """Means drawn to their middle, each by no more than its standard deviation."""
    drawn = middle + (mean - middle) * real / (real + error)
    return np.clip(drawn, mean - np.sqrt(error), mean + np.sqrt(error))


def _ratio(half: Target, drawn: np.ndarray) -> np.ndarray:
    """Variance of a difference of two replicates over that stated; 1 where they do not tell."""
    seen = np.isfinite(drawn)
    count = seen.sum(axis=0)
    mean = np.where(seen, drawn, 0.0).sum(axis=0) / np.maximum(count, 1)
    square = np.where(seen, drawn - mean, 0.0) ** 2
    variance = 2.0 * square.sum(axis=0) / np.maximum(count - 1, 1)
    usable = (count == len(drawn)) & (variance > 0.0)
    return np.where(usable, variance / half.stated**2, 1.0)


def expressed(state: State, there: FitProblem, here: FitProblem) -> State:
    """A state expressed in the reproducibility standard deviations of another problem."""
    train = there.train.expressed(state.train, here.train)
    return replace(
        state,
        train=train,
        unseen=cache(lambda: there.test.expressed(state.test, here.test)),
        jacobian=state.jacobian
        * (there.train.reproducibility_sd / here.train.reproducibility_sd)[:, None],
        bounds=here.train.bounds(loss(train, here.train.weight) / len(train)),
        weight=here.train.weight,
    )
