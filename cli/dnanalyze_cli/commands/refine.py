"""``dnanalyze refine``: diagnose and add until nothing more is missing; ``channels`` by channel."""

from __future__ import annotations

import shlex
from typing import Annotated

from dnanalyze.errors import InputError
from dnanalyze_cli.options import (
    STEER,
    Budget,
    Exclude,
    ModelOptions,
    ModelOut,
    NoDescribe,
    Scheduler,
    option,
    takes,
)
from dnanalyze_cli.scheduler import executor_at


@takes(ModelOptions)
def refine(
    options: ModelOptions,
    output: ModelOut = None,
    exclude: Exclude = None,
    max_effects: Annotated[
        int | None,
        option("--max-effects N", "Add at most N effects to the baseline model.", STEER, min=0),
    ] = None,
    baseline_only: Annotated[
        bool,
        option(
            "--baseline-only", "Add the baseline effects alone; the same as --max-effects 0.", STEER
        ),
    ] = False,
    until_error: Annotated[
        float | None,
        option("--until-error E", "Stop once the model error is E or less.", STEER, min=0.0),
    ] = None,
    budget: Budget = None,
    no_describe: NoDescribe = False,
    scheduler: Scheduler = None,
) -> None:
    """Diagnose and add until nothing more is missing; the model error at each step.

    Model, JSON and report are written at each step; an interrupted run continues with --model.
    """
    from dnanalyze.diagnosis.refine import Refinement
    from dnanalyze.diagnosis.refine import refine_on as run
    from dnanalyze.diagnosis.search_path import SearchLimits
    from dnanalyze.model.registry import find
    from dnanalyze.report import words
    from dnanalyze.report.results import refinement as report
    from dnanalyze_cli import channel_commands
    from dnanalyze_cli.residual_description import describe_residual
    from dnanalyze_cli.resume import command_line, kept_when_stopped

    if baseline_only:
        if max_effects:
            raise InputError("--baseline-only: adds no effect; leave out --max-effects")
        max_effects = 0
    limits = SearchLimits(max_effects, until_error)
    session = options.session("refine", output=output)
    session.remaining(budget)
    known, captures = session.known(), options.captures
    excluded = tuple(exclude or ())
    for name in excluded:
        find(name, known)
    found, own = options.begin(session)
    if len(found.channels) > 1:
        from dnanalyze.channels.refinement import refine_channels

        with executor_at(scheduler) as executor:
            channel_commands.run_over_channels(
                session,
                found,
                lambda progress: refine_channels(
                    found,
                    own,
                    exclude=excluded,
                    limits=limits,
                    budget=session.remaining(budget),
                    effects=known,
                    progress=progress,
                    executor=executor,
                ),
            )
        return

    def keep(result: Refinement) -> None:
        so_far.append(result)
        session.keep(result, lambda: report.page_so_far(result))

    def go_on() -> list[str]:
        given = {"--exclude": exclude, "--until-error": until_error} | options.given()
        return command_line(captures, output, given, max_effects, so_far[-1] if so_far else None)

    so_far: list[Refinement] = []
    with kept_when_stopped(session.files, so_far, go_on), executor_at(scheduler) as executor:
        with session.progress("Reading frames") as progress:
            problem = session.fit_problem(progress, found, executor)
            result = run(
                found,
                model=own,
                problem=problem,
                exclude=excluded,
                limits=limits,
                budget=session.remaining(budget),
                known=known,
                on_step=lambda step: progress.note(
                    f"{words.number(step.error):>7}  {words.step_name(step.added, 0)}"
                ),
                on_progress=progress.trying,
                on_result=keep,
                first=progress.first,
            )
            if not result.timed_out:
                progress.now("Standard errors of the parameters")
                _ = result.parameters
        session.show(result)
        more = (
            {}
            if no_describe
            else describe_residual(
                session, found, result.problem, result, known, budget, result.state
            )
        )
        session.not_kept()
        if result.timed_out and (line := go_on()):
            text = shlex.join([*line, "--time-limit", f"{budget:g}"])
            session.console.print(f"To continue the search: {text}", style="dim", soft_wrap=True)
        session.finish(result, more=more)


@takes(ModelOptions)
def channels(options: ModelOptions, output: ModelOut = None) -> None:
    """Refine each HDR channel; separate effects of the pixel from those of the readout."""
    from dnanalyze.channels.refinement import by_channel, refine_channels
    from dnanalyze_cli import channel_commands

    session = options.session("channels", output=output)
    known = session.known()
    found, own = options.begin(session)
    by_channel(found)  # refuses captures without
    channel_commands.run_over_channels(
        session,
        found,
        lambda progress: refine_channels(found, own, effects=known, progress=progress),
    )
