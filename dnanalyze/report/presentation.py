"""How a result looks in every form, and what is made of that."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from dnanalyze.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from dnanalyze.report.figures.pictures import Draw
    from dnanalyze.report.page import Page, Section


class Presentation(Protocol):
    """One type of result in words, sections, figures, as a document and a table.

    A file in ``dnanalyze.report.results`` has these functions; terminal, notebook, page and files
    are made of them.
    """

    def headline(self, result: Any, /) -> str:
        """The verdict in a sentence or a few."""

    def sections(self, result: Any, /) -> list[Section]:
        """What follows the verdict, in the terminal and on the page."""

    def page(self, result: Any, /) -> Page:
        """The report: these sections and those that only a page has."""

    def document(self, result: Any, /) -> dict[str, Any]:
        """The JSON document."""

    def table(self, result: Any, /) -> pd.DataFrame:
        """The numbers."""

    def plots(self, result: Any, /) -> Mapping[str, Draw]:
        """The figures by kind, the most telling first.

        What is simulated for one is simulated when it is drawn.
        """


def summary(result: Any) -> str:
    """What the terminal prints, 80 columns."""
    from dnanalyze.report.terminal import as_text, show

    return as_text(lambda console: show(console, result))


def save(result: Any, shown: Presentation, path: str | PathLike[str]) -> None:
    """Write the form that the suffix of ``path`` names; see `dnanalyze.result.Result.save`."""
    from dnanalyze.loaders.writers import atomic_write
    from dnanalyze.report.output_files import check_output
    from dnanalyze.report.page import render
    from dnanalyze.report.plain import to_json

    forms: dict[str, Callable[[], str]] = {
        ".json": lambda: to_json(shown.document(result)),
        ".html": lambda: render(shown.page(result)),
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
    text = escape(summary(result))
    parts.append(
        f'<details><summary>Summary</summary><pre style="line-height:1.25">{text}</pre></details>'
    )
    return f'<div class="dnanalyze-result">{"".join(parts)}</div>'
