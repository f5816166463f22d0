"""``dnanalyze fit``: the model's parameters with their standard errors."""

from __future__ import annotations

from typing import Annotated

from dnanalyze_cli.options import ModelOptions, ModelOut, option, takes

Frozen = Annotated[
    list[str] | None,
    option(
        "--frozen PARAMETER",
        "Do not fit this parameter: effect.parameter, or pedestal (repeatable).",
    ),
]
Replicates = Annotated[
    int | None,
    option(
        "--replicates N",
        "Simulated sensors for the standard errors; 0: no standard errors, no bias correction.",
        min=0,
        show_default="24",
    ),
]


@takes(ModelOptions)
def fit(
    options: ModelOptions,
    output: ModelOut = None,
    frozen: Frozen = None,
    replicates: Replicates = None,
) -> None:
    """Fit a model's parameters, with their standard errors; -o writes the model file."""
    from dnanalyze.fitting.fit import REPLICATES
    from dnanalyze.fitting.fit import fit_on as run
    from dnanalyze_cli import channel_commands

    session = options.session("fit", output=output)
    found, start = options.begin(session)
    if start is not None:
        start = channel_commands.with_rows_by_channel(start, found)
    with session.progress("Fitting") as progress:
        problem = progress.fit_problem(found)
        result = run(
            found,
            model=start,
            frozen=frozen or (),
            replicates=REPLICATES if replicates is None else replicates,
            problem=problem,
            on_state=progress.fitting(problem),
        )
    session.show(result)
    session.finish(result)
