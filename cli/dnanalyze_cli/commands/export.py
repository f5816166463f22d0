"""``dnanalyze export``: a model for those who do not run dnanalyze."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.numbers import celsius, rows_and_columns
from dnanalyze_cli.options import EffectFiles, Quiet
from dnanalyze_cli.session import Session

FORMATS = ("csv", "getframes", "json", "numpy", "pyxel", "torch", "yaml")
MOST = 100_000  # rows or columns of another program's detector


def export(
    model: Annotated[
        Path,
        typer.Argument(
            metavar="M.yaml",
            help="Model file; a table (.csv, .json) or exported code (.py) is read back.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path,
        typer.Option("-o", "--output", metavar="OUT", help="File to write.", show_default=False),
    ],
    format: Annotated[
        str,
        typer.Option(
            "--format",
            "--to",
            help="csv, json: parameters over temperature; numpy: one file with dark_frames(); "
            "torch: the same with a transform; yaml: the model file, from a table or code that is "
            "read back; "
            "getframes: a camera preset (TOML); pyxel: a pipeline (YAML); what these programs "
            "cannot express is listed.",
        ),
    ] = "json",
    temperatures: Annotated[
        str | None,
        typer.Option(
            "--temperatures",
            metavar="C,C,...",
            help="Temperatures at which a table states the parameters; for getframes and pyxel, "
            "the one at which the dark current is stated; default: those of the model.",
        ),
    ] = None,
    shape: Annotated[
        str,
        typer.Option(
            "--shape", metavar="ROWSxCOLUMNS", help="Frame size, for getframes and pyxel."
        ),
    ] = "512x512",
    effects: EffectFiles = None,
    quiet: Quiet = False,
) -> None:
    """Write a model as a table, NumPy function, PyTorch transform, or for another simulator."""
    from dnanalyze.model.export.getframes_camera import getframes_preset
    from dnanalyze.model.export.numpy_code import numpy_source, read_source, torch_source
    from dnanalyze.model.export.pyxel_pipeline import pyxel_pipeline
    from dnanalyze.model.export.table import read_table, to_csv, to_json
    from dnanalyze.model.noise_model import dump_model, load_model

    if format not in FORMATS:
        raise InputError(
            f"--format {format}: valid: {', '.join(FORMATS)}; frames come from simulate"
        )
    session = Session("export", output=output, effects=tuple(effects or ()), quiet=quiet)
    reader = {".csv": read_table, ".json": read_table, ".py": read_source}
    own = reader.get(model.suffix.lower(), load_model)(model, session.known())
    points = celsius("--temperatures", temperatures)
    if format in ("getframes", "pyxel"):
        if len(points) > 1:
            raise InputError(f"--temperatures {temperatures}: {format} takes one temperature")
        size = rows_and_columns(shape)
        if not all(1 <= n <= MOST for n in size):
            raise InputError(f"--shape {shape}: valid: 1 to {MOST} rows and columns")
        translate = getframes_preset if format == "getframes" else pyxel_pipeline
        made = translate(own, size, points[0] if points else None)
        session.write({}, model=lambda: made.text)
        for what in made.lost:
            session.say(f"note: {format} does not express {what}")
        return
    text = {
        "csv": lambda: to_csv(own, points),
        "json": lambda: to_json(own, points),
        "numpy": lambda: numpy_source(own),
        "torch": lambda: torch_source(own),
        "yaml": lambda: dump_model(own),
    }[format]
    session.write({}, model=text)
