"""A spacing and a number of steps from a histogram, against what they were drawn with."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dnanalyze.model.guesses.counted_steps import counted_steps

PIXELS = 150_000


def histogram(values, bins=640):
    width = (np.quantile(values, 0.999) - values.min()) / bins * 2
    edges = np.arange(values.min() - width, values.max() + 2 * width, width)
    return (edges[1:] + edges[:-1]) / 2, np.histogram(values, edges)[0]


@pytest.mark.parametrize("number", [0.1, 0.3, 1.0])
@pytest.mark.parametrize("core", [0.1, 0.2])
def test_the_ripple_tells_spacing_and_number(number, core):
    """Of a log-normal core; of three steps a pixel the power between the ripples is lost."""
    rng = np.random.default_rng(3)
    y = 12.0 * rng.lognormal(0.0, 0.3, PIXELS) + 1.5 * rng.standard_normal(PIXELS)
    spacing = y.std() / core
    found = counted_steps(*histogram(y + spacing * rng.poisson(number, PIXELS)))
    assert found is not None
    assert found[0] == pytest.approx(spacing, rel=0.04)  # tried in steps of 2 %, a broad crest
    assert found[1] == pytest.approx(number, rel=0.25)  # of the smooth part, which may bend too


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.05, 1.3), st.floats(0.0, 3.0))
def test_a_smooth_law_has_none(seed, spread, noise):
    """Or a faint one, where its lower end is as steep as a step."""
    rng = np.random.default_rng(seed)
    y = 5.0 * rng.lognormal(0.0, spread, PIXELS) + noise * rng.standard_normal(PIXELS)
    found = counted_steps(*histogram(y))
    assert found is None or (spread > 0.5 and found[1] < 0.15)


@pytest.mark.parametrize("counts", [np.zeros(64), np.eye(64)[30], np.ones(2)])
def test_what_has_no_width_has_none(counts):
    assert counted_steps(np.arange(float(counts.size)), counts) is None
