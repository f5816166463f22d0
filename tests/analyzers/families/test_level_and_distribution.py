import math

import numpy as np
import pytest
from dark_frames import dark_frames
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal, stats

from dnanalyze.analyzers.estimators.quantiles import Ordered
from dnanalyze.analyzers.estimators.steps import pattern_steps
from dnanalyze.analyzers.families import distribution, level
from dnanalyze.analyzers.families.distribution import lognormal_through, peaks, summits
from dnanalyze.analyzers.streaming.accumulation import accumulate

SHAPE = (160, 192)
SIGMAS = 5


def near(value, truth, more=0.0):
    """Within 5 stated standard errors and ``more``, for the approximation of the truth."""
    assert abs(value.value - truth) < SIGMAS * value.se + more, (value, truth)


def near_log(value, truth, more=0.0):
    assert abs(math.log(value.value / truth)) < SIGMAS * value.se + more, (value, truth)


@pytest.mark.parametrize("codes", [True, False])
def test_levels_of_a_log_normal_pattern_with_gaussian_noise(codes):
    frames = dark_frames(11, 8, SHAPE, hot=0.0, spread=0.4, noise=2.0, codes=codes)
    values = level.finish(accumulate(frames).finish()).values
    q, m1 = math.exp(0.4**2), 4 * math.exp(0.4**2 / 2)
    step = 1 / 12 if codes else 0.0
    near(values["mean"], 100 + m1)
    near_log(values["temporal_noise"], math.sqrt(4 + step))
    near_log(values["temporal_noise_core"], math.sqrt(4 + step), 0.002)
    near(values["s2_temporal"], 4 + step)
    pattern_variance = m1**2 * (q - 1)
    near_log(values["pattern_noise"], math.sqrt(pattern_variance + (4 + step) / 8), 0.01)
    near(values["dsnu_1288"], math.sqrt(pattern_variance), 0.005)


@pytest.mark.parametrize("wanders", [False, True])
def test_the_error_of_the_level_holds_where_it_scatters_or_wanders(wanders):
    rng = np.random.default_rng(21)
    pulls = []
    for _ in range(200):
        levels = rng.normal(size=6)
        if wanders:
            levels = np.cumsum(np.append(0.0, levels[1:]))  # from the level that is asked for
        frames = [100.0 + 0.3 * a + rng.normal(size=(64, 64)) for a in levels]
        values = level.finish(accumulate(np.float32(frames)).finish()).values
        pulls.append((values["mean"].value - 100.0) / values["mean"].se)
    # of means of 6 the pulls are t-distributed (sd 1.29); 200 tell their sd by some 10 %
    assert 0.9 < np.std(pulls) < (2.2 if wanders else 1.8)


def test_quantiles_are_those_of_the_convolved_law():
    frames = dark_frames(12, 4, SHAPE, hot=0.0, spread=0.5, noise=2.0)
    values = distribution.finish(accumulate(frames).finish()).values
    rng = np.random.default_rng(99)
    draws = 4 * np.exp(0.5 * rng.normal(size=4_000_000))
    single = draws + 2.0 * rng.normal(size=draws.size)
    mean = draws + math.sqrt((4 + 1 / 12) / 4) * rng.normal(size=draws.size)
    for text in distribution.LEVELS[:-1]:
        p = float(text)
        for what, law in (("frame", single), ("pattern", mean)):
            truth, middle = np.quantile(law, [p, 0.5])
            near(values[f"{what}_q{text}"], truth - middle, 0.01 + 0.02 * (p > 0.99))
    for text in distribution.TEMPORAL_LEVELS:
        near(
            values[f"temporal_q{text}"], stats.norm.ppf(float(text), 0, math.sqrt(4 + 1 / 12)), 0.02
        )
    near(values["temporal_kurtosis"], 0.0)
    near(values["temporal_skewness"], 0.0)


@pytest.mark.parametrize(("count", "drift"), [(3, 0.0), (6, 0.0), (6, 30.0)])
def test_the_skewness_of_counted_charge_is_poissons_however_the_level_moves(count, drift):
    """The third cumulant of K n is K^3 n, whatever the pixels' means; read noise has none."""
    rng = np.random.default_rng(14)
    gain, noise, pulls, thirds = 3.0, 2.0, [], []
    for _ in range(40):
        rate = 5.0 * np.exp(0.5 * rng.normal(size=(96, 128)))
        frames = [
            gain * rng.poisson(rate) + noise * rng.normal(size=rate.shape) + 500 + drift * a
            for a in rng.normal(size=count)
        ]
        values = distribution.finish(accumulate(np.float32(frames)).finish()).values
        m2, m3 = gain**2 * rate.mean() + noise**2, gain**3 * rate.mean()
        found = values["temporal_skewness"]
        pulls.append((found.value - m3 / m2**1.5) / found.se)
        thirds.append(values["temporal_third_cumulant"].value / m3 - 1.0)
    assert abs(np.mean(pulls)) < 5 / math.sqrt(40)
    assert 0.6 < np.std(pulls) < 1.5  # 40 tell their sd by 11 %
    assert np.mean(thirds) == pytest.approx(0.0, abs=5 * np.std(thirds) / math.sqrt(40))


@pytest.mark.parametrize(
    ("frames", "reason"),
    [(2, "needs at least three frames"), (4, "the frames differ by their levels alone")],
)
def test_no_skewness_without_three_frames_that_differ(frames, reason):
    still = dark_frames(12, 1, SHAPE)[0].astype(np.float32)
    noise = np.random.default_rng(2).normal(size=SHAPE).astype(np.float32)
    seen = [still, still + noise] if frames == 2 else [still + np.float32(k * k) for k in range(4)]
    out = distribution.finish(accumulate(seen).finish())
    assert out.missing["temporal_skewness"] == reason


def test_codes_and_continuous_data_of_one_law_agree_but_for_a_twelfth():
    codes = level.finish(accumulate(dark_frames(13, 6, SHAPE, noise=1.0)).finish()).values
    plain = level.finish(
        accumulate(dark_frames(13, 6, SHAPE, noise=1.0, codes=False)).finish()
    ).values
    assert codes["temporal_noise"].value ** 2 - plain["temporal_noise"].value ** 2 == pytest.approx(
        1 / 12, abs=5 * 2 * 1.04 * plain["temporal_noise"].se
    )
    for name in ("median", "mean", "pattern_noise_core"):
        difference = codes[name].value - plain[name].value
        assert abs(difference) < 5 * plain[name].se + 0.01


def test_emva_split_finds_rows_columns_and_pixels():
    rng = np.random.default_rng(14)
    pattern = 100 + 1.5 * rng.normal(size=SHAPE)
    pattern += 0.8 * rng.normal(size=SHAPE[1]) + 0.4 * rng.normal(size=SHAPE[0])[:, None]
    frames = [(pattern + rng.normal(size=SHAPE)).astype(np.float32) for _ in range(4)]
    values = level.emva_split(accumulate(frames).finish())
    near(values["dsnu_1288_pix"], 1.5)
    near(values["dsnu_1288_col"], 0.8)
    near(values["dsnu_1288_row"], 0.4)
    near(values["dsnu_1288"], math.sqrt(1.5**2 + 0.8**2 + 0.4**2))


def test_column_offsets_widen_the_error_of_the_mean():
    columns = dark_frames(15, 3, SHAPE, columns=2.0, hot=0.0)
    value = level.finish(accumulate(columns).finish()).values["mean"]
    # sd of the mean of 192 column offsets; white pixels alone would give .02
    assert value.se == pytest.approx(2.0 / math.sqrt(SHAPE[1]), rel=0.5)


def test_shape_is_scipys():
    frames = dark_frames(16, 3, SHAPE, codes=False)
    values = distribution.finish(accumulate(frames).finish()).values
    pattern = np.mean(np.array(frames, float), axis=0).ravel()
    assert values["pattern_skewness"].value == pytest.approx(stats.skew(pattern), rel=1e-3)
    assert values["pattern_kurtosis"].value == pytest.approx(stats.kurtosis(pattern), rel=1e-3)
    every = np.ravel(frames)
    assert values["frame_skewness"].value == pytest.approx(stats.skew(every), rel=1e-2)


def test_one_frame_tells_no_temporal_noise_and_says_so():
    acc = accumulate(dark_frames(17, 1, SHAPE)).finish()
    for family in (level, distribution):
        result = family.finish(acc)
        names = {info.name for info in family.INFOS}
        assert set(result.values) | set(result.missing) == names
        assert not any(n.startswith(("pattern_", "temporal_")) for n in result.values)
        assert "one frame" in result.missing[next(n for n in names if n.startswith("pattern_"))]
    assert "frame_q0.001" in distribution.finish(acc).values


def test_log_normal_through_its_own_quantiles():
    law = stats.lognorm(0.7, 3.0, math.exp(1.2))
    mu, delta, shift = lognormal_through(law.ppf([0.05, 0.5, 0.95]))
    assert (mu, delta, shift) == pytest.approx((1.2, 0.7, 3.0), rel=1e-6)
    assert lognormal_through(np.array([0.0, 1.0, 1.5])) is None


def test_steps_are_found_with_their_spacing():
    rng = np.random.default_rng(18)
    steps = 7.0 * rng.poisson(2.0, 60_000) + rng.normal(0, 0.8, 60_000)
    strength, spacing = pattern_steps(Ordered(steps.astype(np.float32)), 0.8)
    assert spacing.value == pytest.approx(7.0, rel=0.05)
    assert strength.value > 30


def test_smooth_patterns_have_no_steps():
    for seed in range(20):
        smooth = 4 * np.exp(0.5 * np.random.default_rng(seed).normal(size=30_000))
        strength, _ = pattern_steps(Ordered(smooth.astype(np.float32)), 0.2)
        # the largest of at most 256 exponential deviates over their mean: 12 with p ~ .002
        assert strength.value < 15


def test_peaks_of_a_histogram():
    x = np.arange(200)
    one = np.random.default_rng(19).poisson(500 * np.exp(-(((x - 80) / 20) ** 2)))
    two = one + np.random.default_rng(20).poisson(300 * np.exp(-(((x - 150) / 8) ** 2)))
    assert peaks(one) == 1
    assert peaks(two) == 2


@given(st.lists(st.integers(0, 40), min_size=1, max_size=60, unique=True), st.integers(1, 30))
def test_summits_are_maxima_of_some_prominence(heights, least):
    """As many as by the definition, which looks left and right of each maximum."""
    curve = np.array(heights, float)
    padded = np.concatenate(([0.0], curve + 1e-6, [0.0]))
    found, _ = signal.find_peaks(padded, prominence=least)
    assert summits(curve + 1e-6, least) == len(found)


def test_curves_count_every_pixel():
    acc = accumulate(dark_frames(21, 3, SHAPE)).finish()
    curves = distribution.finish(acc).curves
    pixels = SHAPE[0] * SHAPE[1]
    assert curves["histogram_counts"].sum() == 3 * pixels
    assert curves["pattern_hist_n"].sum() == pixels
    assert curves["difference_hist_n"].sum() == 2 * pixels
