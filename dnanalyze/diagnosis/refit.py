"""Refit the model with one more effect, from a first guess."""

from __future__ import annotations

import numpy as np

from dnanalyze.diagnosis.bend import UNBENT, bending, least_noise
from dnanalyze.diagnosis.screening import Prospect
from dnanalyze.fitting.from_part import carried, part_for
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import State, derive, minimise, start
from dnanalyze.fitting.predictor import Bench

BOLD = 50.0  # promise from which a bad beginning is worth derivatives of its own
FAR = 3.0  # times the loss without it: where a few steps leave it farther off it is given up
SURE = 100.0  # fall of the loss that leaves no doubt of a refit's worth


def refitted(
    bench: Bench,
    seen: Prospect,
    like: State,
    wanted: float,
    iterations: int,
    again: bool = True,
) -> State:
    """Refit a prospect from its first guess, with what is known of the model without it.

    On a part of the field first, where that may be. A refit that can no longer reach the ``wanted``
    loss is given up; ``again``: whether it promises enough, beside what another brought, for
    derivatives of its own and more steps.
    """
    part = part_for(bench, seen.model)
    if part is not None:
        there = carried(like, bench, part)
        share = there.loss / like.loss
        near = _from_guess(part, seen, there, share * wanted, iterations, share * SURE, again)
        return minimise(bench, carried(near, part, bench), iterations, below=wanted)
    return _from_guess(bench, seen, like, wanted, iterations, SURE, again)


def _from_guess(
    bench: Bench,
    seen: Prospect,
    like: State,
    wanted: float,
    iterations: int,
    sure: float,
    again: bool,
) -> State:
    """A refit on one field.

    An effect that bends the statistics much (a filter, a gain) begins farther off than the model
    without it stands, and the others' derivatives do not carry over: if it promises much they are
    taken anew, and more steps allowed (``again``). Not where it gained ``sure`` without, nor where
    it is so far off still that these steps would not bring it near.
    """
    begun = start(bench, seen.model, knobs_of(seen.model), like=like)
    guess = begun.model.get(seen.effect)
    assert guess is not None
    noise = least_noise(bench)
    moved = [bending(guess, k, begun.model, noise) != UNBENT for k in begun.knobs]
    begun.jacobian[:, moved] = np.nan
    ended = minimise(bench, begun, iterations, below=wanted)
    open_yet = begun.loss > like.loss and like.loss - sure < ended.loss < FAR * like.loss
    if again and open_yet and (seen.promise > BOLD or any(moved)):
        return minimise(bench, derive(bench, ended, anew=True), 3 * iterations, below=wanted)
    return ended
