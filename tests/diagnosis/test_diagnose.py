"""What is missing in a model, and in one that has nothing of what every sensor has."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_sensor import captures_with

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.diagnosis.diagnose import diagnose_on, judge
from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.diagnosis.search_path import SearchLimits
from dnanalyze.diagnosis.selection import OUTSIDE
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.residual import Residual
from dnanalyze.fitting.state import start
from dnanalyze.model.registry import BASE, BASELINE, WANG, built_in

pytestmark = pytest.mark.long

NEW = [n for n in BASELINE if n not in WANG]  # in a model of Wang 2025 that is rounded to codes
FEW = (BASE, *BASELINE, "row_fpn", "row_noise", "column_fpn")
KNOWN = {name: effect for name, effect in built_in().items() if name in FEW}


def of(hidden, every=2):
    captures = captures_with(hidden, every)
    return captures, fit_problem(design(captures))


@pytest.fixture(scope="module")
def rows():
    return of({"row_fpn": "strong"})


@pytest.fixture(scope="module")
def found(rows):
    captures, problem = rows
    return diagnose_on(captures, known=KNOWN, problem=problem)


def test_an_effect_is_found_beside_what_every_sensor_has(rows, found):
    captures, problem = rows
    assert found.verdict == "missing"
    assert found.ordinary == NEW
    assert [c.effect for c in found.candidates[:4]] == ["row_fpn", *NEW]
    first, *every = found.candidates[:5]
    assert 0.94 < first.confidence <= 1.0 - OUTSIDE
    assert first.error_after < every[-1].error_after < found.error
    assert all(c.confidence > 0.99 for c in every)
    assert len({c.error_after for c in every}) == 1  # they are fitted together
    share = (found.error - every[0].error_after) / (found.error - 1.0)
    assert all(c.explained == pytest.approx(min(1.0, max(0.0, share))) for c in every)
    assert set(BASELINE) < set(found.model.names)
    # the model with what every sensor has is asked the same question, and nothing of that is new
    again = diagnose_on(captures, found.model, known=KNOWN, problem=problem)
    assert again.ordinary == []
    assert again.candidates[0].effect == "row_fpn"
    assert not {c.effect for c in again.candidates} & set(BASELINE)
    assert again.error == pytest.approx(every[-1].error_after, rel=0.1)


def test_of_an_ordinary_sensor_only_what_every_sensor_has_is_missing():
    captures, problem = of({})
    told = []
    found = diagnose_on(captures, known=KNOWN, problem=problem, on_progress=told.append)
    assert found.verdict == "missing"
    assert [c.effect for c in found.candidates] == NEW
    assert "baseline effects" in told
    full = diagnose_on(captures, found.model, known=KNOWN, problem=problem)
    assert full.verdict == "adequate"
    assert full.error == pytest.approx(found.candidates[-1].error_after, rel=0.1)


def test_of_two_hidden_effects_the_second_accounts_for_what_the_first_leaves():
    captures, problem = of({"row_noise": "strong", "column_fpn": "strong"})
    found = diagnose_on(captures, known=KNOWN, problem=problem)
    assert found.verdict == "missing"
    first = found.candidates[0]
    assert first.effect in ("row_noise", "column_fpn")
    assert first.confidence > 0.9
    assert set(first.leaves) == set(found.unexplained)
    (other,) = {"row_noise", "column_fpn"} - {first.effect}
    assert any(f"which {other} in addition would correct" in words for words in first.evidence)


def test_where_no_candidate_explains_the_rest_the_first_may_stand_in_for_another():
    # at five temperatures what is left is plainly more than the row noise explains
    captures, problem = of({"row_noise": "strong", "column_fpn": "strong"}, every=1)
    found = diagnose_on(captures, known=KNOWN, problem=problem, exclude=["column_fpn"])
    first = found.candidates[0]
    assert found.unexplained
    assert first.confidence <= 0.5
    assert catalogue()[found.unexplained[0]].title in first.evidence[-1]


def test_a_candidate_that_is_not_significant_is_no_sure_name(rows, found):
    """One story: the list says what the verdict says."""
    captures, problem = rows
    null = FittedModel.of(problem, start(problem, found.model))
    leader = found.trials[0]
    idle = replace(leader, effect="row_noise", state=null.state)  # corrects nothing
    told = judge(captures, null, [leader, idle], None, KNOWN)
    assert told.verdict == "unexplained"
    assert told.unexplained == null.left != []
    sure = [c.confidence for c in told.candidates]
    assert sure == sorted(sure, reverse=True)
    assert max(sure) <= 0.5
    named = {c.effect: c for c in told.candidates}
    assert named["row_noise"].leaves == told.unexplained
    assert set(named["row_fpn"].leaves) < set(told.unexplained)
    assert all(c.evidence for c in told.candidates)


def test_an_adequate_model_has_no_candidates(rows, found):
    captures, problem = rows
    model = found.trials[0].state.model
    null = FittedModel.of(problem, start(problem, model))
    told = judge(captures, null, [found.trials[0]], None, KNOWN)
    assert (told.verdict, told.candidates, told.unexplained) == ("adequate", [], [])


def test_what_is_excluded_is_not_put_in(rows):
    captures, problem = rows
    found = diagnose_on(captures, known=KNOWN, problem=problem, exclude=["quantization", "row_fpn"])
    named = {c.effect for c in found.candidates}
    assert not named & {"quantization", "row_fpn"}
    assert found.ordinary == [n for n in BASELINE if n != "quantization"]
    assert "quantization" not in found.model.names


def test_where_all_of_it_is_excluded_the_model_is_asked_as_it_is(rows):
    captures, problem = rows
    found = diagnose_on(captures, known=KNOWN, problem=problem, exclude=BASELINE)
    assert found.ordinary == []
    assert found.model.names == [BASE]
    assert not {c.effect for c in found.candidates} & set(BASELINE)
    limits = SearchLimits(max_effects=0)
    kept = refine_on(
        captures, known=KNOWN, problem=problem, exclude=BASELINE, limits=limits, classifier=False
    )
    assert kept.effects == [BASE]


def test_a_model_with_some_of_it_is_asked_as_it_is(rows, found):
    captures, problem = rows
    some = found.model.without("quantization")
    partly = diagnose_on(captures, some, known=KNOWN, problem=problem)
    assert partly.ordinary == []
    assert partly.candidates[0].effect in ("row_fpn", "quantization")


def nearly_all_alike(captures):
    """The captures, the coldest frames of one code but for two pixels in the lower half."""
    first, *others = captures.settings

    def alike(window):
        pixels = np.full(captures.sensor.shape, 100, np.uint16)
        pixels[100, 50], pixels[110, 7] = 130, 101
        return pixels if window is None else np.ascontiguousarray(pixels[window.slices])

    frames = tuple(replace(frame, load=alike) for frame in first.frames)
    return replace(captures, settings=(replace(first, frames=frames), *others))


def test_a_setting_whose_frames_are_nearly_all_alike_is_diagnosed_too():
    """A filter may leave that little; warnings are errors here."""
    problem = fit_problem(design(nearly_all_alike(captures_with({}))))
    model = paper_start(problem)
    clues = Residual(problem, start(problem, model))
    for effect in built_in().values():
        assert all(isinstance(guess, effect) for guess in effect.guess(clues))
    found = diagnose_on(problem.plan.captures, model, known=KNOWN, problem=problem)
    assert found.verdict in ("missing", "unexplained")
    assert np.isfinite(found.error)
