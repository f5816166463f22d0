"""``dnanalyze channels``: which effects belong to which HDR readout channel."""

from __future__ import annotations

from dnanalyze_cli.options import (
    Captures,
    Config,
    EffectFiles,
    Json,
    KeepOutliers,
    Mask,
    Model,
    ModelOut,
    Quiet,
    Report,
    Tolerance,
)
from dnanalyze_cli.session import Session


def channels(
    captures: Captures,
    model: Model = None,
    output: ModelOut = None,
    json: Json = None,
    report: Report = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    keep_outliers: KeepOutliers = False,
    mask: Mask = None,
    effects: EffectFiles = None,
    quiet: Quiet = False,
) -> None:
    """Refine each HDR channel; separate effects of the pixel from those of the readout."""
    from dnanalyze.channels.refinement import by_channel, refine_channels
    from dnanalyze_cli import over_channels

    session = Session(
        "channels",
        captures,
        json,
        report,
        output=output,
        effects=tuple(effects or ()),
        quiet=quiet,
    )
    known = session.known()
    own = session.model(model)
    found = session.load(config, tolerance_c, keep_outliers=keep_outliers, mask=mask)
    by_channel(found)  # refuses captures without
    over_channels.refine(
        session,
        found,
        lambda progress: refine_channels(found, own, effects=known, progress=progress),
    )
