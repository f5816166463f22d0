"""``dnanalyze export``: a model for those who do not run dnanalyze."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.options import EffectFiles, Quiet, option
from dnanalyze_cli.session import Session
from dnanalyze_cli.typed_numbers import celsius, rows_and_columns


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
        Path, option("-o --output OUT", "File to write; - prints it.", show_default=False)
    ],
    format: Annotated[
        str,
        option(
            "--format --to",
            "csv, json: parameters over temperature; numpy: one file with dark_frames(); "
            "torch: the same with a transform; yaml: the model file, from a table or code that is "
            "read back; "
            "getframes: a camera preset (TOML); pyxel: a pipeline (YAML); what these programs "
            "cannot express is listed.",
        ),
    ] = "json",
    temperatures: Annotated[
        str | None,
        option(
            "--temperatures C,C,...",
            "Temperatures at which a table states the parameters; for getframes and pyxel, "
            "the one at which the dark current is stated; default: those of the model.",
        ),
    ] = None,
    shape: Annotated[
        str, option("--shape ROWSxCOLUMNS", "Frame size, for getframes and pyxel.")
    ] = "512x512",
    effects: EffectFiles = None,
    quiet: Quiet = False,
) -> None:
    """Write a model as a table, NumPy function, PyTorch transform, or for another simulator."""
    from dnanalyze.model.export.export import exported
    from dnanalyze.model.export.numpy_code import read_source
    from dnanalyze.model.export.table import read_table
    from dnanalyze.model.noise_model import load_model

    session = Session("export", output=output, effects=tuple(effects or ()), quiet=quiet)
    reader = {".csv": read_table, ".json": read_table, ".py": read_source}
    own = reader.get(model.suffix.lower(), load_model)(model, session.known())
    points = celsius("--temperatures", temperatures)
    try:
        made = exported(own, format, points, rows_and_columns(shape))
    except InputError as error:  # its arguments are options here
        option = str(error).startswith(("format ", "shape ", "temperatures "))
        raise InputError(f"--{error}" if option else str(error)) from None
    session.write({}, model=lambda: made.text)
    for what in made.lost:
        session.say(f"note: {format} does not express {what}")
