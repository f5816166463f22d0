"""A page: what it holds, and how that becomes one self-contained HTML file."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from dnanalyze.report import capture_facts
from dnanalyze.report.figures.palette import TONES, turning
from dnanalyze.report.figures.pictures import Key, Panel, Picture
from dnanalyze.report.figures.svg import named_apart
from dnanalyze.report.subscripts import subscripts

if TYPE_CHECKING:
    from dnanalyze.loaders.captures import CaptureSet


@dataclass(frozen=True)
class Table:
    """Rows of text under column names.

    Parameters
    ----------
    columns : sequence of str
    rows : sequence of sequence of str
    words : int
        The first columns, which hold words; the others hold numbers and stand to the right.
    title : str
        What stands on the fold, where ``folded``.
    folded : bool
        Closed until the reader opens it.
    sortable : bool
        By a click on a column's name; the page then carries the few lines of script for it.
    narrow : bool
        Many columns: their names may take several lines.
    note : str
        A sentence below it.
    bars : sequence of float
        Of the terminal: a share of each row, drawn as a bar.
    wide : int
        Last columns for which only a page has room.
    most : int
        Of the terminal: rows that are printed at most. A folded table is not printed.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]
    words: int = 1
    title: str = ""
    folded: bool = False
    sortable: bool = False
    narrow: bool = False
    note: str = ""
    bars: Sequence[float] = ()
    wide: int = 0
    most: int = 24


@dataclass(frozen=True)
class Section:
    """A heading with sentences, figures and tables.

    ``badge`` is a number beside the heading (the family's error); ``calm`` says that it is good.
    ``half``: two such stand side by side where there is room. ``pictures``: also functions that
    draw one, which only a page calls. ``paged``, ``printed``: whether page and terminal show it;
    the terminal prints at most ``most`` points.
    """

    key: str
    title: str
    text: Sequence[str] = ()
    points: Sequence[str] = ()
    pictures: Sequence[Picture | Callable[[], Picture | None] | None] = ()
    tables: Sequence[Table] = ()
    badge: str = ""
    calm: bool = True
    code: str = ""
    half: bool = False
    paged: bool = True
    printed: bool = True
    most: int = 99

    @property
    def drawn(self) -> Section:
        """With its pictures, and without tables that have no row."""
        made = (p() if callable(p) else p for p in self.pictures)
        return replace(
            self,
            pictures=[p for p in made if p is not None],
            tables=[t for t in self.tables if t.rows],
        )

    @property
    def empty(self) -> bool:
        """Nothing to show but the heading."""
        return not (self.text or self.points or self.pictures or self.tables or self.code)


@dataclass(frozen=True)
class Page:
    """One report.

    Parameters
    ----------
    kind : str
        What was asked, such as "Comparison".
    title : str
        Name of the captures.
    verdict : str
        The answer in one or two sentences.
    tone : str
        "good", "fair" or "poor"; colours the verdict's edge.
    points : sequence of str
        What stands behind the verdict, most important first.
    figures : sequence of (str, str)
        Numbers to show large, each with a few words.
    facts : dict
        Of the captures.
    sections : sequence of Section
        Folded where the page has a front.
    notes : sequence of str
        What the loader had to assume.
    front : sequence of Section
        What is read first: two pages, open.
    about : str
        The captures in a line, under the title.
    """

    kind: str
    title: str
    verdict: str
    sections: Sequence[Section]
    tone: str = "fair"
    points: Sequence[str] = ()
    figures: Sequence[tuple[str, str]] = ()
    facts: dict[str, str] = field(default_factory=dict)
    notes: Sequence[str] = ()
    front: Sequence[Section] = ()
    about: str = ""


def page_of(
    captures: CaptureSet, kind: str, verdict: str, sections: Sequence[Section], **more: Any
) -> Page:
    """A page on these captures: their name, facts and notes are theirs."""
    if more.get("front"):
        more["about"] = capture_facts.about(captures)
    return Page(
        kind,
        capture_facts.title(captures),
        verdict,
        sections,
        facts=capture_facts.facts(captures) | more.pop("facts", {}),
        notes=captures.notes,
        **more,
    )


def render(page: Page, made: datetime | None = None) -> str:
    """The HTML file: nothing fetched, everything escaped, no script but for sorting tables.

    Parameters
    ----------
    page : Page
    made : datetime, optional
        When; now by default.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

    import dnanalyze

    environment = Environment(
        loader=PackageLoader("dnanalyze.report"),
        autoescape=select_autoescape(default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    count = itertools.count()
    environment.filters["inline"] = lambda panel: _inline(panel, next(count))
    environment.filters["swatch"] = swatch
    environment.filters["subscripts"] = subscripts
    when = (made or datetime.now(UTC)).strftime("%Y-%m-%d %H:%M UTC")
    shown = _drawn(page.sections)
    sortable = any(t.sortable for s in shown for t in s.tables)
    return environment.get_template("page.html.j2").render(
        page=page,
        sections=shown,
        front=_drawn(page.front),
        sortable=sortable,
        when=when,
        version=dnanalyze.__version__,
        tones=TONES,
    )


def _drawn(sections: Iterable[Section]) -> list[Section]:
    """Those of the page that have something to show."""
    return [s for s in (s.drawn for s in sections if s.paged) if not s.empty]


def _inline(panel: Panel, count: int) -> Markup:
    """The SVG as part of the page: matplotlib has escaped its text; its names are its own."""
    return Markup(named_apart(panel.svg, f"p{count}-"))


MARKERS = {
    "o": 'circle cx="13" cy="5" r="3.2"',
    "s": 'path d="M10 2h6v6h-6z"',
    "_": 'path d="M8 5h10"',
}


def swatch(key: Key) -> Markup:
    """A line, or a marker, as it looks in the figure."""
    colour = turning(key.colour)
    if key.marker:
        shape = MARKERS.get(key.marker, MARKERS["o"])
        fill = colour if key.filled else "none"
        drawn = f'<{shape} fill="{fill}" stroke="{colour}"/>'
    else:
        dashes = ",".join(f"{v * key.width:.1f}" for v in key.dash or ())
        drawn = (
            f'<path d="M0 5H26" stroke="{colour}" stroke-width="{1.3 * key.width:.1f}"'
            f' stroke-dasharray="{dashes or "none"}"/>'
        )
    return Markup(f'<svg width="26" height="10" aria-hidden="true">{drawn}</svg>')


def tone_of(error: float | None, adequate: bool) -> str:
    """Tone of a model error, and of whether the model is adequate."""
    if adequate:
        return "good"
    return "fair" if error is not None and error < 2 else "poor"
