"""Misfit as evidence, and what is left of it."""

import numpy as np
import pytest

from dnanalyze.diagnosis.deviance import DOUBT, deviance, dispersion, falls

NAMES = np.array(["lines"] * 3 + ["shading"] * 7)


def halves(lines: float, shading: float) -> np.ndarray:
    return np.array([lines] * 3 + [shading] * 7)


def test_a_statistic_falls_by_what_all_its_settings_do():
    names = np.array(["lines", "shading", "lines"])
    fell = falls(names, np.array([9.0, 1.0, 2.0]), np.array([1.0, 4.0, 2.5]))
    expected = [
        deviance(np.array([9.0, 2.0])) - deviance(np.array([1.0, 2.5])),
        deviance(np.array([1.0])) - deviance(np.array([4.0])),
    ]
    np.testing.assert_allclose(fell, expected)


def test_what_it_leaves_as_it_was_says_nothing_against_an_effect():
    assert dispersion(NAMES, halves(9.0, 5.0), halves(1.0, 5.0)) == 1.0


def test_what_it_bends_without_putting_right_counts():
    left = dispersion(NAMES, halves(9.0, 4.0), halves(4.0, 3.5))
    lines, shading = deviance(np.array([4.0])), deviance(np.array([3.5]))
    moved = np.array(
        [3 * (deviance(np.array([9.0])) - lines), 7 * (deviance(np.array([4.0])) - shading)]
    )
    assert left == pytest.approx(
        min(moved @ [lines, shading] / moved.sum(), 0.3 * lines + 0.7 * shading)
    )


def test_what_it_makes_worse_counts_as_much_as_what_it_mends():
    found = dispersion(NAMES, halves(9.0, 0.0), halves(2.0, 3.0))
    lines, shading = deviance(np.array([2.0])), deviance(np.array([3.0]))
    moved = np.array([3 * (deviance(np.array([9.0])) - lines), 7 * shading])
    assert found == pytest.approx(moved @ [lines, shading] / moved.sum())


def test_where_all_else_fits_it_is_that_of_all():
    assert dispersion(NAMES, halves(20.0, 0.0), halves(6.0, 0.0)) == pytest.approx(
        0.3 * DOUBT**2 * np.log(2)
    )


@pytest.mark.parametrize("left", [0.5, 0.99, 1.05, 1.3, 1.5])
def test_it_grows_from_one_without_a_step(left):
    found = dispersion(NAMES, halves(9.0, 9.0), halves(left, left))
    assert found == pytest.approx(max(1.0, deviance(np.array([left]))))


def test_an_effect_that_moves_nothing_is_told_by_all_statistics():
    still = halves(3.0, 3.0)
    assert dispersion(NAMES, still, still) == pytest.approx(deviance(np.array([3.0])))
    assert dispersion(np.empty(0, str), np.empty(0), np.empty(0)) == 1.0


def test_deviance_is_a_square_below_the_doubt_and_one_witness_beyond_it():
    assert deviance(np.array([0.1, -0.2])) == pytest.approx(0.05, rel=1e-3)
    assert deviance(np.array([DOUBT])) == pytest.approx(DOUBT**2 * np.log(2))
    assert deviance(np.full(10, 3.0)) > 0.2 * deviance(np.array([100.0]))
    assert deviance(np.array([1e4])) < 16 * DOUBT**2
