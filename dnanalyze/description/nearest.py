"""The nearest effects of the catalogue, and why they fail."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dnanalyze.comparator.error import ERROR_SCATTER
from dnanalyze.comparator.predictive_check import error_of
from dnanalyze.diagnosis.candidates import candidates_of
from dnanalyze.diagnosis.explain import evidence_against
from dnanalyze.diagnosis.score_test import Guess, score_tests
from dnanalyze.digits import number
from dnanalyze.fitting.from_part import FIT_STEPS
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State
from dnanalyze.fitting.state import start as begun_at
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.model.effect import Effect
from dnanalyze.model.registry import BASE

PROMISING = 2  # largest score tests: the effect that is missing, and what it is confounded with
# By geometry and time: what the catalogue has that leaves power at the same place.
NEAREST_BY_KIND = {
    ("wave", "fixed"): ("periodic_pattern", "cfa_mismatch", "column_taps"),
    ("rings", "fixed"): ("periodic_pattern", "flicker_fpn"),
    ("diagonal", "fixed"): ("flicker_fpn", "periodic_pattern"),
    ("block", "fixed"): ("column_taps", "cfa_mismatch"),
    ("quadrants", "fixed"): ("dark_gradient", "column_taps"),
    ("halves", "fixed"): ("dark_gradient", "column_taps"),
    ("surface", "frame"): ("offset_drift", "flicker_noise"),
    ("quadrants", "frame"): ("offset_drift", "flicker_noise"),
    ("halves", "frame"): ("offset_drift", "row_noise"),
    ("blob", "frame"): ("flicker_noise", "cosmic_rays"),
    ("block", "frame"): ("crosstalk", "denoise"),
    ("column_segments", "frame"): ("column_noise", "rts"),
    ("row_segments", "frame"): ("row_noise", "rts"),
    ("row", "fixed"): ("row_noise", "heavy_tailed_read_noise"),
    ("column", "fixed"): ("column_noise", "heavy_tailed_read_noise"),
}
NOISE = ("column_noise", "heavy_tailed_read_noise")


@dataclass(frozen=True)
class Nearest:
    """An effect of the catalogue instead of the structure."""

    effect: str
    error_after: float  # model error with it; NaN where it shows no sign or is in the model already
    why: str  # why it fails


def as_good(near: Sequence[Nearest], error: float) -> str | None:
    """The effect of the catalogue with which the error is as low; its name is preferred."""
    close = [n for n in near if n.error_after <= (1.0 + ERROR_SCATTER) * error]
    return min(close, key=lambda n: n.error_after).effect if close else None


def nearest(
    problem: FitProblem,
    state: State,
    ended: State,
    effect: CompositeEffect,
    known: Mapping[str, type[Effect]],
) -> list[Nearest]:
    """A few effects, each refitted instead of the structure.

    Those that look alike, and the two with the largest score tests: what is all over the spectrum
    leaves power where the structure was found, too.
    """
    alike = (
        NOISE
        if effect.what == "noise" and effect.where in ("wave", "rings")
        else NEAREST_BY_KIND.get((effect.where, effect.when), ())
    )
    open_to = candidates_of(state, dict(known), [BASE])
    guesses: dict[str, Guess] = {}
    for guess in score_tests(problem, state, open_to):  # the largest first
        guesses.setdefault(guess.effect, guess)
    nan = float("nan")
    found = []
    for name in dict.fromkeys([*(n for n in alike if n in known), *list(guesses)[:PROMISING]]):
        error, why = nan, "not indicated by the statistics"
        if state.model.get(name) is not None:
            why = f"already in the model, model error {number(error_of(problem, state))}"
        elif name in guesses:
            begun = begun_at(problem, guesses[name].model, like=state)
            rival = minimise(problem, begun, FIT_STEPS)
            against = evidence_against(problem, rival, ended, name, CompositeEffect.name)
            error, why = error_of(problem, rival), against or "explains nearly as much"
        found.append(Nearest(name, error, why))
    return found
