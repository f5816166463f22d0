"""Forward, backward and swap steps."""

import math
from dataclasses import replace

import numpy as np
import pytest
from drawn_sensor import problem_with, with_random_codes

from dnanalyze.comparator.predictive_check import FittedModel, error_of
from dnanalyze.diagnosis import stepwise
from dnanalyze.diagnosis.baseline import far_off
from dnanalyze.diagnosis.gains import trial_by_prediction
from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.diagnosis.results import Step
from dnanalyze.diagnosis.search_path import Path, SearchLimits
from dnanalyze.diagnosis.selection import EVIDENCE_DECISIVE, EVIDENCE_NULL, EVIDENCE_ODDS_10, Trial
from dnanalyze.diagnosis.stepwise import Search, choose, lower_without, reduced, supported, swapped
from dnanalyze.fitting import design as designs
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.from_part import converge
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.fitting.state import carried, start
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.fitting.yardstick import fitted_by_design
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.amp_glow import AmpGlow
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, BASELINE, built_in
from dnanalyze.model.simulate import simulate

pytestmark = pytest.mark.long

ROWS = {"row_fpn": RowFpn, "row_noise": RowNoise}


@pytest.fixture(scope="module")
def problem():
    return problem_with({"row_fpn": "strong"})


def fitted(problem, *effects):
    model = baseline_model(problem)
    for effect in effects:
        model = model.with_effect(effect)
    return converge(problem, start(problem, model))


@pytest.fixture(scope="module")
def null(problem):
    return FittedModel(problem, fitted(problem))


def trial(null, gain, state=None, overdispersion=1.0):
    return Trial("row_fpn", state or null.state, gain, gain, 0.5 * null.error, 0.5, overdispersion)


def test_the_hidden_effect_is_chosen_first(null):
    tried, best = choose(null, ROWS)
    assert best is tried[0]
    assert best.effect == "row_fpn"
    assert {t.effect for t in tried} <= set(ROWS)


def test_nothing_is_chosen_where_nothing_is_missing(problem):
    _, best = choose(FittedModel(problem, fitted(problem, RowFpn(1.0))), {"row_noise": RowNoise})
    assert best is None


def test_the_evidence_asked_for_goes_by_the_residual_that_a_candidate_corrects(null):
    """Replicates reject the model; a candidate that corrects that needs less evidence."""
    right = fitted(null.problem, RowFpn(1.0))
    assert null.corrects(null.left[:3], right)
    assert supported(null, []) is None
    for state, least in ((right, EVIDENCE_NULL), (null.state, EVIDENCE_DECISIVE)):
        for overdispersion in (1.0, 3.0):
            enough, little = (
                trial(null, f * least * overdispersion, state, overdispersion) for f in (1.01, 0.99)
            )
            assert supported(null, [enough]) is enough
            assert supported(null, [little]) is None
    done = FittedModel(null.problem, right)
    assert done.left == []
    assert supported(done, [trial(done, 0.99 * EVIDENCE_ODDS_10)]) is None
    assert supported(done, [trial(done, 1.01 * EVIDENCE_ODDS_10)]) is not None


@pytest.mark.parametrize("shared", [False, True])
def test_behind_a_candidate_that_raises_the_error_only_one_of_other_statistics_is_supported(
    null, shared
):
    plain = trial(null, 2.0 * EVIDENCE_DECISIVE, fitted(null.problem, RowFpn(1.0)))
    one, other = np.array([9.0, 0.0]), np.array([0.0, 9.0])
    first = replace(plain, error_fall=-0.1, falls=one)
    second = replace(plain, falls=one if shared else other)
    assert supported(null, [first, second]) is (None if shared else second)
    # what gains on one half alone is in nobody's place
    assert supported(null, [replace(first, fitted_gain=1.0), second]) is second


def test_a_superfluous_effect_is_dropped_and_a_needed_one_kept(problem):
    state, gone = reduced(problem, fitted(problem, RowFpn(1.0), RowNoise(1e-3)))
    assert gone == ["row_noise"]
    assert state.model.get("row_fpn") is not None
    again, gone = reduced(problem, state)
    assert gone == []
    assert again is state


def test_a_confounded_effect_gives_way_to_the_hidden_one(problem):
    state = fitted(problem, RowNoise(0.5))
    found = swapped(problem, state, ["row_noise"], {"row_fpn": RowFpn}, lambda _: None)
    assert found is not None
    gone, without, comes = found
    assert (gone, comes.effect) == ("row_noise", "row_fpn")
    assert without.state.model.get("row_noise") is None
    null = FittedModel.of(problem, state)
    assert comes.error < null.error
    by_make = trial_by_prediction(null, comes)
    assert (comes.gain, comes.fitted_gain) == pytest.approx((by_make.gain, by_make.fitted_gain))
    assert swapped(problem, state, [], {"row_fpn": RowFpn}, lambda _: None) is None


def test_the_right_effect_stays(problem):
    state = fitted(problem, RowFpn(1.0))
    assert swapped(problem, state, ["row_fpn"], {"row_noise": RowNoise}, lambda _: None) is None


def test_an_effect_at_a_wrong_place_is_guessed_again():
    problem = problem_with({"amp_glow": {"level": "strong", "corner": [1, 1]}})
    state = fitted(problem, AmpGlow(1.0, 0.1, location="n"))
    found = swapped(problem, state, ["amp_glow"], {}, lambda _: None)
    assert found is not None
    assert found[2].state.model.get("amp_glow").location == "se"
    assert found[2].error < 0.5 * error_of(problem, state)


def test_a_search_states_its_steps_and_keeps_complete_models(problem):
    told, kept, trying = [], [], []
    known = {**ROWS, "column_fpn": built_in()["column_fpn"]}
    search = Search(
        problem, known, on_step=told.append, on_path=kept.append, on_progress=trying.append
    )
    path = search.run(fitted(problem))
    assert [s.added for s in path.steps] == [None, "row_fpn"]
    # the last step is told before its last fit
    assert [(s.added, s.confidence) for s in told] == [(s.added, s.confidence) for s in path.steps]
    assert path.error == pytest.approx(told[-1].error, rel=0.25)
    assert kept[-1].state.model == path.state.model
    assert error_of(kept[-1].problem, kept[-1].state) == pytest.approx(path.error, rel=1e-12)
    assert path.error == path.steps[-1].error < path.steps[0].error
    assert path.best is None
    assert {"row_fpn", "row_noise"} <= set(trying)


def test_a_refused_effect_is_open_again_once_another_is_in_the_model(problem):
    state = fitted(problem)
    begun = Path(state, (Step(None, error_of(problem, state)),), refused=("row_noise",))
    search = Search(problem, {**ROWS, "column_fpn": built_in()["column_fpn"]})
    assert "row_noise" not in search._open(begun)
    path = search._tested(begun, FittedModel.of(problem, state))
    path = search._with(path, FittedModel.of(problem, state), path.best, math.inf)
    assert path.steps[-1].added == "row_fpn"
    assert path.refused == ()
    assert "row_noise" in search._open(path)


def test_an_effect_that_is_not_beyond_doubt_is_compared_with_the_model_at_its_optimum(
    problem, null, monkeypatch
):
    """A refit with it moves all parameters, and gains what these had left to gain."""
    state = fitted(problem, RowFpn(1.0))
    noise = state.model.get("read_noise")
    begun = start(problem, state.model.with_effect(replace(noise, sigma=0.95 * noise.sigma)))
    found = replace(trial(null, 2.0 * EVIDENCE_ODDS_10), effect="row_noise")
    refits, compared = [], []

    def seen(beside, known):
        return beside.state.model.get("read_noise").sigma, set(known)

    def refitted(beside, known, *_):
        refits.append(seen(beside, known))
        return ["row_noise"], [found]

    def chosen(beside, known, *_, **__):
        compared.append(seen(beside, known))
        return [], None

    monkeypatch.setattr("dnanalyze.diagnosis.stepwise.refitted_once", refitted)
    monkeypatch.setattr("dnanalyze.diagnosis.stepwise.choose", chosen)
    steps = (Step(None, 99.0), Step("row_fpn", error_of(problem, begun)))
    known = {n: built_in()[n] for n in ("row_noise", "column_noise")}
    limits = SearchLimits(until_error=0.0)
    path = Search(problem, known, limits=limits)._searched(Path(begun, steps, converged=False))
    assert [s.added for s in path.steps] == [None, "row_fpn"]
    assert path.converged
    assert path.best is None
    assert refits == [(pytest.approx(0.95 * noise.sigma), set(known))]
    if compared:  # at its optimum the model is not adequate
        assert compared[0] == (pytest.approx(noise.sigma, rel=0.02), {"row_noise"})
    assert path.state.model.get("read_noise").sigma == pytest.approx(noise.sigma, rel=0.02)


def test_an_effect_has_no_evidence_of_a_minimum_that_is_as_low_without_it(problem, monkeypatch):
    """A fit ended in one of several minima; the refit with a candidate found a lower one."""
    right = fitted(problem, RowFpn(1.0))
    noise = right.model.get("read_noise")
    poor = start(problem, right.model.with_effect(replace(noise, sigma=0.8 * noise.sigma)))
    null = FittedModel.of(problem, poor)
    with_it = start(null.problem, right.model.with_effect(RowNoise(1e-3)))
    found = replace(trial(null, 9e9, with_it), effect="row_noise")
    lower = lower_without(null, found)
    assert lower.model.names == right.model.names
    assert lower.loss < 0.5 * null.state.loss
    assert lower_without(FittedModel.of(problem, right), found) is None
    assert lower_without(null, replace(found, effect=BASE)) is None

    asked = []

    def chosen(beside, known, *_, **__):
        asked.append(beside.state.model.get("read_noise").sigma)
        return ([found], found) if len(asked) == 1 else ([], None)

    monkeypatch.setattr("dnanalyze.diagnosis.stepwise.choose", chosen)
    steps = (Step(None, 99.0), Step("row_fpn", error_of(problem, poor)))
    path = Search(problem, {"row_noise": RowNoise})._searched(Path(poor, steps))
    assert [s.added for s in path.steps] == [None, "row_fpn"]
    assert path.error < steps[-1].error
    assert path.state.model.get("read_noise").sigma == pytest.approx(noise.sigma, rel=0.02)


def test_an_effect_that_raises_the_error_is_not_taken(problem):
    begun = Path(fitted(problem), (Step(None, 1e-3),))
    path = Search(problem, {"row_fpn": RowFpn})._searched(begun)
    assert path.refused == ("row_fpn",)
    assert path.steps == begun.steps
    assert path.state.model.get("row_fpn") is None


@pytest.fixture(scope="module")
def with_rows(problem):
    """A model with an effect, and its model error at its optimum."""
    state = fitted(problem, RowFpn())
    return state, Search(problem, ROWS)._error(fitted_by_design(problem, state, converge))


def test_an_effect_that_raises_the_error_at_the_optimum_is_no_step(problem, with_rows):
    state, error = with_rows
    model, told = state.model.without("row_fpn"), []
    steps = (Step(None, 0.97 * error, model=model), Step("row_fpn", 0.98 * error))
    search = Search(problem, ROWS, on_step=told.append)
    path = search._converged(Path(state, steps, converged=False))
    assert [s.added for s in path.steps] == [None]
    assert [s.added for s in told] == ["-row_fpn"]
    assert path.dropped == ("row_fpn",)
    assert path.state.model.get("row_fpn") is None
    assert path.converged
    assert path.error <= max(steps[0].error, search._error(path.state))


def test_an_exchange_is_compared_with_the_step_before_it(problem, with_rows):
    """The last fit raises the error that both of its steps have, by less than its scatter."""
    state, error = with_rows
    steps = (Step(None, 2.0 * error), *(Step(n, 0.97 * error) for n in ("-column_fpn", "row_fpn")))
    path = Search(problem, ROWS)._converged(Path(state, steps, converged=False))
    assert [s.added for s in path.steps] == [None, "-column_fpn", "row_fpn"]
    assert path.state.model.get("row_fpn") is not None
    assert path.error == pytest.approx(FittedModel.of(problem, path.state).error)
    assert path.steps[1].error == path.error > 0.97 * error


def test_an_exchange_that_raises_the_error_is_undone_whole(problem, with_rows):
    state, error = with_rows
    model, told = state.model.without("row_fpn"), []
    exchange = (Step(n, 0.98 * error) for n in ("-column_fpn", "row_fpn"))
    steps = (Step(None, 0.97 * error, model=model), *exchange)
    search = Search(problem, ROWS, on_step=told.append)
    path = search._converged(Path(state, steps, converged=False))
    assert [s.added for s in path.steps] == [None]
    assert [s.added for s in told] == ["-row_fpn", "column_fpn"]
    assert path.state.model.get("row_fpn") is None


def test_a_last_fit_with_which_the_error_rises_is_not_taken(problem, with_rows):
    state, error = with_rows
    steps = (Step(None, 2.0 * error), Step("row_fpn", 0.9 * error))
    begun = Path(state, steps, converged=False)
    path = Search(problem, ROWS)._converged(begun)
    assert path.state is state
    assert [s.error for s in path.steps] == [s.error for s in steps]
    assert path.converged


def test_a_search_ends_at_the_users_limits(problem):
    state = fitted(problem)
    most = Search(problem, ROWS, limits=SearchLimits(max_effects=0)).run(state)
    assert [s.added for s in most.steps] == [None]
    assert most.best.effect == "row_fpn"
    enough = Search(problem, ROWS, limits=SearchLimits(until_error=1e3)).run(state)
    assert enough.tried == ()
    assert enough.best is None


@pytest.fixture(scope="module")
def far():
    """Two effects of 20 times the read noise, in a field that has a part."""
    points = tuple(OperatingPoint(t, 0.1) for t in (25.0, 65.0))
    numbers = {
        "convolved_lognormal": {"mu": 3.0, "delta": 0.6, "sigma": 1e-6},
        "dark_shot_noise": {"dn_per_e": 0.5}, "read_noise": {"sigma": 2.0},
        "pixel_fpn": {"sigma": 1.0}, "quantization": {},
        "row_noise": {"sigma": 40.0}, "column_fpn": {"sigma": 40.0},
    }  # fmt: skip
    effects = tuple(built_in()[name](**own) for name, own in numbers.items())
    model = NoiseModel(effects, 500.0, points[0], seed=4)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(designs, "PART_FROM_PIXELS", 0)
        return fit_problem(design(simulate(model, (256, 256), [(p, 4) for p in points])))


def test_what_is_far_off_is_searched_on_a_part_and_confirmed_on_the_whole(far, monkeypatch):
    fields, simulated = [], FitProblem.several

    def several(self, models):
        fields.append((self.plan.windows, self.even))
        return simulated(self, models)

    monkeypatch.setattr(FitProblem, "several", several)
    known = {n: built_in()[n] for n in ("row_noise", "column_fpn", "row_fpn", "column_noise")}
    begun, told, kept = fitted(far), [], []
    assert far_off(carried(begun, far, far.part))
    path = Search(far, known, on_step=told.append, on_path=kept.append).run(begun)
    assert {s.added for s in path.steps} == {None, "row_noise", "column_fpn"}
    assert (far.part.plan.windows, False) in fields  # a fit of the whole begins on an even part
    for state in (path.state, *(k.state for k in kept)):
        assert len(state.train) == len(far.train.keys)
    assert path.error == pytest.approx(FittedModel.of(far, path.state).error)
    assert path.error < 1.3
    # both are stated as the part has them, with the error that `compare` states for them
    both = next(k.state.model for k in kept if len(k.steps) == 3)
    assert told[2].error == pytest.approx(FittedModel.of(far, start(far, both)).error)
    assert told[1].confidence > 0.9


def test_a_model_that_is_far_off_is_not_brought_to_its_optimum_first(far, problem, monkeypatch):
    """The next effect moves all that is fitted there: candidates are compared where it is."""
    state = fitted(far)
    for name in BASELINE:
        state = start(far, state.model.without(name))
    begun, path = Search(far, {})._on_part(state, ())
    assert [s.added for s in begun.steps] == [None]
    assert {s.added for s in path.steps} == {None, *BASELINE}
    assert far_off(path.state)
    assert not path.converged

    class Compared(Exception):
        """Of the candidates at their optima."""

    class Refitted(Exception):
        """Of one refit of each."""

    def raised(kind):
        def called(*_, **__):
            raise kind

        return called

    monkeypatch.setattr("dnanalyze.diagnosis.stepwise.choose", raised(Compared))
    monkeypatch.setattr("dnanalyze.diagnosis.stepwise.refitted_once", raised(Refitted))
    with pytest.raises(Compared):
        Search(far, {})._searched(path)
    near = Path(fitted(problem, RowFpn(1.0)), path.steps, converged=False)
    with pytest.raises(Refitted):
        Search(problem, {})._searched(near)
    with pytest.raises(Compared):
        Search(problem, {})._searched(replace(near, converged=True))


def test_a_search_without_time_keeps_the_start_with_its_error_on_the_whole_field(far):
    begun, kept = fitted(far), []
    timed = far.within(TimeLimit.after(1e-9))
    with pytest.raises(TimeUp):
        Search(timed, {"row_noise": built_in()["row_noise"]}, on_path=kept.append).run(begun)
    (path,) = kept
    assert [s.added for s in path.steps] == [None]
    assert path.error == pytest.approx(FittedModel.of(far, begun).error)


def test_no_effect_is_taken_out_where_the_model_error_would_rise(far, monkeypatch):
    without = fitted(far)  # both effects are missing
    monkeypatch.setattr(stepwise, "reduced", lambda problem, state: (without, ["row_noise"]))
    error = FittedModel.of(far, without).error
    for before, rises in ((0.9 * error, True), (1.1 * error, False)):
        path = Path(without, (Step(None, before), Step("row_noise", before)))
        left = Search(far, {})._reduced(path)
        added = [s.added for s in left.steps]
        assert added == [None, "row_noise", *([] if rises else ["-row_noise"])]


def test_effects_of_different_statistics_are_added_together(far):
    """Rows and columns, 20 times the read noise each: one test of the candidates, two steps."""
    known = {n: built_in()[n] for n in ("row_noise", "column_fpn")}
    tested: list[str] = []
    search = Search(far, known, on_progress=tested.append)
    state = fitted(far)
    null = FittedModel.of(far, state)
    begun = search._tested(Path(state, (Step(None, null.error),)), null)
    tested.clear()
    path = search._with(begun, null, begun.best, math.inf)
    assert {s.added for s in path.steps} == {None, *known}
    assert tested == []
    errors = [s.error for s in path.steps]
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2]
    assert errors[2] == pytest.approx(FittedModel.of(far, path.state).error)
    assert [set(s.model.names) - set(state.model.names) for s in path.steps[1:]] == [
        {path.steps[1].added}, set(known),
    ]  # fmt: skip
    assert all(s.confidence > 0.9 for s in path.steps[1:])
    assert path.open == ()
    one = replace(search, limits=SearchLimits(max_effects=1))
    assert len(one._with(begun, null, begun.best, math.inf).steps) == 2


def test_where_effects_together_raise_the_error_the_first_is_added_alone(far, monkeypatch):
    known = {n: built_in()[n] for n in ("row_noise", "column_fpn")}
    search, state = Search(far, known), fitted(far)
    null = FittedModel.of(far, state)
    begun = search._tested(Path(state, (Step(None, null.error),)), null)
    errors, asked = Search._errors, []

    def rising(self, states):
        asked.append(len(states))
        return errors(self, states) if len(states) == 1 else [1.0, 2.0]

    monkeypatch.setattr(Search, "_errors", rising)
    path = search._with(begun, null, begun.best, math.inf)
    assert asked == [2, 1]
    assert [s.added for s in path.steps[1:]] == [begun.best.effect]


def test_an_effect_that_is_a_simpler_one_at_its_optimum_is_not_taken(far, monkeypatch):
    known = {n: built_in()[n] for n in ("row_noise", "column_fpn")}
    search, state = Search(far, known), fitted(far)
    null = FittedModel.of(far, state)
    begun = search._tested(Path(state, (Step(None, null.error),)), null)
    monkeypatch.setattr(known[begun.best.effect], "shows_in", lambda *_: False)
    path = search._with(begun, null, begun.best, math.inf)
    assert path.refused == (begun.best.effect,)
    assert [s.added for s in path.steps] == [None]


def test_the_whole_field_begins_with_the_candidates_of_the_part(far):
    known = {n: built_in()[n] for n in ("rts", "persistence", "row_noise", "column_fpn")}
    tested: list[str] = []
    search = Search(far, known, limits=SearchLimits(max_effects=0), on_progress=tested.append)
    begun, path = search._on_part(state := fitted(far), ())
    assert {"row_noise", "column_fpn"} <= set(path.open) < set(known)
    assert path.state is state
    tested.clear()
    assert search._searched(path).steps == begun.steps
    assert set(tested) == set(path.open)  # one of them is significant: no other is tested


def test_nothing_is_taken_with_which_the_model_error_would_rise(problem, null):
    """An exchange is not made, and the spread law is refused until the model is another."""
    search = Search(problem, ROWS)
    found = trial(null, 1000.0, fitted(problem, RowFpn(1.0)))
    best, worst = (Path(null.state, (Step(None, error),)) for error in (0.0, math.inf))
    assert search._exchanged(best, "row_noise", null, found) is None
    taken = search._exchanged(worst, "row_noise", null, found)
    assert [s.added for s in taken.steps] == [None, "-row_noise", "row_fpn"]
    assert taken.steps[1].error == taken.steps[2].error  # the model between them is none to show
    law = replace(trial(null, 1000.0), effect=BASE)
    assert search._with_law(best, null, law, best.error).refused == (BASE,)
    assert search._with_law(worst, null, law, worst.error).refused == ()


def test_codes_of_random_widths_are_all_that_a_search_adds_and_stay():
    """By the scatter of such sensors any model is near; that without them has another."""
    found = refine_on(with_random_codes(4.0, 106), classifier=False)
    codes = found.model.get("missing_codes")
    assert found.verdict == "adequate"
    assert set(found.model.names) == {BASE, *BASELINE, "missing_codes"}
    assert codes.kind == "random"
    assert codes.sigma == pytest.approx(0.5, rel=0.5)
