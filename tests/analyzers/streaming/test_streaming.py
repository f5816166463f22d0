"""The accumulators against plain NumPy over the whole stack, and merging against one pass."""

from itertools import pairwise

import numpy as np
import pytest
from dark_frames import dark_frames
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from dnanalyze.analyzers.analyze import finish
from dnanalyze.analyzers.streaming.accumulation import accumulate, make_plan, read_ahead
from dnanalyze.loaders.captures import OperatingPoint

SHAPE = (24, 40)


def stack_of(codes, count=11):
    return np.array(dark_frames(3, count, SHAPE, drift=0.3, codes=codes), np.float64)


@pytest.mark.parametrize("codes", [True, False])
@pytest.mark.parametrize("count", [2, 5, 8, 11, 17])
def test_pixel_maps_are_numpys(codes, count):
    frames = dark_frames(3, count, SHAPE, drift=0.3, codes=codes)
    y = np.array(frames, np.float64)
    acc = accumulate(frames).finish()
    plan, maps = acc.plan, acc.maps
    np.testing.assert_allclose(maps.mean, y.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(maps.variance, y.var(axis=0, ddof=1), rtol=1e-5, atol=1e-6)
    d = y - y.mean(axis=0)
    np.testing.assert_allclose(maps.lag_one, (d[1:] * d[:-1]).sum(axis=0), rtol=1e-4, atol=1e-4)
    np.testing.assert_array_equal(maps.high, y.max(axis=0).astype(np.float32))
    np.testing.assert_array_equal(maps.high_at, y.argmax(axis=0))
    np.testing.assert_array_equal(maps.low, y.min(axis=0).astype(np.float32))
    cut = 64 * 2 * plan.difference_sigma**2
    squares = np.minimum(np.diff(y, axis=0) ** 2, cut)
    for ours, first in zip(maps.pair_squares, (0, 2), strict=True):
        np.testing.assert_allclose(ours, squares[first::4].sum(axis=0), rtol=1e-5, atol=1e-9)
    w = np.clip(y - plan.centre, -6 * plan.sigma, 6 * plan.sigma)
    scalars = maps.scalars
    np.testing.assert_allclose(scalars[:, 0], w.sum(axis=(1, 2)), rtol=1e-5, atol=1e-2)
    np.testing.assert_allclose(scalars[:, 1], (w * w).sum(axis=(1, 2)), rtol=1e-5)
    np.testing.assert_allclose(scalars[1:, 2], (w[1:] * w[:-1]).sum(axis=(1, 2)), rtol=1e-4)
    hot = y > plan.centre + 5 * plan.sigma
    np.testing.assert_array_equal(scalars[:, 3], hot.sum(axis=(1, 2)))
    np.testing.assert_array_equal(scalars[1:, 4], (hot[1:] & hot[:-1]).sum(axis=(1, 2)))
    np.testing.assert_allclose(acc.frame_means, w.mean(axis=(1, 2)), atol=1e-5)


@pytest.mark.parametrize("codes", [True, False])
def test_cumulants_are_the_k_statistics_of_three_frames_less_their_levels(codes):
    frames = dark_frames(3, 6, SHAPE, hot=0.0, drift=20.0, codes=codes)
    y = np.array(frames, np.float64)
    y -= y.mean(axis=(1, 2), keepdims=True)  # nothing is cut
    found = accumulate(frames).finish().maps.cumulants
    for row, k in zip(found, range(4), strict=True):
        for value, order in zip(row, (2, 3), strict=True):
            known = stats.kstat(y[k : k + 3], order, axis=0)
            assert value == pytest.approx(known.mean(), rel=1e-3, abs=1e-3)


def test_a_pixel_that_is_hit_is_cut():
    frames = dark_frames(3, 3, SHAPE, hot=0.0, codes=False)
    hit = [frames[0], frames[1].copy(), frames[2]]
    hit[1][5, 5] += 1e6
    plan = make_plan(frames[0], frames[1])
    still, struck = (accumulate(f, plan).finish().maps.cumulants[0, 1] for f in (frames, hit))
    reach = 8 * np.sqrt(2) * plan.difference_sigma
    assert 0 < struck - still < 0.4 * reach**3 / (SHAPE[0] * SHAPE[1])


def test_histograms_of_codes_count_every_value_and_difference():
    frames = dark_frames(4, 5, SHAPE)
    acc = accumulate(frames).finish()
    y = np.array(frames, np.int64)
    expected = np.bincount((y - y.min()).ravel())
    np.testing.assert_array_equal(acc.values.counts, expected)
    assert acc.values.first == y.min()
    steps = np.diff(y, axis=0)
    expected = np.bincount((steps - steps.min()).ravel())
    np.testing.assert_array_equal(acc.differences.counts, expected)
    assert acc.differences.first == pytest.approx(steps.min() / np.sqrt(2))


def test_histograms_of_continuous_values_have_their_quantiles():
    frames = dark_frames(4, 5, SHAPE, codes=False)
    acc = accumulate(frames).finish()
    p = np.array([0.05, 0.5, 0.95])
    width = acc.plan.sigma / 64
    np.testing.assert_allclose(acc.values.quantile(p), np.quantile(frames, p), atol=width)
    d = np.diff(np.array(frames, float), axis=0) / np.sqrt(2)
    np.testing.assert_allclose(acc.differences.quantile(p), np.quantile(d, p), atol=width)


@pytest.mark.parametrize(("low", "high"), [(-300, 200), (70_000, 90_000)])
def test_codes_outside_sixteen_bits_are_counted_one_by_one(low, high):
    codes = np.random.default_rng(1).integers(low, high, (2, 16, 16), np.int32)
    acc = accumulate(list(codes)).finish()
    expected = np.bincount((codes - codes.min()).ravel())
    np.testing.assert_array_equal(acc.values.counts, expected)


def sums_of(acc):
    """Every array that is summed over frames, by accumulator and name."""
    acc.wait()
    acc.parts["maps"].flush()
    out = {f"maps {k}": a for k, a in enumerate(acc.parts["maps"]._sums)}
    spectra, neighbours = acc.parts["spectra"], acc.parts["neighbours"]
    out |= {"power": spectra.power_sum, "winsorised": spectra.sum}
    out |= {name: getattr(neighbours, name) for name in ("peaks", "ranks", "lags", "tiles")}
    return out | {"scalars": acc.parts["maps"].scalars, "cumulants": acc.parts["maps"].cumulants}


@pytest.mark.parametrize(("codes", "drift"), [(True, 0.3), (False, 0.3), (True, 40.0)])
@settings(max_examples=15, deadline=None)
@given(cuts=st.sets(st.integers(1, 10), max_size=4))
def test_any_split_merges_to_one_pass(codes, drift, cuts):
    frames = dark_frames(5, 11, SHAPE, drift=drift, codes=codes)
    plan = make_plan(frames[0], frames[1])
    whole = accumulate(frames, plan)
    edges = [0, *sorted(cuts), len(frames)]
    parts = [accumulate(frames[a:b], plan, a) for a, b in pairwise(edges)]
    merged = parts[0]
    for part in parts[1:]:
        merged.merge(part)
    mine, his = sums_of(merged), sums_of(whole)
    for name, array in his.items():
        np.testing.assert_allclose(
            mine[name], array, rtol=1e-12, atol=1e-12 * np.abs(array).max(), err_msg=name
        )
    for name in ("scalars", "cumulants"):
        np.testing.assert_array_equal(mine[name], his[name])
    split, once = merged.finish(), whole.finish()
    assert split.frames == once.frames
    np.testing.assert_array_equal(split.values.counts, once.values.counts)
    np.testing.assert_array_equal(split.differences.counts, once.differences.counts)
    for one, other in zip(split.end_differences, once.end_differences, strict=True):
        np.testing.assert_array_equal(one, other)
    ours, theirs = (finish(acc, OperatingPoint()) for acc in (split, once))
    assert ours.missing == theirs.missing
    # sums of codes are exact; else a sum's last digit may round a single-precision map otherwise
    tolerance = 1e-12 if codes else 1e-6
    for name, value in theirs.values.items():
        found = ours.values[name]
        assert found.value == pytest.approx(value.value, rel=tolerance, abs=tolerance), name
        assert found.se == pytest.approx(value.se, rel=tolerance), name


def test_read_ahead_keeps_the_order_and_raises_what_reading_raises():
    assert list(read_ahead(lambda k=k: np.array(k) for k in range(5))) == [0, 1, 2, 3, 4]

    def broken():
        raise OSError("gone")

    with pytest.raises(OSError, match="gone"):
        list(read_ahead([broken]))
