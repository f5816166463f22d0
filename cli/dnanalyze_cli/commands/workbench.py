"""``dnanalyze workbench``: compare, diagnose and add on one live page."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.options import EffectFiles, Model, Reading, Seed, option, takes
from dnanalyze_cli.session import Session

if TYPE_CHECKING:
    from dnanalyze.workbench.source import CaptureSource


@takes(Reading)
def workbench(
    options: Reading,
    captures: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="CAPTURES ...",
            help="Folders of dark frames; the page offers the choice.",
            show_default=False,
        ),
    ] = None,
    model: Model = None,
    demo: Annotated[
        bool, option("--demo", "A built-in virtual sensor with a hidden effect.")
    ] = False,
    port: Annotated[int, option("--port", "Port; 0 takes a free one.", min=0, max=65535)] = 0,
    host: Annotated[
        str,
        option("--host", "Address to listen on; any but the loopback address requires a token."),
    ] = "127.0.0.1",
    no_browser: Annotated[bool, option("--no-browser", "Only print the page's address.")] = False,
    effects: EffectFiles = None,
    seed: Seed = None,
) -> None:
    """Live page: discrepancies of the model, missing effects, the model error at each step."""
    if demo == bool(captures):
        raise InputError("workbench: give a folder of dark frames, or --demo without one")
    from dnanalyze.workbench.source import CaptureSource

    own = tuple(effects or ())
    if demo:
        with tempfile.TemporaryDirectory(prefix="dnanalyze-") as temporary:
            folder = _virtual_sensor(Path(temporary) / "demo")
            source = CaptureSource(folder, effects=own)
            _serve([source], model, port, host, no_browser, seed)
        return
    sources = [
        CaptureSource(
            Path(folder),
            options.config,
            options.tolerance_c,
            options.channel,
            own,
            keep_outliers=options.keep_outliers,
            mask=options.mask,
        )
        for folder in captures or ()
    ]
    _serve(sources, model, port, host, no_browser, seed, options.quiet)


def _serve(
    sources: list[CaptureSource],
    model: Path | None,
    port: int,
    host: str,
    no_browser: bool,
    seed: int | None,
    quiet: bool = False,
) -> None:
    from dnanalyze.workbench.server import serve

    session = Session("workbench", str(sources[0].folder), effects=sources[0].effects, quiet=quiet)
    serve(
        sources,
        session.model(model, seed),
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
