"""Files of a session's present model."""

from __future__ import annotations

from dnanalyze.model.noise_model import dump_model
from dnanalyze.workbench.session import WorkbenchSession


def model_file(session: WorkbenchSession) -> str:
    """The model file."""
    return dump_model(session.present.model)


def report(session: WorkbenchSession) -> str:
    """The report of `compare`, one self-contained page."""
    from dnanalyze.comparator.compare import compare_on
    from dnanalyze.report.page import render
    from dnanalyze.report.results.comparison import page

    model = session.present.model
    return render(page(compare_on(session.captures, model, problem=session.problem)))


def targets(session: WorkbenchSession) -> str:
    """Targets for `check`, from simulated sensors; takes seconds."""
    from dnanalyze.checking.margins import propose
    from dnanalyze.checking.targets import dump_targets

    return dump_targets(propose(session.captures, session.present.model))
