"""Try an effect: put it in, refit everything, and see what the half that no fit saw says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.comparator.error import pooled
from dnanalyze.diagnosis.residual import Residual
from dnanalyze.errors import InputError
from dnanalyze.fitting.knobs import knobs_of, positions, turned
from dnanalyze.fitting.least_squares import State, loss, minimise, start, weights
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel

MOST_REFITS = 4
WORTH = 0.15  # share of the best promise from which a candidate is refitted
LEAST = 6.0  # and the least promise; what chance promises is several times as much
BOLD = 50.0  # promise from which a bad beginning is worth derivatives of its own
FAR = 3.0  # times the present loss: another kind that begins farther off is not refitted
CLOSE = 0.6  # share of the best gain from which a rival is followed to the end
SURE = 100.0  # fall of the loss that leaves no doubt of a refit's worth
DOUBT = 6.0  # floors from which a difference tells less and less
KIND_GAIN = 4.0  # fall of the loss that another kind must bring
UNTRIED = ("bits", "step", "spacing")  # facts of the converter and the mosaic, not kinds
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
        linearly along the guess, with the model's own parameters free to follow.
    """

    effect: str
    model: NoiseModel
    promise: float


@dataclass(frozen=True)
class Trial:
    """The model with one more effect, refitted.

    Parameters
    ----------
    effect : str
    state : State
        After the refit.
    gain : float
        Fall of the deviance on the judged half; a useless effect gains about nothing.
    fitted_gain : float
        The same on the half that was fitted.
    error : float
        Pooled error on the judged half.
    """

    effect: str
    state: State
    gain: float
    fitted_gain: float
    error: float


def error_of(bench: Bench, state: State) -> float:
    """Pooled error on the judged half."""
    return pooled(state.test, bench.test.families)


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
    small = bench.only(few)
    part = _restricted(bench, state, few)
    found = []
    for name, effect in known.items():
        tell(name)
        made = [p for g in effect.guess(clues) for p in _prospects(small, part, g)]
        found += sorted(made, key=lambda p: -p.promise)[:2]
    return sorted(found, key=lambda p: -p.promise)


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
        state.model, state.knobs, state.train[here], state.test[there], state.jacobian[here]
    )


def _prospects(small: Bench, part: State, guess: Effect) -> list[Prospect]:
    """The guess in the model as it is, and in one whose numbers no longer make up for it."""
    models, bent = [part.model], guess.bent()
    if bent:
        knobs = knobs_of(part.model)
        plain = [k.plain(x) for k, x in zip(knobs, positions(part.model, knobs), strict=True)]
        right = [k.position(x * bent.get(k.name, 1.0)) for k, x in zip(knobs, plain, strict=True)]
        models.append(turned(part.model, knobs, np.array(right)))
    found = []
    for model in models:
        try:
            larger = model.with_effect(guess)
        except InputError:
            continue
        moved, _ = small.z(larger)
        found.append(Prospect(guess.name, larger, part.loss - _reachable(part, moved)))
    return found


def _reachable(state: State, moved: np.ndarray) -> float:
    """Least loss along the line from the present statistics through the moved ones."""
    w = weights(state.train)
    usable = np.linalg.norm(state.jacobian, axis=0) > 1e-6
    free = np.linalg.qr(state.jacobian[:, usable] * w[:, None])[0]

    def absorbed(z: np.ndarray) -> np.ndarray:
        return z - (free @ (free.T @ (z * w))) / w

    return min(loss(absorbed(state.train + s * (moved - state.train))) for s in STRIDES)


def trials(
    bench: Bench,
    state: State,
    known: dict[str, type[Effect]],
    tell: Callable[[str], None] = lambda _: None,
    iterations: int = 3,
) -> list[Trial]:
    """Refit the most promising candidates; best gain on the unseen half first."""
    seen = prospects(bench, state, known, tell)
    if not seen:
        return []
    least = max(WORTH * seen[0].promise, LEAST)
    best: dict[str, Trial] = {}
    most = 0.0
    for p in [p for p in seen if p.promise >= least][:MOST_REFITS]:
        if p.effect in best and best[p.effect].fitted_gain > SURE:
            continue
        wanted = state.loss - WORTH * most
        made = judged(bench, state, p.effect, refitted(bench, p, state, wanted, iterations))
        if p.effect not in best or made.state.loss < best[p.effect].state.loss:
            best[p.effect] = made
        most = max(most, made.fitted_gain)
    if best:
        _polish(bench, state, best)
    return sorted(best.values(), key=lambda t: -t.gain)


def _polish(bench: Bench, state: State, best: dict[str, Trial]) -> None:
    """Go on with rivals that gain much and nearly alike, or that raise the error for all they gain.

    A refit of few steps may mend what is far off at the cost of much that was right, and which of
    two is the better shows once both stand at their best.
    """
    most = max(t.gain for t in best.values())
    close = [t for t in best.values() if t.gain > CLOSE * most and t.fitted_gain > 0]
    if most < SURE or (len(close) < 2 and all(t.error < error_of(bench, state) for t in close)):
        return
    for t in close:
        fresh = replace(t.state, jacobian=np.full_like(t.state.jacobian, np.nan))
        best[t.effect] = judged(bench, state, t.effect, minimise(bench, fresh, 6))


def refitted(bench: Bench, seen: Prospect, like: State, wanted: float, iterations: int) -> State:
    """Refit a prospect from its first guess, with what is known of the model without it.

    A refit that can no longer reach the ``wanted`` loss is given up. An effect that bends the
    statistics much (a filter, a gain) begins farther off than the model without it stands, and the
    others' derivatives do not carry over: if it promises much they are taken anew, and more steps
    allowed.
    """
    begun = start(bench, seen.model, knobs_of(seen.model), like=like)
    moved = [k.name in _effect(begun.model, seen.effect).bent() for k in begun.knobs]
    begun.jacobian[:, moved] = np.nan
    ended = minimise(bench, begun, iterations, below=wanted)
    if (seen.promise > BOLD or any(moved)) and begun.loss > like.loss < ended.loss + SURE:
        unknown = np.full_like(ended.jacobian, np.nan)
        return minimise(bench, replace(ended, jacobian=unknown), 3 * iterations, below=wanted)
    return ended


def deviance(z: np.ndarray) -> float:
    """Misfit as evidence: z^2 for small differences, growing as their log beyond `DOUBT` floors.

    However far off, one statistic is one witness: a saturated quantile, a floor that is too small
    by luck. (Twice the negative log likelihood of Student's t, but for a constant factor.)
    """
    return float(DOUBT**2 * np.sum(np.log1p((z / DOUBT) ** 2)))


def judged(bench: Bench, before: State, effect: str, after: State) -> Trial:
    """A refit, with what it gained on either half."""
    return Trial(
        effect,
        after,
        deviance(before.test) - deviance(after.test),
        deviance(before.train) - deviance(after.train),
        error_of(bench, after),
    )


def settled(bench: Bench, state: State, name: str, iterations: int = 3) -> State:
    """The best of an effect's kinds: each alternative to its choices, refitted from here."""
    for choice, info in _effect(state.model, name).parameters().items():
        if info.scale != "choice" or choice in UNTRIED:
            continue
        for other in info.choices:
            effect = _effect(state.model, name)
            if other != getattr(effect, choice):
                kind = replace(effect, **{choice: other})
                state = _better(bench, state, kind, iterations)
    for other in _effect(state.model, name).relatives():
        state = _better(bench, state, other, 2 * iterations, anew=True)
    return state


def _better(bench: Bench, state: State, kind: Effect, iterations: int, anew: bool = False) -> State:
    """The model with another kind of an effect, refitted, if that is clearly better.

    ``anew``: its numbers are others, and so are its derivatives.
    """
    try:
        model = state.model.with_effect(kind)
    except InputError:
        return state
    begun = start(bench, model, knobs_of(model), like=state)
    if begun.loss > FAR * state.loss or np.array_equal(begun.train, state.train):
        return state
    if anew:
        begun.jacobian[:, [k.effect == kind.name for k in begun.knobs]] = np.nan
    ended = minimise(bench, begun, iterations)
    return ended if ended.loss < state.loss - KIND_GAIN else state


def _effect(model: NoiseModel, name: str) -> Effect:
    found = model.get(name)
    assert found is not None
    return found


def removal(bench: Bench, state: State, name: str, iterations: int = 3) -> State:
    """The model without an effect, refitted."""
    model = state.model.without(name)
    return minimise(bench, start(bench, model, knobs_of(model), like=state), iterations)


def candidates_of(
    state: State, known: dict[str, type[Effect]], exclude: Sequence[str]
) -> dict[str, type[Effect]]:
    """Effects that are neither in the model nor excluded."""
    return {n: e for n, e in known.items() if n not in exclude and state.model.get(n) is None}
