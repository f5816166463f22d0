import numpy as np
import pytest

from dnanalyze.model.guesses.code_widths import WIDEST, _stacked, code_widths

PERIODS = 2, 4, 8, 16, 32, 64
# every fourth edge .6 DN too high: the code below it 1.6 wide, the one above it .4
EXPECTED = (-0.6, 0.0, 0.0, 0.6)


def converted(mean, sd, shift=0.6, count=200_000, seed=3):
    x = mean + sd * np.random.default_rng(seed).standard_normal(count)
    upper = np.arange(1, 1001)
    edges = upper - 0.5 + shift * (upper % 4 == 0)
    return np.unique(np.searchsorted(edges, x, side="right"), return_counts=True)


def rough(x, widths):
    """Codes of a converter whose widths repeat."""
    edges = np.cumsum(np.tile(np.asarray(widths) + 1.0, 4096 // len(widths)))
    return np.unique(np.searchsorted(edges, x, side="right"), return_counts=True)


@pytest.mark.parametrize("sd", [1.8, 2.5, 20.0])
def test_widths_of_a_mismatched_bit_whatever_the_spread(sd):
    one, every = code_widths([converted(100.3, sd)], PERIODS)
    # a class has 50,000 counts (.5 %), more in the wide one; few codes share with the density
    np.testing.assert_allclose(one, EXPECTED, atol=0.02)
    np.testing.assert_allclose(every, EXPECTED, atol=0.04 if sd > 2 else 0.06)


def test_histograms_too_narrow_alone_tell_together():
    told = [converted(100.3 + 1.7 * n, 1.0, seed=n) for n in range(5)]
    one, every = code_widths(told, PERIODS)
    np.testing.assert_allclose(one, EXPECTED, atol=0.02)
    np.testing.assert_allclose(every, EXPECTED, atol=0.1)


@pytest.mark.parametrize("sd", [0.55, 0.6, 0.9])
def test_a_code_is_an_integral_where_the_noise_is_less_than_a_code(sd):
    told = [converted(100.3 + 0.9 * n, sd, seed=n) for n in range(8)]
    one, _ = code_widths(told, PERIODS)
    np.testing.assert_allclose(one, EXPECTED, atol=0.05)


def test_a_code_that_never_occurs_has_no_width():
    for d in code_widths([converted(300.0, 12.0, shift=1.0)], PERIODS):
        np.testing.assert_allclose(d, (-1.0, 0.0, 0.0, 1.0), atol=0.03)


def test_equal_codes_are_equally_wide():
    for d in code_widths([converted(300.0, 5.0, shift=0.0)], PERIODS):
        assert np.abs(d).max() < 5 / np.sqrt(200_000 / d.size)


def test_no_answer_where_codes_of_a_class_are_not_seen():
    assert code_widths([converted(100.0, 0.3)], [16]) == []
    assert code_widths([converted(100.0, 0.3)], PERIODS) == []
    assert code_widths([converted(100.0, 1.0)], [64]) == []
    assert code_widths([], PERIODS) == []


def test_widths_that_all_differ_are_told_with_their_period():
    d = np.array([-0.4, 0.3, 0.1, -0.2, 0.25, -0.35, 0.3, 0.0])
    rng = np.random.default_rng(8)
    told = [rough(m + 3.0 * rng.standard_normal(300_000), d) for m in (203.0, 209.0, 230.0)]
    _, every = code_widths(told, PERIODS)
    # 37,000 counts in a class and histogram: .3 %, with the neighbours' and the density's
    np.testing.assert_allclose(every, d, atol=0.03)


@pytest.mark.parametrize("level", [89.0, 95.4])
def test_a_skewed_tail_does_not_pass_for_widths_of_a_long_period(level):
    rng = np.random.default_rng(7)
    edges = np.arange(1, 4096) - 0.5 + 0.6 * (np.arange(1, 4096) % 16 == 0)
    told = []
    for scale in (0.3, 1.5, 8.0):  # cold to hot, log-normal dark current on .6 DN of noise
        x = level + 0.6 * rng.standard_normal(300_000)
        x += scale * np.exp(0.78 * rng.standard_normal(300_000))
        told.append(np.unique(np.searchsorted(edges, x, side="right"), return_counts=True))
    one, _ = code_widths(told, PERIODS)
    np.testing.assert_allclose(one, [-0.6, *[0.0] * 14, 0.6], atol=0.05)


def test_what_few_codes_say_of_slow_periods_gives_way_to_what_many_codes_say():
    wide, narrow = converted(300.0, 40.0, shift=0.8), converted(300.3, 1.3, shift=0.8)
    _, every = code_widths([wide, narrow], [16])
    np.testing.assert_allclose(every, np.tile((-0.8, 0.0, 0.0, 0.8), 4), atol=0.1)


def test_a_narrow_tail_does_not_pass_for_widths_of_a_long_period():
    rng = np.random.default_rng(7)
    edges = np.arange(1, 4096) - 0.5 + (np.arange(1, 4096) % 16 == 0)
    told = []
    for centre, scale in ((89.0, 1.0), (95.0, 40.0)):  # cold and hot, log-normal dark current
        x = centre + 1.05 * rng.standard_normal(300_000)
        x += scale * np.exp(0.78 * rng.standard_normal(300_000))
        told.append(np.unique(np.searchsorted(edges, x, side="right"), return_counts=True))
    one, _ = code_widths(told, [16])
    np.testing.assert_allclose(one, [-1.0, *[0.0] * 14, 1.0], atol=0.05)


def test_far_more_codes_than_periods_need_cost_no_more():
    wide = converted(500.0, 110.0, count=2_000_000)
    assert _stacked([wide]).codes.size <= WIDEST + 1
    one, _ = code_widths([wide], PERIODS)
    np.testing.assert_allclose(one, EXPECTED, atol=0.02)
