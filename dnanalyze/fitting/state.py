"""State of a fit: a model, its misfits, and their derivatives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from dnanalyze.fitting.free_parameters import FreeParameter, free_parameters, positions
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.ties import Tie, misfits
from dnanalyze.fitting.vectors import SCALE
from dnanalyze.model.noise_model import NoiseModel

# Weight of the square of what a level lies beyond its bound, in bounds. On a real CCD the other
# statistics gained 2,200 by four bounds of the level: they put it some percent beyond. Where bounds
# cannot all be kept, half a bound beyond costs 2,500: no more than much else that is wrong there.
STIFF = 1e4


@dataclass(frozen=True)
class State:
    """A model with its misfits and their derivatives with respect to the free parameters.

    Parameters
    ----------
    model : NoiseModel
    free : list of FreeParameter
    train : ndarray
        Misfits z on the fitted half, in reproducibility SDs.
    unseen : callable
        Those on the held-out half: simulated when first asked for, which no step of a fit does.
    jacobian : ndarray
        d train / d parameter, (numbers, free parameters); NaN columns are not known yet.
    at_rest : bool
        Whether a fit has ended here because its derivatives, which its last step showed to be true,
        promise no more.
    bounds : ndarray, optional
        Of each train number, in SDs: how far it may be off, inf where that is left to the loss.
    ties : tuple of Tie
        Constraints of free parameters by direct measurements.
    weight : ndarray or float
        Of each train number in the loss.
    """

    model: NoiseModel
    free: list[FreeParameter]
    train: np.ndarray
    unseen: Callable[[], np.ndarray]
    jacobian: np.ndarray
    at_rest: bool = False
    bounds: np.ndarray | None = None
    ties: tuple[Tie, ...] = ()
    weight: np.ndarray | float = 1.0

    @property
    def test(self) -> np.ndarray:
        """Misfits z of the held-out half."""
        return self.unseen()

    @property
    def loss(self) -> float:
        """Weighted sum of the deviance over the train numbers."""
        return loss(self.train, self.weight)

    @property
    def merit(self) -> float:
        """Objective of a fit: the loss, with the terms of bounds and ties."""
        off = misfits(self.ties, positions(self.model, self.free)) if self.ties else np.zeros(1)
        return self.loss + stiff(self.train, self.bounds) + float(off @ off)


def unseen(problem: FitProblem, model: NoiseModel) -> Callable[[], np.ndarray]:
    """Function that computes the misfits of the held-out half when first asked."""
    return cache(partial(problem.held_out_z, model))


def deviance(z: np.ndarray) -> np.ndarray:
    """Pseudo-Huber loss 2 c^2 (sqrt(1 + (z/c)^2) - 1) of each: z^2 well below c, 2 c |z| above."""
    return np.asarray(2 * SCALE**2 * (np.sqrt(1 + (z / SCALE) ** 2) - 1))


def loss(z: np.ndarray, weight: np.ndarray | float = 1.0) -> float:
    """Weighted sum of the deviance; a fit minimises that with the weights of `Target.weight`."""
    return float(np.sum(weight * deviance(z)))


def stiff(z: np.ndarray, bounds: np.ndarray | None) -> float:
    """Contribution of numbers beyond their bounds to the merit."""
    return STIFF * float(np.sum(beyond(z, bounds) ** 2))


def beyond(z: np.ndarray, bounds: np.ndarray | None) -> np.ndarray:
    """How far numbers lie beyond their bounds, in bounds; 0 within them."""
    return np.zeros(1) if bounds is None else np.maximum(np.abs(z) / bounds - 1.0, 0.0)


def start(
    problem: FitProblem,
    model: NoiseModel,
    free: list[FreeParameter] | None = None,
    like: State | None = None,
) -> State:
    """Simulate a model; take over derivatives from a like model where free parameters agree.

    ``free``: all parameters of the model by default.
    """
    free = free_parameters(model) if free is None else free
    train = problem.fitted_z(model)
    blank = np.full((len(train), len(free)), np.nan)
    weight = problem.train.weight
    over = loss(train, weight) / len(train)
    bounds, ties = problem.train.bounds(over), problem.ties(model, free, over)
    begun = State(model, free, train, unseen(problem, model), blank, False, bounds, ties, weight)
    return begun if like is None else with_derivatives_of(begun, like)


def with_derivatives_of(state: State, like: State) -> State:
    """The state with a like model's derivatives where free parameters agree, and no others."""
    known = {k.name: i for i, k in enumerate(like.free)}
    jacobian = np.full((len(state.train), len(state.free)), np.nan)
    for i, parameter in enumerate(state.free):
        if parameter.name in known:
            jacobian[:, i] = like.jacobian[:, known[parameter.name]]
    return replace(state, jacobian=jacobian)


def evened(problem: FitProblem, state: State) -> tuple[FitProblem, State]:
    """The problem without half of the field, where the model allows it, and what it shows.

    Predictions are to be compared with those of this state.
    """
    alone = problem.evened(state.model)
    if alone.even == problem.even:
        return problem, state
    return alone, replace(state, train=alone.fitted_z(state.model))


def carried(state: State, there: FitProblem, here: FitProblem) -> State:
    """The model of a state, with its derivatives, from the part to the whole or back.

    A statistic's derivative is the same but for its reproducibility SD; it is taken to be 0 for one
    that only one of them has.
    """
    begun = start(here, state.model, state.free)
    return replace(begun, jacobian=there.train.derivatives_of(here.train, state.jacobian))


def root_weights(z: np.ndarray, weight: np.ndarray | float = 1.0) -> np.ndarray:
    """Square roots of the weights with which least squares equal the loss."""
    return np.asarray(np.sqrt(weight) * (1 + (z / SCALE) ** 2) ** -0.25)
