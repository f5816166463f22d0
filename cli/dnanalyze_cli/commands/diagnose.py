"""``dnanalyze diagnose``: which effect is missing."""

from __future__ import annotations

from dnanalyze_cli.options import (
    Captures,
    Channel,
    Config,
    Csv,
    EffectFiles,
    Json,
    Model,
    NoCache,
    Quiet,
    Report,
    Seed,
    Tolerance,
)
from dnanalyze_cli.session import Session


def diagnose(
    captures: Captures,
    model: Model = None,
    json: Json = None,
    report: Report = None,
    csv: Csv = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    channel: Channel = None,
    effects: EffectFiles = None,
    seed: Seed = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Which effect is missing, ranked, with the evidence for and against."""
    from dnanalyze.diagnosis.diagnose import diagnose as run
    from dnanalyze.report import documents, tables
    from dnanalyze_cli import over_channels, show

    session = Session(
        "diagnose",
        captures,
        json,
        report,
        csv,
        effects=tuple(effects or ()),
        quiet=quiet,
        cache=not no_cache,
    )
    own = session.model(model)
    found = session.load(config, tolerance_c, channel)
    own = session.seeded(found, own, seed)
    if len(found.channels) > 1:
        over_channels.diagnose(session, found, own, session.known())
        return
    with session.progress("Reading") as progress:
        held = progress.bench(found)
        diagnosis = run(
            found,
            model=own,
            known=session.known(),
            held=held,
            tell=lambda name: progress.now(f"Trying {name}"),
        )
    show.diagnosis(session.console, found, diagnosis)

    def page() -> str:
        from dnanalyze.comparator.compare import compare
        from dnanalyze.report.pages.diagnose import diagnose_page

        with session.progress("Comparing"):
            comparison = compare(found, diagnosis.model, held=held)
        return diagnose_page(found, diagnosis, comparison)

    session.write(
        documents.diagnosis(captures, diagnosis), page, lambda: tables.candidates(diagnosis)
    )
