"""An effect that may be missing, with what speaks for it."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing.

    Parameters
    ----------
    effect : str
    error_after : float
        Error on the unseen half once it is in and everything is refitted.
    explained : float
        Share of the error above 1 that it removes, 0 to 1.
    confidence : float
        Probability that this is the effect to add next.
    confused_with : list of str
    evidence : list of str
    leaves : list of str
        Statistics that the model leaves and that it does not put right, worst first.
    """

    effect: str
    error_after: float
    explained: float
    confidence: float
    confused_with: list[str]
    evidence: list[str]
    leaves: list[str] = field(default_factory=list)
