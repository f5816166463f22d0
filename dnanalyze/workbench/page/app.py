"""One open page: its panes, laid out on one screen, and what brings the session's news to them."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import panel as pn
import param
from panel.custom import JSComponent

from dnanalyze.report.capture_facts import size
from dnanalyze.report.words import plural
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.failures import Failures
from dnanalyze.workbench.page.history import HistoryPane
from dnanalyze.workbench.page.missing import Missing
from dnanalyze.workbench.page.model import Model
from dnanalyze.workbench.page.sensor import Sensor
from dnanalyze.workbench.page.strip import Strip
from dnanalyze.workbench.page.style import Palette, card, inner, layout, palette, sheet
from dnanalyze.workbench.session import WorkbenchSession


def page(
    session: WorkbenchSession,
    query: str,
    theme: str,
    begun: Callable[[], None] = lambda: None,
    others: Mapping[str, str] = MappingProxyType({}),
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
    others : mapping
        Queries of the other folders' pages, by name.

    Returns
    -------
    panel.viewable.Viewable
    """
    colours = palette(theme)
    context = Context(session, colours, pn.state.curdoc)
    bar, strip = TopBar(context, query, others), Strip(context)
    light = len(context.listeners)  # the panes that a browser draws at once
    failures = Failures(context)
    areas = {"bar": bar.view, "strip": strip.view, "fails": failures.view}
    areas |= {name: _pane(context.palette) for name in ("sensor", "model", "missing", "history")}

    def tell(what: str, said: str = "") -> None:
        known, draft = session.evaluation, context.draft
        if what == "draft":
            if draft is not None or session.draft is None:
                return
            context.shown, what = session.draft, "preview"
        elif (  # a slider that moves on shows its own
            what in ("evaluation", "yardstick")
            and known is not None
            and draft in (None, known.model)
        ):
            context.shown = known
        context.tell(said or what)

    def listener(what: str) -> None:
        if what in ("evaluation", "yardstick"):  # first the error alone: a browser draws the panes
            context.back(lambda: tell(what, "error"))  # for ten times as long
        context.back(lambda: tell(what))

    def begin() -> None:
        session.listeners.append(listener)
        context.shown = session.evaluation
        show(context.listeners[:light])
        proceed()
        begun()

    def show(listeners: Sequence[Callable[[str], None]]) -> None:
        with context.combined(exchanging=True):
            _all(context, listeners)

    def put(area: str, kind: Callable[[Context], Any]) -> Any:
        """Make a pane, and send it with what it shows."""
        there = len(context.listeners)
        with context.combined(exchanging=True):
            pane = kind(context)
            _all(context, context.listeners[there:])
            context.send(areas[area], [pane.view])
        return pane

    def opening() -> Iterator[None]:
        """Send pane after pane, the frames first; meanwhile the browser draws the one before."""
        heavy = context.listeners[light:]
        sensor = put("sensor", Sensor)
        yield
        show(heavy)
        sensor.side.open()
        yield
        put("model", Model)
        yield
        put("missing", Missing)
        yield
        put("history", HistoryPane)

    steps = opening()

    def proceed() -> None:
        if next(steps, False) is None:
            context.back(proceed)

    whole = pn.Column(sizing_mode="stretch_both", margin=0, stylesheets=[layout()])
    context.send(whole, list(areas.values()))
    pn.state.onload(lambda: context.back(begin))
    pn.state.on_session_destroyed(lambda _: _forget(session, listener))
    for area, pane in areas.items():
        least = {"min-width": "0"} | ({} if area == "strip" else {"min-height": "0"})
        pane.styles = {**pane.styles, "grid-area": area, **least}
    return whole


def _pane(p: Palette) -> Any:
    """What a pane is put into once the browser has the page; till then it says so."""
    loading = pn.pane.HTML(
        "<div class=loading>loading …</div>", stylesheets=[inner(p)], styles=card(p),
        sizing_mode="stretch_both", margin=0,
    )  # fmt: skip
    return pn.Column(loading, sizing_mode="stretch_both", margin=0)


class Address(JSComponent):
    """Names the session in the browser's address, so that a reload asks for it."""

    query = param.String(default="")

    _esm = Path(__file__).with_name("address.js").read_text(encoding="utf-8")


class OneLayout(JSComponent):
    """One layout of the page for all that changes between two frames of the screen."""

    _esm = Path(__file__).with_name("one_layout.js").read_text(encoding="utf-8")


def _all(context: Context, listeners: Sequence[Callable[[str], None]]) -> None:
    """Show a session as it is to panes that have not been sent, or have been drawn."""
    session = context.session
    for what in ("statistics", "history", "evaluation", "diagnosis", "detection", "message"):
        if what in ("history", "evaluation") and session.history is None:
            continue
        if what == "evaluation" and session.evaluation is None:
            continue
        for listener in listeners:
            listener(what)


def _forget(session: WorkbenchSession, listener: Any) -> None:
    if listener in session.listeners:
        session.listeners.remove(listener)
    if not session.listeners:
        session.left()


class TopBar:
    """What is open, and the theme."""

    def __init__(self, context: Context, query: str, others: Mapping[str, str]) -> None:
        style = [inner(context.palette)]
        captures = context.session.captures
        where = html.escape(Path(captures.name).name)
        facts = (
            f"{plural(captures.frame_count, 'frame')} of <span title='rows × columns'>"
            f"{size(captures.sensor.shape)}</span> pixels, "
            f"{plural(len(captures.settings), 'operating point')}"
        )
        if captures.notes:
            items = "".join(f"<li>{html.escape(n)}</li>" for n in captures.notes)
            facts += (
                f", <details class=notes><summary>{plural(len(captures.notes), 'note')}</summary>"
                f"<ul>{items}</ul></details>"
            )
        if others:
            items = "".join(
                f"<li><a href='{html.escape(q)}' target=_self>{html.escape(n)}</a></li>"
                for n, q in others.items()
            )
            facts += (
                f", <details class=notes><summary>other folders</summary><ul>{items}</ul></details>"
            )
        other = "light" if context.palette.name == "dark" else "dark"
        there = query.replace(f"theme={context.palette.name}", f"theme={other}")
        link = f"<a href='{html.escape(there)}' target=_self>{other} theme</a>"
        self.view = pn.Row(
            pn.pane.HTML(
                f"<b style='font-size:15px'>dnanalyze</b> &nbsp;<b>{where}</b> "
                f"<span class=quiet>{facts}</span>",
                stylesheets=style, margin=(3, 20, 0, 4), styles={"white-space": "nowrap"},
            ),
            pn.layout.HSpacer(),
            pn.pane.HTML(link, stylesheets=style, margin=(5, 4, 0, 0)),
            Address(query=query, width=1, height=1, margin=0),
            OneLayout(width=1, height=1, margin=0),
            sizing_mode="stretch_width", margin=0,
        )  # fmt: skip


def style_sheet(theme: str) -> str:
    """Style sheet of the document itself."""
    return sheet(palette(theme))
