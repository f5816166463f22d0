"""Effects that a model does without."""

from __future__ import annotations

from dnanalyze.diagnosis.adequacy import on_average
from dnanalyze.diagnosis.confidence import CERTAIN, LUCK, NOTHING
from dnanalyze.diagnosis.trial import error_of, judged, removal
from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.registry import BASE, EVERYDAY

REFIT = 3  # steps of the fit without an effect


def needless(held: Bench, state: State) -> tuple[State, list[str]]:
    """Drop effects whose removal, after a refit, costs nothing on the unseen half.

    The latest too: it may have led others to a place from which they do without it. Where the refit
    bends the rest around one half, removal as it is counts.

    Returns
    -------
    state : State
        The model without them, refitted.
    gone : list of str
    """
    gone = []
    for name in list(state.model.names):
        if name in (*EVERYDAY, BASE):
            continue
        without = _without(held, state, name)
        if without is not None:
            state = without
            gone.append(name)
    return state, gone


def _without(held: Bench, state: State, name: str) -> State | None:
    """The model without an effect, refitted or as it is, if it does without."""
    removed = (removal(held, state, name, steps) for steps in (REFIT, 0))
    return next((s for s in removed if _idle(held, s, state, name)), None)


def _idle(held: Bench, without: State, state: State, name: str) -> bool:
    """Whether an effect gains nothing on the unseen half, and the error stays without it; where
    the fitted half gains much, on average over simulated sensors.
    """
    found = judged(held, without, name, state)
    if error_of(held, without) > (1.0 + LUCK) * found.error:
        return False
    if found.gain < NOTHING / 2 and found.fitted_gain > CERTAIN:
        before, after = (on_average(held, s)[1] for s in (without, state))
        found = judged(held, before, name, after)
    return found.gain < NOTHING / 2
