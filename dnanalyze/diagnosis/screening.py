"""Which effects are worth a refit: each simulated once at its first guesses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.diagnosis.bend import beside, least_noise, relevelled, unbent
from dnanalyze.diagnosis.residual import Residual
from dnanalyze.errors import InputError
from dnanalyze.fitting.fit import ordinary_start
from dnanalyze.fitting.from_part import carried, part_for
from dnanalyze.fitting.least_squares import State, evened, loss, weights
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect, Placing
from dnanalyze.model.guesses.evidence import SIGN
from dnanalyze.model.noise_model import NoiseModel

LEAST = 6.0  # promise below which a refit is not worth it; what chance promises is several times
FIRST = 6  # guesses of an effect that are simulated; the rest only where one of these promises
HOPEFUL = 0.1  # share of the best promise of all from which the rest may come to something
FAINT = 60.0  # best promise below which other settings may show what these do not
PLAIN = 1.2  # loss a number from which much is missing
STRIDES = (0.03, 0.1, 0.25, 0.5, 1.0, 1.5, 2.5)


@dataclass(frozen=True)
class Prospect:
    """An effect at its first guess, with what it promises before any refit.

    Parameters
    ----------
    effect : str
    model : NoiseModel
        With the effect at its first guess.
    promise : float
        Fall of the fitted half's loss, at the two most telling settings, if the statistics moved
        linearly along the guess, with the model's own parameters free to follow; beyond what these
        parameters, free at two settings alone, would gain without it.
    levelled : NoiseModel, optional
        The guess at the level that moments tell, where the fit may have moved it.
    spare : bool
        Of another kind than those that promise more: refitted once the effect is the one to add.
    """

    effect: str
    model: NoiseModel
    promise: float
    levelled: NoiseModel | None = None
    spare: bool = False

    @property
    def kind(self) -> object:
        """Of the guess; None of an effect that has but one."""
        return kind_of(self.model, self.effect)


def kind_of(model: NoiseModel, effect: str) -> object:
    """Of an effect whose guesses come in several kinds; None of any other."""
    return getattr(model.get(effect), "kind", None)


def prospects(
    bench: Bench,
    state: State,
    known: dict[str, type[Effect]],
    tell: Callable[[str], None] = lambda _: None,
) -> list[Prospect]:
    """Simulate every effect that shows a sign at its first guesses; most promising first.

    Parameters
    ----------
    bench : Bench
    state : State
        Fitted model without the effects.
    known : dict
        Effects to consider, by name.
    tell : callable
        Called with each name.
    """
    clues = Residual(bench, state)
    few = _telling(bench, state)
    whole = _View.of(bench, state, few)
    half = whole.evened()
    part = _of_part(bench, state, few, whole.idle)
    views = {
        Placing.EVERYWHERE: half if part is None else part,
        Placing.ANYWHERE: half,
        Placing.SOMEWHERE: whole,
    }
    guesses, found, seen = {}, {}, {}
    for name, effect in known.items():
        tell(name)
        guesses[name] = effect.guess(clues)
        seen[name] = views[effect.placing]
        found[name] = _at_guesses(seen[name], guesses[name][:FIRST])
    most = max((p.promise for made in found.values() for p in made), default=0.0)
    if most < FAINT:
        for name in [n for n, made in found.items() if made]:
            again = _looked_at_again(bench, state, known[name], guesses[name][:FIRST], few)
            found[name] = sorted([*found[name], *again], key=lambda p: -p.promise)
    for name, made in found.items():
        if any(p.promise > max(LEAST, HOPEFUL * most) for p in made):
            made += _at_guesses(seen[name], guesses[name][FIRST:])
    best = [p for made in found.values() for p in _best(made)]
    return sorted(best, key=lambda p: -p.promise)


def _looked_at_again(
    bench: Bench, state: State, effect: type[Effect], guesses: Sequence[Effect], few: list[int]
) -> list[Prospect]:
    """Guesses at the two settings where both halves show the effect's fingerprint most plainly.

    None where these are the settings looked at already, or none shows it plainly.
    """
    shown = [_both_show(bench, state, name) for name in effect.fingerprint]
    strength = np.max([np.zeros(len(bench.plan.settings)), *shown], axis=0)
    settings = sorted(np.argsort(-strength, kind="stable")[:2].tolist())
    if strength.max() < SIGN or settings == few:
        return []
    view = _View.of(bench, state, settings)
    return _at_guesses(view.evened() if effect.placing < Placing.SOMEWHERE else view, guesses)


def _both_show(bench: Bench, state: State, name: str) -> np.ndarray:
    """How far a statistic is off on both halves alike, in floors, one a setting."""
    count = len(bench.plan.settings)
    sides = []
    for half, z in ((bench.train, state.train), (bench.test, state.test)):
        here = half.names == name
        number = np.bincount(half.setting[here], minlength=count)
        sides.append(np.bincount(half.setting[here], z[here], count) / np.maximum(number, 1))
    a, b = sides
    return np.where(a * b > 0, np.minimum(np.abs(a), np.abs(b)), 0.0)


@dataclass(frozen=True)
class _View:
    """Two settings, as a guess is looked at.

    Parameters
    ----------
    bench : Bench
    state : State
    idle : float
        The loss that an effect which moves nothing would reach.
    noise : float
        Of the quietest frames of all settings, DN.
    levelled : NoiseModel, optional
        The model at the level that moments tell, where much is missing.
    weight : float
        What a unit of its loss stands for.
    """

    bench: Bench
    state: State
    idle: float
    noise: float
    levelled: NoiseModel | None = None
    weight: float = 1.0

    @classmethod
    def of(cls, bench: Bench, state: State, settings: list[int]) -> _View:
        """Of some of the settings."""
        there = _restricted(bench, state, settings)
        idle = _reachable(there, there.train)
        levelled = relevelled(state.model, ordinary_start(bench)) if much_left(state) else None
        return cls(bench.only(settings), there, idle, least_noise(bench), levelled)

    def evened(self) -> _View:
        """The same without half of the field, where the model lets it be left out."""
        bench, state = evened(self.bench, self.state)
        return replace(self, bench=bench, state=state, idle=_reachable(state, state.train))


def _of_part(bench: Bench, state: State, settings: list[int], idle: float) -> _View | None:
    """The view of a part of the field, where much is missing and every part shows it.

    ``idle``: that of the whole field; a promise is taken to be the same share of it.
    """
    there = part_for(bench, state.model)
    if there is None or not much_left(state):
        return None
    view = _View.of(there, carried(state, bench, there), settings)
    return replace(view, weight=idle / view.idle)


def much_left(state: State) -> bool:
    """Whether so much is missing that a part of the field shows it, and a fit bends for it."""
    return state.loss >= PLAIN * len(state.train)


def _best(made: Sequence[Prospect]) -> list[Prospect]:
    """The best two, and the best of another kind to spare."""
    two = _two(made)
    others = [p for p in made if p.kind not in {q.kind for q in two}]
    spare = max(others, key=lambda p: p.promise, default=None)
    return two if spare is None else [*two, replace(spare, spare=True)]


def _two(made: Sequence[Prospect]) -> list[Prospect]:
    """The best two, of two guesses where there are several; else of two models with the one."""
    if not made:
        return []
    first, *rest = sorted(made, key=lambda p: -p.promise)
    rest = [p for p in rest if p.model != first.model]
    other = [p for p in rest if p.model.get(p.effect) != first.model.get(p.effect)]
    return [first, *(other or rest)[:1]]


def _telling(bench: Bench, state: State) -> list[int]:
    """The setting that the model misses most, and the one farthest from it in temperature."""
    train = bench.train
    losses = [loss(state.train[train.setting == s]) for s in range(len(bench.plan.settings))]
    worst = int(np.argmax(losses))
    ends = {0, len(losses) - 1}
    return sorted({worst, max(ends, key=lambda e: abs(e - worst))})


def _restricted(bench: Bench, state: State, settings: list[int]) -> State:
    """The state as seen at some of the settings."""
    here = np.isin(bench.train.setting, settings)
    there = np.isin(bench.test.setting, settings)
    return State(
        state.model, state.knobs, state.train[here], lambda: state.test[there], state.jacobian[here]
    )


def _at_guesses(view: _View, guesses: Sequence[Effect]) -> list[Prospect]:
    """Each guess in the model as it is, and in one whose numbers no longer make up for it."""
    bench, state = view.bench, view.state
    made = []
    for guess in guesses:
        right = unbent(state.model, guess, view.noise)
        levelled = view.levelled and unbent(view.levelled, guess, view.noise)
        rest = beside(bench, state.model, guess) if view.levelled else None
        for model in [m for m in (state.model, right, rest) if m is not None]:
            with suppress(InputError):
                other = levelled.with_effect(guess) if levelled and model is right else None
                made.append((guess, model.with_effect(guess), other))
    here = [guess.lies_in(bench.plan.windows[0]) for guess, *_ in made]
    moved = iter(
        bench.several([larger for (_, larger, _), seen in zip(made, here, strict=True) if seen])
    )
    found = []
    for (guess, larger, other), seen in zip(made, here, strict=True):
        if seen:
            promise = view.idle - _reachable(state, bench.train.z(next(moved)))
        else:  # the fitted half has none of it
            promise = loss(state.test) - loss(bench.judged_z(larger))
        found.append(Prospect(guess.name, larger, view.weight * promise, other))
    return found


def _reachable(state: State, moved: np.ndarray) -> float:
    """Least loss along the line from the present statistics through the moved ones."""
    w = weights(state.train)
    usable = np.linalg.norm(state.jacobian, axis=0) > 1e-6
    free = np.linalg.qr(state.jacobian[:, usable] * w[:, None])[0]

    def absorbed(z: np.ndarray) -> np.ndarray:
        return z - (free @ (free.T @ (z * w))) / w

    return min(loss(absorbed(state.train + s * (moved - state.train))) for s in STRIDES)
