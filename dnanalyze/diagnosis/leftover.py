"""What a first candidate leaves over: few steps, another choice, another effect, or a doubt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from dnanalyze.diagnosis.adequacy import FEW, HASTY, WORST, mends, unexplained
from dnanalyze.diagnosis.candidate import Candidate
from dnanalyze.diagnosis.confidence import PLAIN, STANDS_IN, significant
from dnanalyze.diagnosis.refit import refitted
from dnanalyze.diagnosis.screening import kind_of, prospects
from dnanalyze.diagnosis.trial import (
    STEPS,
    Trial,
    candidates_of,
    error_of,
    judged,
    related,
    settled,
)
from dnanalyze.fitting.from_part import derived_anew
from dnanalyze.fitting.least_squares import State, minimise
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect
from dnanalyze.model.registry import BASE


@dataclass(frozen=True)
class Leftover:
    """What a candidate leaves unexplained, and what that says of it.

    Parameters
    ----------
    found : Trial
        The candidate; refitted further if it left what no other candidate puts right.
    left : list of str
        Statistics that are off still, worst first.
    mender : str, optional
        An effect that puts the worst of them right.
    """

    found: Trial
    left: list[str]
    mender: str | None = None

    @property
    def doubted(self) -> bool:
        """Whether nothing is in sight that would account for what is left."""
        return bool(self.left) and self.mender is None

    def told(self, candidate: Candidate) -> Candidate:
        """The candidate with what it leaves said, and less sure where that doubts it."""
        worst = ", ".join(self.left[:WORST])
        if self.doubted:
            words = (
                f"it does not explain {worst}, and no other candidate does: it may replace "
                "an effect that is not in the catalogue"
            )
            sure = candidate.confidence * STANDS_IN
            told = [*candidate.evidence, words]
            return replace(candidate, confidence=sure, evidence=told, leaves=self.left)
        if self.mender is None:
            return candidate
        words = f"it does not explain {worst}, which {self.mender} in addition would correct"
        return replace(candidate, evidence=[*candidate.evidence, words], leaves=self.left)


def leftover(
    held: Bench,
    state: State,
    found: Trial,
    tried: Sequence[Trial],
    known: dict[str, type[Effect]],
) -> Leftover:
    """What a candidate leaves.

    Parameters
    ----------
    held : Bench
    state : State
        The model without it.
    found : Trial
    tried : sequence of Trial
        Of all candidates: another may account for what is left.
    known : dict
        Effects, by name, of which one may account for it too. Of none: nothing is followed up.
    """
    error = error_of(held, state)
    others = [t for t in tried if t is not found and significant(t, error)]
    # that it leaves any is enough where no other is asked for it
    rough = unexplained(held, found.state, HASTY) if known and not others else []
    left = rough or unexplained(held, found.state, FEW)
    mender = next((t.effect for t in others if mends(held, left[:1], state, t.state)), None)
    if known and left and mender is None:
        ended = found.state
        if not ended.at_rest:  # of what a few steps left, others tell little
            ended = minimise(held, derived_anew(held, ended), STEPS)
        left = unexplained(held, ended, FEW)
        guessed = kind_of(ended.model, found.effect) is not None  # in all kinds already
        for among_others in () if guessed else (settled, related):
            if left:
                ended = among_others(held, ended, found.effect)
                left = unexplained(held, ended, FEW)
        found = replace(judged(held, state, found.effect, ended), others=found.others)
        mender = _mender(held, ended, left, known)
    return Leftover(found, left, mender)


def _mender(
    held: Bench, state: State, left: Sequence[str], known: dict[str, type[Effect]]
) -> str | None:
    """The most promising effect, if it plainly puts some of the worst of what is left right."""
    open_to = candidates_of(state, known, [BASE]) if left else {}
    seen = prospects(held, state, open_to) if open_to else []
    if not seen:
        return None
    ended = refitted(held, seen[0], state, state.loss, STEPS)
    found = judged(held, state, seen[0].effect, ended)
    plain = found.evidence > PLAIN * found.spread and significant(found, error_of(held, state))
    return found.effect if plain and mends(held, left[:WORST], state, ended) else None
