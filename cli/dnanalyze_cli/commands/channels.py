"""``dnanalyze channels``: which effects belong to which HDR readout channel."""

from __future__ import annotations

from dnanalyze_cli.options import ModelOptions, ModelOut, takes


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
