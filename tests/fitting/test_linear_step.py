"""One linear step of several sensors."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from dnanalyze.fitting.least_squares import DAMPING, linear_step
from dnanalyze.fitting.state import root_weights
from dnanalyze.fitting.vectors import Key, Target

NAMES = "mean", "temporal_noise", "pattern_noise", "drift", "hot_count_5"


def half(*names: str, floor: float = 1.0) -> Target:
    n = len(names)
    keys = tuple(Key(0, "", name) for name in names)
    return Target(keys, np.zeros(n), np.zeros(n), np.full(n, floor), np.array(["level"] * n))


def state(jacobian: np.ndarray):
    return SimpleNamespace(jacobian=jacobian, weight=1.0)


def test_what_the_parameters_can_absorb_is_taken_off_on_both_halves():
    jacobian = np.zeros((5, 2))
    jacobian[0, 0], jacobian[3, 1] = 2.0, 0.5
    z = np.array([[3.0, 1.0, -1.0, 2.0, 0.5]])
    fitted, judged = half(*NAMES), half(*reversed(NAMES), floor=2.0)
    train, test = linear_step(state(jacobian), fitted, judged, z, z[:, ::-1].copy())
    left = DAMPING / (1.0 + DAMPING)
    np.testing.assert_allclose(train, [[3.0 * left, 1.0, -1.0, 2.0 * left, 0.5]])
    # of twice the floor, a change is half as many floors
    taken = (1.0 - left) / 2.0
    np.testing.assert_allclose(test, [[0.5, 2.0 * (1.0 - taken), -1.0, 1.0, 3.0 * (1.0 - taken)]])


def test_the_step_is_that_of_damped_weighted_least_squares():
    rng = np.random.default_rng(4)
    jacobian = rng.normal(size=(5, 3)) * [1.0, 10.0, 0.1]
    z = rng.normal(size=(4, 5)) * 20.0
    train, _ = linear_step(state(jacobian), half(*NAMES), half(*NAMES), z, z)
    for made, given in zip(train, z, strict=True):
        w = root_weights(given)
        a = jacobian * w[:, None]
        damped = np.vstack([a, np.sqrt(DAMPING) * np.diag(np.linalg.norm(a, axis=0))])
        step = lsq_linear(damped, np.concatenate([-given * w, np.zeros(3)])).x
        np.testing.assert_allclose(made, given + jacobian @ step, atol=1e-6)


@pytest.mark.parametrize("unknown", [0.0, np.nan])
def test_what_no_fit_has_moved_absorbs_nothing(unknown):
    z = np.ones((2, 5))
    train, test = linear_step(
        state(np.full((5, 2), unknown)), half(*NAMES), half(*NAMES), z, 2.0 * z
    )
    np.testing.assert_array_equal(train, z)
    np.testing.assert_array_equal(test, 2.0 * z)


def test_a_number_that_the_fitted_half_lacks_keeps_its_misfit():
    z, other = np.ones((1, 1)), np.full((1, 2), 5.0)
    _, test = linear_step(state(np.ones((1, 1))), half("mean"), half("drift", "mean"), z, other)
    np.testing.assert_allclose(test, [[5.0, 5.0 - 1.0 / (1.0 + DAMPING)]])
