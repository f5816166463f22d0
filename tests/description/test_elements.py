"""The analysis of variance behind all random elements, and the test of two levels."""

import numpy as np
import pytest

from dnanalyze.description.elements import Elements
from dnanalyze.description.found import distribution

ROW, COLUMN = np.indices((60, 80))


def test_means_and_the_variance_within_are_those_of_the_elements():
    rng = np.random.default_rng(1)
    number = (ROW // 5) * 16 + COLUMN // 5
    value = rng.normal(0.0, 1.5, 192)
    maps = value[number] + rng.normal(0.0, 2.0, (7, 60, 80))
    means, within = Elements({}, number).analysed(maps)
    assert means.shape == (7, 192)
    assert within == pytest.approx(4.0, rel=5 * np.sqrt(2 / maps.size))
    rest = means.mean(axis=0) - (value - value.mean())
    assert np.std(rest) == pytest.approx(2.0 / np.sqrt(25 * 7), rel=5 / np.sqrt(2 * 192))


def test_pixels_of_no_element_do_not_count():
    number = np.where(ROW % 2 == COLUMN % 2, ROW // 2, -1)
    maps = np.where(number >= 0, 1.0 * number, 1e6)[None]
    means, within = Elements({}, number).analysed(maps)
    assert means[0] == pytest.approx(np.arange(30) - 14.5)
    assert within == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("frames", "elements"), [(6, 60), (8, 40), (16, 10)])
def test_two_levels_are_told_from_a_normal_distribution(frames, elements):
    told = {"two_level": 0, "normal": 0}
    for seed in range(40):
        rng = np.random.default_rng(seed)
        for name, drawn in (
            ("two_level", rng.choice([-1.0, 1.0], (frames, elements))),
            ("normal", rng.standard_normal((frames, elements))),
        ):
            told[name] += distribution([drawn - drawn.mean(axis=0)]) == name
    assert told["two_level"] >= 38  # of 40
    assert told["normal"] >= 38


def test_few_values_are_taken_as_normal():
    values = np.array([[-1.0], [1.0], [1.0], [-1.0]])
    assert distribution([values]) == "normal"
