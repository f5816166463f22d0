"""A model on its way to completion, and how it came there."""

from __future__ import annotations

from dataclasses import dataclass, field

from dnanalyze.diagnosis.trial import Trial
from dnanalyze.fitting.least_squares import State


@dataclass(frozen=True)
class Step:
    """What was added, and the error then.

    Parameters
    ----------
    added : str, optional
        None: the starting model; "-name": taken out again.
    error : float
    confidence : float, optional
        Probability that it was missing; None where nothing was asked.
    evidence : list of str
    confused_with : list of str
        Effects that explained nearly as much of the same.
    supported : bool
        Whether the data support it; what a user adds may not be.
    """

    added: str | None
    error: float
    confidence: float | None = None
    evidence: list[str] = field(default_factory=list)
    confused_with: list[str] = field(default_factory=list)
    supported: bool = True


@dataclass(frozen=True)
class Path:
    """A model and how it came there.

    Parameters
    ----------
    state : State
    steps : tuple of Step
        The first entry is the starting model.
    dropped : tuple of str
        Effects that were taken out again and do not come back.
    tried : tuple of Trial
        At its end: what was asked last.
    best : Trial, optional
        Of these, what the data support, where it was told to add no more.
    forks : tuple of Fork
        Where another effect explained nearly as much as the one that was added.
    """

    state: State
    steps: tuple[Step, ...]
    dropped: tuple[str, ...] = ()
    tried: tuple[Trial, ...] = ()
    best: Trial | None = None
    forks: tuple[Fork, ...] = ()

    @property
    def error(self) -> float:
        """At its end."""
        return self.steps[-1].error


@dataclass(frozen=True)
class Fork:
    """Where two effects explained nearly as much.

    Parameters
    ----------
    before : Path
        Up to there.
    taken, other : Trial
        What was added, and its closest rival.
    """

    before: Path
    taken: Trial
    other: Trial

    @property
    def nearness(self) -> float:
        """Evidence of the other over that of what was taken."""
        return self.other.evidence / self.taken.evidence
