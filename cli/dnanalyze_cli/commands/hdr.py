"""``dnanalyze hdr``: combined HDR frames against the models of their channels."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.options import (
    Captures,
    Config,
    EffectFiles,
    Json,
    KeepOutliers,
    Mask,
    Quiet,
    Seed,
    Tolerance,
)
from dnanalyze_cli.session import Session


def hdr(
    captures: Captures,
    model: Annotated[
        Path,
        typer.Option(
            "--model",
            metavar="M.yaml",
            help="Model of all channels, as `channels -o` writes it.",
            show_default=False,
        ),
    ],
    combine: Annotated[
        Path,
        typer.Option(
            "--combine",
            metavar="HDR.yaml",
            help="How the channels become one output.",
            show_default=False,
        ),
    ],
    light: Annotated[
        float,
        typer.Option("--light", metavar="DN", min=0.0, help="Uniform light, DN of channel one."),
    ] = 0.0,
    simulated: Annotated[
        Path | None,
        typer.Option("--simulate", metavar="OUT", help="Also write the simulated frames, TIFF."),
    ] = None,
    json: Json = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    keep_outliers: KeepOutliers = False,
    mask: Mask = None,
    effects: EffectFiles = None,
    seed: Seed = None,
    quiet: Quiet = False,
) -> None:
    """Compare combined HDR frames with the models of their channels."""
    from rich.text import Text

    from dnanalyze.comparator.combined import compare_combined
    from dnanalyze.loaders import write_captures
    from dnanalyze.model.channel_models import channels_of, require
    from dnanalyze.model.hdr import noise_steps, simulate_combined
    from dnanalyze.model.hdr_file import load_combination
    from dnanalyze.report import capture
    from dnanalyze.report.files import atomic_folder
    from dnanalyze.report.plain import document
    from dnanalyze.report.words import closeness, number, sentence

    session = Session("hdr", captures, json, effects=tuple(effects or ()), quiet=quiet)
    how = load_combination(combine)
    own = session.model(model, seed)
    assert own is not None
    if not channels_of(own):
        raise InputError(
            f"--model {model}: has no parameters by channel, and --combine {combine} names "
            f"{', '.join(how.names)}; give a model of all channels, as `channels -o` writes it"
        )
    require(own, how.names)
    found = session.load(config, tolerance_c, keep_outliers=keep_outliers, mask=mask)
    with session.progress("Combining"):
        result = compare_combined(found, own, how, light)
        first = found.settings[0].point
        shape = (min(256, found.sensor.shape[0]), min(256, found.sensor.shape[1]))
        steps = noise_steps(
            lambda level: simulate_combined(own, how, shape, [(first, 2)], light=level), how
        )
    console = session.console
    console.print(Text(capture.one_line(found), style="dim"))
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
        with atomic_folder(simulated) as folder:
            write_captures(made, folder, "tif")
        session.say(f"wrote {simulated}")
    session.write(_document(captures, document, result, steps, model, combine))


def _document(
    captures: str, document: Any, result: Any, steps: Any, model: Path, combine: Path
) -> dict[str, Any]:
    """The JSON document."""
    return document(
        "hdr",
        captures,
        error=result.error,
        families=result.families,
        failures=result.failures,
        noise_steps=[vars(s) | {"step_db": s.step_db} for s in steps],
        statistics=result.statistics,
        model=model,
        combination=combine,
    )
