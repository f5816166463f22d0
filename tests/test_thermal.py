"""Activated quantities against closed forms, and their fit against what made the numbers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dnanalyze.thermal import (
    BOLTZMANN_EV,
    KELVIN,
    activation,
    arrhenius,
    arrhenius_line,
    least_energy,
    over_constant,
)

CELSIUS = np.array([5.0, 20.0, 35.0, 50.0, 65.0])
X = activation(CELSIUS + KELVIN, 20.0 + KELVIN)
GRID = np.linspace(0.3, 1.3, 51)


@given(st.floats(-40, 120), st.floats(0.0, 1.5))
def test_growth_is_the_boltzmann_factor_of_the_two_temperatures(celsius, energy):
    expected = np.exp(energy / BOLTZMANN_EV * (1 / 293.15 - 1 / (celsius + 273.15)))
    assert arrhenius(celsius, 20.0, energy) == pytest.approx(expected, rel=1e-9)
    assert float(activation(celsius + KELVIN, 293.15)) * energy == pytest.approx(
        np.log(expected), abs=1e-9
    )


def test_a_line_gives_energy_rate_and_the_error_of_weighted_least_squares():
    rate = 3.0 * np.exp(0.65 * X)
    relative = np.array([0.2, 0.1, 0.05, 0.05, 0.1])
    found = arrhenius_line(X, rate, relative)
    assert found.energy_ev == pytest.approx(0.65)
    assert np.exp(found.log_rate) == pytest.approx(3.0)
    assert found.pulls == pytest.approx(np.zeros(5), abs=1e-9)
    weight = relative**-2
    centre = np.average(X, weights=weight)
    assert found.variance == pytest.approx(1 / np.sum(weight * (X - centre) ** 2))


def test_the_least_energy_lies_between_the_grid_points():
    assert least_energy(lambda e: (e - 0.6134) ** 2, GRID) == pytest.approx(0.6134, abs=2e-4)
    assert least_energy(lambda e: e, GRID) == pytest.approx(0.3, abs=2e-4)


@pytest.mark.parametrize("energy", [0.45, 0.83])
def test_a_constant_under_an_activated_part_is_found_again(energy):
    exposure = np.array([0.1, 0.2, 0.1, 0.2, 0.1])
    level = 64.0 + 5.0 * exposure * np.exp(energy * X)
    found = over_constant(X, exposure, level, np.full(5, 0.1), GRID)
    assert found.constant == pytest.approx(64.0, abs=1e-3)
    assert found.energy_ev == pytest.approx(energy, abs=1e-3)
    assert found.size == pytest.approx(5.0, rel=1e-2)


def test_the_error_of_the_constant_is_the_scatter_of_repeated_fits():
    rng = np.random.default_rng(4)
    exposure, sigma = np.full(5, 0.1), np.full(5, 0.2)
    level = 64.0 + 20.0 * exposure * np.exp(0.7 * X)
    fits = [
        over_constant(X, exposure, level + rng.normal(0.0, sigma), sigma, GRID) for _ in range(200)
    ]
    scatter = np.std([f.constant for f in fits], ddof=1)
    # a standard deviation of 200 is known to 5 %
    assert scatter == pytest.approx(np.mean([f.error for f in fits]), rel=0.2)


def test_a_recorded_constant_decides_where_the_series_is_flat():
    level = np.full(5, 70.0)
    error = np.full(5, 0.1)
    found = over_constant(X, np.ones(5), level, error, GRID, known=(64.0, 1e-4))
    assert found.constant == pytest.approx(64.0, abs=0.1)
    assert found.size > 0.0
    free = over_constant(X, np.ones(5), level, error, GRID)
    assert free.constant + free.size == pytest.approx(70.0, abs=0.5)


def test_a_level_that_falls_with_temperature_has_no_activated_part():
    level = 64.0 - CELSIUS / 10.0
    found = over_constant(X, np.ones(5), level, np.full(5, 0.1), GRID)
    assert found.size == 0.0
    assert found.constant == pytest.approx(level.mean())
