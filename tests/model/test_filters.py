import numpy as np
import pytest
from scipy import ndimage
from skimage.restoration import denoise_nl_means

from dnanalyze.model import filters

RNG = np.random.default_rng(3)
NOISE = RNG.normal(100.0, 5.0, (60, 75)).astype(np.float32)
NOISE[RNG.random(NOISE.shape) < 0.02] += 60.0
RING = np.ones((3, 3), bool)
RING[1, 1] = False
FAR = np.ones((5, 5), bool)
FAR[2, 2] = False


def around(function, footprint=RING):
    return ndimage.generic_filter(NOISE.astype(float), function, footprint=footprint, mode="mirror")


@pytest.mark.parametrize("name", ["MIDPOINT", "MEAN"])
@pytest.mark.parametrize("both", [False, True])
def test_outliers_are_replaced_by_the_neighbours_centre(name, both):
    reference = around(np.median if name == "MIDPOINT" else np.mean)
    off = NOISE - reference
    outlying = np.abs(off) > 8.0 if both else off > 8.0
    assert outlying.sum() > 20
    found = filters.replace_outliers(NOISE, 8.0, False, both, getattr(filters, name))
    np.testing.assert_allclose(found, np.where(outlying, reference, NOISE), atol=1e-3)
    np.testing.assert_allclose(
        filters.neighbour_centre(NOISE, getattr(filters, name)), reference, atol=1e-3
    )


def test_median_is_a_rank_of_the_neighbours():
    rank = ndimage.median_filter(NOISE, footprint=RING, mode="mirror")
    np.testing.assert_array_equal(filters.neighbour_centre(NOISE, filters.MEDIAN), rank)


def test_a_local_threshold_is_in_units_of_the_neighbours_spread():
    spread = around(np.ptp) / 2.847
    middle = around(np.median)
    expected = np.where(NOISE - middle > 4.0 * spread, middle, NOISE)
    found = filters.replace_outliers(NOISE, 4.0, True, False, filters.MIDPOINT)
    np.testing.assert_allclose(found, expected, atol=1e-3)
    deviates = RNG.normal(size=(8, 200_000))
    assert np.ptp(deviates, axis=0).mean() == pytest.approx(2.847, abs=5 * 0.82 / 447)


@pytest.mark.parametrize(("radius", "footprint"), [(1, RING), (2, FAR)])
def test_clamp_caps_at_the_largest_neighbour(radius, footprint):
    high, low = around(np.max, footprint), around(np.min, footprint)
    expected = np.where(high + 3.0 < NOISE, high, NOISE)
    np.testing.assert_allclose(
        filters.replace_excess(NOISE, 3.0, False, radius, filters.EXTREME), expected
    )
    expected = np.where(low - 3.0 > NOISE, low, expected)
    np.testing.assert_allclose(
        filters.replace_excess(NOISE, 3.0, True, radius, filters.EXTREME), expected
    )


@pytest.mark.parametrize(("radius", "footprint"), [(1, RING), (2, FAR)])
def test_ratio_rule_of_published_cameras(radius, footprint):
    high = around(np.max, footprint)
    hit = 2.0 * np.maximum(high - 90.0, 0) + 5.0 < NOISE - 90.0
    assert hit.sum() > 5
    for name, centre in (("MIDPOINT", np.median), ("MEAN", np.mean), ("EXTREME", np.max)):
        found = filters.replace_by_ratio(NOISE, 2.0, 5.0, 90.0, radius, getattr(filters, name))
        expected = np.where(hit, around(centre, footprint), NOISE)
        np.testing.assert_allclose(found, expected, atol=1e-3)


def test_median_of_nine():
    np.testing.assert_array_equal(
        filters.median3(NOISE), ndimage.median_filter(NOISE, 3, mode="mirror")
    )


def test_gaussian():
    np.testing.assert_allclose(
        filters.gaussian(NOISE, 0.8, 6),
        ndimage.gaussian_filter(NOISE.astype(float), 0.8, radius=6, mode="mirror"),
        rtol=1e-5,
    )


def test_bilateral_is_the_weighted_mean_of_its_window():
    y = NOISE.astype(float)
    padded = np.pad(y, 2, mode="reflect")
    total, weight = np.zeros_like(y), np.zeros_like(y)
    for dy in range(5):
        for dx in range(5):
            k = padded[dy : dy + 60, dx : dx + 75]
            d2 = (dy - 2) ** 2 + (dx - 2) ** 2
            w = np.exp(-d2 / (2 * 0.9**2) - (k - y) ** 2 / (2 * 6.0**2))
            total, weight = total + w * k, weight + w
    np.testing.assert_allclose(filters.bilateral(NOISE, 6.0, 0.9, 2), total / weight, rtol=1e-5)


def test_nonlocal_means_is_the_mean_weighted_by_likeness_of_patches():
    y = NOISE[:30, :28].astype(float)
    h, far = 5.0, 2
    padded = np.pad(y, 1 + far, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (3, 3))
    here = windows[far:-far, far:-far]
    total, weight = np.zeros_like(y), np.zeros_like(y)
    for dy in range(-far, far + 1):
        for dx in range(-far, far + 1):
            there = windows[far + dy :, far + dx :][:30, :28]
            d = ((there - here) ** 2).mean(axis=(2, 3)) / h**2
            w = np.where(d > 5.0, 0.0, np.exp(-d))
            total, weight = total + w * there[..., 1, 1], weight + w
    found = filters.nonlocal_means(np.ascontiguousarray(NOISE[:30, :28]), h, 3, far)
    np.testing.assert_allclose(found, total / weight, rtol=1e-4)


@pytest.mark.parametrize(("theirs", "ours"), [(3, 2), (5, 4), (7, 6)])
@pytest.mark.parametrize("distance", [3, 6])
def test_an_even_patch_is_what_a_fast_mode_makes_of_the_next_odd_one(theirs, ours, distance):
    """Its sum over the lesser patch is divided by the pixels of the larger one."""
    h = 6.0
    expected = denoise_nl_means(
        NOISE.astype(float), theirs, distance, h=h * ours / theirs, fast_mode=True
    )
    found = filters.nonlocal_means(NOISE, h, ours, distance)
    # its exponential is right within some percent
    assert np.std(found - expected) < 0.01 * np.std(expected - NOISE)


def test_planes_of_a_mosaic_do_not_mix():
    mosaic = NOISE.copy()
    mosaic[::2, ::2] += 500.0
    found = filters.planewise(lambda plane, _: filters.median3(plane), mosaic, 2)
    for dy in range(2):
        for dx in range(2):
            plane = mosaic[dy::2, dx::2]
            np.testing.assert_array_equal(
                found[dy::2, dx::2], ndimage.median_filter(plane, 3, mode="mirror")
            )


def test_codes_stay_codes():
    whole = np.array([[1.0, 2.0]], np.float32)
    half = np.array([[1.4, 2.6]], np.float32)
    np.testing.assert_array_equal(filters.rounded_like(whole, half), [[1.0, 3.0]])
    np.testing.assert_array_equal(filters.rounded_like(half, half), half)
