"""The options that commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

_FILES, _READING, _RUN = "Results", "Reading the captures", "The run"

Captures = Annotated[
    str, typer.Argument(metavar="CAPTURES", help="Folder of dark frames.", show_default=False)
]
Json = Annotated[
    Path | None,
    typer.Option(
        "--json", metavar="OUT.json", rich_help_panel=_FILES, help="All numbers; - prints them."
    ),
]
Report = Annotated[
    Path | None,
    typer.Option(
        "--report", metavar="OUT.html", rich_help_panel=_FILES, help="One self-contained page."
    ),
]
Csv = Annotated[
    Path | None,
    typer.Option("--csv", metavar="OUT.csv", rich_help_panel=_FILES, help="The table of numbers."),
]
Config = Annotated[
    Path | None,
    typer.Option(
        "--config",
        metavar="SIDE.yaml",
        rich_help_panel=_READING,
        help="What the files do not say: raw layout, names, metadata.",
    ),
]
Tolerance = Annotated[
    float | None,
    typer.Option(
        "--tolerance-c",
        metavar="C",
        min=0.0,
        rich_help_panel=_READING,
        help="Frames within so many C share an operating point; default 1.5.",
    ),
]
Channel = Annotated[
    str | None,
    typer.Option(
        "--channel",
        metavar="NAME",
        rich_help_panel=_READING,
        help="Only this HDR readout channel; default: all.",
    ),
]
SystemGain = Annotated[
    float | None,
    typer.Option(
        "--system-gain",
        metavar="K",
        rich_help_panel=_READING,
        help="Overall system gain K, DN/e-; default: as recorded, else from the frames.",
    ),
]
EffectFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--effects",
        metavar="FILE.py",
        rich_help_panel=_RUN,
        help="Your own effects; may be given again.",
    ),
]
Seed = Annotated[
    int | None,
    typer.Option(
        "--seed",
        min=0,
        rich_help_panel=_RUN,
        help="Names the simulated sensor; default: the model's.",
    ),
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", rich_help_panel=_RUN, help="No progress, no notes.")
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS|local",
        rich_help_panel=_RUN,
        help="Dask workers read the frames; an interrupted run goes on where it was.",
    ),
]
NoCache = Annotated[
    bool,
    typer.Option(
        "--no-cache", rich_help_panel=_RUN, help="Read the frames again; keep no statistics."
    ),
]
Model = Annotated[
    Path | None,
    typer.Option(
        "--model",
        metavar="M.yaml",
        rich_help_panel=_RUN,
        help="Model file; default: the paper's model.",
    ),
]
ModelOut = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="M.yaml", rich_help_panel=_FILES, help="The new model file."
    ),
]
