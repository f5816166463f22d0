"""``dnanalyze workbench``: compare, diagnose and add on one live page."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.options import Channel, Config, EffectFiles, Model, Quiet, Seed, Tolerance
from dnanalyze_cli.session import Session


def workbench(
    captures: Annotated[
        str | None,
        typer.Argument(metavar="CAPTURES", help="Folder of dark frames.", show_default=False),
    ] = None,
    model: Model = None,
    demo: Annotated[
        bool, typer.Option("--demo", help="A built-in virtual sensor with a hidden effect.")
    ] = False,
    port: Annotated[
        int, typer.Option("--port", min=0, max=65535, help="Port; 0 takes a free one.")
    ] = 0,
    host: Annotated[
        str,
        typer.Option(
            "--host", help="Address to listen on; any but the loopback address requires a token."
        ),
    ] = "127.0.0.1",
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Only print the page's address.")
    ] = False,
    config: Config = None,
    tolerance_c: Tolerance = None,
    channel: Channel = None,
    effects: EffectFiles = None,
    seed: Seed = None,
    quiet: Quiet = False,
) -> None:
    """Live page: discrepancies of the model, missing effects, the model error at each step."""
    if demo == (captures is not None):
        raise InputError("workbench: give a folder of dark frames, or --demo without one")
    if demo:
        with tempfile.TemporaryDirectory(prefix="dnanalyze-") as temporary:
            folder = _virtual_sensor(Path(temporary) / "demo")
            _serve(str(folder), model, port, host, no_browser, None, None, None, effects, seed)
        return
    assert captures is not None
    _serve(
        captures, model, port, host, no_browser, config, tolerance_c, channel, effects, seed, quiet
    )


def _serve(
    captures: str,
    model: Path | None,
    port: int,
    host: str,
    no_browser: bool,
    config: Path | None,
    tolerance_c: float | None,
    channel: str | None,
    effects: list[Path] | None,
    seed: int | None,
    quiet: bool = False,
) -> None:
    from dnanalyze.workbench.server import serve
    from dnanalyze.workbench.source import CaptureSource

    session = Session("workbench", captures, effects=tuple(effects or ()), quiet=quiet)
    begun = session.model(model, seed)
    source = CaptureSource(Path(captures), config, tolerance_c, channel, tuple(effects or ()))
    serve(
        source,
        begun,
        port=port,
        host=host,
        browser=not no_browser,
        say=lambda address: print(f"{address}  (Ctrl-C ends it)", flush=True),
    )


def _virtual_sensor(folder: Path) -> Path:
    """Frames of the sensor that `dnanalyze demo` makes."""
    import numpy as np

    from dnanalyze.demo import draw_sensor, generate, write_folder
    from dnanalyze_cli.commands.demo import FRAMES, SHAPE

    sensor = draw_sensor(np.random.default_rng(1))
    return write_folder(
        generate(sensor, {"column_fpn": "middling"}, SHAPE, frames=FRAMES, seed=1), folder
    )
