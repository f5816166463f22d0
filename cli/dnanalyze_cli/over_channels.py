"""`refine`, `add`, `channels` and `diagnose` over all channels of an HDR sensor."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from dnanalyze_cli.session import Session

if TYPE_CHECKING:
    from dnanalyze.channels.refinement import ChannelRefinement
    from dnanalyze.loaders.captures import CaptureSet
    from dnanalyze.model.noise_model import NoiseModel
    from dnanalyze.progress import Progress

    Run = Callable[[Progress], ChannelRefinement]


def spread(model: NoiseModel, found: CaptureSet) -> NoiseModel:
    """A row for every channel in what belongs to the readout, where the model has one for all."""
    from dnanalyze.model.channel_models import channel_model, channels_of, merged

    if channels_of(model) or len(found.channels) < 2:
        return model
    known = {s.point.temperature_c for s in found.settings}
    celsius = sorted(t for t in known if t is not None)
    return merged({c: channel_model(model, c) for c in found.channels}, celsius)


def refine(session: Session, found: CaptureSet, run: Run) -> None:
    """Run, show and write what completes the model of every channel."""
    from dnanalyze.model.noise_model import dump_model
    from dnanalyze.report import channel_results, tables
    from dnanalyze.report.terminal.channels import refinement as show
    from dnanalyze.report.terminal.refinement import not_kept

    with session.progress("Reading frames") as progress:
        result = run(progress)
    show(session.console, found, result)
    if session.output is None:
        not_kept(session.console)

    def page() -> str:
        from dnanalyze.comparator.compare import compare_on
        from dnanalyze.report.pages.hdr_channels import refinement_page

        with session.progress("Comparing the model with the captures"):
            comparison = compare_on(found, result.model, held=result.bench)
        return refinement_page(found, result, comparison)

    where = str(session.captures)
    session.write(
        channel_results.refinement(where, session.command, result, session.output),
        page,
        lambda: tables.steps(result),
        lambda: dump_model(result.model),
    )


def diagnose(
    session: Session,
    found: CaptureSet,
    model: NoiseModel | None,
    known: dict[str, Any],
    budget: float | None = None,
) -> None:
    """Run, show and write the diagnosis of every channel."""
    from dnanalyze.channels.refinement import diagnose_channels, worst_verdict
    from dnanalyze.report import channel_results, tables
    from dnanalyze.report.terminal.channels import diagnosis as show

    with session.progress("Reading frames") as progress:
        made = diagnose_channels(found, model, budget=budget, known=known, tell=progress.now)
    verdict = worst_verdict(d.verdict for d in made.values())
    show(session.console, found, made, verdict)

    def page() -> str:
        from dnanalyze.report.pages.hdr_channels import diagnosis_page

        return diagnosis_page(found, made, verdict)

    def table() -> Any:
        import pandas as pd

        parts = [tables.candidates(d).assign(channel=name) for name, d in made.items()]
        return pd.concat(parts, ignore_index=True)

    session.write(channel_results.diagnosis(str(session.captures), made, verdict), page, table)
