"""The way of the rival at a fork, where the end of the first is poor."""

from dataclasses import replace

import pytest

from dnanalyze.diagnosis import other_way as module
from dnanalyze.diagnosis.other_way import by_another_way
from dnanalyze.diagnosis.path import Fork, Path, Step
from dnanalyze.diagnosis.trial import error_of, judged
from dnanalyze.diagnosis.walk import Walk
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import converge, start

RIGHT, WRONG = "row_fpn", "row_noise"


@pytest.fixture(autouse=True)
def soon_poor(monkeypatch):
    """Of so few pixels a model that lacks the rows is not far off."""
    monkeypatch.setattr(module, "POOR", 1.1)


@pytest.fixture(scope="module")
def tried(ordinary, known):
    held, state = ordinary.bench, ordinary.state
    found = {}
    for name in (RIGHT, WRONG):
        model = state.model.with_effect(known[name](0.5))
        refit = converge(held, start(held, model, knobs_of(model)))
        found[name] = judged(held, state, name, refit)
    return found


def gone(ordinary, tried, taken, other):
    """The walk, and a path that ended with what was taken; only what is at the fork may come."""
    told, kept = [], []
    walk = Walk(ordinary.bench, {}, tell=told.append, keep=kept.append)
    begun = Path(ordinary.state, (Step(None, error_of(ordinary.bench, ordinary.state)),))
    path = replace(begun, forks=(Fork(begun, tried[taken], tried[other]),))
    path = walk.note(path, tried[taken].state, taken, 0.6)
    del told[:]
    return walk, path, told, kept


def test_the_better_end_is_taken_and_told_with_what_was_given_up(ordinary, tried):
    walk, path, told, kept = gone(ordinary, tried, WRONG, RIGHT)
    found = by_another_way(walk, path)
    assert [s.added for s in found.steps] == [None, RIGHT]
    assert found.error < 1.1 < path.error
    assert found.steps[1].confidence > 0.99
    assert [s.added for s in told] == [f"-{WRONG}", RIGHT]
    assert told[0].error == path.steps[0].error
    assert told[1] == found.steps[1]
    assert kept == [found]
    assert found.steps[1].confused_with == [WRONG]


def test_an_end_that_is_no_better_makes_what_was_taken_surer(ordinary, tried, monkeypatch):
    monkeypatch.setattr(module, "POOR", 0.5)
    walk, path, told, kept = gone(ordinary, tried, RIGHT, WRONG)
    found = by_another_way(walk, path)
    assert found.state is path.state
    assert found.steps[1].confidence > 0.99 > path.steps[1].confidence
    assert not told
    assert not kept


@pytest.mark.parametrize("why", ["good", "no fork", "told to stop"])
def test_otherwise_no_other_way_is_gone(ordinary, tried, monkeypatch, why):
    monkeypatch.setattr(Walk, "add", None)  # fails where it is called
    walk, path, *_ = gone(ordinary, tried, *((RIGHT, WRONG) if why == "good" else (WRONG, RIGHT)))
    if why == "no fork":
        path = replace(path, forks=())
    if why == "told to stop":
        walk = replace(walk, most_effects=1)
    assert by_another_way(walk, path) is path


def test_the_nearest_fork_is_taken(ordinary, tried):
    walk, path, *_ = gone(ordinary, tried, WRONG, RIGHT)
    near = replace(path.forks[0], taken=replace(tried[WRONG], gain=1e3, fitted_gain=1e3))
    far = replace(near, other=replace(tried[WRONG], gain=0.1, fitted_gain=0.1))
    assert far.nearness < near.nearness
    for forks in ((far, near), (near, far)):
        found = by_another_way(walk, replace(path, forks=forks))
        assert [s.added for s in found.steps] == [None, RIGHT]


@pytest.mark.parametrize("fits", [True, False])
@pytest.mark.parametrize("lower", [True, False])
def test_the_other_end_must_fit_better_and_have_the_lower_error(
    ordinary, tried, monkeypatch, fits, lower
):
    monkeypatch.setattr(module, "preferred", lambda mine, other: other if fits else mine)
    walk, path, *_ = gone(ordinary, tried, WRONG, RIGHT)
    if not lower:
        path = replace(path, steps=(path.steps[0], replace(path.steps[1], error=0.1)))
    found = by_another_way(walk, path)
    assert (found.state is not path.state) == (fits and lower)
