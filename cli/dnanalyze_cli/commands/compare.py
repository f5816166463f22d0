"""``dnanalyze compare``: the model against the measurement."""

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


def compare(
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
    """The model against the measurement; without --model the paper's model is fitted first."""
    from dnanalyze.comparator.compare import compare as run
    from dnanalyze.fitting.fit import fit
    from dnanalyze.report import documents, tables
    from dnanalyze_cli import show

    session = Session(
        "compare",
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
    with session.progress("Comparing") as progress:
        held = progress.bench(found)
        tell = progress.fitting(held)
        if own is not None and model is None:  # the paper's, of that seed: fitted like any
            own = fit(found, own, replicates=0, held=held, tell=tell).model
        comparison = run(found, model=own, held=held, tell=tell)
    show.comparison(session.console, found, comparison)

    def page() -> str:
        from dnanalyze.report.pages.compare import compare_page

        return compare_page(found, comparison)

    session.write(
        documents.comparison(captures, comparison), page, lambda: tables.comparison(comparison)
    )
