"""The steps of a refinement as they are shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dnanalyze.model.registry import BASELINE
from dnanalyze.report.words import step_name

if TYPE_CHECKING:
    from dnanalyze.diagnosis.results import Step


BASELINE_STAGE = "baseline model"


@dataclass(frozen=True)
class Stage:
    """A bar of the waterfall.

    Parameters
    ----------
    name : str
    error : float
        After it.
    parts : tuple
        The refinement's steps that it holds.
    """

    name: str
    error: float
    parts: tuple[Step, ...]


def stages(steps: Sequence[Step]) -> list[Stage]:
    """The steps of a refinement, the baseline effects, which are fitted together, as one."""
    made = [Stage(step_name(s.added, n), s.error, (s,)) for n, s in enumerate(steps)]
    first = 1
    while first < len(made) and steps[first].added in BASELINE:
        first += 1
    if first < 3:  # one alone stands under its own name
        return made
    held = tuple(steps[1:first])
    return [made[0], Stage(BASELINE_STAGE, held[-1].error, held), *made[first:]]
