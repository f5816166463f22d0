"""Try an effect: put it in, refit everything, and see what the half that no fit saw says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


from dnanalyze.comparator.error import pooled
from dnanalyze.diagnosis.residual import Residual
from dnanalyze.errors import InputError
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import State, loss, minimise, start
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect


@dataclass(frozen=True)
class Trial:
    """The model with one more effect, refitted.

    Parameters
    ----------
    effect : str
    state : State
        After the refit.
    gain : float
        Fall of the loss on the judged half; a useless effect gains about nothing.
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


def trial(
    bench: Bench,
    state: State,
    effect: type[Effect],
    iterations: int = 3,
    frozen: Sequence[str] = (),
) -> Trial | None:
    """Add an effect from each of its first guesses and refit; the best, or None without a guess.

    Parameters
    ----------
    bench : Bench
    state : State
        Fitted model without the effect.
    effect : type
    iterations : int
        Steps of the refit.
    frozen : sequence of str
        Parameters to hold.
    """
    best: State | None = None
    for guess in effect.guess(Residual(bench, state)):
        try:
            model = state.model.with_effect(guess)
        except InputError:
            continue
        begun = start(bench, model, knobs_of(model, frozen), like=state)
        ended = minimise(bench, begun, iterations)
        if best is None or ended.loss < best.loss:
            best = ended
    if best is None:
        return None
    return Trial(
        effect.name,
        best,
        loss(state.test) - loss(best.test),
        state.loss - best.loss,
        error_of(bench, best),
    )


def removal(
    bench: Bench, state: State, name: str, iterations: int = 3, frozen: Sequence[str] = ()
) -> State:
    """The model without an effect, refitted."""
    model = state.model.without(name)
    begun = start(bench, model, knobs_of(model, frozen), like=state)
    return minimise(bench, begun, iterations)


