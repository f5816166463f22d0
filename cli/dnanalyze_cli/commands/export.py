"""``dnanalyze export``: a model for those who do not run dnanalyze."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.numbers import celsius
from dnanalyze_cli.options import EffectFiles, Quiet
from dnanalyze_cli.session import Session

FORMATS = ("csv", "json", "numpy", "torch", "yaml")


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
            help="csv, json: parameters over temperature; numpy: one file with dark_frames(); "
            "torch: the same with a transform; yaml: the model file, of what is read back.",
        ),
    ] = "json",
    temperatures: Annotated[
        str | None,
        typer.Option(
            "--temperatures",
            metavar="C,C,...",
            help="Where tables state the parameters; default: the model's own.",
        ),
    ] = None,
    effects: EffectFiles = None,
    quiet: Quiet = False,
) -> None:
    """Write a model as a table, NumPy function or PyTorch transform; frames: see simulate."""
    from dnanalyze.model.export.numpy_code import numpy_source, read_source, torch_source
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
    text = {
        "csv": lambda: to_csv(own, points),
        "json": lambda: to_json(own, points),
        "numpy": lambda: numpy_source(own),
        "torch": lambda: torch_source(own),
        "yaml": lambda: dump_model(own),
    }[format]
    session.write({}, model=text)
