"""What is simulated of a candidate before any refit."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from dnanalyze.diagnosis.score_test import (
    LONGEST,
    along,
    informative,
    much_left,
    restricted,
    score_tests,
)
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.from_part import converge
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.state import State, deviance, start
from dnanalyze.fitting.ties import SessionLevels
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import HALF_THE_VARIANCE, Effect
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate

KNOWN = built_in()
POINTS = [OperatingPoint(t, 0.1, 1.0) for t in (25.0, 65.0)]


def sensor(*more):
    """A sensor of dark current with shot noise, and more."""
    effects = (
        KNOWN["convolved_lognormal"](mu=TableLaw(tuple(POINTS), (1.0, 4.0)), delta=0.3, sigma=1e-6),
        KNOWN["dark_shot_noise"](dn_per_e=0.5),
        *more,
    )
    model = NoiseModel(effects, 100.0, POINTS[0], seed=5)
    return fit_problem(design(simulate(model, (128, 128), [(p, 6) for p in POINTS])))


def baseline(problem):
    """The baseline model, fitted."""
    model = baseline_model(problem)
    return converge(problem, start(problem, model))


@pytest.fixture(scope="module")
def problem():
    """A sensor whose read noise has heavy tails."""
    return sensor(
        KNOWN["heavy_tailed_read_noise"](sigma=3.0, tail=-0.2),
        KNOWN["pixel_fpn"](sigma=1.0),
        KNOWN["quantization"](),
    )


@pytest.fixture(scope="module")
def state(problem):
    return baseline(problem)


def test_the_hidden_effect_promises_most_and_no_more_than_the_loss(problem, state):
    known = {n: KNOWN[n] for n in ("heavy_tailed_read_noise", "row_noise", "column_fpn", "rts")}
    seen = score_tests(problem, state, known)
    assert seen[0].effect == "heavy_tailed_read_noise"
    promises = [g.promise for g in seen]
    assert promises == sorted(promises, reverse=True)
    assert promises[0] <= state.loss
    for guess in seen:
        assert guess.model.get(guess.effect) is not None


def test_a_guess_is_simulated_beside_parameters_that_its_absence_has_not_biased(problem, state):
    name = "heavy_tailed_read_noise"
    seen = score_tests(problem, state, {name: KNOWN[name]})
    spreads = {g.model.get("read_noise").spread for g in seen}
    biased = state.model.get("read_noise").spread
    assert biased > 0.0
    # the fit without it took the tails for noise that differs by pixel
    (spread,) = spreads
    assert spread == pytest.approx(HALF_THE_VARIANCE * biased)


def test_the_clock_is_looked_at_before_each_effect(problem, state):
    """Initial values that take long are not begun after the end."""
    asked = []

    class Slow(KNOWN["row_noise"]):
        @classmethod
        def guess(cls, clues):
            asked.append(cls.name)
            return []

    with pytest.raises(TimeUp):
        score_tests(problem.within(TimeLimit(0.0)), state, {"slow": Slow})
    assert asked == []


def test_an_effect_that_moves_nothing_promises_nothing(problem, state):
    class Still(Effect):
        name = "still"

        def apply(self, signal, site):
            return signal

    (seen,) = score_tests(problem, state, {"still": Still})
    assert seen.promise == pytest.approx(0.0, abs=1e-6)


def test_a_guess_at_the_wrong_scale_promises_as_much(problem, state):
    """The score test goes along the line through the guess, not to the guess itself."""

    class Weak(KNOWN["row_noise"]):
        @classmethod
        def guess(cls, clues):
            return [cls(0.5), cls(0.7)]

    seen = score_tests(problem, state, {"row_noise": Weak})
    weak, strong = sorted(seen, key=lambda g: g.model.get("row_noise").sigma)
    assert abs(weak.promise - strong.promise) < 0.05 * state.loss


def test_an_effect_without_a_strength_promises_what_it_brings_as_it_is(problem, state):
    """A hundredth of a filter is none: its guess must be near by itself."""

    class Marks(Effect):
        """A checkerboard of a size that is no parameter."""

        name = "marks"
        size: ClassVar[float] = 0.0

        def apply(self, signal, site):
            y, x = np.indices(signal.shape[-2:])
            return signal + self.size * np.float32((x + y) % 2)

        @classmethod
        def guess(cls, clues):
            return [cls()]

    promise = {}
    for size in (0.02, 40.0):
        known = {"marks": type("Sized", (Marks,), {"size": size})}
        (promise[size],) = (g.promise for g in score_tests(problem, state, known))
    assert promise[40.0] < -state.loss < promise[0.02]


def test_the_promise_is_near_what_a_refit_brings():
    problem = sensor(
        KNOWN["read_noise"](sigma=3.0),
        KNOWN["pixel_fpn"](sigma=1.0),
        KNOWN["quantization"](),
        KNOWN["row_noise"](2.0),
    )
    state = baseline(problem)
    first = score_tests(problem, state, {"row_noise": KNOWN["row_noise"]})[0]
    begun = start(problem, first.model, like=state)
    fell = state.loss - minimise(problem, begun, 6).loss
    # two of two operating points are simulated: all of what the refit sees
    assert first.promise == pytest.approx(fell, rel=0.15)


def test_a_state_at_some_operating_points_keeps_the_weights_of_its_statistics(problem, state):
    here = restricted(problem, state, [1])
    which = problem.train.setting == 1
    np.testing.assert_array_equal(here.weight, state.weight[which])
    assert 0.0 < here.loss < state.loss
    assert here.loss == pytest.approx(np.sum((state.weight * deviance(state.train))[which]))


def test_the_least_loss_along_a_change_is_where_the_change_explains_the_misfits():
    """Of small misfits, where the loss is a sum of squares; nuisance parameters are projected out.

    z = 0.25 change + nuisance: least at a quarter of the change, where nothing is left.
    """
    draw = np.random.default_rng(2)
    nuisance, change = draw.standard_normal((2, 200))
    z = 0.01 * (0.25 * change + 3.0 * nuisance)
    state = State(None, [], z, lambda: z, nuisance[:, None])
    least = along(state, 0.01 * change)
    assert least.share == pytest.approx(0.25, abs=1e-3)
    assert least.loss == pytest.approx(0.0, abs=1e-4 * np.sum(z**2))
    near = along(state, 0.01 * change, shortest=0.5)
    assert near.share == pytest.approx(0.5, abs=1e-3)
    assert near.loss > least.loss
    far = along(state, 1e-5 * change)  # beyond the longest step
    assert far.share == pytest.approx(LONGEST, rel=1e-3)


def test_much_is_left_where_the_loss_per_statistic_is_beyond_an_adequate_models(state):
    for loss, much in ((1.2, False), (1.4, True)):
        assert much_left(replace(state, train=np.full(len(state.train), np.sqrt(loss)))) == much


@pytest.mark.long
@pytest.mark.parametrize("share", [0.5, 0.75])
def test_a_median_mixed_into_few_codes_promises_most_at_its_share(share):
    """No derivative leads from another share to it: the residual changes by steps."""
    hidden = KNOWN["denoise"](share, kind="median")
    few_codes = KNOWN["read_noise"](0.6), KNOWN["pixel_fpn"](0.6), KNOWN["quantization"]()
    problem = sensor(*few_codes, hidden)
    first = score_tests(problem, baseline(problem), {"denoise": KNOWN["denoise"]})[0]
    found = first.model.get("denoise")
    assert (found.kind, found.strength) == (hidden.kind, hidden.strength)


def test_a_baseline_beside_a_guess_has_the_black_levels_of_all_operating_points():
    """Also of those at which the guesses are not compared."""
    points = [OperatingPoint(t, 0.1, 1.0) for t in (25.0, 45.0, 65.0, 85.0)]
    levels = TableLaw(tuple(points), (1.0, 2.0, 3.0, 4.0))
    strips = KNOWN["column_taps"](sigma=40.0, kind="blocks", levels=(2.0, -0.5), begins=(30,))
    effects = (KNOWN["convolved_lognormal"](mu=levels, delta=0.3, sigma=1e-6),
               KNOWN["read_noise"](sigma=2.0), KNOWN["quantization"](), strips)  # fmt: skip
    made = simulate(NoiseModel(effects, 200.0, points[0]), (128, 128), [(p, 3) for p in points])
    problem = fit_problem(design(made))
    model = baseline_model(problem)
    begun = start(problem, model)
    away = next(n for n in range(4) if n not in informative(problem, begun))
    black = TableLaw(tuple(points), tuple(230.0 if n == away else 200.0 for n in range(4)))
    sessions = SessionLevels(black, np.full(4, 0.1), (points[away],))
    problem = replace(problem, direct=replace(problem.direct, sessions=sessions))
    taps = {"column_taps": KNOWN["column_taps"]}
    found = [g.model for g in score_tests(problem, begun, taps)]
    anew = [m for m in found if m.without("column_taps") != model]
    assert anew
    for beside in anew:
        shown = [beside.pedestal.at(p) + beside.black_shift(p, (128, 128)) for p in points]
        assert shown == pytest.approx(black.values)
    # of 40 DN of the strips the offsets of the pixels have a small part left
    assert min(m.get("pixel_fpn").sigma for m in anew) < 0.2 * model.get("pixel_fpn").sigma
