"""Buttons that save what a pane shows: its numbers as CSV, its figure as PNG or SVG."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import pandas as pd
import panel as pn
from matplotlib.figure import Figure

FORMS = "csv", "png", "svg"
WIDTH = 38  # screen pixels
SMALL = (  # a button no wider than its three letters ask
    ".bk-btn, a, button { padding:0 3px !important; font-size:11px !important; "
    "min-width:0 !important; }"
)


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
        Style sheets of the page's widgets.
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
            button_type="default", stylesheets=[*style, SMALL], margin=0, width=WIDTH,
            description=f"{what} as {form.upper()}" if what else None,
        )
        for form in FORMS
    ]  # fmt: skip
