import numpy as np
import pytest
from scipy import stats

from dnanalyze.analyzers.estimators.quantiles import Counted, Ordered, Tied, in_order, median

P = np.array([0.001, 0.05, 0.25, 0.5, 0.84, 0.99])


def counted(sample):
    low = int(sample.min())
    return Counted(low, 1.0, np.bincount(sample.astype(int) - low))


def test_quantiles_of_codes_are_those_of_the_signal_before_rounding():
    sample = np.random.default_rng(1).normal(100.3, 1.5, 400_000)
    codes = np.rint(sample)
    truth = stats.norm.ppf(P, 100.3, 1.5)
    se = np.sqrt(P * (1 - P) / sample.size) / stats.norm.pdf(truth, 100.3, 1.5)
    # linear interpolation inside a code adds at most max|f'| / (8 f) of its width squared
    curve = np.abs(truth - 100.3) / 1.5**2 / 8 * 1.6
    for law in (Ordered(codes.astype(np.float32), 1.0), counted(codes)):
        assert np.all(np.abs(law.quantile(P) - truth) < 5 * se + curve + 1e-3)


def test_histogram_and_ordered_codes_agree():
    codes = np.rint(np.random.default_rng(2).gamma(3.0, 4.0, 20_000))
    np.testing.assert_allclose(
        counted(codes).quantile(P), Ordered(codes, 1.0).quantile(P), rtol=1e-12
    )


@pytest.mark.parametrize("step", [0.0, 0.25])
def test_a_cell_is_shared_so_that_each_side_has_its_part_of_the_sample(step):
    sample = np.random.default_rng(4).normal(size=999)
    law = Ordered(np.rint(sample / step) * step if step else sample, step)
    low, high, share = law.cells(P)
    under, upto = law.count_below(low), law.count_below(high)
    middle = law.quantile(P)
    if step:
        np.testing.assert_allclose(high - low, step)
        np.testing.assert_allclose(under + share * (upto - under), P * sample.size)
        np.testing.assert_allclose(low + share * step, middle)
    else:
        np.testing.assert_array_equal((low, high, share), (middle, middle, 0.0 * middle))


def test_continuous_quantiles_are_numpys():
    sample = np.random.default_rng(3).normal(size=1001)
    expected = np.quantile(sample, P, method="hazen")
    np.testing.assert_allclose(Ordered(sample).quantile(P), expected, rtol=1e-12)


@pytest.mark.parametrize("size", [1, 2, 1001, 1002])
def test_median_is_numpys(size):
    sample = np.random.default_rng(4).normal(size=size).astype(np.float32)
    assert median(sample) == np.median(sample)


def test_limits_of_counts_are_not_rounded_to_single_precision():
    low, high = np.float32(1), np.nextafter(np.float32(1), np.float32(2))
    law = Ordered(np.array([low, high, high], np.float32))
    between = float(low) + 1e-9  # nearer to the lower one
    for limit in (between, np.float64(between), np.array([between])):
        assert law.count_below(limit) == 1
        assert law.count_above(limit) == 2
    assert law.count_below(float(high)) == 1
    assert law.count_above(float(low)) == 2


def test_tied_quantiles_lie_between_the_values():
    law = Tied(np.repeat([1.0, 2.0, 6.0], [2, 6, 2]))
    np.testing.assert_allclose(law.quantile([0.1, 0.5, 0.7, 0.9, 1.0]), [1.0, 2.0, 4.0, 6.0, 6.0])
    sample = np.random.default_rng(6).normal(size=501)
    np.testing.assert_allclose(Tied(sample).quantile(P), Ordered(sample).quantile(P), atol=1e-9)


def test_a_constant_has_the_spread_of_its_resolution():
    assert Ordered(np.full(100, 7.0), 1.0).robust_sigma() == pytest.approx(0.5 / 1.349, rel=1e-3)
    assert Ordered(np.full(100, 7.0)).robust_sigma() > 0


def test_share_below_inverts_quantile():
    codes = np.rint(np.random.default_rng(4).normal(50, 5, 50_000))
    law = counted(codes)
    np.testing.assert_allclose(law.share_below(law.quantile(P)), P, atol=1e-9)


def test_moments_of_a_histogram():
    codes = np.rint(np.random.default_rng(5).gamma(2.0, 5.0, 10_000))
    d = codes - codes.mean()
    expected = [codes.mean(), *(np.mean(d**k) for k in (2, 3, 4))]
    np.testing.assert_allclose(counted(codes).moments(), expected, rtol=1e-10)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.uint16, np.int32])
@pytest.mark.parametrize("frames", [1, 3, 7, 8])
def test_a_lattice_is_put_in_order_as_any_sample_is(dtype, frames):
    rng = np.random.default_rng(frames)
    total = np.rint(rng.normal(300, 12, (40, 50)) * frames)
    sample = (total / frames).astype(dtype)
    np.testing.assert_array_equal(in_order(sample, 1 / frames), np.sort(sample, axis=None))


@pytest.mark.parametrize(
    "sample",
    [
        [0.0, 1.0, 1e9],  # far apart
        [0.3, 0.4, 1.0, 2.0, 2.1],  # on no lattice of step 1
        [5.0, np.nan, 1.0],
        [np.inf, 0.0, 3.0],
        [7.0],
        [2.0, 2.0, 2.0],
        [-3.0, -1.0, -2.0, -0.0, 0.0],
    ],
)
def test_what_is_on_no_lattice_is_sorted_all_the_same(sample):
    sample = np.array(sample)
    np.testing.assert_array_equal(in_order(sample, 1.0), np.sort(sample))
