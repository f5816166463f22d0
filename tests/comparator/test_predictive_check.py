"""A model against replicates of itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.comparator.error import pooled
from dnanalyze.comparator.predictive_check import REPLICATES, FittedModel
from dnanalyze.diagnosis.gains import trial_of
from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.design import design
from dnanalyze.fitting.level import MEAN
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.fitting.state import start
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.flicker_fpn import FlickerFpn
from dnanalyze.model.effects.offset_drift import OffsetDrift
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

COLD, WARM = (OperatingPoint(t, 1.0, 1.0) for t in (25.0, 45.0))
BASE = (ReadNoise(4.0), PixelFpn(2.0), Quantization(12))


def _model(*more: object, seed: int) -> NoiseModel:
    return NoiseModel((*BASE, *more), 64.0, COLD, seed)


@pytest.fixture(scope="module")
def problem() -> FitProblem:
    drifts = _model(OffsetDrift(1.0), seed=1)
    return fit_problem(design(simulate(drifts, (128, 128), [(COLD, 8), (WARM, 8)])))


def _null(problem: FitProblem, model: NoiseModel) -> FittedModel:
    return FittedModel(problem, start(problem, model))


def with_misfits(null: FittedModel, train: np.ndarray, test: np.ndarray) -> FittedModel:
    """The same model beside a measurement that differs from it by so much."""
    problem, state = null.problem, null.state
    sides = (problem.train, state.train, train), (problem.test, state.test, test)
    there = [
        replace(half, coordinates=half.coordinates + (z - own) * half.reproducibility_sd)
        for half, own, z in sides
    ]
    measured = replace(problem, train=there[0], test=there[1])
    return FittedModel(measured, replace(state, train=train, unseen=lambda: test))


@pytest.fixture(scope="module")
def without(problem) -> FittedModel:
    return _null(problem, _model(seed=2))


@pytest.fixture(scope="module")
def right(problem) -> FittedModel:
    return _null(problem, _model(OffsetDrift(1.0), seed=2))


def test_a_residual_beyond_the_replicates_is_left(without):
    assert not without.adequate
    assert "drift" in without.left
    assert without.unexplained == without.left


def test_nothing_is_left_of_a_sensor_of_the_same_make(right):
    assert right.left == right.unexplained == []
    assert right.adequate


def test_replicates_are_sensors_of_the_make_less_the_models_own(right):
    problem, model = right.problem, right.state.model
    for side, half in enumerate((problem.train, problem.test)):
        drawn, own = problem.replicate(model, 3)[side], problem.coordinates(model)[side]
        told = np.isfinite(drawn) & np.isfinite(own)
        expected = ((drawn - own) / half.reproducibility_sd)[told]
        np.testing.assert_allclose(right.replicates[side][3][told], expected, atol=1e-6)
        assert len(right.replicates[side]) == REPLICATES


def test_the_mean_prediction_is_that_of_nine_sensors_of_the_make(right):
    model = right.state.model
    made = [
        _null(right.problem, replace(model, seed=model.seed + n)).state
        for n in range(REPLICATES + 1)
    ]
    for half, (mean, _) in zip(("train", "test"), right.predictive, strict=True):
        each = np.array([getattr(state, half) for state in made])
        known = np.isfinite(each).all(axis=0)
        np.testing.assert_allclose(mean[known], each.mean(axis=0)[known], atol=1e-6)


def test_chance_that_the_parameters_absorb_is_no_spread_of_a_make():
    """The offsets of the frames shift the mean of a sensor, and its pedestal is fitted to it."""
    made = _model(OffsetDrift(3.0), seed=1)
    problem = fit_problem(design(simulate(made, (128, 128), [(COLD, 8)])))
    raw = _null(problem, replace(made, seed=2))
    fitted = FittedModel(problem, derive(problem, raw.state))
    (_, raw_sd), (_, fitted_sd) = raw.predictive[0], fitted.predictive[0]
    at, walks = (problem.train.names == name for name in ("mean", "drift"))
    assert fitted_sd[at] < 0.6 * raw_sd[at]
    assert fitted_sd[walks] > 0.7 * raw_sd[walks]


def test_an_error_beyond_every_replicate_is_unexplained_by_its_largest_differences(right):
    sizes = {"temporal_noise": (1.45, 1.4), "mean": (1.3, 1.35)}
    train, test = (
        np.array([sizes.get(str(n), (1.25, 1.25))[side] for n in half.names])
        for side, half in enumerate((right.problem.train, right.problem.test))
    )
    worst = max(pooled(z, right.problem.test.families) for z in right.replicates[1])
    for error, adequate in ((1.29, True), (1.02 * max(worst, 1.3), False)):
        factor = error / pooled(test, right.problem.test.families)
        off = with_misfits(right, factor * train, factor * test)
        assert off.error == pytest.approx(error)
        assert off.left == []
        assert off.adequate == adequate
        assert off.unexplained[:2] == ([] if adequate else ["temporal_noise", "mean"])


def test_a_mean_level_beyond_its_limits_is_left_first(problem):
    shifted = _null(problem, replace(_model(seed=2), pedestal=68.0))
    assert shifted.left[0] == MEAN


def test_the_effect_corrects_the_residual_and_the_same_model_does_not(without, right):
    left = without.left
    assert without.corrects(left, right.state)
    assert not without.corrects(left, without.state)
    assert not without.corrects([], right.state)


def test_a_statistic_is_corrected_where_it_is_on_both_halves(without):
    state, problem = without.state, without.problem
    train, test = (
        np.where(half.names == "drift", 0.0, z)
        for half, z in ((problem.train, state.train), (problem.test, state.test))
    )
    assert without.corrects(["drift", "mean"], replace(state, train=train, unseen=lambda: test))
    assert not without.corrects(["drift", "mean"], replace(state, unseen=lambda: test))
    assert not without.corrects(["mean"], replace(state, train=train, unseen=lambda: test))


@pytest.mark.long
def test_evidence_from_one_sensors_random_field_is_in_units_of_its_scatter():
    """A cloud is the same at all operating points of a sensor, and another in the next one.

    Expected by the scatter of 40 further sensors; that of eight replicates is good to a quarter.
    """
    clouds = FlickerFpn(3.0, 2.0)
    points = [(OperatingPoint(t, 1.0, 1.0), 6) for t in (15.0, 25.0, 35.0, 45.0)]
    seen = fit_problem(design(simulate(_model(clouds, seed=1), (128, 128), points)))
    plain = _null(seen, _model(clouds, seed=2))
    null = FittedModel.of(plain.problem, plain.state)
    train, test = (
        np.where(np.char.startswith(half.names.astype(str), "shading"), 0.0, z)
        for half, z in ((seen.train, null.state.train), (seen.test, null.state.test))
    )
    after = replace(null.state, train=train, unseen=lambda: test)
    found = trial_of(null, "glow", after)
    further = [plain.problem.replicate(plain.state.model, n) for n in range(100, 140)]
    expected = 0.0
    for i, (half, z) in enumerate(((seen.train, plain.state.train), (seen.test, plain.state.test))):
        shaded = np.char.startswith(half.names.astype(str), "shading")
        spread = np.sqrt(2.0) * np.std([drawn[i] for drawn in further], axis=0, ddof=1)
        expected += float(np.sum((z * half.stated)[shaded] ** 2 / spread[shaded] ** 2)) / 2.0
    assert expected > 60.0
    assert found.evidence == pytest.approx(expected, rel=0.25)


def test_evidence_from_a_parameter_keeps_its_size():
    noisy = NoiseModel((ReadNoise(5.0), *BASE[1:]), 64.0, COLD, 1)
    seen = fit_problem(design(simulate(noisy, (128, 128), [(COLD, 8), (WARM, 8)])))
    null = _null(seen, _model(seed=2))
    found = trial_of(null, "more_noise", _null(seen, replace(noisy, seed=2)).state)
    assert found.falls.sum() / 2.0 == pytest.approx(found.evidence)
    assert found.evidence > 60.0
