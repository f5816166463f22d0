"""Buttons that save what a pane shows: its numbers as CSV, its figure as PNG or SVG."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import pandas as pd
import panel as pn
from matplotlib.figure import Figure

WIDTHS = {"csv": 48, "png": 48, "svg": 48}
SMALL = "button, a { padding:0 5px !important; font-size:11px !important; }"


def downloads(
    name: str,
    table: Callable[[], pd.DataFrame],
    figure: Callable[[], Figure],
    style: list[str],
    what: str = "",
) -> list[Any]:
    """Three buttons, CSV, PNG and SVG.

    Parameters
    ----------
    name : str
        Of the files, without their ending.
    table, figure : callable
        Numbers and figure as they are when a button is pressed.
    style : list of str
        Style sheets.
    what : str
        What is saved, for the tooltip.
    """

    def saved(form: str) -> io.BytesIO:
        if form == "csv":
            return io.BytesIO(table().to_csv(index=False).encode())
        out = io.BytesIO()
        figure().savefig(out, format=form, dpi=150)
        out.seek(0)
        return out

    return [
        pn.widgets.FileDownload(
            callback=lambda form=form: saved(form), filename=f"{name}.{form}", label=form.upper(),
            button_type="default", stylesheets=style, margin=0, width=width,
            description=f"{what} as {form.upper()}" if what else None,
        )
        for form, width in WIDTHS.items()
    ]  # fmt: skip
