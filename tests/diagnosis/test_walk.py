"""From one addition to the next."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.diagnosis import walk as module
from dnanalyze.diagnosis.evidence import evidence_for
from dnanalyze.diagnosis.exchange import Exchange
from dnanalyze.diagnosis.path import Path, Step
from dnanalyze.diagnosis.trial import error_of
from dnanalyze.diagnosis.walk import Walk
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import start
from dnanalyze.model.registry import BASE


@pytest.mark.parametrize("poor", [True, False])
def test_before_it_gives_up_on_a_poor_model_it_asks_once_more_with_true_derivatives(
    ordinary, known, monkeypatch, poor
):
    asked, real = [], module.ranked

    def blind(held, state, *more):
        """Sees nothing at first."""
        asked.append(state)
        return real(held, state, *more) if len(asked) > 1 else []

    monkeypatch.setattr(module, "ranked", blind)
    monkeypatch.setattr(module, "POOR", 1.0 if poor else 1e3)
    begun = Path(ordinary.state, (Step(None, error_of(ordinary.bench, ordinary.state)),))
    found = Walk(ordinary.bench, known).to_end(begun)
    assert (found.state.model.get("row_fpn") is not None) == poor
    if poor:
        assert not np.array_equal(asked[0].jacobian, asked[1].jacobian)
    else:
        assert len(asked) == 1


@pytest.mark.parametrize(
    ("evidence", "gain", "forks"), [(800.0, 800.0, 1), (700.0, 700.0, 0), (800.0, -10.0, 0)]
)
def test_a_rival_that_explains_nearly_as_much_and_would_do_is_a_fork(evidence, gain, forks):
    best = module.Trial("a", None, 1000.0, 1000.0, 1.0)
    other = module.Trial("b", None, gain, 2 * evidence - gain, 1.1)
    begun = Path(None, (Step(None, 2.0),))
    found = module._forked(begun, best, [best, other], 2.0)
    assert [f.other.effect for f in found.forks] == ["b"] * forks
    assert all(f.nearness == evidence / 1000.0 and f.before is begun for f in found.forks)
    again = module._forked(found, best, [best, other], 2.0)
    assert len(again.forks) == 2 * forks


@pytest.fixture
def completed_at_once(ordinary, known, monkeypatch):
    """The walk and the state with row FPN, of which no more is asked than to stand."""
    model = ordinary.model.with_effect(known["row_fpn"](0.5))
    state = start(ordinary.bench, model, knobs_of(model))
    monkeypatch.setattr(module, "completed", lambda _held, state, _name: state)
    monkeypatch.setattr(module, "needless", lambda _held, state: (state, []))
    return Walk(ordinary.bench, known), state


def test_what_every_sensor_has_and_what_was_there_is_not_counted_as_added(
    completed_at_once,
):
    walk, state = completed_at_once
    assert replace(walk, begun=(BASE,)).added(state) == ["row_fpn"]
    assert replace(walk, begun=(BASE, "row_fpn")).added(state) == []


def test_what_is_needless_with_an_addition_goes_and_does_not_come_back(
    ordinary, completed_at_once, monkeypatch
):
    walk, state = completed_at_once
    monkeypatch.setattr(module, "needless", lambda _held, _state: (ordinary.state, ["row_noise"]))
    begun = Path(ordinary.state, (Step(None, 2.0),))
    found = walk.add(begun, module.Trial("row_fpn", state, 90.0, 90.0, 1.0), 0.7)
    assert [(s.added, s.confidence) for s in found.steps] == [
        (None, None), ("row_fpn", 0.7), ("-row_noise", None)
    ]  # fmt: skip
    assert found.state is ordinary.state
    assert found.dropped == ("row_noise",)
    begun, added, gone = (s.evidence for s in found.steps)
    assert added == evidence_for(
        ordinary.bench, ordinary.state, state, type(state.model.get("row_fpn"))
    )
    assert any("with row_fpn" in words for words in added)
    assert begun == gone == []


def test_an_exchange_is_told_as_a_removal_and_an_addition(ordinary, completed_at_once, monkeypatch):
    walk, state = completed_at_once
    found = module.Trial("row_fpn", state, 90.0, 90.0, 1.0)
    answers = iter([Exchange("row_noise", ordinary.state, found), None])
    monkeypatch.setattr(module, "POOR", 0.1)
    monkeypatch.setattr(module, "ranked", lambda *_: [])
    monkeypatch.setattr(module, "exchange", lambda *_: next(answers))
    monkeypatch.setattr(
        module, "confidence_of", lambda best, among, _: 0.4 if among == [best] == [found] else None
    )
    begun = Path(state, (Step(None, 2.0),))
    ended = walk.to_end(begun)
    assert [s.added for s in ended.steps] == [None, "-row_noise", "row_fpn"]
    assert ended.steps[1].error == error_of(ordinary.bench, ordinary.state)
    assert ended.dropped == ("row_noise",)
    assert ended.steps[2].confidence == 0.4
