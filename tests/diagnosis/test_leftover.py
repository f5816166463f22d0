"""What a first candidate leaves over."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis import leftover as module
from dnanalyze.diagnosis.candidate import Candidate
from dnanalyze.diagnosis.confidence import PLAIN, STANDS_IN
from dnanalyze.diagnosis.diagnose import ranked
from dnanalyze.diagnosis.everyday import everyday
from dnanalyze.diagnosis.leftover import leftover
from dnanalyze.diagnosis.screening import Prospect
from dnanalyze.diagnosis.trial import error_of
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.from_part import fitted
from dnanalyze.fitting.predictor import bench
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.registry import built_in

CANDIDATE = Candidate("a", 0.9, 0.5, 0.8, [], ["why"])


@pytest.fixture(scope="module")
def sensor():
    """Rows and columns, both off; the state with what every sensor has."""
    hidden = {"row_noise": {"level": "strong"}, "column_fpn": {"level": "strong"}}
    captures = generate(
        draw_sensor(np.random.default_rng(11)), hidden, (128, 128), frames=4, seed=3
    )
    held, stages = bench(design(captures)), []
    everyday(held, fitted(held, paper_start(held)), (), lambda _, stage: stages.append(stage))
    return held, stages[-1]


def of(*names):
    return {name: effect for name, effect in built_in().items() if name in names}


def test_what_another_effect_would_put_right_is_no_doubt(sensor):
    held, state = sensor
    tried = ranked(held, state, of("row_noise"))
    over = leftover(held, state, tried[0], tried, of("row_noise", "column_fpn", "row_fpn"))
    assert over.mender == "column_fpn"
    assert any(name.startswith("pattern_columns") for name in over.left)
    told = over.told(CANDIDATE)
    assert told.confidence == CANDIDATE.confidence
    assert "column_fpn" in told.evidence[-1]


def test_what_no_effect_would_put_right_doubts_it(sensor):
    held, state = sensor
    tried = ranked(held, state, of("row_noise"))
    over = leftover(held, state, tried[0], tried, of("row_noise", "row_fpn", "stuck_pixels"))
    assert over.doubted
    told = over.told(CANDIDATE)
    assert told.confidence == pytest.approx(STANDS_IN * CANDIDATE.confidence)
    assert over.left[0] in told.evidence[-1]


def test_an_effect_that_promises_much_and_puts_nothing_right_does_not_account_for_it(
    sensor, monkeypatch
):
    held, state = sensor
    tried = ranked(held, state, of("row_noise"))
    useless = tried[0].state.model.with_effect(RowFpn(0.01))
    monkeypatch.setattr(module, "prospects", lambda *_: [Prospect("row_fpn", useless, 900.0)])
    assert leftover(held, state, tried[0], tried, of("row_noise", "row_fpn")).doubted


@pytest.mark.parametrize(
    ("share", "right", "doubted"), [(0.9, True, True), (1.1, True, False), (1.1, False, True)]
)
def test_only_what_plainly_puts_the_worst_right_accounts_for_it(
    sensor, share, right, doubted, monkeypatch
):
    held, state = sensor
    tried = ranked(held, state, of("row_noise"))
    gain = share * PLAIN
    other = replace(tried[0], effect="row_fpn", gain=gain, fitted_gain=gain, spread=1.0)
    monkeypatch.setattr(module, "judged", lambda *_: other)
    monkeypatch.setattr(module, "prospects", lambda *_: [Prospect("row_fpn", state.model, 900.0)])
    monkeypatch.setattr(module, "refitted", lambda *_: state)
    monkeypatch.setattr(module, "mends", lambda *_: right)
    over = leftover(held, state, tried[0], [tried[0]], of("row_noise", "row_fpn"))
    assert over.doubted == doubted


def test_another_candidate_may_account_for_it(sensor, monkeypatch):
    held, state = sensor
    monkeypatch.setattr(module, "minimise", lambda *_: pytest.fail("of no effect, no more steps"))
    tried = ranked(held, state, of("row_noise", "column_fpn"))
    over = leftover(held, state, tried[0], tried, {})
    assert over.left
    assert over.mender == tried[1].effect
    weak = replace(tried[1], gain=1.0, fitted_gain=1.0)  # of no evidence
    alone = leftover(held, state, tried[0], [tried[0], weak], {})
    assert alone.doubted
    other = replace(weak, gain=1e4, fitted_gain=1e4, state=state)  # of what is not left
    assert leftover(held, state, tried[0], [tried[0], other], {}).doubted


def _in_few_steps(held, state, *names):
    """Trials of which none is at rest."""
    tried = ranked(held, state, of(*names))
    return [replace(t, state=replace(t.state, at_rest=False)) for t in tried]


def test_it_goes_to_its_end_before_others_are_asked(sensor, monkeypatch):
    held, state = sensor
    tried = _in_few_steps(held, state, "row_noise")
    end, seen = replace(tried[0].state), []
    monkeypatch.setattr(module, "derived_anew", lambda _, there: there)
    monkeypatch.setattr(module, "minimise", lambda *_: end)
    monkeypatch.setattr(module, "prospects", lambda _, there, __: seen.append(there) or [])
    over = leftover(held, state, tried[0], tried, of("row_noise", "row_fpn"))
    assert over.doubted
    assert len(seen) == 1
    assert seen[0] is end


def test_what_a_few_steps_left_is_taken_to_its_end_before_it_doubts(sensor, monkeypatch):
    held, state = sensor
    tried = _in_few_steps(held, state, "row_noise", "column_fpn")
    end = next(t.state for t in tried if t.effect == "column_fpn")
    left = {id(tried[0].state): ["pattern_columns_0.3_0.5"], id(end): []}
    monkeypatch.setattr(module, "unexplained", lambda _, s, __: left[id(s)])
    monkeypatch.setattr(module, "prospects", lambda *_: [])
    monkeypatch.setattr(module, "derived_anew", lambda _, there: there)
    monkeypatch.setattr(module, "minimise", lambda *_: end)
    over = leftover(held, state, tried[0], [tried[0]], of("row_noise"))
    assert over.found.state is end
    assert over.found.error == pytest.approx(error_of(held, end))
    assert (over.left, over.doubted, over.mender) == ([], False, None)


@pytest.mark.parametrize(
    ("kinds", "better", "taken"), [(None, True, True), (None, False, False), ("all", True, False)]
)
def test_another_choice_of_it_is_asked_before_another_effect(
    sensor, monkeypatch, kinds, better, taken
):
    """Unless its guesses came in all kinds."""
    held, state = sensor
    tried = _in_few_steps(held, state, "row_noise", "column_fpn")
    end, kind = tried[0].state, next(t.state for t in tried if t.effect == "column_fpn")
    left = {id(end): ["pattern_columns_0.3_0.5"], id(kind): []}
    asked = []
    monkeypatch.setattr(module, "unexplained", lambda _, s, __: left[id(s)])
    monkeypatch.setattr(module, "derived_anew", lambda _, there: there)
    monkeypatch.setattr(module, "minimise", lambda *_: end)
    monkeypatch.setattr(module, "settled", lambda _, s, __: kind if better else s)
    monkeypatch.setattr(module, "kind_of", lambda *_: kinds)
    monkeypatch.setattr(module, "prospects", lambda _, s, __: asked.append(s) or [])
    over = leftover(held, state, tried[0], [tried[0]], of("row_noise", "row_fpn"))
    assert over.found.state is (kind if taken else end)
    assert over.doubted != taken
    assert asked == ([] if taken else [end])


def test_at_rest_it_goes_no_further(sensor, monkeypatch):
    held, state = sensor
    (found,) = _in_few_steps(held, state, "row_noise")
    found = replace(found, state=replace(found.state, at_rest=True))
    monkeypatch.setattr(module, "unexplained", lambda *_: ["mean"])
    monkeypatch.setattr(module, "minimise", lambda *_: pytest.fail("nothing was left to gain"))
    monkeypatch.setattr(module, "prospects", lambda *_: [])
    assert leftover(held, state, found, [found], of("row_noise")).found.state is found.state


@pytest.mark.parametrize("mended", [True, False])
def test_forms_with_other_numbers_are_asked_where_no_choice_mends(sensor, monkeypatch, mended):
    held, state = sensor
    (found,) = _in_few_steps(held, state, "row_noise")
    choice, form = replace(found.state), replace(found.state)
    left = {id(found.state): ["mean"], id(choice): [] if mended else ["mean"], id(form): []}
    asked = []
    monkeypatch.setattr(module, "unexplained", lambda _, s, __: left[id(s)])
    monkeypatch.setattr(module, "derived_anew", lambda _, there: there)
    monkeypatch.setattr(module, "minimise", lambda _, there, __: there)
    monkeypatch.setattr(module, "settled", lambda *_: choice)
    monkeypatch.setattr(module, "related", lambda _, there, __: asked.append(there) or form)
    over = leftover(held, state, found, [found], of("row_noise"))
    assert over.found.state is (choice if mended else form)
    assert asked == ([] if mended else [choice])
    assert not over.doubted


def test_few_replicates_do_where_no_other_is_asked(sensor, monkeypatch):
    """What is left is told by all of them."""
    held, state = sensor
    (found,) = _in_few_steps(held, state, "row_noise")
    counts = []
    monkeypatch.setattr(module, "unexplained", lambda _, __, n: counts.append(n) or ["mean"])
    monkeypatch.setattr(module, "derived_anew", lambda _, there: there)
    monkeypatch.setattr(module, "minimise", lambda _, there, __: there)
    monkeypatch.setattr(module, "prospects", lambda *_: [])
    monkeypatch.setattr(module, "kind_of", lambda *_: "all")  # nothing but other effects to ask
    monkeypatch.setattr(module, "mends", lambda *_: True)
    assert leftover(held, state, found, [found], {}).left == ["mean"]
    assert counts == [module.FEW]
    for at_rest, beside, asked in (
        (False, [], [module.HASTY, module.FEW]),
        (True, [], [module.HASTY, module.FEW]),
        (False, [replace(found, gain=1e4, fitted_gain=1e4)], [module.FEW]),
    ):
        there = replace(found, state=replace(found.state, at_rest=at_rest))
        counts.clear()
        leftover(held, state, there, [there, *beside], of("row_noise"))
        assert counts == asked
