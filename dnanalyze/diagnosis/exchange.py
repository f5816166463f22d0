"""Another effect in the place of one that was added: an early choice may be its relative's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from dnanalyze.diagnosis.confidence import significant
from dnanalyze.diagnosis.trial import Trial, error_of, judged, removal, trials
from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect


@dataclass(frozen=True)
class Exchange:
    """One effect in the place of another.

    Parameters
    ----------
    gone : str
    without : State
        The model without it, refitted.
    found : Trial
        What comes instead; its gains are over the model that had the other.
    """

    gone: str
    without: State
    found: Trial


def exchange(
    bench: Bench,
    state: State,
    added: Sequence[str],
    open_to: dict[str, type[Effect]],
    tell: Callable[[str], None] = lambda _: None,
) -> Exchange | None:
    """The exchange that gains most; None where none is worth more than chance.

    While much is missing, two effects that are confused with each other may explain nearly as
    much, and which of them it was shows only once the rest is in the model.

    Parameters
    ----------
    bench : Bench
    state : State
    added : sequence of str
        Effects of the model that may go.
    open_to : dict
        Effects that may come, by name.
    tell : callable
        Called with each name that is tried.
    """
    error = error_of(bench, state)
    found: list[Exchange] = []
    for name in added:
        rivals = {n: e for n, e in open_to.items() if _alike(state, name, n, e)}
        if not rivals:
            continue
        without = removal(bench, state, name)
        for trial in trials(bench, without, rivals, tell):
            made = judged(bench, state, trial.effect, trial.state)
            if significant(made, error):
                found.append(Exchange(name, without, replace(made, others=trial.others)))
    return max(found, key=lambda f: f.found.evidence, default=None)


def _alike(state: State, name: str, other: str, effect: type[Effect]) -> bool:
    """Whether one of them names the other among what it is confused with."""
    mine = state.model.get(name)
    return name in effect.confused_with or (mine is not None and other in mine.confused_with)
