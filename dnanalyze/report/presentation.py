"""How a result looks in every form, and what is made of that."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dnanalyze.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from rich.console import Console

Draw = Callable[[], Any]  # a figure function with its arguments; None where nothing is to be seen


@dataclass(frozen=True)
class Presentation:
    """One type of result in the terminal, as a document, a table, a page and in figures.

    Parameters
    ----------
    terminal : callable
        Called with a console and the result; prints.
    headline : callable
        The verdict in a sentence or a few.
    document : callable
        The JSON document.
    table : callable
        The numbers.
    page : callable
        The report.
    plots : callable
        The figures by kind, the most telling first; what is simulated for one is simulated when
        it is drawn.
    """

    terminal: Callable[[Console, Any], None]
    headline: Callable[[Any], str]
    document: Callable[[Any], dict[str, Any]]
    table: Callable[[Any], pd.DataFrame]
    page: Callable[[Any], str]
    plots: Callable[[Any], Mapping[str, Draw]]

    def summary(self, result: Any) -> str:
        """What the terminal prints, 80 columns."""
        from dnanalyze.report.terminal.common import as_text

        return as_text(lambda console: self.terminal(console, result))


def save(result: Any, shown: Presentation, path: str | PathLike[str]) -> None:
    """Write the form that the suffix of ``path`` names; see `dnanalyze.result.Result.save`."""
    from dnanalyze.loaders.writers import atomic_write
    from dnanalyze.report.files import check_output
    from dnanalyze.report.plain import to_json

    forms: dict[str, Callable[[], str]] = {
        ".json": lambda: to_json(shown.document(result)),
        ".html": lambda: shown.page(result),
        ".csv": lambda: shown.table(result).to_csv(index=False),
    }
    model = getattr(result, "model", None)
    if model is not None:
        from dnanalyze.model.noise_model import dump_model

        forms |= {suffix: lambda: dump_model(model) for suffix in (".yaml", ".yml")}
    target = Path(path)
    if target.suffix.lower() == ".html" and getattr(result, "captures", result) is None:
        raise InputError(f"{target}: the report shows the captures, and this result has none")
    form = forms.get(target.suffix.lower())
    if form is None:
        raise InputError(f"{target}: unknown suffix {target.suffix!r}; valid: {', '.join(forms)}")
    check_output(target)
    atomic_write(target, form())


def plot(result: Any, shown: Presentation, kind: str | None, ax: Axes | None) -> Any:
    """Draw one kind; see `dnanalyze.result.Result.plot`."""
    from dnanalyze.report.figures.pictures import plotted

    kinds = shown.plots(result)
    if kind is not None and kind not in kinds:
        raise InputError(f"kind={kind!r}: unknown; valid: {', '.join(kinds)}")
    for name in [kind] if kind is not None else kinds:
        picture = _first(kinds[name]())
        if picture is not None:
            return plotted(picture, ax)
    what = f"kind={kind!r}" if kind is not None else "plot"
    raise InputError(f"{what}: these captures have nothing to draw; kinds: {', '.join(kinds)}")


def _first(drawn: Any) -> Any:
    """A picture, or the first of several; None where there is none."""
    several = drawn if isinstance(drawn, (list, tuple)) else [drawn]
    return next((picture for picture in several if picture is not None), None)


def notebook(result: Any, shown: Presentation) -> str:
    """An HTML fragment: the verdict, the first figure, and the summary on demand."""
    from dnanalyze.report.figures.svg import standing_alone
    from dnanalyze.report.page import swatch

    pictures = (_first(draw()) for draw in shown.plots(result).values())
    picture = next((p for p in pictures if p is not None), None)
    parts = [f"<p><strong>{escape(shown.headline(result))}</strong></p>"]
    if picture is not None:
        words = escape(picture.alt, quote=True)
        style = "max-width:100%;background:#ffffff"
        images = (
            f'<img src="{standing_alone(panel.svg)}" alt="{words}" style="{style}">'
            for panel in picture.panels
        )
        keys = " &emsp; ".join(f"{swatch(key)} {escape(key.label)}" for key in picture.legend)
        parts.append(f"<p>{keys}</p><p>{''.join(images)}</p>")
        parts.append(f"<p><small>{escape(picture.caption)}</small></p>")
    text = escape(shown.summary(result))
    parts.append(
        f'<details><summary>Summary</summary><pre style="line-height:1.25">{text}</pre></details>'
    )
    return f'<div class="dnanalyze-result">{"".join(parts)}</div>'
