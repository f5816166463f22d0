"""Files of a session's present model."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from dnanalyze.model.noise_model import dump_model
from dnanalyze.model.registry import BASELINE
from dnanalyze.workbench.session import WorkbenchSession

if TYPE_CHECKING:
    from dnanalyze.fitting.problem import FitProblem
    from dnanalyze.report.rivals import Rivals


def model_file(session: WorkbenchSession) -> str:
    """The model file."""
    return dump_model(session.present.model)


def report(session: WorkbenchSession) -> str:
    """The report of `compare`, one self-contained page, with the named effect before and after."""
    from dnanalyze.comparator.compare import compare_on
    from dnanalyze.report.page import render
    from dnanalyze.report.results.comparison import page

    problem, model = session.problem, session.present.model
    assert problem is not None
    compared = compare_on(session.captures, model, problem=problem)
    return render(page(compared, rivals=_beside(session, problem)))


def _beside(session: WorkbenchSession, problem: FitProblem) -> Rivals:
    """The step on the way to the present model that lowered the error most by a named effect."""
    from dnanalyze.report.rivals import Rivals, rival, unfiltered

    assert session.history is not None
    path = session.history.path()
    steps = {
        node.action.removeprefix("add "): (before, node)
        for before, node in pairwise(path)
        if node.action.startswith("add ") and before.error is not None and node.error is not None
    }
    named = {n: pair for n, pair in steps.items() if n in session.known and n not in BASELINE}
    raw = unfiltered(problem, path[-1].model)
    if not named:
        return Rivals(raw=raw)
    effect = max(named, key=lambda n: (named[n][0].error or 0.0) - (named[n][1].error or 0.0))
    before, after = (rival(problem, node.model) for node in named[effect])
    return Rivals(effect, before, after, raw)


def targets(session: WorkbenchSession) -> str:
    """Targets for `check`, from simulated sensors; takes seconds."""
    from dnanalyze.checking.margins import propose
    from dnanalyze.checking.targets import dump_targets

    return dump_targets(propose(session.captures, session.present.model))
