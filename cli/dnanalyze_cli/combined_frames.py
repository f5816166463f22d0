"""`compare --combine`: combined HDR frames against the models of their channels."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from dnanalyze.errors import InputError

if TYPE_CHECKING:
    from dnanalyze_cli.options import ModelOptions
    from dnanalyze_cli.session import Session


def compare(
    session: Session,
    options: ModelOptions,
    combine: Path,
    light: float,
    simulated: Path | None,
    force: bool,
) -> None:
    """Simulate the channels, combine them, compare with the captures; show and write the result.

    Raises
    ------
    InputError
        No model, or one without channels; an output that cannot be written.
    """
    import pandas as pd
    from rich.text import Text

    from dnanalyze.comparator.combined import compare_combined
    from dnanalyze.loaders import write_captures
    from dnanalyze.model.channel_models import channels_of, require
    from dnanalyze.model.hdr import noise_steps, simulate_combined
    from dnanalyze.model.hdr_file import load_combination
    from dnanalyze.report import capture_facts
    from dnanalyze.report.output_files import atomic_folder, check_folder
    from dnanalyze.report.plain import document
    from dnanalyze.report.words import closeness, number, sentence

    if options.report is not None:
        raise InputError("--report: not for combined frames; use --json or --csv")
    how = load_combination(combine)
    own = session.model(options.model, options.seed)
    if own is None:
        raise InputError("--combine: needs --model M.yaml, a model of all channels")
    if not channels_of(own):
        raise InputError(
            f"--model {options.model}: has no parameters by channel, and --combine {combine} names "
            f"{', '.join(how.names)}; give a model of all channels, as `refine -o` writes it"
        )
    require(own, how.names)
    if simulated is not None:
        check_folder(simulated, force)
    found = options.load(session)
    with session.progress("Combining"):
        result = compare_combined(found, own, how, light)
        first = found.settings[0].point
        shape = (min(256, found.sensor.shape[0]), min(256, found.sensor.shape[1]))
        steps = noise_steps(
            lambda level: simulate_combined(own, how, shape, [(first, 2)], light=level), how
        )
    console = session.console
    console.print(Text(capture_facts.one_line(found), style="dim"))
    verdict = sentence(f"Model error {number(result.error)}: {closeness(result.error)}")
    console.print(Text(verdict, style="bold"))
    for failure in result.failures[:6]:
        console.print(Text(f"  {sentence(failure)}"))
    for step in steps:
        text = f"  {step.before} to {step.after} at {number(step.light)} DN: {step.step_db:+.1f} dB"
        console.print(Text(text))
    if simulated is not None:
        settings = [(s.point, len(s.frames)) for s in found.settings]
        made = simulate_combined(own, how, found.sensor.shape, settings, light=light)
        made = replace(made, sensor=replace(made.sensor, bits=how.bits))
        with atomic_folder(simulated, force) as folder:
            write_captures(made, folder, "tif")
        session.say(f"wrote {simulated}")
    content = document(
        session.command,
        options.captures,
        error=result.error,
        baselines={"gaussian": None, "paper": None},
        families=result.families,
        failures=result.failures,
        noise_steps=[vars(s) | {"step_db": s.step_db} for s in steps],
        statistics=result.statistics,
        model=options.model,
        combination=combine,
    )
    session.write(content, table=lambda: pd.DataFrame(result.statistics))
