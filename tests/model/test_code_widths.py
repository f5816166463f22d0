import numpy as np
import pytest

from dnanalyze.model.code_widths import code_widths

# every fourth edge .6 DN too high: the code below it 1.6 wide, the one above it .4
EXPECTED = (-0.6, 0.0, 0.0, 0.6)


def converted(mean, sd, shift=0.6, count=200_000, seed=3):
    x = mean + sd * np.random.default_rng(seed).standard_normal(count)
    upper = np.arange(1, 1001)
    edges = upper - 0.5 + shift * (upper % 4 == 0)
    return np.unique(np.searchsorted(edges, x, side="right"), return_counts=True)


@pytest.mark.parametrize("sd", [1.8, 2.5, 20.0])
def test_widths_of_a_mismatched_bit_whatever_the_spread(sd):
    d = code_widths([converted(100.3, sd)], 4)
    # a class has 50,000 counts (.5 %), more in the wide one; few codes share with the density
    np.testing.assert_allclose(d, EXPECTED, atol=0.04 if sd > 2 else 0.06)


def test_histograms_too_narrow_alone_tell_together():
    told = [converted(100.3 + 1.7 * n, 1.0, seed=n) for n in range(5)]
    np.testing.assert_allclose(code_widths(told, 4), EXPECTED, atol=0.1)


def test_a_code_that_never_occurs_has_no_width():
    d = code_widths([converted(300.0, 12.0, shift=1.0)], 4)
    np.testing.assert_allclose(d, (-1.0, 0.0, 0.0, 1.0), atol=0.03)


def test_equal_codes_are_equally_wide():
    d = code_widths([converted(300.0, 5.0, shift=0.0)], 8)
    assert np.abs(d).max() < 5 / np.sqrt(200_000 / 8)


def test_no_answer_where_codes_of_a_class_are_not_seen():
    assert code_widths([converted(100.0, 0.3)], 16).size == 0
    assert code_widths([converted(100.0, 1.0)], 4).size == 0
    assert code_widths([], 4).size == 0


def test_what_few_codes_say_of_slow_periods_gives_way_to_what_many_codes_say():
    wide, narrow = converted(300.0, 40.0, shift=0.8), converted(300.3, 1.3, shift=0.8)
    expected = np.tile((-0.8, 0.0, 0.0, 0.8), 4)
    np.testing.assert_allclose(code_widths([wide, narrow], 16), expected, atol=0.1)


def test_a_narrow_tail_does_not_pass_for_widths_of_a_long_period():
    rng = np.random.default_rng(7)
    edges = np.arange(1, 4096) - 0.5 + (np.arange(1, 4096) % 16 == 0)
    told = []
    for centre, scale in ((89.0, 1.0), (95.0, 40.0)):  # cold and hot, log-normal dark current
        x = centre + 1.05 * rng.standard_normal(300_000)
        x += scale * np.exp(0.78 * rng.standard_normal(300_000))
        told.append(np.unique(np.searchsorted(edges, x, side="right"), return_counts=True))
    d = code_widths(told, 16)
    np.testing.assert_allclose(d, [-1.0, *[0.0] * 14, 1.0], atol=0.05)
