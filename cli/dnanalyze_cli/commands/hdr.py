"""``dnanalyze hdr``: the earlier name of ``compare --combine``, not shown in the help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dnanalyze_cli import combined_frames
from dnanalyze_cli.options import CombinedOut, Force, Light, ModelOptions, takes


@takes(ModelOptions)
def hdr(
    options: ModelOptions,
    combine: Annotated[Path, typer.Option("--combine", metavar="HDR.yaml")],
    light: Light = 0.0,
    simulated: CombinedOut = None,
    force: Force = False,
) -> None:
    """Compare combined HDR frames with the models of their channels."""
    session = options.session("hdr")
    combined_frames.compare(session, options, combine, light, simulated, force)
