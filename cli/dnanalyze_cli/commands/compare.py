"""``dnanalyze compare``: the model beside the measurement; ``hdr``: the same of combined frames."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from dnanalyze.errors import InputError
from dnanalyze_cli import combined_frames
from dnanalyze_cli.options import Combine, CombinedOut, Force, Light, ModelOptions, option, takes

if TYPE_CHECKING:
    from dnanalyze.report.page import Page


@takes(ModelOptions)
def compare(
    options: ModelOptions,
    classifier: Annotated[
        bool,
        option(
            "--classifier",
            "Also train a classifier: can it tell the simulated frames from the measured "
            "ones? Area under the ROC curve, with its control.",
        ),
    ] = False,
    combine: Combine = None,
    light: Light = 0.0,
    simulated: CombinedOut = None,
    force: Force = False,
) -> None:
    """Compare a model with the captures; without --model the Wang 2025 model is fitted first."""
    if combine is not None:
        if classifier:
            raise InputError("--classifier: not with --combine")
        session = options.session("compare")
        combined_frames.compare(session, options, combine, light, simulated, force)
        return
    if light or simulated is not None:
        raise InputError("--light, --simulate: are of combined HDR frames; give --combine HDR.yaml")
    from dnanalyze.comparator.compare import compare_on as run
    from dnanalyze.fitting.fit import fit_on
    from dnanalyze.report.results import classification
    from dnanalyze.report.results import comparison as report

    session = options.session("compare")
    found, own = options.begin(session)
    with session.progress("Comparing") as progress:
        problem = progress.fit_problem(found)
        tell = progress.fitting(problem)
        if own is not None and options.model is None:  # of that seed: fitted like any
            own = fit_on(found, own, replicates=0, problem=problem, on_state=tell).model
        comparison = run(found, model=own, problem=problem, on_state=tell)
        judged = None
        if classifier:
            from dnanalyze.classifier.classify import classify_on

            progress.now("Training the classifier")
            model, seed = comparison.model, options.seed or 0
            judged = classify_on(found, model, seed=seed, helpers=problem.helpers)
    session.show(comparison)
    session.print(classification.line(judged))

    def page() -> Page:
        from dnanalyze.report.rivals import Rivals, unfiltered

        beside = Rivals(raw=unfiltered(problem, comparison.model))
        return report.page(comparison, judged, beside)

    more = {} if judged is None else {"classifier": classification.body(judged)}
    session.finish(comparison, page, more)


@takes(ModelOptions)
def hdr(
    options: ModelOptions,
    combine: Annotated[Path, option("--combine HDR.yaml")],
    light: Light = 0.0,
    simulated: CombinedOut = None,
    force: Force = False,
) -> None:
    """Compare combined HDR frames with the models of their channels."""
    session = options.session("hdr")
    combined_frames.compare(session, options, combine, light, simulated, force)
