"""What a search has come to: a model, the steps that led to it, and its limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from dnanalyze.diagnosis.results import Step
from dnanalyze.diagnosis.selection import Trial
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State
from dnanalyze.model.registry import BASELINE


@dataclass(frozen=True)
class Path:
    """A model and the steps that led to it.

    ``dropped``: effects that were removed and are not added again. ``converged``: whether all
    parameters are at their optimum, which waits for the end where much is missing. ``refused``:
    effects with which the error of the present model would rise; a further effect in the model, or
    a fit of all parameters, opens them again, since they then no longer fit its residual. ``open``:
    candidates tried before all others: those of other statistics that were significant beside the
    last one, and those with the largest score tests on a part of the field. At the end, ``tried``:
    the candidates tested last, and ``best``: the significant one that a limit of the user kept out.
    ``problem``: the captures by the yardstick by which the last error is stated.
    """

    state: State
    steps: tuple[Step, ...] = ()
    dropped: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()
    converged: bool = True
    open: tuple[str, ...] = ()
    tried: tuple[Trial, ...] = ()
    best: Trial | None = None
    problem: FitProblem | None = None

    @property
    def error(self) -> float:
        """Model error of the last step."""
        return self.steps[-1].error


def descending(steps: Sequence[Step]) -> list[Step]:
    """The steps without those by which the model error rises, and with which it never falls.

    A Wang 2025 model has tables of its own for every operating point; where much is missing, the
    baseline effects describe a sensor worse until some of that is found. They then enter with the
    first effect that takes the error below the one before, and share its error.
    """
    made: list[Step] = []
    waiting: list[Step] = []
    for step in steps:
        rises = bool(made) and step.error > made[-1].error
        if rises and (waiting or step.added in BASELINE):
            waiting.append(step)
            continue
        words = f"it enters with {step.added}: without that the model error would rise"
        made += [replace(w, error=step.error, evidence=[*w.evidence, words]) for w in waiting]
        made.append(step)
        waiting = []
    return made


def last_change(steps: Sequence[Step]) -> int:
    """Number of steps of the last change: two of an exchange, which share their error."""
    if len(steps) < 3:
        return 1
    gone, come = steps[-2:]
    removed, added = (str(s.added).startswith("-") for s in (gone, come))
    return 2 if removed and not added and gone.error == come.error else 1


@dataclass(frozen=True)
class Addition:
    """An effect that may be added, and the model that has it.

    ``trial``: its refit beside the model before, ``tried``: among these candidates. ``error``:
    model error. ``evidence``: sentences.
    """

    trial: Trial
    tried: Sequence[Trial]
    state: State
    error: float
    evidence: Sequence[str]


def falling(errors: Sequence[float]) -> bool:
    """Whether no error exceeds the one before it."""
    return all(after <= before for before, after in pairwise(errors))


@dataclass(frozen=True)
class SearchLimits:
    """When a search ends although further effects are detectable.

    Parameters
    ----------
    max_effects : int, optional
        Once this many effects were added to the baseline model; with 0 no others are tested.
    until_error : float, optional
        Once the model error is at or below this.
    """

    max_effects: int | None = None
    until_error: float | None = None


NO_LIMITS = SearchLimits()
