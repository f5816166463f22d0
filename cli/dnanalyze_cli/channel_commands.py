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


def with_rows_by_channel(model: NoiseModel, found: CaptureSet) -> NoiseModel:
    """A row for every channel in what belongs to the readout, where the model has one for all."""
    from dnanalyze.model.channel_models import channel_model, channels_of, merged

    if channels_of(model) or len(found.channels) < 2:
        return model
    known = {s.point.temperature_c for s in found.settings}
    celsius = sorted(t for t in known if t is not None)
    return merged({c: channel_model(model, c) for c in found.channels}, celsius)


def run_over_channels(session: Session, found: CaptureSet, run: Run) -> None:
    """Run, show and write what completes the model of every channel."""
    with session.progress("Reading frames") as progress:
        result = run(progress)
    session.show(result)
    session.not_kept()
    session.finish(result, more={"schema": f"dnanalyze/{session.command}/1"})


def diagnose_over_channels(
    session: Session,
    found: CaptureSet,
    model: NoiseModel | None,
    known: dict[str, Any],
    budget: float | None = None,
) -> None:
    """Run, show and write the diagnosis of every channel."""
    from dnanalyze.channels.refinement import diagnose_channels, worst_verdict
    from dnanalyze.report.results import channelrefinement as report
    from dnanalyze.report.terminal import head

    with session.progress("Reading frames") as progress:
        made = diagnose_channels(found, model, budget=budget, known=known, on_progress=progress.now)
    verdict = worst_verdict(d.verdict for d in made.values())
    head(session.console, found, report.diagnoses_headline(made, verdict))
    session.print(report.diagnoses_sections(made))
    session.write(
        report.diagnoses_document(str(session.captures), made, verdict),
        lambda: report.diagnoses_page(found, made, verdict),
        lambda: report.diagnoses_table(made),
    )
