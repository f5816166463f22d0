"""The random numbers: bits by a published vector, normals by their distribution, tails included."""

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
from numba import njit
from scipy import stats
from scipy.special import ndtr, ndtri

from dnanalyze.loaders.captures import Window
from dnanalyze.model import draws, kernels

WIDTH = 4000
WHOLE = Window(0, 2500, 0, WIDTH)  # 1e7 pixels


@pytest.fixture(scope="module")
def normals() -> np.ndarray:
    return draws.normal(2026, WHOLE, WIDTH)


@njit
def _inverse(words, out):
    for i in range(words.size):
        out[i] = kernels._normal(words[i])


def test_bits_are_splitmix64():
    # first outputs for seed 1234567, as listed at rosettacode.org, Pseudo-random numbers/Splitmix64
    published = (
        6457827717110365317, 3203168211198807973, 9817491932198370423,
        4593380528125082431, 16408922859458223821,
    )  # fmt: skip
    got = draws.bits(1234567, Window(0, 1, 0, 5), 5)[0]
    assert got.tolist() == [x >> 32 for x in published]


def test_golden_values_to_the_last_bit():
    window = Window(3, 5, 7, 11)
    assert draws.normal(42, window, 100).view(np.uint32).tolist() == [
        [1021426618, 1054101025, 3208720812, 1064530121],
        [3215138514, 3213684853, 3201754450, 1067907374],
    ]
    assert draws.uniform(42, window, 100).view(np.uint32).tolist() == [
        [1057149016, 1059662454, 1046913394, 1062487375],
        [1037001693, 1040887277, 1051506829, 1063742016],
    ]
    few = draws.counts(np.full((2, 4), 3.7, np.float32), 0.5, 42, window, 100)
    assert few.tolist() == [[3.5, 4.0, 2.5, 5.0], [2.0, 2.0, 3.0, 5.5]]
    many = draws.counts(np.full((2, 4), 370, np.float32), 0.5, 42, window, 100)
    assert many.tolist() == [[370.5, 375.5, 359.5, 383.0], [352.5, 355.0, 364.0, 388.0]]
    paper = draws.add_lognormal(
        np.zeros((2, 4), np.float32), 1.0, 0.5, 0.02, 0.1, (42, 43), window, 100
    )
    assert paper.view(np.uint32).tolist() == [
        [1077476738, 1079204101, 1074138253, 1087339854],
        [1075098396, 1072810817, 1065156690, 1081664301],
    ]


@pytest.mark.parametrize(
    "window", [Window(0, 1, 0, 1), Window(7, 40, 13, 300), Window(2, 3, 0, 401)]
)
def test_a_window_draws_the_numbers_of_the_whole(window):
    whole = Window(0, 60, 0, 401)
    for draw in (draws.bits, draws.uniform, draws.normal):
        np.testing.assert_array_equal(draw(9, window, 401), draw(9, whole, 401)[window.slices])


def test_threads_and_tiles_draw_the_numbers_of_one_pass():
    whole = draws.normal(9, Window(0, 512, 0, 401), 401)
    tiles = [Window(r, r + 37, 0, 401) for r in range(0, 470, 37)]
    with ThreadPoolExecutor(4) as pool:
        parts = list(pool.map(lambda tile: draws.normal(9, tile, 401), tiles))
    for tile, part in zip(tiles, parts, strict=True):
        np.testing.assert_array_equal(part, whole[tile.slices])


def test_a_few_pixels_by_index_are_those_of_the_field():
    whole = Window(0, 60, 0, 401)
    index = np.array([[0, 5], [24059, 401]])
    for field, sparse in ((draws.bits, draws.bits_at), (draws.uniform, draws.uniform_at)):
        np.testing.assert_array_equal(sparse(9, index), field(9, whole, 401).ravel()[index])


def test_normal_is_the_inverse_distribution_function_for_every_kind_of_word():
    near_ends = np.unique(np.geomspace(1, 2.0**31, 200_000).astype(np.int64)) - 1
    words = np.r_[near_ends, 2**32 - 1 - near_ends].astype(np.uint32)
    got = np.empty(words.size, np.float32)
    _inverse(words.view(np.int32), got)
    exact = ndtri((words + 0.5) * 2.0**-32)
    assert np.abs(got - exact).max() < 2e-6
    assert got.max() == -got.min()
    assert got.max() > 6.33


def test_uniform_is_open_and_fine_near_zero():
    u = draws.uniform(3, WHOLE, WIDTH)
    assert 0 < u.min() < 5 / u.size  # Exp(1)/n: above 5/n once in 150 keys; this key is fixed
    assert u.max() < 1
    exact = (draws.bits(3, WHOLE, WIDTH) + 0.5) * 2.0**-32
    assert np.abs(u / exact - 1).max() < 2e-7


def test_both_fields_of_a_key_rise_together():
    window = Window(0, 100, 0, 1000)
    z, u = draws.normal(5, window, 1000), draws.uniform(5, window, 1000)
    assert np.abs(ndtr(z) - u).max() < 1e-6


def test_moments_and_shape_of_ten_million_normals(normals):
    z = normals.ravel().astype(float)
    n = z.size
    # standard errors of the first four moments of a standard normal; 5 sigma
    for power, expected, spread in ((1, 0, 1), (2, 1, 2), (3, 0, 15), (4, 3, 96)):
        assert abs(np.mean(z**power) - expected) < 5 * np.sqrt(spread / n)
    counts = np.histogram(ndtr(z), 1000, (0, 1))[0]
    chi2 = ((counts - n / 1000) ** 2 / (n / 1000)).sum()
    assert stats.chi2.sf(chi2, 999) > 1e-6
    assert stats.chi2.cdf(chi2, 999) > 1e-6  # nor too regular


def test_tails_of_ten_million_normals(normals):
    for k in (3.0, 3.5, 4.0, 4.5, 5.0):
        expected = normals.size * ndtr(-k)
        for count in ((normals > k).sum(), (normals < -k).sum()):
            assert stats.poisson.sf(count - 1, expected) > 1e-6
            assert stats.poisson.cdf(count, expected) > 1e-6


@pytest.mark.slow
def test_tails_of_a_thousand_million_normals():
    window = Window(0, 2500, 0, 4000)
    levels = np.arange(2.0, 5.75, 0.25)
    beyond = np.zeros((2, levels.size))
    total = 0
    for key in range(100):
        z = np.sort(draws.normal(key * 7919 + 1, window, 4000), axis=None)
        total += z.size
        beyond += np.searchsorted(z, -levels), z.size - np.searchsorted(z, levels)
    between = -np.diff(beyond, axis=1, append=0)
    share = -np.diff(ndtr(-levels), append=0) * total
    # 30 Poisson counts, the rarest of 19 expected: 5 sigma each side
    assert stats.poisson.sf(between - 1, share).min() > 3e-7
    assert stats.poisson.cdf(between, share).min() > 3e-7


def _correlation(a, b):
    return float(np.mean(a.astype(float) * b) * np.sqrt(a.size))  # N(0,1) for independent normals


def test_neighbours_rows_and_squares_are_uncorrelated(normals):
    z = normals
    pairs = [(z[:, :-d], z[:, d:]) for d in (1, 2, 3, 4, 8, 16, 64)]
    pairs += [(z[:-d], z[d:]) for d in (1, 2, 4)] + [(z[:-1, :-1], z[1:, 1:])]
    for a, b in pairs:
        assert abs(_correlation(a, b)) < 5
        assert abs(_correlation((a**2 - 1) / 2**0.5, (b**2 - 1) / 2**0.5)) < 5


@pytest.mark.parametrize("other", [2027, 2026 + 2**32, 2026 ^ (1 << 63), 2025])
def test_keys_that_differ_little_give_independent_fields(normals, other):
    window = Window(0, 500, 0, WIDTH)
    z = draws.normal(other, window, WIDTH)
    a = normals[:500]
    assert abs(_correlation(a, z)) < 5
    assert abs(_correlation(a[:, 1:], z[:, :-1])) < 5
    assert abs(_correlation((a**2 - 1) / 2**0.5, (z**2 - 1) / 2**0.5)) < 5


def test_words_have_no_favourite_bit():
    words = draws.bits(77, Window(0, 1000, 0, 1000), 1000)
    for bit in range(32):
        share = np.mean((words >> np.uint32(bit)) & np.uint32(1))
        assert abs(share - 0.5) < 5 * 0.5 / 1000


@pytest.mark.parametrize("mean", [1e-4, 0.03, 0.4, 1.0, 3.3, 9.9])
def test_few_counts_are_the_exact_quantiles(mean):
    window = Window(0, 300, 0, 1000)
    n = draws.counts(np.full(window.shape, mean, np.float32), 1.0, 8, window, 1000)
    u = (draws.bits(8, window, 1000) + 0.5) * 2.0**-32
    np.testing.assert_array_equal(n, stats.poisson.ppf(u, np.float64(np.float32(mean))))


@pytest.mark.parametrize(("mean", "differs"), [(10.0, 5e-4), (30.0, 2e-4), (1000.0, 2e-4)])
def test_many_counts_are_the_exact_quantiles_but_for_a_few_by_one(mean, differs):
    window = Window(0, 300, 0, 1000)
    n = draws.counts(np.full(window.shape, mean, np.float32), 1.0, 8, window, 1000)
    exact = stats.poisson.ppf((draws.bits(8, window, 1000) + 0.5) * 2.0**-32, mean)
    assert np.abs(n - exact).max() <= 1
    assert np.mean(n != exact) < differs


@pytest.mark.parametrize("mean", [0.2, 2.0, 9.99, 10.01, 25.0, 400.0, 3e4])
def test_counts_have_poisson_cumulants(mean):
    window = Window(0, 1000, 0, 1000)
    n = draws.counts(np.full(window.shape, mean, np.float32), 1.0, 11, window, 1000).astype(float)
    d = n - mean
    # 5 sigma of the sample cumulants: var(k2) = (2 m^2 + m)/N, var(k3) ~ (6 m^3 + 18 m^2 + m)/N
    assert abs(d.mean()) < 5 * np.sqrt(mean / n.size)
    assert abs(n.var() - mean) < 5 * np.sqrt((2 * mean**2 + mean) / n.size)
    third = np.mean((n - n.mean()) ** 3)
    assert abs(third - mean) < 5 * np.sqrt((6 * mean**3 + 18 * mean**2 + mean) / n.size)


def test_a_count_does_not_depend_on_how_many_electrons_its_neighbours_have():
    rng = np.random.default_rng(6)
    mean = (10.0 * np.exp(rng.normal(0.0, 1.5, (7, 700)))).astype(np.float32)
    mean[0], mean[1] = 1.0, 1000.0
    mean[0, 300], mean[1, 300] = mean[1, 0], mean[0, 0]  # one among others
    few = mean < kernels.INVERTED_BELOW
    assert 0.2 < few.mean() < 0.8
    window = Window(3, 10, 5, 705)

    def counted(m):
        return draws.counts(m.copy(), 0.7, 11, window, 900) / 0.7

    mixed = counted(0.7 * mean)
    alone = [counted(np.float32(0.7) * np.where(few == low, mean, mean[few == low][0]))
             for low in (True, False)]  # fmt: skip
    np.testing.assert_array_equal(mixed, np.where(few, *alone))


def test_counts_rise_with_the_mean_and_leave_negative_signal():
    window = Window(0, 100, 0, 1000)
    means = (0.0, 1.0, 5.0, 9.9, 10.1, 11.0, 40.0)
    got = [draws.counts(np.full(window.shape, m, np.float32), 1.0, 4, window, 1000) for m in means]
    for low, high in pairwise(got):
        assert np.mean(high < low) < 1e-3  # only where the two methods meet
    assert not got[0].any()
    below = draws.counts(np.full(window.shape, -2.5, np.float32), 1.0, 4, window, 1000)
    assert (below == -2.5).all()


def test_crosstalk_kernel_is_the_convolution():
    from scipy.ndimage import convolve

    a = np.random.default_rng(0).normal(size=(31, 47)).astype(np.float32)
    kernel = np.array([[0.01, 0.01, 0.01], [0.05, 0.84, 0.05], [0.01, 0.01, 0.01]])
    got = draws.share_with_neighbours(a, 0.03, 0.01, 0.02)
    np.testing.assert_allclose(got, convolve(a.astype(float), kernel, mode="nearest"), atol=1e-6)
    for shape in ((1, 1), (1, 5), (5, 1), (2, 2)):
        ones = draws.share_with_neighbours(np.ones(shape, np.float32), 0.03, 0.01)
        np.testing.assert_allclose(ones, 1.0, rtol=1e-6)
