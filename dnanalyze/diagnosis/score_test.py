"""First-order screening: what each candidate promises at its first guesses, before any refit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from dnanalyze.diagnosis.nuisance import from_moments, least_noise, unbiased
from dnanalyze.diagnosis.selection import TOLERABLE
from dnanalyze.errors import InputError
from dnanalyze.fitting.from_part import carried, part_for
from dnanalyze.fitting.least_squares import State, evened, loss, weights
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.residual import Residual
from dnanalyze.model.effect import Effect, Placing
from dnanalyze.model.noise_model import NoiseModel


@dataclass(frozen=True)
class Guess:
    """A candidate at a first guess of its parameters.

    ``model``: with the effect. ``promise``: score test, the fall of the loss of the fitted half at
    the two most telling operating points, if the statistics move along the guess and the nuisance
    parameters follow linearly; less what these would gain alone.
    """

    effect: str
    model: NoiseModel
    promise: float

    @property
    def kind(self) -> object:
        """Of an effect whose guesses come in several kinds; None of any other."""
        return getattr(self.model.get(self.effect), "kind", None)


def score_tests(
    bench: Bench,
    state: State,
    known: dict[str, type[Effect]],
    tell: Callable[[str], None] = lambda _: None,
) -> list[Guess]:
    """Simulate every candidate once at each of its first guesses.

    Largest promise first; none of an effect of which the residual shows no sign. ``state``: the
    fitted model without the candidates. ``tell``: called with each name.
    """
    clues, few = Residual(bench, state), _telling(bench, state)
    whole = _View.of(bench, state, few)
    half = whole.evened()
    views = {
        Placing.EVERYWHERE: _of_part(bench, state, few, whole.idle) or half,
        Placing.ANYWHERE: half,
        Placing.SOMEWHERE: whole,
    }
    found: list[Guess] = []
    for name, effect in known.items():
        tell(name)
        found += _at_guesses(views[effect.placing], effect.guess(clues))
    return sorted(found, key=lambda g: -g.promise)


@dataclass(frozen=True)
class _View:
    """Two operating points, at which guesses are simulated.

    ``idle``: loss that the nuisance parameters reach alone. ``noise``: of the operating point with
    the least, DN. ``biased``: whether so much is missing that the level itself may be biased.
    ``weight``: what a unit of the loss stands for on the whole field.
    """

    bench: Bench
    state: State
    idle: float
    noise: float
    biased: bool
    weight: float = 1.0

    @classmethod
    def of(cls, bench: Bench, state: State, settings: list[int]) -> _View:
        there = _restricted(bench, state, settings)
        idle = _least_loss(there, there.train)
        return cls(bench.only(settings), there, idle, least_noise(bench), much_left(state))

    def evened(self) -> _View:
        """Without the held-out half of the field, where the model lets it be left out."""
        bench, state = evened(self.bench, self.state)
        return replace(self, bench=bench, state=state, idle=_least_loss(state, state.train))


def _of_part(bench: Bench, state: State, settings: list[int], idle: float) -> _View | None:
    """A part of the field, where it may stand for the whole and much is missing."""
    there = part_for(bench, state.model)
    if there is None or not much_left(state):
        return None
    view = _View.of(there, carried(state, bench, there), settings)
    return replace(view, weight=idle / view.idle)


def much_left(state: State) -> bool:
    """Whether the loss per statistic is beyond what an adequate model leaves."""
    return state.loss >= TOLERABLE * len(state.train)


def _telling(bench: Bench, state: State) -> list[int]:
    """The operating point with the largest loss, and the end of the series farther from it."""
    train = bench.train
    losses = [loss(state.train[train.setting == s]) for s in range(len(bench.plan.settings))]
    worst = int(np.argmax(losses))
    return sorted({worst, max((0, len(losses) - 1), key=lambda e: abs(e - worst))})


def _restricted(bench: Bench, state: State, settings: list[int]) -> State:
    here = np.isin(bench.train.setting, settings)
    there = np.isin(bench.test.setting, settings)
    return State(
        state.model, state.knobs, state.train[here], lambda: state.test[there], state.jacobian[here]
    )


def _at_guesses(view: _View, guesses: Sequence[Effect]) -> list[Guess]:
    """Each guess beside the parameters as fitted, and beside such as no longer make up for it."""
    bench, state = view.bench, view.state
    made: list[tuple[str, NoiseModel, bool]] = []
    for guess in guesses:
        seen = guess.lies_in(bench.plan.windows[0])
        starts = [state.model, unbiased(state.model, guess, view.noise)]
        if view.biased:
            starts.append(from_moments(bench, state.model, guess))
        for model in starts:
            if model is not None:
                with suppress(InputError):
                    made.append((guess.name, model.with_effect(guess), seen))
    moved = iter(bench.several([model for _, model, seen in made if seen]))
    found = []
    for name, model, seen in made:
        if seen:
            promise = view.idle - _least_loss(state, bench.train.z(next(moved)))
        else:  # the fitted half has none of it
            promise = loss(state.test) - loss(bench.judged_z(model))
        found.append(Guess(name, model, view.weight * promise))
    return found


def _least_loss(state: State, moved: np.ndarray) -> float:
    """Least loss along the line from the present statistics through the moved ones.

    The nuisance parameters are projected out.
    """
    w = weights(state.train)
    usable = np.linalg.norm(state.jacobian, axis=0) > 1e-6
    free = np.linalg.qr(state.jacobian[:, usable] * w[:, None])[0]

    def at(step: float) -> float:
        z = state.train + step * (moved - state.train)
        return loss(z - (free @ (free.T @ (z * w))) / w)

    return float(min(at(1.0), minimize_scalar(at, bounds=(0.0, 3.0), method="bounded").fun))
