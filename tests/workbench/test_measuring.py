"""Full errors give way to a slider that moves."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest

import dnanalyze
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.model.memo import Memo
from dnanalyze.model.registry import built_in
from dnanalyze.workbench.evaluation import judged
from dnanalyze.workbench.measuring import Interruptible, Measurements, Superseded, seen_at


@pytest.fixture(scope="module")
def problem(folder):
    return fit_problem(design(dnanalyze.load(str(folder))))


def made(problem, **calls):
    calls = {"told": lambda _: None, "failed": lambda _: None, "busy": lambda: False} | calls
    found = Measurements(**calls)
    found.begin(problem)
    return found


def test_parts_taken_one_by_one_are_the_same_simulation(problem, fitted):
    job = problem._job(fitted, None)
    (one,) = Interruptible(lambda: False).statistics([job], Memo(0))
    (other,) = problem.helpers.statistics([job], Memo(0))
    assert one.keys() == other.keys()
    for part in one:
        for a, b in zip(one[part], other[part], strict=True):
            assert {n: v.value for n, v in a.values.items()} == pytest.approx(
                {n: v.value for n, v in b.values.items()}, nan_ok=True
            )


def moved_at(model, setting, factor=1.3):
    """The model with one entry of its table of mu changed."""
    effect = model.get("convolved_lognormal")
    values = list(effect.mu.values)
    values[setting] *= factor
    return model.with_effect(replace(effect, mu=replace(effect.mu, values=tuple(values))))


def with_dpc(model):
    return model.with_effect(built_in()["dpc"]())


@pytest.mark.parametrize("changed", [lambda m: m, with_dpc])
def test_an_error_after_others_is_the_one_that_is_simulated_anew(problem, fitted, changed):
    measurements = made(problem)
    for setting in (0, 1, 0):
        model = changed(moved_at(fitted, setting))
        found, anew = measurements.now(model), judged(problem, model)
        assert np.array_equal(found.predicted, anew.predicted, equal_nan=True)


def test_an_operating_point_is_another_where_its_own_entry_of_a_table_is(fitted):
    first, last = (fitted.get("convolved_lognormal").mu.points[i] for i in (0, -1))
    other = moved_at(fitted, 0)
    assert seen_at(other, last) == seen_at(fitted, last)
    assert seen_at(other, first) != seen_at(fitted, first)
    assert seen_at(replace(fitted, seed=9), last) != seen_at(fitted, last)
    assert seen_at(with_dpc(other), last) != seen_at(with_dpc(fitted), last)  # it may calibrate


def test_the_half_that_is_fitted_adds_its_shading_alone_to_the_error(problem, fitted):
    assert np.array_equal(
        judged(problem, fitted).predicted,
        judged(problem, fitted, problem.statistics(fitted)).predicted,
        equal_nan=True,
    )


def test_a_simulation_ends_within_a_part_once_it_is_no_longer_asked_for(problem, fitted):
    job, looks = problem._job(fitted, 0), []
    job = replace(job, settings=job.settings[:1], even=True)

    def over():
        looks.append(0)
        return len(looks) > 2

    assert len(job.parts()) == 1
    with pytest.raises(Superseded):
        Interruptible(over).statistics([job], Memo(0))
    assert len(looks) == 3  # before the part, and after its first two frames


def test_a_slider_that_rests_lets_a_simulation_begin_at_once(problem, fitted):
    measurements = made(problem)
    measurements.moved()
    assert measurements.moving
    measurements.rested()
    assert measurements.now(fitted).error == judged(problem, fitted).error


def test_a_simulation_ends_where_a_slider_moves_until_its_page_is_gone(
    problem, fitted, monkeypatch
):
    monkeypatch.setattr("dnanalyze.workbench.measuring.GONE_S", 0.3)
    measurements = made(problem)
    measurements.moved()
    with pytest.raises(Superseded):
        measurements.now(fitted)
    assert measurements.rest()
    assert measurements.now(fitted).error == judged(problem, fitted).error


def test_nothing_more_is_simulated_once_it_is_closed(problem, fitted):
    measurements = made(problem)
    measurements.close()
    assert not measurements.rest()
    with pytest.raises(Superseded):
        measurements.now(fitted)


def test_what_a_simulation_raises_is_told_and_the_next_model_is_measured(
    problem, fitted, monkeypatch
):
    told, failures, over = [], [], threading.Event()
    measurements = made(
        problem, told=lambda e: (told.append(e), over.set()), failed=failures.append
    )  # fmt: skip
    known = measurements.now(fitted)
    assert not known.exact
    bad = "dnanalyze.workbench.measuring.exact"

    def raising(*_):
        monkeypatch.undo()
        over.set()
        raise ValueError("one")

    monkeypatch.setattr(bad, raising)
    measurements.refine(known)
    assert over.wait(60)
    over.clear()
    other = measurements.now(replace(fitted, pedestal=fitted.pedestal + 1.0))
    measurements.refine(other)
    assert over.wait(60)
    assert [str(e) for e in failures] == ["one"]
    assert told[-1].exact
    assert np.isfinite(told[-1].error)
    assert measurements.now(other.model) is told[-1]


def test_a_yardstick_waits_for_the_error_of_the_present_model(problem, fitted, monkeypatch):
    measurements = made(problem)
    known = measurements.now(fitted)
    begun, over, replicated = threading.Event(), threading.Event(), threading.Event()

    def judging(*_):
        begun.set()
        over.wait(60)
        return known

    monkeypatch.setattr("dnanalyze.workbench.measuring.judged", judging)
    monkeypatch.setattr(type(problem), "replicate", lambda *_: replicated.set())
    monkeypatch.setattr("dnanalyze.workbench.measuring.exact", lambda *_: known)
    other = replace(fitted, pedestal=fitted.pedestal + 1.0)
    asking = threading.Thread(target=measurements.now, args=(other,))
    asking.start()
    assert begun.wait(60)
    measurements.refine(known)
    assert not replicated.wait(0.3)
    over.set()
    assert replicated.wait(60)
    measurements.close()
    asking.join()


def test_an_earlier_model_becomes_exact_after_the_present_one(problem, fitted):
    told, over = [], threading.Event()

    def tell(found):
        told.append(found.model)
        if len(told) == 2:
            over.set()

    measurements = made(problem, told=tell)
    measurements.now(fitted)
    present = measurements.now(replace(fitted, pedestal=fitted.pedestal + 1.0))
    measurements.refine(present)
    assert over.wait(60)
    assert told == [present.model, fitted]
    after = measurements.now(replace(fitted, pedestal=fitted.pedestal + 2.0))
    assert np.array_equal(
        after.problem.test.reproducibility_sd,
        measurements.now(present.model).problem.test.reproducibility_sd,
    )
