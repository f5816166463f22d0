"""``dnanalyze diagnose``: which effect is missing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dnanalyze_cli.options import Budget, Exclude, ModelOptions, NoDescribe, takes

if TYPE_CHECKING:
    from dnanalyze.report.page import Page


@takes(ModelOptions)
def diagnose(
    options: ModelOptions,
    exclude: Exclude = None,
    budget: Budget = None,
    no_describe: NoDescribe = False,
) -> None:
    """Rank the effects that may be missing in a model, with the evidence for and against."""
    from dnanalyze.diagnosis.diagnose import diagnose_on as run
    from dnanalyze.model.registry import find
    from dnanalyze_cli import channel_commands
    from dnanalyze_cli.residual_description import describe_residual

    session = options.session("diagnose")
    session.remaining(budget)
    known = session.known()
    for name in exclude or ():
        find(name, known)
    found, own = options.begin(session)
    if len(found.channels) > 1:
        for name in exclude or ():
            known.pop(name)
        channel_commands.diagnose_over_channels(
            session, found, own, known, session.remaining(budget)
        )
        return
    with session.progress("Reading frames") as progress:
        problem = session.fit_problem(progress, found)
        diagnosis = run(
            found,
            model=own,
            exclude=tuple(exclude or ()),
            budget=session.remaining(budget),
            known=known,
            problem=problem,
            on_progress=progress.trying,
            first=progress.first,
        )
    session.show(diagnosis)
    more = (
        {} if no_describe else describe_residual(session, found, problem, diagnosis, known, budget)
    )

    def page() -> Page:
        from dnanalyze.comparator.compare import compared, paper_model
        from dnanalyze.fitting.yardstick import by_design
        from dnanalyze.report.results import diagnosis as report
        from dnanalyze.report.rivals import of_diagnosis

        with session.progress("Comparing the model with the captures"):
            assert diagnosis.model is not None
            paper = paper_model(problem, diagnosis.begun, in_time=diagnosis.finished)
            there = by_design(problem, diagnosis.model)
            comparison = compared(found, there, diagnosis.model, paper)
            beside = of_diagnosis(problem, diagnosis)
        return report.page(diagnosis, comparison, beside)

    session.finish(diagnosis, page, more)
