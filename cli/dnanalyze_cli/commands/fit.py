"""``dnanalyze fit``: the model's parameters with their uncertainties."""

from __future__ import annotations

from dnanalyze_cli.options import (
    Captures,
    Config,
    Csv,
    EffectFiles,
    Json,
    Model,
    ModelOut,
    NoCache,
    Quiet,
    Report,
    Seed,
    Tolerance,
)
from dnanalyze_cli.session import Session


def fit(
    captures: Captures,
    model: Model = None,
    output: ModelOut = None,
    json: Json = None,
    report: Report = None,
    csv: Csv = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    effects: EffectFiles = None,
    seed: Seed = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """The model's parameters with uncertainties, as a model file (-o)."""
    from dnanalyze.fitting.fit import fit as run
    from dnanalyze.model.noise_model import dump_model
    from dnanalyze.report import documents, tables
    from dnanalyze_cli import show

    session = Session(
        "fit",
        captures,
        json,
        report,
        csv,
        output,
        effects=tuple(effects or ()),
        quiet=quiet,
        cache=not no_cache,
    )
    start = session.model(model)
    found = session.load(config, tolerance_c)
    start = session.seeded(found, start, seed)
    with session.progress("Fitting"):
        result = run(found, model=start)
    show.fit(session.console, found, result)

    def page() -> str:
        from dnanalyze.report.pages.fit import fit_page

        return fit_page(found, result)

    session.write(
        documents.fit(captures, result, output),
        page,
        lambda: tables.parameters(result),
        lambda: dump_model(result.model),
    )
