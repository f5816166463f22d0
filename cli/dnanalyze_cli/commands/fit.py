"""``dnanalyze fit``: the model's parameters with their uncertainties."""

from __future__ import annotations

from dnanalyze_cli.options import (
    Captures,
    Channel,
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
    channel: Channel = None,
    effects: EffectFiles = None,
    seed: Seed = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """The model's parameters with uncertainties, as a model file (-o)."""
    from dnanalyze.fitting.fit import fit as run
    from dnanalyze.model.noise_model import dump_model
    from dnanalyze.report import documents, tables
    from dnanalyze_cli import over_channels, show

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
    found = session.load(config, tolerance_c, channel)
    start = session.seeded(found, start, seed)
    if start is not None:
        start = over_channels.spread(start, found)
    with session.progress("Fitting") as progress:
        held = progress.bench(found)
        result = run(found, model=start, held=held, tell=progress.fitting(held))
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
