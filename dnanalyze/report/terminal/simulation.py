"""The outcome of `simulate` in the terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console

from dnanalyze.report import words


def written(console: Console, made: Any, out: Path, form: str) -> None:
    """What was simulated and where it lies."""
    rows, columns = made.sensor.shape
    console.print(
        f"{words.plural(made.frame_count, 'frame')} of {rows} × {columns} at "
        f"{words.plural(len(made.settings), 'operating point')} as {form} in {out}"
    )
