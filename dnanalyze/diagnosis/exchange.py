"""Another effect, or another guess, in the place of one that was added while much was missing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from dnanalyze.diagnosis.confidence import significant
from dnanalyze.diagnosis.in_its_place import alike
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
    much, and which of them it was shows only once the rest is in the model. So does where an
    effect is best begun: it may come in its own place, guessed anew.

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
    for mine in [e for e in state.model.effects if e.name in added]:
        similar = {n: e for n, e in open_to.items() if alike(mine, e)}
        without = removal(bench, state, mine.name)
        for trial in trials(bench, without, {mine.name: type(mine), **similar}, tell):
            made = judged(bench, state, trial.effect, trial.state)
            if significant(made, error):
                found.append(Exchange(mine.name, without, replace(made, others=trial.others)))
    return max(found, key=lambda f: f.found.evidence, default=None)
