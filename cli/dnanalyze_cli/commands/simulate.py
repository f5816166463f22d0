"""``dnanalyze simulate``: frames of a model, in any format that the loaders read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.options import EffectFiles, Force, Json, Reading, option, takes
from dnanalyze_cli.session import Session
from dnanalyze_cli.typed_numbers import celsius, numbers, rows_and_columns

_FRAMES = "The frames"


@takes(Reading)
def simulate(
    options: Reading,
    out: Annotated[Path, typer.Argument(metavar="OUT", help="Folder to make.", show_default=False)],
    model: Annotated[Path, option("--model M.yaml", "Model file.", show_default=False)],
    like: Annotated[
        str | None,
        option(
            "--like CAPTURES",
            "Use the frame size, operating points and numbers of frames of this folder.",
            _FRAMES,
        ),
    ] = None,
    shape: Annotated[
        str | None, option("--shape ROWSxCOLUMNS", "Frame size, such as 1080x1920.", _FRAMES)
    ] = None,
    temperatures: Annotated[
        str | None, option("--temperatures C,C,...", "Temperatures, °C, such as 25,45,65.", _FRAMES)
    ] = None,
    exposure: Annotated[
        str | None, option("--exposure S,S,...", "Exposure times, s, such as 0.05.", _FRAMES)
    ] = None,
    gain: Annotated[
        str | None, option("--gain G,G,...", "Gain settings, such as 1,4.", _FRAMES)
    ] = None,
    channel: Annotated[
        str | None,
        option("--channel NAME,NAME,...", "HDR readout channels; default: all.", _FRAMES),
    ] = None,
    frames: Annotated[
        int | None, option("--frames N", "Frames at each operating point.", _FRAMES, min=1)
    ] = None,
    format: Annotated[
        str,
        option(
            "--format",
            "tif, fits, npy, h5, png, pgm; raw10, raw12, ... with -mipi or -lsb where packed.",
            _FRAMES,
        ),
    ] = "tif",
    seed: Annotated[
        int | None, option("--seed", "Seed of the simulated sensor; default: the model's.", min=0)
    ] = None,
    device: Annotated[
        str,
        option(
            "--device DEVICE", "cpu, or cuda: a GPU, by way of CuPy; the same frames.", "The run"
        ),
    ] = "cpu",
    json: Json = None,
    force: Force = False,
    effects: EffectFiles = None,
) -> None:
    """Simulate frames of a model; writes a new folder with a manifest."""
    from dataclasses import replace

    from dnanalyze.loaders import write_captures
    from dnanalyze.model.channel_models import require
    from dnanalyze.model.simulate import simulate as run
    from dnanalyze.processors import cpu_count
    from dnanalyze.report.documents import point
    from dnanalyze.report.output_files import atomic_folder, check_folder
    from dnanalyze.report.plain import document
    from dnanalyze.report.words import plural

    session = Session(
        "simulate", like, json=json, effects=tuple(effects or ()), quiet=options.quiet
    )
    own = session.model(model)
    assert own is not None
    if seed is not None:
        own = replace(own, seed=seed)
    if like is not None and out.resolve() == Path(like).resolve():
        raise InputError(f"{out}: is the folder of --like, which is never changed; name another")
    check_folder(out, force)
    if options.mask is not None and like is None:
        raise InputError("--mask: leaves out pixels of --like CAPTURES; give both")
    pattern = options.load(session) if like else None
    size = rows_and_columns(shape) if shape else (pattern.sensor.shape if pattern else (512, 512))
    channels = channel.split(",") if channel else (pattern.channels if pattern else [])
    if channels or pattern is not None:
        require(own, channels)
    if pattern is not None and channel:
        pattern = replace(
            pattern, settings=tuple(s for c in channels for s in pattern.channel(c).settings)
        )
    points = _points(own, pattern, temperatures, exposure, gain, channels, frames)
    _check_size(size, sum(count for _, count in points))
    sensor = replace(pattern.sensor, shape=size, filled=0.0) if pattern else None
    threads = cpu_count()
    made = run(own, size, points, name=str(model), sensor=sensor, threads=threads, device=device)
    with atomic_folder(out, force) as folder, session.progress("Simulating") as tick:
        write_captures(made, folder, format, progress=tick)
    session.console.print(
        f"{plural(made.frame_count, 'frame')} of {size[0]} × {size[1]} at "
        f"{plural(len(made.settings), 'operating point')} as {format} in {out}"
    )
    settings = [point(s.point) | {"frames": len(s.frames)} for s in made.settings]
    about = {"model": model, "seed": own.seed, "like": like, "format": format, "shape": size}
    session.write(document("simulate", str(out), **about, settings=settings))


def _check_size(shape: tuple[int, int], frames: int) -> None:
    """Refuse what cannot be drawn, before anything is."""
    from dnanalyze.loaders.checks import (
        MAX_FRAMES,
        MAX_PIXELS,
        MIN_COLUMNS,
        MIN_ROWS,
        available_memory,
    )  # fmt: skip
    from dnanalyze.model.simulator import MAPS

    rows, columns = shape
    pixels, free = rows * columns, available_memory()
    if pixels > MAX_PIXELS or rows < MIN_ROWS or columns < MIN_COLUMNS:
        raise InputError(
            f"--shape {rows}x{columns}: valid: {MIN_ROWS} x {MIN_COLUMNS} to {MAX_PIXELS} pixels"
        )
    if free is not None and 4 * MAPS * pixels > free:  # the maps of one effect at the least
        raise InputError(
            f"--shape {rows}x{columns}: takes {4 * MAPS * pixels / 1e9:.1f} GB to draw and "
            f"{free / 1e9:.1f} GB are free; give a smaller shape"
        )
    if frames > MAX_FRAMES:
        raise InputError(
            f"simulate: {frames} frames; valid: 1 to {MAX_FRAMES}, over all operating points"
        )


def _points(own, pattern, temperatures, exposure, gain, channels, frames):
    """Operating points with their number of frames: the pattern's, or a grid of what is named."""
    from itertools import product

    from dnanalyze.loaders.captures import OperatingPoint
    from dnanalyze.model.channel_models import channels_of

    grid = (
        celsius("--temperatures", temperatures),
        numbers("--exposure", exposure, "exposure_s"),
        numbers("--gain", gain, "gain"),
    )
    if pattern is not None:
        if any(grid):
            raise InputError(
                "--like: gives the operating points; leave out --temperatures, --exposure, --gain"
            )
        return [(s.point, frames or len(s.frames)) for s in pattern.settings]
    made = []
    for channel in channels or channels_of(own) or [None]:
        home = own.reference_of(channel)
        axes = [
            values or [default]
            for values, default in zip(
                grid, (home.temperature_c, home.exposure_s, home.gain), strict=True
            )
        ]
        made += [(OperatingPoint(t, e, g, channel), frames or 8) for t, e, g in product(*axes)]
    return made
