import numpy as np
import pytest
from scipy.signal import lfilter

from dnanalyze.model.guesses.change_points import equal_strips, strips


def test_edges_and_levels_of_a_staircase_under_a_slope():
    rng = np.random.default_rng(1)
    begins, levels = [60, 130, 300], np.array([0.0, 8.0, 3.0, 12.0])
    clean = np.repeat(levels, np.diff([0, *begins, 400])) + np.linspace(0, 5, 400)
    found = strips(clean + 0.5 * rng.standard_normal(400))
    assert np.abs(found.begins - begins).max() <= 1
    # a step between strips of 60 and more lines beside a cubic: a few times .5 sqrt(2 / 60)
    np.testing.assert_allclose(np.diff(found.levels), np.diff(levels), atol=1.0)
    assert found.share == 0.0


def test_a_settling_is_told_with_its_side_share_and_length():
    rng = np.random.default_rng(2)
    line = np.arange(400) - 90.0
    clean = np.where(line < 0, 0.0, 20.0 * (1 - 0.3 * np.exp(-np.abs(line) / 12.0)))
    found = strips(clean + 0.2 * rng.standard_normal(400))
    assert list(found.begins) == [90]
    assert found.side == "after"
    assert found.share == pytest.approx(0.3, abs=0.05)
    assert 6.0 < found.length < 24.0  # a grid of factors of about 2.4


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.95])
def test_noise_alike_from_line_to_line_has_no_edges(rho):
    rng = np.random.default_rng(3)
    noise = rng.standard_normal((20, 600))
    made = lfilter([1.0], [1.0, -rho], noise, axis=1)[:, 200:]
    assert sum(strips(line) is not None for line in made) <= 1


def test_defect_lines_and_short_profiles_have_no_edges():
    rng = np.random.default_rng(4)
    line = rng.standard_normal(300)
    line[[40, 41, 200]] += 50.0
    assert strips(line) is None
    assert strips(line[:20]) is None
    assert strips(np.zeros(300)) is None


def test_equal_strips_are_known_by_their_seams():
    line = np.repeat([0.0, 5.0, 2.0, 9.0], 64) + 0.1 * np.random.default_rng(5).standard_normal(256)
    found = strips(line)
    assert equal_strips(found, 256, (2, 4, 8, 16)) == 4
    assert equal_strips(strips(np.repeat([0.0, 5.0], [70, 186])), 256, (2, 4)) is None
