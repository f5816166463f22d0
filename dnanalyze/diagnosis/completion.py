"""An effect that was put in, taken to its end: its best kind and strength, everything in place."""

from __future__ import annotations

from dnanalyze.diagnosis.background import along_background
from dnanalyze.diagnosis.bend import along_bend, begun_again, begun_elsewhere
from dnanalyze.diagnosis.trial import error_of, preferred, related, settled
from dnanalyze.fitting.least_squares import State, converge
from dnanalyze.fitting.predictor import Bench

POOR = 1.3  # error above which a choice is reconsidered


def completed(held: Bench, state: State, name: str) -> State:
    """The effect in its best kind and everything at its best place; each may change the other.

    Parameters
    ----------
    held : Bench
    state : State
        With the effect, as refitted from its guess.
    name : str
    """
    if error_of(held, state) > POOR:
        state = converge(held, state)  # the others are at their ends when they are compared with it
    # of a wrong strength the wrong kind may be the better
    for other in (begun_again, along_bend, begun_elsewhere):
        if error_of(held, state) > POOR:
            state = preferred(state, other(held, state, name) or state)
    state = converge(held, settled(held, state, name))
    state = preferred(state, along_bend(held, state, name) or state)
    if error_of(held, state) > POOR:
        state = along_background(held, state)
    again = related(held, settled(held, state, name), name)
    return state if again is state else converge(held, again)
