"""One open page: its panes, laid out on one screen, and what brings the session's news to them."""

from __future__ import annotations

import html
from collections.abc import Callable
from pathlib import Path
from typing import Any

import panel as pn
import param
from panel.custom import JSComponent

from dnanalyze.report.words import number, plural
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.failures import Failures
from dnanalyze.workbench.page.history import HistoryPane
from dnanalyze.workbench.page.missing import Missing
from dnanalyze.workbench.page.model import Model
from dnanalyze.workbench.page.sensor import Sensor
from dnanalyze.workbench.page.style import inner, layout, palette, sheet
from dnanalyze.workbench.session import WorkbenchSession


def page(
    session: WorkbenchSession, query: str, theme: str, begun: Callable[[], None] = lambda: None
) -> Any:
    """The page of a session.

    Parameters
    ----------
    session : WorkbenchSession
    query : str
        Query of the page's address, which names the session and the theme.
    theme : {"light", "dark"}
    begun : callable
        Called when the browser has the page.

    Returns
    -------
    panel.viewable.Viewable
    """
    colours = palette(theme)
    context = Context(session, colours, pn.state.curdoc)
    bar, failures = TopBar(context, query), Failures(context)
    later: dict[str, Callable[[Context], Any]] = {
        "sensor": Sensor,
        "model": Model,
        "missing": Missing,
        "history": HistoryPane,
    }
    areas = {"bar": bar.view, "fails": failures.view} | {name: _pane() for name in later}

    def tell(what: str) -> None:
        if what == "evaluation":
            context.shown = session.evaluation
        context.tell(what)

    def listener(what: str) -> None:
        context.back(lambda: tell(what))

    def begin() -> None:
        for name, kind in later.items():  # half of the time that a page takes: painted first
            areas[name].append(kind(context).view)
        session.listeners.append(listener)
        _all(context)
        begun()

    pn.state.onload(begin)  # a change of panes is lost before the browser has the document
    pn.state.on_session_destroyed(lambda _: _forget(session, listener))
    for area, pane in areas.items():
        pane.styles = {**pane.styles, "grid-area": area, "min-width": "0", "min-height": "0"}
    return pn.Column(*areas.values(), sizing_mode="stretch_both", margin=0, stylesheets=[layout()])


def _pane() -> Any:
    """What a pane is put into once the browser has the page."""
    return pn.Column(sizing_mode="stretch_both", margin=0)


class Address(JSComponent):
    """Names the session in the browser's address, so that a reload asks for it."""

    query = param.String(default="")

    _esm = Path(__file__).with_name("address.js").read_text(encoding="utf-8")


def _all(context: Context) -> None:
    """Show a session as it is, when a page is opened or reloaded."""
    session = context.session
    context.shown = session.evaluation
    for what in ("history", "evaluation", "diagnosis", "detection", "message"):
        if what in ("history", "evaluation") and session.history is None:
            continue
        if what == "evaluation" and session.evaluation is None:
            continue
        context.tell(what)


def _forget(session: WorkbenchSession, listener: Any) -> None:
    if listener in session.listeners:
        session.listeners.remove(listener)


class TopBar:
    """What is open, the error, and the theme."""

    def __init__(self, context: Context, query: str) -> None:
        self.context = context
        style = [inner(context.palette)]
        captures = context.session.captures
        rows, columns = captures.sensor.shape
        where = html.escape(Path(captures.name).name)
        facts = (
            f"{plural(captures.frame_count, 'frame')} of {columns} × {rows} pixels, "
            f"{plural(len(captures.settings), 'operating point')}"
        )
        if captures.notes:
            notes = html.escape(chr(10).join(captures.notes))
            facts += f", <u title='{notes}'>{plural(len(captures.notes), 'note')}</u>"
        other = "light" if context.palette.name == "dark" else "dark"
        self.error = pn.pane.HTML("", stylesheets=style, margin=(0, 16, 0, 0))
        there = query.replace(f"theme={context.palette.name}", f"theme={other}")
        link = f"<a href='{html.escape(there)}' target=_self>{other} theme</a>"
        self.view = pn.Row(
            pn.pane.HTML(
                f"<b style='font-size:15px'>dnanalyze</b> &nbsp;<b>{where}</b> "
                f"<span class=quiet>{facts}</span>",
                stylesheets=style, margin=(8, 20, 0, 4), styles={"white-space": "nowrap"},
            ),
            pn.layout.HSpacer(),
            self.error,
            pn.pane.HTML(link, stylesheets=style, margin=(10, 4, 0, 0)),
            Address(query=query, width=1, height=1, margin=0),
            sizing_mode="stretch_width", margin=0,
        )  # fmt: skip
        context.listeners.append(self.update)
        self.update("statistics")

    def update(self, what: str) -> None:
        """Draw what has changed."""
        shown, history = self.context.shown, self.context.session.history
        pending = what == "history" and history is not None and history.present.error is None
        if shown is None or (pending and not shown.preview):
            text = "taking statistics of the captures …"
            if self.context.session.bench is not None:
                text = "computing the error …"
            self.error.object = f"<span class=quiet>{text}</span>"
        elif what in ("evaluation", "preview"):
            about = "≈ " if shown.preview else ""
            self.error.object = (
                f"<span class=quiet>model error</span> <span class=error>{about}"
                f"{number(shown.error)}</span> <span class=quiet>1 = second sensor</span>"
            )


def style_sheet(theme: str) -> str:
    """Style sheet of the document itself."""
    return sheet(palette(theme))
