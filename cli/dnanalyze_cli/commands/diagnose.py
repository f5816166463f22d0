"""``dnanalyze diagnose``: which effect is missing."""

from __future__ import annotations

from dnanalyze_cli.options import Budget, Exclude, ModelOptions, NoDescribe, takes


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
    from dnanalyze.report import documents, tables
    from dnanalyze.report.terminal.diagnosis import diagnosis as show
    from dnanalyze_cli import over_channels
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
        over_channels.diagnose(session, found, own, known, session.remaining(budget))
        return
    with session.progress("Reading frames") as progress:
        held = progress.bench(found)
        diagnosis = run(
            found,
            model=own,
            exclude=tuple(exclude or ()),
            budget=session.remaining(budget),
            known=known,
            held=held,
            tell=progress.trying,
            first=progress.first,
        )
    show(session.console, found, diagnosis)
    more = {} if no_describe else describe_residual(session, found, held, diagnosis, known, budget)

    def page() -> str:
        from dnanalyze.comparator.compare import compare_on
        from dnanalyze.comparator.rivals import of_diagnosis
        from dnanalyze.report.pages.diagnose import diagnose_page

        with session.progress("Comparing the model with the captures"):
            comparison = compare_on(found, diagnosis.model, held=held)
            beside = of_diagnosis(held, diagnosis)
        return diagnose_page(found, diagnosis, comparison, beside)

    session.write(
        documents.diagnosis(options.captures, diagnosis) | more,
        page,
        lambda: tables.candidates(diagnosis),
    )
