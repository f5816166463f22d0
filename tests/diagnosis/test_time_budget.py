"""Searches that end before they are done."""

import math
from dataclasses import replace

import pytest

from dnanalyze.comparator.error import TOLERABLE
from dnanalyze.demo import tiny
from dnanalyze.diagnosis.diagnose import diagnose_on
from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.diagnosis.results import Step
from dnanalyze.diagnosis.search_path import Path, SearchLimits
from dnanalyze.diagnosis.selection import UNFINISHED
from dnanalyze.diagnosis.stepwise import Search
from dnanalyze.errors import InputError
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp

NONE, PLENTY = 1e-6, 3600.0  # s


@pytest.fixture(scope="module")
def captures():
    return tiny()


def test_a_limit_ends_and_no_limit_does_not():
    TimeLimit().check()
    TimeLimit.after(PLENTY).check()
    with pytest.raises(TimeUp):
        TimeLimit(0.0).check()


@pytest.mark.parametrize("search", [refine_on, diagnose_on])
@pytest.mark.parametrize("budget", [0.0, -1.0, math.nan])
def test_a_budget_is_above_zero(captures, search, budget):
    with pytest.raises(InputError, match=r"budget.*above 0"):
        search(captures, budget=budget)


def test_without_time_the_starting_model_is_the_answer(captures):
    found = refine_on(captures, budget=NONE)
    assert found.timed_out
    assert not found.finished
    assert found.verdict == "missing"
    assert [s.added for s in found.steps] == [None]
    assert math.isfinite(found.steps[0].error)
    assert found.parameters
    assert all(math.isnan(p.se) for p in found.parameters)
    found.problem.fitted_z(found.model)  # what is done with the result has no limit


@pytest.mark.parametrize(("error", "share"), [(TOLERABLE, 1.0), (TOLERABLE + 0.1, UNFINISHED)])
def test_names_of_an_unfinished_search_far_from_the_captures_are_less_certain(
    captures, monkeypatch, error, share
):
    def stopped(search, state, exclude):
        steps = (Step(None, 9.0), Step("column_fpn", error, 0.95))
        search.on_path(Path(state, steps, problem=search.problem))
        raise TimeUp

    monkeypatch.setattr(Search, "run", stopped)
    found = refine_on(captures, budget=PLENTY, classifier=False)
    assert found.timed_out
    assert [s.confidence for s in found.steps] == [None, pytest.approx(0.95 * share)]


def test_what_is_known_directly_is_stated_without_time_too(captures):
    known = replace(captures, sensor=replace(captures.sensor, system_gain_dn_e=0.5))
    begun = baseline_model(fit_problem(design(known)))
    found = {a.quantity: a for a in refine_on(known, begun, budget=NONE).direct}
    gain = found["system gain, recorded"]
    assert gain.direct == 0.5
    assert gain.model == begun.get("dark_shot_noise").value("dn_per_e", begun.reference)


def test_without_time_no_candidate_is_named(captures):
    found = diagnose_on(captures, budget=NONE)
    assert not found.finished
    assert found.verdict == "unexplained"
    assert found.candidates == []


@pytest.mark.long
def test_time_enough_changes_nothing(captures, known):
    few = {"known": known, "limits": SearchLimits(max_effects=0), "classifier": False}
    free = refine_on(captures, **few)
    limited = refine_on(captures, **few, budget=PLENTY)
    assert limited.finished
    assert not limited.timed_out
    assert limited.steps == free.steps
    assert limited.model == free.model


def test_no_replicate_is_begun_without_time(captures):
    problem = fit_problem(design(captures))
    model = baseline_model(problem)
    late = problem.within(TimeLimit(0.0))
    with pytest.raises(TimeUp):
        late.replicate(model, 0)
    drawn = problem.replicate(model, 0)
    assert late.replicate(model, 0) is drawn  # what is known costs no time
