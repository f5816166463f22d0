"""Fits that begin on a part of the field."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.fitting import design as designs
from dnanalyze.fitting import from_part
from dnanalyze.fitting.changes import Changes, part_for
from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.free_parameters import free_parameters, positions, with_values
from dnanalyze.fitting.from_part import converge, fitted
from dnanalyze.fitting.moments import moments
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.start import paper_models
from dnanalyze.fitting.state import State, carried, start
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Placing
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, built_in
from dnanalyze.model.simulate import simulate

KNOWN = built_in()
POINTS = tuple(OperatingPoint(t, 0.1) for t in (25.0, 65.0))
SHAPE, FRAMES = (256, 256), 4
TRUTH = {
    BASE: {"mu": 3.0, "delta": 0.6, "sigma": 1e-6},
    "dark_shot_noise": {"dn_per_e": 0.5},
    "read_noise": {"sigma": 3.0},
    "pixel_fpn": {"sigma": 2.0},
    "quantization": {},
}


def model(seed, **more):
    numbers = TRUTH | more
    return NoiseModel(tuple(KNOWN[n](**v) for n, v in numbers.items()), 64.0, POINTS[0], seed=seed)


@pytest.fixture(scope="module")
def problem():
    """Two temperatures, with a part though they are small."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(designs, "PART_FROM_PIXELS", 0)
        return fit_problem(design(simulate(model(4), SHAPE, [(p, FRAMES) for p in POINTS])))


@pytest.fixture
def simulated(monkeypatch):
    """What of a problem is simulated, in order."""
    made, whole = [], FitProblem.several

    def several(self, models):
        made.extend([self.part is not None] * len(models))
        return whole(self, models)

    monkeypatch.setattr(FitProblem, "several", several)
    return made


def test_a_part_is_measured_as_if_it_were_all_there_is(problem):
    alone = fit_problem(problem.part.plan)
    for one, other in ((alone.train, problem.part.train), (alone.test, problem.part.test)):
        assert one.keys == other.keys
        np.testing.assert_array_equal(one.coordinates, other.coordinates)
        np.testing.assert_array_equal(one.reproducibility_sd, other.reproducibility_sd)
    assert problem.part.memo is problem.memo
    assert problem.part.helpers is problem.helpers
    assert problem.only([0]).part.train.keys == problem.part.only([0]).train.keys


def test_a_quarter_of_the_field_tells_each_number_half_as_well(problem):
    whole, part = problem.train, problem.part.train
    place = {k: i for i, k in enumerate(whole.keys)}
    ratio = [
        reproducibility_sd / whole.reproducibility_sd[place[k]]
        for k, reproducibility_sd in zip(part.keys, part.reproducibility_sd, strict=True)
        if k in place
    ]
    assert len(ratio) > 0.85 * len(whole.keys)  # its bands are too narrow for shading
    assert 1.5 < np.median(ratio) < 2.5


def test_derivatives_go_over_in_the_floors_of_where_they_are_used(problem):
    there = derive(problem.part, start(problem.part, model(4)))
    here = carried(there, problem.part, problem)
    place = {k: i for i, k in enumerate(problem.part.train.keys)}
    for i, key in enumerate(problem.train.keys):
        if key in place:
            j = place[key]
            np.testing.assert_allclose(
                here.jacobian[i] * problem.train.reproducibility_sd[i],
                there.jacobian[j] * problem.part.train.reproducibility_sd[j],
            )
        else:
            assert not here.jacobian[i].any()
    np.testing.assert_array_equal(here.train, problem.fitted_z(model(4)))
    back = carried(here, problem, problem.part)
    common = [i for i, key in enumerate(problem.part.train.keys) if key in set(problem.train.keys)]
    np.testing.assert_allclose(back.jacobian[common], there.jacobian[common])


def test_they_are_nearly_those_of_the_whole_field(problem):
    begun = start(problem, model(4))
    own = derive(problem, begun).jacobian
    there = derive(problem.part, start(problem.part, model(4)))
    other = carried(there, problem.part, problem).jacobian
    size = np.linalg.norm(own, axis=0)
    plain = size > 200.0  # of what moves little, each draws the luck of its own pixels
    assert plain.sum() >= 5
    likeness = np.sum(own * other, axis=0) / size / np.linalg.norm(other, axis=0)
    assert np.all(likeness[plain] > 0.9)


@pytest.mark.long
@pytest.mark.parametrize(
    "seed", [5, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (6, 7))]
)
def test_a_fit_from_the_part_ends_where_one_of_the_whole_does(problem, simulated, seed):
    begun = model(seed)
    free = free_parameters(begun)
    off = with_values(begun, free, positions(begun, free) + [0.2 * k.log for k in free])
    alone = converge(replace(problem, part=None), start(problem, off, free))
    simulated.clear()
    ended = fitted(problem, off)
    first = simulated.index(True)
    assert not any(simulated[:first])  # the part, then the whole, in a step or a few
    assert all(simulated[first:])
    assert len(simulated) - first < 16  # a round with derivatives of the part, and one to see
    ended = converge(problem, ended)
    # nearer than the truth is chance: the valley is as flat as two simulated sensors differ
    least = max(alone.loss, start(problem, begun, free).loss)
    assert ended.loss < least + 0.05 * len(problem.train.keys)


def test_what_lies_somewhere_is_fitted_to_the_whole_at_once(problem, simulated):
    shaded = model(4, amp_glow={"amplitude": 5.0})
    assert part_for(problem, shaded) is None
    assert part_for(problem, model(4)) is problem.part
    asked = []
    fitted(problem, shaded, lambda on, state: asked.append(on) or state)
    (on,) = asked
    assert on.plan is problem.plan
    assert all(simulated)


def test_without_a_part_the_fit_is_of_the_whole_alone(problem):
    asked = []
    fitted(replace(problem, part=None), model(4), lambda on, state: asked.append(state) or state)
    assert np.isnan(asked[0].jacobian).all()


def test_the_papers_pedestal_is_chosen_on_the_part(problem, simulated):
    chosen = paper_start(problem)
    assert simulated == [False] * 4
    tried = paper_models(moments(Readings(problem.measured[0]), None))
    assert chosen.without("quantization") in tried


def test_derivatives_of_what_is_everywhere_are_taken_on_the_part(problem, simulated):
    state = start(problem, model(1))
    assert np.isnan(state.jacobian).all()
    blank = replace(state, jacobian=np.zeros_like(state.jacobian))
    simulated.clear()
    found = derive(problem, blank, anew=True)
    assert found.model is state.model
    np.testing.assert_array_equal(found.train, state.train)
    assert not any(simulated)
    near = derive(problem.part, carried(blank, problem, problem.part), anew=True)
    np.testing.assert_array_equal(found.jacobian, carried(near, problem.part, problem).jacobian)


def test_derivatives_of_what_has_a_place_are_taken_on_the_whole(problem, simulated):
    placed = model(1, amp_glow={"amplitude": 5.0})
    state = start(problem, placed)
    simulated.clear()
    found = derive(problem, state)
    of_glow = [k.effect == "amp_glow" for k in state.free]
    groups = {k.group for k in state.free}
    assert sum(simulated) >= len({k.group for k in state.free if k.effect == "amp_glow"})
    assert simulated.count(False) >= len({g for g in groups if "amp_glow" not in g})
    alone = derive(replace(problem, part=None), state)
    np.testing.assert_array_equal(found.jacobian[:, of_glow], alone.jacobian[:, of_glow])


@pytest.mark.parametrize(
    ("kept", "hopeless", "rounds"),
    [(0.9999, np.inf, 2), (0.9, np.inf, 6), (0.9, 5.0, 6), (0.9, 1.0, 1)],
)
def test_a_fit_ends_where_a_round_gains_nothing_a_hopeless_one_after_the_first(
    kept, hopeless, rounds, monkeypatch
):
    made = []

    def lower(_bench, state, *_, **__):
        made.append(state)
        return replace(state, train=kept**0.5 * state.train)

    monkeypatch.setattr(from_part, "minimise", lower)
    monkeypatch.setattr(from_part, "derive", lambda _bench, state, **_: state)
    begun = State(None, [], np.full(1000, 2.0), lambda: np.zeros(1), np.zeros((1000, 0)))
    from_part.converge(None, begun, hopeless=hopeless)
    assert len(made) == rounds


@pytest.mark.parametrize("beside", [{}, {"row_fpn": {}}, {"column_taps": {}}, {"amp_glow": {}}])
def test_what_lies_everywhere_changes_the_part_as_the_whole(problem, beside):
    before = model(4, **beside)
    after = before.with_effect(KNOWN["read_noise"](sigma=3.3))
    part = Changes.of(problem, before, Placing.EVERYWHERE)
    whole = Changes.of(problem, before, Placing.SOMEWHERE)
    assert part.problem is problem.part
    assert whole.problem is problem
    (near,), (true,) = part.by([after]), whole.by([after])
    assert np.linalg.norm(near - true) < 0.2 * np.linalg.norm(true)


def test_what_lies_at_places_of_its_own_is_simulated_on_the_whole(problem):
    placed = model(4, column_taps={})
    assert not Changes.of(problem, placed, Placing.ANYWHERE).problem.even
    assert not Changes.of(problem, model(4), Placing.SOMEWHERE).problem.even
    assert Changes.of(problem, model(4), Placing.ANYWHERE).problem.even
