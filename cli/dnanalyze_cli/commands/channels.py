"""``dnanalyze channels``: which effects belong to which HDR readout channel."""

from __future__ import annotations

from dnanalyze_cli.options import (
    Captures,
    Config,
    EffectFiles,
    Json,
    ModelOut,
    Quiet,
    Tolerance,
)
from dnanalyze_cli.session import Session


def channels(
    captures: Captures,
    output: ModelOut = None,
    json: Json = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    effects: EffectFiles = None,
    quiet: Quiet = False,
) -> None:
    """Refine each HDR channel; what is the pixel's, what the readout's; one model (-o)."""
    from rich.text import Text

    from dnanalyze.diagnosis.channels import refine_channels
    from dnanalyze.model.noise_model import dump_model
    from dnanalyze.report import capture
    from dnanalyze.report.plain import document
    from dnanalyze.report.words import listing, number, sentence

    session = Session(
        "channels", captures, json, output=output, effects=tuple(effects or ()), quiet=quiet
    )
    known = session.known()
    found = session.load(config, tolerance_c)
    with session.progress("Refining") as progress:
        result = refine_channels(found, known=known, tell=progress.now)
    session.console.print(Text(capture.one_line(found), style="dim"))
    for finding in result.findings:
        session.console.print(Text(sentence(finding), style="bold"))
    for name, part in result.channels.items():
        error = number(part.steps[-1].error)
        text = f"{name}: error {error}, {part.verdict}; {listing(part.effects)}"
        session.console.print(Text(text))
    content = document(
        "channels",
        captures,
        findings=result.findings,
        shared=result.shared,
        own=result.own,
        channels={
            name: {
                "effects": part.effects,
                "error": part.steps[-1].error,
                "verdict": part.verdict,
                "model": part.model.to_plain(),
            }
            for name, part in result.channels.items()
        },
        model=output,
    )
    session.write(content, model=lambda: dump_model(result.model))
