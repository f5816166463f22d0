"""The yardstick of a model's design against sensors of it that were not used for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.statistics import Scale
from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.design import design
from dnanalyze.fitting.free_parameters import free_parameters
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.fitting.state import start
from dnanalyze.fitting.vectors import MISSING, Key, Target
from dnanalyze.fitting.yardstick import (
    REPLICATES,
    by_design,
    expressed,
    measured_by,
    misfit_share,
    scales,
)
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.amp_glow import AmpGlow
from dnanalyze.model.effects.flicker_fpn import FlickerFpn
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINT = OperatingPoint(25.0, 1.0, 1.0)
PLAIN = (ReadNoise(4.0), PixelFpn(2.0), Quantization(12))
NAMES = [n for n, info in catalogue().items() if info.compared and info.scale is Scale.LOG][:40]
FURTHER = range(100, 124)  # sensors that the yardstick has not seen


def of(*more: object) -> NoiseModel:
    return NoiseModel((*PLAIN, *more), 64.0, POINT, 1)


def fit_problem_of(model: NoiseModel) -> FitProblem:
    return fit_problem(design(simulate(model, (128, 128), [(POINT, 6)])))


def spread(problem: FitProblem, model: NoiseModel, name: str) -> float:
    """Standard deviation of the difference of two further sensors, on the statistic's scale."""
    (at,) = np.flatnonzero(problem.train.names == name)
    seen = [problem.replicate(model, n)[0][at] for n in FURTHER]
    return float(np.sqrt(2.0) * np.std(seen, ddof=1))


@pytest.mark.parametrize(
    ("more", "name"),
    [
        ((), "median"),
        ((), "pattern_noise"),
        ((AmpGlow(200.0, length=0.3, location="edges"),), "pattern_noise"),
        ((FlickerFpn(3.0, 2.0),), "shading_0_1"),
    ],
)
def test_the_floor_is_what_two_sensors_differ_by(more, name):
    """Of 8 and of 24 replicates: within 3 times sqrt(1 / (2 * 14) + 1 / (2 * 23))."""
    model = of(*more)
    problem = fit_problem_of(model)
    reproducibility_sd = by_design(problem, model).train.reproducibility_sd[
        problem.train.names == name
    ]
    ratio = float(reproducibility_sd[0]) / spread(problem, model, name)
    assert abs(np.log(ratio)) < 3.0 * np.sqrt(1 / 28 + 1 / 46)


def target(stated: float, *names: str) -> Target:
    keys = tuple(Key(0, "", name) for name in names)
    n = len(keys)
    return Target(keys, np.zeros(n), np.zeros(n), np.full(n, stated), np.full(n, "level"))


def scaled(halves, train, test):
    return scales(halves, (train, test))


def drawn(rng: np.random.Generator, sd: float) -> np.ndarray:
    return sd * rng.standard_normal((REPLICATES, 1))


@pytest.mark.parametrize(
    ("sd", "low", "high"),
    [
        (0.1, 0.06, 0.15),  # the stated error holds structure
        (0.8, 0.5, 1.2),
        (5.0, 3.0, 7.5),
    ],
)
def test_the_scale_of_one_statistic_is_the_scatter_of_its_replicates(sd, low, high):
    rng = np.random.default_rng(3)
    halves = target(np.sqrt(2.0), "mean"), target(np.sqrt(2.0), "mean")
    train, test = scaled(halves, drawn(rng, sd), drawn(rng, sd))
    assert train == test
    assert low <= train[0] <= high


def test_of_many_statistics_that_scatter_alike_each_is_drawn_to_the_others():
    """14 degrees of freedom leave 19 % of each alone; of 40 together 3 %."""
    half = target(np.sqrt(2.0), *NAMES)
    rng = np.random.default_rng(4)
    train, _ = scaled((half, half), *(0.8 * rng.standard_normal((2, REPLICATES, 40))))
    assert np.sqrt(np.mean(np.log(train / 0.8) ** 2)) < 0.6 * np.sqrt(1 / 28)


def test_one_that_scatters_far_less_than_its_family_is_left_near_its_own():
    half = target(np.sqrt(2.0), *NAMES)
    rng = np.random.default_rng(4)
    sd = np.where(np.arange(40) == 7, 0.1, 1.0)
    train, _ = scaled((half, half), *(sd * rng.standard_normal((2, REPLICATES, 40))))
    assert 0.1 * np.exp(-3 / np.sqrt(28)) < train[7] < 0.1 * np.exp(4 / np.sqrt(28))


def test_shares_and_counts_of_few_keep_their_stated_error():
    rng = np.random.default_rng(3)
    half = replace(target(1.0, "hot_repeat"), families=np.array(["tails"]))
    train, _ = scaled((half, half), drawn(rng, 0.01), drawn(rng, 0.01))
    assert 1.0 <= train[0] < 1.05


def test_replicates_without_scatter_tell_nothing():
    halves = target(1.0, "mean"), target(1.0, "mean")
    same = np.ones((REPLICATES, 1))
    for drawn_once in (same, np.where(np.eye(8, 1), np.nan, same)):
        assert scaled(halves, drawn_once, same)[0][0] == pytest.approx(1.0, rel=0.05)


def test_a_state_keeps_its_model_and_its_misfit_in_units_of_the_statistics():
    model = of(FlickerFpn(3.0, 2.0))
    problem = fit_problem_of(model)
    free = free_parameters(model)
    state = derive(problem, start(problem, model, free))
    there, moved = measured_by(problem, state)
    for half, other, z, z_there in (
        (problem.train, there.train, state.train, moved.train),
        (problem.test, there.test, state.test, moved.test),
    ):
        assert not np.array_equal(half.reproducibility_sd, other.reproducibility_sd)
        np.testing.assert_allclose(
            z * half.reproducibility_sd, z_there * other.reproducibility_sd, atol=1e-9
        )
    plain, scaled = (
        problem.train.reproducibility_sd[:, None],
        there.train.reproducibility_sd[:, None],
    )
    np.testing.assert_allclose(state.jacobian * plain, moved.jacobian * scaled, atol=1e-9)
    back = expressed(moved, there, problem)
    np.testing.assert_allclose(back.train, state.train)
    for on, seen in ((problem, state), (there, moved), (problem, back)):
        np.testing.assert_array_equal(seen.weight, on.train.weight)


def test_the_weights_come_with_the_yardstick():
    """Of a model that is right nearly all is noise; of one that lacks half of the noise it is not.

    A part of the field has those of the whole.
    """
    problem = fit_problem_of(of())
    right, wrong = by_design(problem, of()), by_design(problem, NoiseModel((ReadNoise(2.0),), 64.0))
    assert right.train.misfit == right.test.misfit < 0.5 < 0.9 < wrong.train.misfit
    assert problem.scaled_as(wrong).train.misfit == wrong.train.misfit


def test_a_statistic_that_the_model_lacks_is_a_misfit_by_any_yardstick():
    problem = target(1.0, "mean", "median")
    z = problem.z(np.array([np.nan, 0.5]))
    assert z[0] == MISSING
    assert problem.expressed(z, problem.scaled(np.array([2.0, 2.0])))[0] == MISSING
    np.testing.assert_array_equal(problem.predicted(z), [np.nan, 0.5])


@pytest.mark.parametrize(("z", "share"), [(0.0, 0.0), (1.0, 0.0), (2.0, 0.75), (4.0, 0.93)])
def test_what_exceeds_a_loss_of_1_a_number_is_misfit(z, share):
    assert misfit_share(np.full(50, z)) == pytest.approx(share, abs=0.02)


def test_the_weights_are_equal_for_noise_and_equal_by_family_for_misfit():
    families = np.array(["level", *["spectrum"] * 9])
    keys = tuple(Key(0, "", f"n{i}") for i in range(10))
    half = Target(keys, *np.zeros((3, 10)), families, misfit=0.0)
    assert half.weight == pytest.approx(np.ones(10))
    balanced = np.array([5.0, *[5.0 / 9.0] * 9])
    assert replace(half, misfit=1.0).weight == pytest.approx(balanced)
    assert replace(half, misfit=0.25).weight == pytest.approx(0.75 + 0.25 * balanced)
    assert replace(half, misfit=0.25).only([0]).weight == pytest.approx(0.75 + 0.25 * balanced)
