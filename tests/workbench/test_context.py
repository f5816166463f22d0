"""News to the panes of a page arrive as one message."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip("panel")

from bokeh.document import Document
from bokeh.models import LinearScale, LogScale

from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.style import LIGHT, plain_figure


@pytest.fixture
def context():
    made = Context(None, LIGHT, Document())
    made.document.add_root(plain_figure(LIGHT))
    return made


def exchange(figure, times=20):
    for k in range(times):
        figure.x_scale = LogScale() if k % 2 else LinearScale()


def test_the_page_is_searched_once_however_many_models_are_exchanged(context, monkeypatch):
    models, searches = context.document.models, []
    search = models.recompute
    monkeypatch.setattr(models, "recompute", lambda: (searches.append(1), search()))
    figure = context.document.roots[0]
    context.listeners.append(lambda _: exchange(figure))
    context.tell("evaluation")
    assert len(searches) == 1
    assert figure.x_scale.id in models


def test_after_an_error_of_a_pane_the_page_knows_its_models_again(context):
    figure = context.document.roots[0]

    def fails(_):
        exchange(figure)
        raise ValueError("of a pane")

    context.listeners.append(fails)
    with pytest.raises(ValueError, match="of a pane"):
        context.tell("evaluation")
    exchange(figure, 1)
    assert figure.x_scale.id in context.document.models
    assert context.document.callbacks.hold_value is None


@pytest.mark.parametrize(("destroyed", "called"), [(None, 0), (True, 0), (False, 1)])
def test_a_result_for_a_page_that_is_gone_is_dropped(destroyed, called):
    """Bokeh takes the session from a document that is closed: it is then None."""
    session = None if destroyed is None else SimpleNamespace(destroyed=destroyed)
    calls = []
    document = SimpleNamespace(session_context=session, add_next_tick_callback=calls.append)
    Context(None, LIGHT, document).back(lambda: None)
    assert len(calls) == called


class Page:
    """A document whose calls of the next tick are carried out when the test says so."""

    def __init__(self) -> None:
        self.session_context = SimpleNamespace(destroyed=False)
        self.calls = []
        self.add_next_tick_callback = self.calls.append
        self.callbacks = SimpleNamespace(hold_value=None)
        self.hold, self.unhold = (lambda policy: None), (lambda: None)

    def tick(self) -> None:
        while self.calls:
            self.calls.pop(0)()


def test_what_comes_while_the_browser_draws_waits_and_keeps_its_order():
    page, place, done = Page(), SimpleNamespace(), []
    context = Context(None, LIGHT, page)
    context.back(lambda: done.append("on its way when panes are sent"))
    context.send(place, ["pane"])
    context.back(lambda: done.append("later"))
    page.tick()
    assert (done, context.drawing) == ([], True)
    pane, mark = place.objects
    mark._handle_msg(True)
    page.tick()
    assert pane == "pane"
    assert (done, context.drawing) == (["on its way when panes are sent", "later"], False)


def test_a_pane_sent_by_what_waited_holds_the_rest():
    page, first, second, done = Page(), SimpleNamespace(), SimpleNamespace(), []
    context = Context(None, LIGHT, page)
    context.send(first, [])
    context.back(lambda: context.send(second, []))
    context.back(lambda: done.append("news"))
    first.objects[-1]._handle_msg(True)
    page.tick()
    assert done == []
    first.objects[-1]._handle_msg(True)  # of panes that are drawn already
    page.tick()
    assert done == []
    second.objects[-1]._handle_msg(True)
    page.tick()
    assert done == ["news"]


def test_news_that_a_pane_tells_while_the_browser_draws_is_told_after():
    page, place, told = Page(), SimpleNamespace(), []
    context = Context(None, LIGHT, page)
    context.listeners.append(told.append)
    context.send(place, [])
    context.tell("preview")
    page.tick()
    assert told == []
    place.objects[-1]._handle_msg(True)
    page.tick()
    assert told == ["preview"]
