"""Standard errors from derivatives that scatter from one simulated sensor to the next."""

from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.fitting.fit import _gain
from dnanalyze.fitting.state import root_weights

NUMBERS, PARAMETERS, SENSORS = 600, 4, 3


def errors(gain: np.ndarray) -> np.ndarray:
    """Of parameters where every number scatters by 1."""
    return np.sqrt(np.diag(gain @ gain.T))


def state_of(jacobian: np.ndarray) -> SimpleNamespace:
    free = [SimpleNamespace()] * jacobian.shape[1]
    return SimpleNamespace(
        train=np.zeros(len(jacobian)), weight=1.0, jacobian=jacobian, ties=(), free=free, model=None
    )


@pytest.fixture
def gain(monkeypatch):
    """`_gain` of a state without ties."""
    none = np.zeros((0, PARAMETERS)), np.zeros(0)
    monkeypatch.setattr("dnanalyze.fitting.fit.tied", lambda state: none)

    def of(jacobians: np.ndarray) -> np.ndarray:
        state = state_of(jacobians.mean(axis=0))
        return _gain(state, jacobians, np.ones(PARAMETERS, bool))

    return of


def test_exact_derivatives_give_weighted_least_squares(gain):
    rng = np.random.default_rng(1)
    exact = rng.normal(size=(NUMBERS, PARAMETERS))
    w = root_weights(np.zeros(NUMBERS))
    expected = np.linalg.pinv(exact * w[:, None]) * w
    assert gain(np.array([exact] * SENSORS)) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_noise_of_derivatives_does_not_shorten_the_errors(gain):
    """Two parameters that differ little: noise as large as half of their difference.

    The products of the mean alone would make the errors of the two .77 times as large.
    """
    rng = np.random.default_rng(2)
    exact = rng.normal(size=(NUMBERS, PARAMETERS))
    exact[:, 1] = exact[:, 0] + 0.3 * exact[:, 1]
    size = 0.3
    true = errors(np.linalg.pinv(exact))
    plain, found = [], []
    for _ in range(60):
        noisy = exact + size * rng.normal(size=(SENSORS, *exact.shape))
        plain.append(errors(np.linalg.pinv(noisy.mean(axis=0))) / true)
        found.append(errors(gain(noisy)) / true)
    # (1 + 2 size^2 / (3 x .3^2))^-1/2 = .77 for the two that differ little
    assert np.all(np.mean(plain, axis=0)[:2] < 0.85)
    assert np.mean(found, axis=0) == pytest.approx(1.0, abs=0.03)


def test_derivatives_of_noise_alone_leave_finite_errors(gain):
    noise = np.random.default_rng(3).normal(size=(2, NUMBERS, PARAMETERS))
    assert np.all(np.isfinite(gain(noise)))
