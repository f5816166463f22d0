from __future__ import annotations

from types import SimpleNamespace

import pytest

import dnanalyze

pytest.importorskip("panel", reason="the extra workbench is not installed")

# Panel announces another name for the argument ``button_type``
pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")


def test_a_slider_that_has_moved_on_keeps_its_move_when_its_last_one_is_adopted():
    from dnanalyze.workbench.page.model import Model
    from dnanalyze.workbench.page.style import LIGHT

    adopted, moved_on, other = (dnanalyze.NoiseModel((), pedestal=x) for x in (1.0, 2.0, 3.0))
    session = SimpleNamespace(
        present=SimpleNamespace(model=adopted), known={}, sliders=list, removed=[], history=object()
    )
    context = SimpleNamespace(
        palette=LIGHT,
        listeners=[],
        session=session,
        draft=adopted,
        act=lambda action: None,
        send=lambda place, panes: None,
    )
    pane = Model(context)
    pane._rested()
    context.draft = moved_on
    pane.update("history")
    assert context.draft is moved_on
    session.present.model = other  # an undo, or a fit that has ended
    pane.update("history")
    assert context.draft is None


def test_a_slider_rests_when_the_browser_has_drawn_its_last_move():
    from dnanalyze.workbench.page.rest import Rest

    rests = []
    rest = Rest(lambda: rests.append(rest.drawn))
    rest.move()
    rest.draw()
    rest.move()  # before the browser answers
    rest._handle_msg(1)
    assert rests == []
    rest.draw()
    rest._handle_msg(2)
    assert rests == [2]
