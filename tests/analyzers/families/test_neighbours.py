"""Neighbours: exact expectations of exchangeable pixels, of kernels, and of filters."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import maximum_filter, median_filter
from structure_frames import accumulated, scatter_over_error, sensor, values, white

from dnanalyze.analyzers.accumulators.neighbour_sums import (
    EXCESS_SIGMAS,
    LAGS,
    Neighbours,
    edges_of,
    lag_products,
    rank_shares,
    top_level,
)
from dnanalyze.analyzers.estimators.halo import halo
from dnanalyze.analyzers.families import neighbours
from dnanalyze.analyzers.kernels import neighbour_loops
from dnanalyze.analyzers.kernels.layout import PEAK_EXCESS, PEAK_SUMS
from dnanalyze.analyzers.kernels.neighbour_loops import peak_sums
from dnanalyze.analyzers.streaming.accumulation import accumulate, make_plan

RANKS = ("frame_pmax8", "frame_pmin8", "temporal_pmax8", "temporal_pmin8")
RING = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], bool)


@pytest.mark.parametrize(
    "law", ["normal", "lognormal", "coarse codes"], ids=["normal", "lognormal", "coarse"]
)
def test_exchangeable_pixels_top_their_neighbours_one_time_in_nine(law):
    rng = np.random.default_rng(1)
    shape, count = (256, 256), 4
    draw = {
        "normal": lambda: rng.normal(100, 1, shape).astype(np.float32),
        "lognormal": lambda: rng.lognormal(2, 1.5, shape).astype(np.float32),
        "coarse codes": lambda: rng.poisson(0.7, shape).astype(np.uint16) * 16,
    }[law]
    found = values(neighbours, [draw() for _ in range(count)])
    # 9 P_max = 1 with sd 9 x .157/sqrt(n): physics of rank tests; the frames are independent
    sd = 9 * 0.157 / np.sqrt(count * 254 * 254)
    for name in RANKS:
        assert abs(found[name].value - 1) < 4.5 * sd * (1.25 if "temporal" in name else 1), name


def test_ties_are_shared():
    plan = make_plan(np.zeros((9, 9), np.uint16))
    image = np.zeros((9, 9), np.float32)
    total = rank_shares(plan, image).sum(axis=(0, 1))
    np.testing.assert_allclose(total, [49, 49 / 9, 49 / 9], rtol=1e-6)
    image[4, 4] = image[4, 5] = 5
    total = rank_shares(plan, image).sum(axis=(0, 1))
    # the two share the top; 10 pixels around them are not highest, and they are not lowest
    lonely = 49 - 12
    assert total[1] == pytest.approx(lonely / 9 + 2 * 0.5, rel=1e-6)


def test_covariances_of_the_papers_kernel():
    """(1,0) V(2 phi - 12 phi^2); (1,1) V(2 phi - 14 phi^2); (2,0) 3 V phi^2, seed redrawn."""
    rng = np.random.default_rng(2)
    phi, delta, sigma, shape, count = 0.04, 0.3, 0.01, (300, 280), 6
    q = np.exp(delta**2)
    m1 = np.exp(delta**2 / 2)
    v, m2 = m1**2 * (q - 1), m1**2 * q
    frames = []
    for _ in range(count):
        seed = rng.lognormal(0, delta, (shape[0] + 2, shape[1] + 2))
        frame = np.zeros(shape)
        for dy in range(3):
            for dx in range(3):
                weight = 1 - 8 * phi if dx == dy == 1 else phi
                tap = weight + sigma * rng.normal(size=shape)
                frame += tap * seed[dy : dy + shape[0], dx : dx + shape[1]]
        frames.append(frame)
    found = values(neighbours, frames)
    total = v * (1 - 16 * phi + 72 * phi**2) + 9 * sigma**2 * m2
    expected = {
        "10": v * (2 * phi - 12 * phi**2),
        "01": v * (2 * phi - 12 * phi**2),
        "11": v * (2 * phi - 14 * phi**2),
        "20": 3 * v * phi**2,
        "02": 3 * v * phi**2,
    }
    for lag, covariance in expected.items():
        value = found[f"temporal_corr_{lag}"]
        assert abs(value.value - covariance / total) < 4.5 * value.se, lag
        assert value.se < 0.01


def test_sums_of_products_are_those_of_a_plain_computation():
    rng = np.random.default_rng(3)
    image = rng.normal(size=(37, 53)).astype(np.float32)
    plan = make_plan(image)
    products = lag_products(plan, image, 1.5).sum(axis=(0, 1))
    x = np.clip(image.astype(float), -1.5, 1.5)
    x = x - x.mean(axis=0) - x.mean(axis=1)[:, None] + x.mean()
    h, w = x.shape
    for (dx, dy), found in zip(LAGS, products, strict=True):
        plain = np.sum(x[: h - dy, : w - dx] * x[dy:, dx:])
        if (dx, dy) == (1, 1):
            plain = (plain + np.sum(x[: h - 1, 1:] * x[1:, : w - 1])) / 2
        assert found == pytest.approx(plain, rel=1e-4, abs=1e-3)


def test_lines_do_not_correlate_pixels():
    rng = np.random.default_rng(4)
    frames = [
        (f + 2 * rng.normal(size=(1, 200)) + 3 * rng.normal(size=(160, 1))).astype(np.float32)
        for f in white(rng, (160, 200), 5)
    ]
    found = values(neighbours, frames)
    for lag in ("10", "01", "11", "20", "02"):
        value = found[f"temporal_corr_{lag}"]
        assert abs(value.value) < 4.5 * value.se, lag


def test_gaussian_tiles_have_their_variance_of_variances():
    found = values(neighbours, white(np.random.default_rng(5), (400, 400), 3))
    value = found["local_variance_cv"]
    assert abs(np.log(value.value / (2 / 15))) < 4.5 * value.se
    assert value.se < 0.03
    assert abs(found["hh_kurtosis"].value) < 4.5 * found["hh_kurtosis"].se


def test_heavy_tails_raise_both():
    rng = np.random.default_rng(6)
    frames = [100 + rng.standard_t(5, (300, 300)).astype(np.float32) for _ in range(8)]
    found = values(neighbours, frames)
    assert found["local_variance_cv"].value > 0.16
    # a t law of 5 degrees has a kurtosis of 6; a difference half, a Haar sum of 4 an eighth of it
    value = found["hh_kurtosis"]
    assert 0.3 < value.value < 0.75 + 4.5 * value.se  # the cut at 8 sigma takes some
    assert value.value > 4.5 * value.se


def test_peaks_are_counted_as_a_plain_filter_counts_them():
    rng = np.random.default_rng(7)
    frames = sensor(rng, (96, 120), 3)
    acc = accumulated(frames)
    found = neighbours.finish(acc).values
    sigma = acc.plan.difference_sigma
    counts, ties, tops = np.zeros(3), 0.0, 0.0
    for frame in frames:
        y = frame.astype(float)
        lead = (y - maximum_filter(y, footprint=RING, mode="nearest"))[1:-1, 1:-1]
        counts += [np.clip(lead - k * sigma + 0.5, 0, 1).sum() for k in (4, 8, 16)]
        level, share = top_level(frame.astype(np.float32))
        weight = np.where(y > level, 1.0, np.where(y == level, share, 0.0))[1:-1, 1:-1]
        tops += weight.sum()
        ties += weight[lead == 0].sum()
    for k, name in enumerate(("excess_4", "excess_8", "excess_16")):
        assert found[name].value == pytest.approx(counts[k] / 3), name
    assert found["ties_max8"].value == pytest.approx(ties / tops, rel=1e-5)


@pytest.mark.parametrize("sigma", [0.1, 0.49, 0.505, 1.0, 1.02, 30.0])
def test_a_lead_counts_by_how_much_of_its_code_lies_beyond_the_threshold(sigma):
    """Codes one apart count less and less as sigma grows, not all at once."""
    frame = np.zeros((40, 40), np.float32)
    frame[5::10, 5::10] = leads = np.arange(16).reshape(4, 4)
    edges, out = np.array([0, 40]), np.zeros((1, 1, PEAK_SUMS))
    limits = np.array(EXCESS_SIGMAS) * sigma
    peak_sums(frame, 99.0, 1.0, limits, np.minimum(1.0, limits), edges, edges, out)
    beyond = [np.clip((leads - k) / min(1.0, k) + 0.5, 0, 1).sum() for k in limits]
    np.testing.assert_allclose(out[0, 0, PEAK_EXCESS:], beyond, rtol=1e-5)


def test_of_converted_noise_the_leads_do_not_jump_with_its_sigma():
    """At 4 sigma of .49 and .51 DN a lead of two codes is just beyond and just within."""
    rng = np.random.default_rng(12)
    noise, tail = rng.standard_normal((6, 256, 256)), rng.exponential(4.0, (256, 256))
    hot = np.where(rng.random((256, 256)) < 0.02, tail, 0.0)
    low, high = (
        values(neighbours, [np.rint(40 + hot + s * n).astype(np.uint16) for n in noise])
        for s in (0.49, 0.51)
    )
    few, many = sorted((low["excess_4"].value, high["excess_4"].value))
    assert many < 1.3 * few  # the tail falls by exp(-.08 / 4), and the core's leads with it


def test_the_top_percent_is_one_percent_even_of_coarse_codes():
    frame = np.random.default_rng(8).poisson(3, (200, 220)).astype(np.float32)
    level, share = top_level(frame)
    assert (frame > level).mean() + share * (frame == level).mean() == pytest.approx(0.01, rel=1e-3)


def test_a_cap_to_the_neighbours_is_seen():
    """A filter that cuts each pixel to its highest neighbour leaves ties and no peaks."""
    rng = np.random.default_rng(9)
    plain = sensor(rng, (160, 160), 3)
    capped = [np.minimum(f, maximum_filter(f, footprint=RING)) for f in plain]
    before, after = values(neighbours, plain), values(neighbours, capped)
    assert before["ties_max8"].value < 0.1
    assert after["ties_max8"].value > 0.5
    assert after["excess_4"].value == 0
    assert after["frame_pmax8"].value < 0.9
    assert before["frame_pmax8"].value > 0.97


def test_a_median_filter_lowers_both_ranks():
    rng = np.random.default_rng(10)
    frames = [median_filter(f, 3) for f in white(rng, (160, 160), 3)]
    found = values(neighbours, frames)
    assert found["frame_pmax8"].value < 0.85
    assert found["frame_pmin8"].value < 0.85
    assert found["temporal_corr_10"].value > 0.4


@pytest.mark.parametrize("phi", [0.0, 0.02])
def test_the_halo_is_the_crosstalk(phi):
    """A hot pixel leaves phi (L - m) on its 8 neighbours: phi / (1 - 8 phi) of its own excess."""
    rng = np.random.default_rng(11)
    shape = (300, 300)
    light = rng.normal(100, 1, shape)
    light[rng.random(shape) < 1e-3] += 200 * rng.lognormal(0, 0.5)
    blurred = (1 - 9 * phi) * light
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            blurred += phi * np.roll(light, (dy, dx), (0, 1))
    frames = [(blurred + rng.normal(0, 1, shape)).astype(np.float32) for _ in range(3)]
    found = values(neighbours, frames)
    value = found["hot_halo"]
    assert abs(value.value - phi / (1 - 8 * phi)) < 4.5 * value.se
    assert value.se < 0.002
    assert abs(found["hot_halo_2"].value) < 4.5 * found["hot_halo_2"].se


def test_pairs_that_are_noisy_together_correlate_as_a_plain_computation_has_it():
    rng = np.random.default_rng(2)
    rows, columns, count = 64, 47, 5
    each = rng.lognormal(0.0, 0.6, (rows // 2, columns)).repeat(2, axis=0)
    stack = [
        (100 + each * rng.normal(0, 3, (rows, columns))).astype(np.float32) for _ in range(count)
    ]
    acc = accumulated(stack)
    found = neighbours.finish(acc).values
    v = np.var(np.array(stack, float), axis=0, ddof=1)
    t = v / (v + acc.difference_sigma**2)
    t = t - t.mean(axis=0) - t.mean(axis=1, keepdims=True) + t.mean()

    def means(t):
        both = t[:-1] * t[1:]
        return both[::2].mean() / np.mean(t**2), both[1::2].mean() / np.mean(t**2)

    for name, map_ in (("rows", t), ("columns", t.T)):
        within, between = means(map_)
        seen = found[f"noise_shared_{name}"]
        assert seen.value == pytest.approx(within - 2 * abs(between), abs=1e-5)
        assert seen.se >= np.sqrt(10.0 / t.size)
    assert found["noise_shared_rows"].value > 5 * found["noise_shared_rows"].se
    assert abs(found["noise_shared_columns"].value) < 5 * found["noise_shared_columns"].se


def test_a_halo_needs_hot_pixels():
    image = np.random.default_rng(12).normal(size=(64, 64)).astype(np.float32)
    assert halo(image, 0.0, 1.0) == {}
    result = neighbours.finish(accumulated(white(np.random.default_rng(13), (64, 64), 2)))
    assert "hot_halo" in result.missing


def test_what_whole_frames_share_counts_as_uncertain():
    """A wave whose strength changes from frame to frame correlates pixels by a random amount."""
    rng = np.random.default_rng(14)
    x = np.arange(160)
    seen, stated = [], []
    for _ in range(30):
        frames = [
            (f + 1.5 * rng.normal() * np.sin(0.6 * x)).astype(np.float32)
            for f in white(rng, (120, 160), 6)
        ]
        value = values(
            neighbours, [f + 0.2 * np.sin(0.5 * np.arange(120))[:, None] for f in frames]
        )
        stated.append(value["temporal_pmax8"].se)
        seen.append(value["temporal_pmax8"].value)
    # 30 captures tell the scatter to 13 %, five differences each tell theirs to 30 %
    assert 0.5 < np.std(seen, ddof=1) / np.sqrt(np.mean(np.square(stated))) < 2


@pytest.mark.parametrize("shape", [(16, 16), (8, 9), (40, 17), (5, 300)])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_small_frames_give_finite_values_or_a_reason(shape, count):
    result = neighbours.finish(accumulated(sensor(np.random.default_rng(15), shape, count)))
    for name, value in result.values.items():
        assert np.isfinite([value.value, value.se]).all(), name
        assert value.se > 0, name
    if min(shape) < 8:
        assert set(result.missing) == {"neighbours"}
    if count == 1:
        assert not any(n.startswith(("pattern", "temporal")) for n in result.values)
        assert "neighbours" in result.missing


def test_constant_frames():
    result = neighbours.finish(accumulated([np.full((64, 64), 7, np.uint16)] * 3))
    assert result.values["frame_pmax8"].value == pytest.approx(1)
    assert result.values["excess_4"].value == 0
    assert "temporal_corr_10" in result.missing
    assert "local_variance_cv" in result.missing


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_merging_equals_one_pass(cut, seed):
    frames = sensor(np.random.default_rng(seed), (33, 26), 7)
    plan = make_plan(frames[0], frames[1])
    whole = accumulate(frames, plan)
    first = accumulate(frames[:cut], plan)
    first.merge(accumulate(frames[cut:], plan, cut))
    a, b = (p.parts["neighbours"] for p in (whole, first))
    assert isinstance(a, Neighbours)
    assert (a.frames, a.differences) == (b.frames, b.differences)
    for name in ("peaks", "ranks", "lags", "tiles"):
        np.testing.assert_allclose(getattr(b, name), getattr(a, name), rtol=1e-12, atol=1e-9)
        np.testing.assert_allclose(b.each[name], a.each[name], rtol=1e-12, atol=1e-9)


def test_errors_are_those_of_independent_captures():
    captures = [sensor(np.random.default_rng((16, k)), hot=3e-3) for k in range(80)]
    ratios = scatter_over_error(neighbours, captures)
    assert len(ratios) == 26
    for name, ratio in ratios.items():  # 8 % sampling error each, honest to 30 %
        assert 0.55 < ratio < 1.5, (name, ratio)


def test_a_single_frame_has_correlations_of_its_own():
    """A moving average (1, a) along the rows: a / (1 + a^2) at lag 1 along them, 0 elsewhere."""
    rng = np.random.default_rng(15)
    a, noise = -0.3, rng.normal(size=(300, 301)).astype(np.float32)
    frame = noise[:, 1:] + np.float32(a) * noise[:, :-1]
    found = values(neighbours, [frame])
    expected = {"10": a / (1 + a * a), "01": 0.0, "11": 0.0, "20": 0.0, "02": 0.0}
    for lag, correlation in expected.items():
        value = found[f"frame_corr_{lag}"]
        assert abs(value.value - correlation) < 4.5 * value.se, lag
        assert 0.5 / 300 <= value.se < 0.01
    assert not any(name.startswith("frame_corr") for name in values(neighbours, [frame, -frame]))


def test_sums_of_inner_pixels_are_those_of_a_plain_computation():
    rng = np.random.default_rng(8)
    image = rng.normal(size=(37, 53)).astype(np.float32)
    lines = neighbour_loops.line_means(image, 1.5)
    edges = edges_of(make_plan(image))
    out = np.zeros((edges[0].size - 1, edges[1].size - 1, 7))
    neighbour_loops.inner_sums(image, 1.5, *lines, *edges, out)
    *products, pixels = out.sum(axis=(0, 1))
    cut = np.clip(image.astype(float), -1.5, 1.5)
    x = image - cut.mean(axis=0) - cut.mean(axis=1)[:, None] + cut.mean()
    x = np.where(np.abs(image) <= 1.5, x, 0.0)
    h, w = x.shape
    assert pixels == np.count_nonzero(np.abs(image) <= 1.5)
    for (dx, dy), found in zip(LAGS, products, strict=True):
        plain = np.sum(x[: h - dy, : w - dx] * x[dy:, dx:])
        if (dx, dy) == (1, 1):
            plain = (plain + np.sum(x[: h - 1, 1:] * x[1:, : w - 1])) / 2
        assert found == pytest.approx(plain, rel=1e-4, abs=1e-3)


def test_particle_tracks_correlate_no_typical_pixels():
    """Of single frames; the correlation of all pixels, cut at 6 sigma, tells them."""
    rng = np.random.default_rng(9)
    frames = white(rng, (200, 200), 6)
    for frame in frames:
        for row, column in zip(rng.integers(0, 200, 30), rng.integers(0, 190, 30), strict=True):
            frame[row, column : column + 6] += 500.0
    result = neighbours.finish(accumulated(frames))
    value, error = result.curves["noise_correlation"][0]
    assert abs(value) < 4 * error
    assert result.values["temporal_corr_10"].value > 0.02
