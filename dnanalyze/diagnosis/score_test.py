"""Score tests: expected fall of the loss of each candidate at its initial values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property, partial

import numpy as np
from scipy.optimize import minimize_scalar

from dnanalyze.comparator.error import TOLERABLE
from dnanalyze.diagnosis.nuisance import from_moments, least_noise, unbiased
from dnanalyze.errors import InputError
from dnanalyze.fitting.changes import Changes
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.residual import Residual
from dnanalyze.fitting.state import State, deviance, loss, root_weights
from dnanalyze.model.effect import Effect, Placing
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.strength import at_factor
from dnanalyze.progress import ignored

LONGEST = 3.0  # times a change; farther the statistics do not follow in proportion
# Least share of the change of an effect without a strength, such as a filter: it acts or it does
# not. Where a filter acts less it has other parameters, and half a strength is a form (`forms`). On
# real cameras without a filter, denoising and defect correction promised most at 0.006 to 0.06 of
# their changes, and took two of four refits in every round of the search.
SHORTEST = 0.5


@dataclass(frozen=True)
class Guess:
    """A candidate with initial values of its parameters.

    ``model``: with the effect. ``promise``: score test, the fall of the loss of the fitted half at
    the two most informative operating points, if the statistics move along the guess and the
    nuisance parameters follow linearly; less what these would gain alone.
    """

    effect: str
    model: NoiseModel
    promise: float

    @property
    def kind(self) -> object:
        """Of an effect whose guesses come in several kinds; None of any other."""
        return getattr(self.model.get(self.effect), "kind", None)


def score_tests(
    problem: FitProblem,
    state: State,
    known: dict[str, type[Effect]],
    on_progress: Callable[[str], None] = ignored,
) -> list[Guess]:
    """Simulate every candidate once at each of its initial values.

    Largest promise first; none of an effect of which the residual shows no sign. ``state``: the
    fitted model without the candidates. ``on_progress``: called with each name.

    Raises
    ------
    TimeUp
        The time is up.
    """
    clues, view = Residual(problem, state), _View.of(problem, state)
    found: list[Guess] = []
    for name, effect in known.items():
        on_progress(name)
        problem.limit.check()
        found += view.promises(effect.guess(clues), effect.placing)
    return sorted(found, key=lambda g: -g.promise)


@dataclass(frozen=True)
class _View:
    """Two operating points, at which guesses are simulated. ``whole``: all of them.

    ``nuisance_loss``: loss that the nuisance parameters reach alone. ``noise``: of the operating
    point with the least, DN. ``biased``: whether so much is missing that the level may be biased.
    """

    problem: FitProblem
    state: State
    whole: FitProblem
    nuisance_loss: float
    noise: float
    biased: bool

    @classmethod
    def of(cls, problem: FitProblem, state: State) -> _View:
        settings = informative(problem, state)
        there = restricted(problem, state, settings)
        nuisance_loss = along(there, np.zeros(len(there.train))).loss
        few = problem.only(settings)
        return cls(few, there, problem, nuisance_loss, least_noise(problem), much_left(there))

    @cached_property
    def changes(self) -> Callable[[Placing], Changes]:
        """For effects of each placing; the present model is simulated once for each."""
        return cache(partial(Changes.of, self.problem, self.state.model))

    def promises(self, guesses: Sequence[Effect], placing: Placing) -> list[Guess]:
        """Score test of each guess, with the nuisance parameters corrected for their bias."""
        made: list[tuple[Effect, NoiseModel, bool]] = []
        for guess in guesses:
            seen = guess.lies_in(self.problem.plan.windows[0])
            for model in self._beside(guess):
                with suppress(InputError):
                    made.append((guess, model.with_effect(guess), seen))
        visible = [model for _, model, seen in made if seen]
        shifts = iter(self.changes(placing).by(visible) if visible else ())
        found = []
        for guess, model, seen in made:
            if seen:
                shortest = 0.0 if at_factor(guess, 0.5) else SHORTEST
                promise = self.nuisance_loss - along(self.state, next(shifts), shortest).loss
            else:  # the fitted half has none of it
                unseen, weight = self.problem.held_out_z(model), self.problem.test.weight
                promise = loss(self.state.test, weight) - loss(unseen, weight)
            found.append(Guess(guess.name, model, promise))
        return found

    def _beside(self, guess: Effect) -> list[NoiseModel]:
        model = self.state.model
        anew = from_moments(self.whole, model, guess) if self.biased else None
        return [unbiased(model, guess, self.noise) or model, *([anew] if anew else [])]


def much_left(state: State) -> bool:
    """Whether the loss per statistic is beyond what an adequate model leaves."""
    return state.loss >= TOLERABLE * len(state.train)


def informative(problem: FitProblem, state: State) -> list[int]:
    """The operating point with the largest loss, and the end of the series farther from it."""
    train = problem.train
    each = state.weight * deviance(state.train)
    losses = np.bincount(train.setting, each, len(problem.plan.settings))
    worst = int(np.argmax(losses))
    return sorted({worst, max((0, len(losses) - 1), key=lambda e: abs(e - worst))})


def restricted(problem: FitProblem, state: State, settings: list[int]) -> State:
    """A state at some of the operating points."""
    here = np.isin(problem.train.setting, settings)
    there = np.isin(problem.test.setting, settings)
    return State(
        state.model, state.free, state.train[here], lambda: state.test[there],
        state.jacobian[here], weight=np.broadcast_to(state.weight, here.shape)[here],
    )  # fmt: skip


@dataclass(frozen=True)
class Least:
    """Least loss along a change of the predictions, and the share of the change where it is."""

    loss: float
    share: float


def along(state: State, change: np.ndarray, shortest: float = 0.0) -> Least:
    """Least loss along the line of a change of the predictions, in reproducibility SDs.

    The nuisance parameters are projected out. ``shortest``: least share of the change.
    """
    w = root_weights(state.train, state.weight)
    usable = np.linalg.norm(state.jacobian, axis=0) > 1e-6
    free = np.linalg.qr(state.jacobian[:, usable] * w[:, None])[0]

    def at(share: float) -> float:
        z = state.train - share * change
        return loss(z - (free @ (free.T @ (z * w))) / w, state.weight)

    whole = Least(at(1.0), 1.0)
    if not change.any():
        return whole
    found = minimize_scalar(at, bounds=(shortest, LONGEST), method="bounded")
    return min(whole, Least(float(found.fun), float(found.x)), key=lambda least: least.loss)
