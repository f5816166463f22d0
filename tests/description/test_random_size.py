"""The spread of random values beyond chance, against its closed form."""

import numpy as np
import pytest

from dnanalyze.description.found import random_size


def test_of_equal_chance_it_is_the_variance_less_chance():
    values = np.random.default_rng(0).normal(0.0, 2.0, 4000)
    size, error, gain = random_size(values, 1.0)
    mean = float(np.mean(values**2))
    assert size == pytest.approx(mean - 1.0, rel=1e-4)
    assert error == pytest.approx(mean * np.sqrt(2.0 / 4000), rel=1e-3)
    # twice the log likelihood ratio of two variances: n (S - 1 - ln S)
    assert gain == pytest.approx(4000 * (mean - 1 - np.log(mean)), rel=1e-4)


def test_what_is_below_chance_is_nothing():
    size, _, gain = random_size(0.5 * np.ones(100), 1.0)
    assert size == pytest.approx(0.0, abs=1e-6)
    assert gain == pytest.approx(0.0, abs=1e-4)
