"""Refits of candidates."""

import math
from dataclasses import dataclass, replace

import pytest
from drawn_sensor import problem_with, with_random_codes

from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.diagnosis.baseline import baseline_fitted, baseline_start
from dnanalyze.diagnosis.candidates import (
    GAIN_OVER_PROMISE,
    WEAKER,
    _at_their_optima,
    _begun,
    _refits,
    candidates_of,
    refitted,
    refitted_beside,
    refitted_once,
    trials,
)
from dnanalyze.diagnosis.forms import in_best_form
from dnanalyze.diagnosis.gains import trial_by_prediction, trial_of
from dnanalyze.diagnosis.score_test import Guess, Least, score_tests
from dnanalyze.diagnosis.selection import (
    COMPETING_SHARE,
    EVIDENCE_DECISIVE,
    EVIDENCE_NULL,
    EVIDENCE_ODDS_10,
    LEAST_GAIN,
    Trial,
    significant,
)
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.state import deviance
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Placing
from dnanalyze.model.effects.column_fpn import ColumnFpn
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, built_in
from dnanalyze.model.simulate import simulate
from dnanalyze.progress import ignored

pytestmark = pytest.mark.long

UPPER, LOWER = Window(0, 50, 0, 80), Window(50, 100, 0, 80)
ROWS = ("row_fpn", "row_noise", "column_fpn")


@pytest.fixture(scope="module")
def null() -> FittedModel:
    """A sensor with row noise and column offsets, and its baseline model."""
    problem = problem_with({"row_noise": "strong", "column_fpn": "strong"})
    return FittedModel(problem, baseline_fitted(problem, baseline_start(problem)))


def of(*names):
    return {name: effect for name, effect in built_in().items() if name in names}


def guessed(null, name):
    found = score_tests(null.problem, null.state, of(name))
    return {name: [g for g in found if g.effect == name]}


def test_both_hidden_effects_are_refitted_and_significant(null):
    steps, told = [], []
    found = trials(null, of(*ROWS), told.append, steps.append)
    so_far = steps[-1]
    assert [len(s.trials) for s in steps] == list(range(len(steps)))
    named = {t.effect: t for t in found}
    assert {found[0].effect, found[1].effect} == {"row_noise", "column_fpn"}
    for name in ("row_noise", "column_fpn"):
        assert significant(named[name])
        assert named[name].state.loss < null.state.loss
        assert named[name].error < null.error
    assert set(so_far.screened) <= set(ROWS)
    assert {t.effect for t in so_far.trials} == set(named)
    assert set(named) <= set(told)


def test_what_is_decisive_beside_another_effect_stays_a_candidate(null):
    """Column offsets beside row noise; with both in the model, row offsets are nothing."""
    found = {t.effect: t for t in trials(null, of(*ROWS))}
    assert {"row_noise", "column_fpn"} <= set(found)
    here = FittedModel(null.problem, found["row_noise"].state)
    column, *_ = refitted_beside(here, list(found.values()))
    assert column.effect == "column_fpn"
    assert {"row_noise", "column_fpn"} <= set(column.state.model.names)
    assert column.state.loss < min(t.state.loss for t in found.values())
    assert column.evidence > EVIDENCE_DECISIVE * column.overdispersion
    done = FittedModel(null.problem, column.state)
    assert refitted_beside(done, list(found.values())) == []


def test_filters_are_left_to_their_tests(null):
    (column,) = (t for t in trials(null, of("column_fpn")) if t.effect == "column_fpn")
    assert refitted_beside(null, [column])
    assert refitted_beside(null, [replace(column, effect="dpc")]) == []


@pytest.mark.parametrize("times", [1.0, 30.0])
def test_a_refit_begins_at_the_strength_that_the_statistics_want(null, times):
    """The wanted sigma is 1; a guess far beyond it comes back, one near it stays."""
    own = next(t.state.model.get("column_fpn") for t in trials(null, of("column_fpn")))
    guess = Guess("column_fpn", null.state.model.with_effect(ColumnFpn(times * own.sigma)), 1.0)
    ended = refitted(null.problem, guess, null.state)
    assert ended.loss < null.state.loss
    assert ended.model.get("column_fpn").sigma == pytest.approx(own.sigma, rel=0.15)


@pytest.mark.parametrize(("losses", "steps"), [((5.0, 6.0), 0), ((5.0, 4.0, 6.0), 1)])
def test_a_refit_does_not_begin_at_a_strength_that_explains_less(null, losses, steps, monkeypatch):
    """Of the line of change the statistics want a tenth, whatever the strength."""
    made = iter([Least(loss, 0.1) for loss in losses])
    monkeypatch.setattr("dnanalyze.diagnosis.candidates.along", lambda *_: next(made))
    guess = Guess("column_fpn", null.state.model.with_effect(ColumnFpn(30.0)), 1.0)
    begun = _begun(null.problem, guess, null.state).model.get("column_fpn").sigma
    assert begun == pytest.approx(30.0 * WEAKER**steps, rel=1e-3)


def test_plain_cases_are_settled_by_one_refit_on_a_part_of_what_is_everywhere(null, monkeypatch):
    names, found = refitted_once(null, of(*ROWS))
    assert {t.effect for t in found} <= set(names) <= set(ROWS)
    assert [t.evidence for t in found] == sorted((t.evidence for t in found), reverse=True)
    assert significant(found[0])
    assert refitted_once(null, of(*ROWS), on_part=True)[1]
    # the largest promise is that of an effect with a place, which a part does not settle
    monkeypatch.setattr(ColumnFpn, "placing", Placing.SOMEWHERE)
    assert refitted_once(null, of("column_fpn"), on_part=True) == (["column_fpn"], [])
    (placed,) = refitted_once(null, of("column_fpn"))[1]
    assert placed.effect == "column_fpn"


def test_a_filter_that_the_frames_do_not_show_is_not_settled_by_its_refit(null, monkeypatch):
    monkeypatch.setattr("dnanalyze.diagnosis.candidates.FILTERS", ("column_fpn",))
    monkeypatch.setattr("dnanalyze.diagnosis.candidates.denied", lambda *_: True)
    (found,) = refitted_once(null, of("column_fpn"))[1]
    assert found.denied
    assert not significant(found)


def test_the_gain_is_that_of_both_halves_in_units_of_the_scatter(null, monkeypatch):
    monkeypatch.setattr(
        "dnanalyze.diagnosis.candidates.EVIDENCE_DECISIVE", math.inf
    )  # no sensor decides alone
    (found,) = trials(null, of("column_fpn"))
    again = trial_by_prediction(null, found)
    assert (again.gain, again.fitted_gain) == (found.gain, found.fitted_gain)
    again = trial_of(null, "column_fpn", found.state)
    assert again.falls.sum() == pytest.approx(again.gain + again.fitted_gain)
    assert trial_of(null, "column_fpn", null.state).evidence == 0.0


def test_candidates_are_not_in_the_model_nor_excluded(null):
    known = of("read_noise", *ROWS)
    assert set(candidates_of(null.state, known, [BASE, "row_fpn"])) == {"row_noise", "column_fpn"}


def test_where_nothing_is_left_a_refit_begins_only_if_it_may_gain_what_is_asked_for(null):
    def refitted_names(left, promise):
        known = replace(null)
        known.__dict__["left"] = left  # as the replicates would have it
        model = null.state.model.with_effect(ColumnFpn(1.0))
        guesses = {"column_fpn": [Guess("column_fpn", model, promise)]}
        return [t.effect for t in _refits(known, guesses, ignored)]

    for left, least in (([], EVIDENCE_ODDS_10), (["column_outliers"], EVIDENCE_NULL)):
        enough = max(least / GAIN_OVER_PROMISE, LEAST_GAIN)
        assert refitted_names(left, 1.01 * enough) == ["column_fpn"]
        assert refitted_names(left, 0.99 * enough) == []


@pytest.mark.parametrize("named", [True, False])
def test_only_a_refit_that_can_be_named_rules_out_what_may_gain_less(null, named, monkeypatch):
    """The model error rises with the first where it cannot be named."""
    of_null = trial_of(null, "column_fpn", null.state)

    def refitted_to(beside, name, after):
        return replace(
            of_null, effect=name, state=after, gain=500.0, fitted_gain=500.0,
            error_fall=0.1 if named else -0.1,
        )  # fmt: skip

    monkeypatch.setattr("dnanalyze.diagnosis.candidates.trial_of", refitted_to)
    model = null.state.model.with_effect(ColumnFpn(1.0))
    first = Guess("column_fpn", model, 200.0)
    fallen = replace(null.state, train=0.5 * null.state.train)
    monkeypatch.setattr("dnanalyze.diagnosis.candidates._refitted_from", lambda *_: fallen)
    gained = null.state.loss - fallen.loss
    reach = max(GAIN_OVER_PROMISE, gained / first.promise)
    second = Guess("row_noise", model, 0.9 * COMPETING_SHARE * gained / reach)
    guesses = {g.effect: [g] for g in (first, second)}
    assert second.promise > EVIDENCE_NULL
    names = [t.effect for t in _refits(null, guesses, ignored)]
    assert names == (["column_fpn"] if named else ["column_fpn", "row_noise"])


def test_candidates_are_fitted_on_although_one_gains_more_on_the_other_half_alone(
    null, monkeypatch
):
    right = next(t for t in _refits(null, guessed(null, "column_fpn"), ignored))
    unseen = replace(right, effect="row_fpn", fitted_gain=1.0, gain=10.0 * right.gain)
    fitted_on = []

    def ended(problem, begun, *_, **__):
        fitted_on.append(begun.model.names)
        return begun

    where = "dnanalyze.diagnosis.candidates"
    monkeypatch.setattr(f"{where}.minimise", ended)
    monkeypatch.setattr(f"{where}.in_best_form", lambda problem, found: found.state)
    monkeypatch.setattr(f"{where}.significant", lambda *_: False)
    _at_their_optima(null, [unseen], {"row_fpn": 1.0})
    assert not fitted_on
    _at_their_optima(null, [unseen, right], {"column_fpn": 1.0, "row_fpn": 1.0})
    assert fitted_on


def test_no_candidates_no_trials(null):
    assert trials(null, {}) == []


@pytest.fixture(scope="module")
def alike() -> FittedModel:
    """A sensor with a few noisy pixels: telegraph noise that switches at once is nearly alike."""
    known = built_in()
    effects = (
        known["convolved_lognormal"](mu=1.0, delta=0.5),
        known["dark_shot_noise"](0.5),
        known["read_noise"](2.0),
        known["noisy_pixels"](0.005, 12.0),
        known["pixel_fpn"](0.5),
        known["quantization"](12),
    )
    points = [(OperatingPoint(celsius, 0.1), 4) for celsius in (25.0, 45.0, 65.0)]
    frames = simulate(NoiseModel(effects, pedestal=100.0, seed=4), (128, 128), points, "made")
    problem = fit_problem(design(frames))
    return FittedModel(problem, baseline_fitted(problem, baseline_start(problem)))


@pytest.fixture(scope="module")
def competing(alike) -> list[Trial]:
    found = trials(alike, of("noisy_pixels", "rts"))
    assert len(found) == 2
    return found


def test_of_the_leader_no_other_form_is_better(alike, competing):
    """Not by what would be evidence; that it is no better at all depends on where fits rest."""
    leader = competing[0]
    assert leader.effect == "noisy_pixels"
    again = in_best_form(alike.problem, leader)
    was, now = (deviance(s.train).sum() + deviance(s.test).sum() for s in (leader.state, again))
    assert (was - now) / 2.0 < EVIDENCE_NULL


def test_competitors_are_judged_by_the_sensors_of_their_make(alike, competing):
    for t in competing:
        again = trial_by_prediction(alike, trial_of(alike, t.effect, t.state))
        assert (t.gain, t.fitted_gain) == pytest.approx((again.gain, again.fitted_gain))


@pytest.mark.parametrize(("noise", "seed"), [(2.0, 107), (4.0, 106)])
def test_codes_of_random_widths_are_told_by_sensors_of_their_design(noise, seed):
    """A refit of one simulated sensor finds a period in them, with less evidence."""
    problem = fit_problem(design(with_random_codes(noise, seed)))
    null = FittedModel.of(problem, baseline_fitted(problem, baseline_start(problem)))
    (found,) = trials(null, of("missing_codes"))
    effect = found.state.model.get("missing_codes")
    assert found.by_design
    assert significant(found, EVIDENCE_DECISIVE)
    assert effect.kind == "random"
    assert effect.sigma == pytest.approx(0.5, rel=0.5)


def test_an_effect_that_the_captures_do_not_show_as_such_is_no_candidate(null):
    @dataclass(frozen=True)
    class Unseen(ColumnFpn):
        def shows_in(self, frames, pixels):
            return frames > 4

    @dataclass(frozen=True)
    class Seen(ColumnFpn):
        def shows_in(self, frames, pixels):
            return (frames, pixels) == (4, 128 * 128)

    for kind in (ColumnFpn, Seen):
        assert [t.effect for t in trials(null, {"column_fpn": kind})] == ["column_fpn"]
        assert [t.effect for t in refitted_once(null, {"column_fpn": kind})[1]] == ["column_fpn"]
    assert trials(null, {"column_fpn": Unseen}) == []
    assert refitted_once(null, {"column_fpn": Unseen}) == (["column_fpn"], [])
