"""``dnanalyze hdr``: the earlier name of ``compare --combine``, not shown in the help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from dnanalyze_cli import combined_frames
from dnanalyze_cli.options import CombinedOut, Force, Light, ModelOptions, option, takes


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
