import math

import numpy as np
import pytest
from dark_frames import dark_frames
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage, signal
from scipy.stats import norm

from dnanalyze.analyzers.families import codes, tails, time
from dnanalyze.analyzers.streaming.accumulation import accumulate

SHAPE = (128, 160)


def values_of(family, frames):
    return family.finish(accumulate(frames).finish()).values


def gaussian(seed, count, noise=2.0, shape=SHAPE):
    rng = np.random.default_rng(seed)
    return [np.rint(100 + noise * rng.normal(size=shape)).astype(np.uint16) for _ in range(count)]


def test_hot_and_cold_counts_are_those_put_in():
    rng = np.random.default_rng(1)
    pattern = 100 + rng.normal(size=SHAPE)
    at = rng.permutation(pattern.size)
    sigma = math.sqrt(1 + 0.25 / 4)
    for share, level in ((slice(0, 40), 12), (slice(40, 60), 24), (slice(60, 70), 300)):
        pattern.flat[at[share]] = 100 + level * sigma
    pattern.flat[at[70:85]] = 100 - 6.5 * sigma
    frames = [(pattern + 0.5 * rng.normal(size=SHAPE)).astype(np.float32) for _ in range(4)]
    values = values_of(tails, frames)
    counts = {k: values[f"hot_count_{k}"].value for k in tails.HOT}
    assert counts == {5: 70, 8: 70, 16: 30, 32: 10, 64: 10, 128: 10}
    assert values["cold_count_5"].value == 15
    assert values["cold_count_8"].value == 0


def test_neighbours_are_found_in_all_eight_directions():
    mask = np.zeros((12, 12), bool)
    mask[0, 0] = mask[11, 11] = mask[5, 11] = mask[6, 0] = True  # alone, across the edges
    assert tails.links(mask).clump_sizes().tolist() == [1] * 4
    for dr, dc in [(-1, -1), (-1, 0), (-1, 1), (0, 1)]:
        pair = mask.copy()
        pair[4, 5] = pair[4 + dr, 5 + dc] = True
        assert sorted(tails.links(pair).clump_sizes()) == [1, 1, 1, 1, 2, 2]
    assert tails.links(np.ones((3, 3), bool)).clump_sizes().tolist() == [9] * 9
    assert tails.links(np.zeros((3, 3), bool)).clump_sizes().size == 0


def test_clumps_are_those_of_labelled_regions():
    mask = np.random.default_rng(4).random((200, 300)) < 0.15
    label, _ = ndimage.label(mask, np.ones((3, 3)))
    expected = np.bincount(label.ravel())[label[mask]]
    np.testing.assert_array_equal(tails.links(mask).clump_sizes(), expected)


def test_errors_of_counts_are_those_of_the_clumps_in_which_they_come():
    counts, errors = {}, {}
    for seed in range(60):
        rng = np.random.default_rng([seed, 9])
        frames = gaussian(seed, 5)
        for frame in frames:  # tracks of 2 to 10 pixels, 5 a frame
            for _ in range(rng.poisson(5)):
                r, c, n = rng.integers(1, 127), rng.integers(1, 140), rng.integers(2, 11)
                frame[r, c : c + n] += 80
        values = values_of(tails, frames)
        for name in ("transient_high", "transient_adjacent"):
            counts.setdefault(name, []).append(values[name].value)
            errors.setdefault(name, []).append(values[name].se)
    for name, seen in counts.items():
        # on the root scale 2 sqrt(n); 60 captures tell a deviation to 9 %
        assert np.std(2 * np.sqrt(seen)) == pytest.approx(np.mean(errors[name]), rel=0.3)


def test_transients_are_counted_and_tracks_known_by_their_frame():
    frames = gaussian(2, 6)
    frames[2][10, 20:26] += 90  # a track
    frames[4][50, 60] += 90
    frames[1][80, 80] += 90  # neighbours in different frames are no track
    frames[3][80, 81] += 90
    frames[5][90, 90] -= 60
    values = values_of(tails, frames)
    assert values["transient_high"].value == 9
    assert values["transient_low"].value == 1
    assert values["transient_adjacent"].value == 6


def test_hot_repeat_is_one_for_silicon_and_nought_for_cosmic_rays():
    fixed, moving = gaussian(3, 4), gaussian(4, 4)
    hot = np.random.default_rng(5).random(SHAPE) < 0.01
    for n in range(4):
        fixed[n][hot] += 100
        moving[n][np.roll(hot, 7 * n + 1, axis=1)] += 100
    assert values_of(tails, fixed)["hot_repeat"].value == 1.0
    assert values_of(tails, moving)["hot_repeat"].value < 0.05


def test_dead_pixels_never_change():
    frames = gaussian(6, 8, noise=6.0)  # chance: 20480 (1 / 15)^7 / sqrt 8 < 1e-4
    for frame in frames:
        frame[3, :7] = 4000
        frame[60, :3] = 0
    found = tails.finish(accumulate(frames).finish())
    assert found.values["dead_count"].value == 10
    assert found.curves["dead_codes"].tolist() == [4000, 0]
    quiet = tails.finish(accumulate(gaussian(6, 5, noise=0.1)).finish())
    assert "dead_count" in quiet.missing


def test_codes_of_dead_pixels_are_told_among_those_that_never_change_by_chance():
    frames = gaussian(6, 4, noise=0.8)  # a pixel in ten gives one code four times
    for frame in frames:
        frame[3, :7] = 4000
        frame[60, :5] = 131
    found = tails.finish(accumulate(frames).finish())
    assert found.values["dead_count"].value > 1000
    assert found.curves["dead_codes"].tolist() == [4000, 131]


def test_tail_index_of_a_pareto_tail():
    rng = np.random.default_rng(7)
    frames = [(100 + rng.pareto(2.5, SHAPE) * np.ones(1)).astype(np.float32)] * 2
    value = values_of(tails, frames)["tail_index"]
    assert abs(value.value - 2.5) < 5 * value.se + 0.25


def test_drift_and_its_trend():
    rng = np.random.default_rng(8)
    steps = np.array([0.0, 1.0, -0.5, 2.0, 0.3])
    frames = [(100 + 2 * rng.normal(size=SHAPE) + s).astype(np.float32) for s in steps]
    values = values_of(time, frames)
    assert values["drift"].value == pytest.approx(np.std(steps, ddof=1), rel=0.03)
    slope = np.polyfit(np.arange(5), steps, 1)[0]
    assert values["drift_trend"].value == pytest.approx(slope, abs=0.03)


def test_temporal_filter_shows_as_memory_and_white_noise_does_not():
    rng = np.random.default_rng(9)
    white = rng.normal(size=(12, *SHAPE)).astype(np.float32)
    filtered = white.copy()
    for n in range(1, 12):
        filtered[n] = 0.8 * filtered[n] * math.sqrt(1 - 0.5**2) / 0.8 + 0.5 * filtered[n - 1]
    value = values_of(time, list(white))["temporal_r1"]
    # the median of r1 of 12 normal values is within .02 of its mean, -1/12
    assert abs(value.value) < 5 * value.se + 0.02
    assert values_of(time, list(filtered))["temporal_r1"].value > 0.3


def test_variance_quantiles_of_equal_pixels_are_chi_squares():
    from scipy import stats

    rng = np.random.default_rng(10)
    values = values_of(time, [rng.normal(size=SHAPE).astype(np.float32) for _ in range(7)])
    for level in time.VARIANCE_LEVELS:
        value = values[f"temporal_variance_q{level}"]
        truth = stats.chi2.ppf(float(level), 6) / 6
        assert abs(math.log(value.value / truth)) < 5 * value.se


def test_blinking_pixels_repeat_and_heavy_noise_does_not():
    rng = np.random.default_rng(11)
    heavy = [(2 * rng.standard_t(4, SHAPE)).astype(np.float32) for _ in range(8)]
    value = values_of(time, heavy)["blink_repeat"]
    assert abs(value.value) < 5 * value.se
    some = np.where(rng.random(SHAPE) < 0.02, 6.0, 1.0)
    blinking = [(some * rng.normal(size=SHAPE)).astype(np.float32) for _ in range(8)]
    assert values_of(time, blinking)["blink_repeat"].value > 0.1


def test_shot_noise_grows_with_the_pattern():
    rng = np.random.default_rng(12)
    dark = 20 * np.exp(0.8 * rng.normal(size=SHAPE))
    frames = [(100 + rng.poisson(dark)).astype(np.uint16) for _ in range(16)]
    values = values_of(time, frames)
    order = np.sort(dark.ravel())
    n = order.size
    for name, (low, high, _) in time.GROUPS.items():
        truth = order[int(low * n) : int(high * n)].mean()
        value = values[f"noise_at_{name}"]
        # F of 16 frames does not order the pixels perfectly: 3 %
        assert abs(math.log(value.value / truth)) < 5 * value.se + 0.03


@pytest.mark.parametrize("noise", [0.2, 0.3, 0.5])
def test_on_little_noise_that_of_a_group_scatters_as_its_error_says(noise):
    """Most pixels then have one code: where a group ends among them, it has its share of them."""
    seen = []
    for seed in range(16):
        rng = np.random.default_rng(seed)
        pattern = 100 + 0.15 * rng.normal(size=SHAPE)
        frames = [np.rint(pattern + noise * rng.normal(size=SHAPE)) for _ in range(6)]
        values = values_of(time, [f.astype(np.uint16) for f in frames])
        found = [values[f"noise_at_{name}"] for name in time.GROUPS]
        seen.append([(math.log(v.value), v.se) for v in found])
    values, errors = np.moveaxis(np.array(seen), 2, 0)
    # of 16 values sd / sigma scatters by .18; errors of few pixels are wide rather than narrow
    ratio = values.std(axis=0, ddof=1) / errors.mean(axis=0)
    assert np.all(ratio < 1.9)
    assert np.all(ratio > 0.4)


def test_pattern_correlation_is_the_fixed_share_of_the_variance():
    rng = np.random.default_rng(13)
    pattern = 3 * rng.normal(size=SHAPE)
    frames = [(pattern + 2 * rng.normal(size=SHAPE)).astype(np.float32) for _ in range(4)]
    value = values_of(time, frames)["pattern_correlation"]
    assert abs(value.value - 9 / 13) < 5 * value.se


def test_missing_codes_make_gaps_roughness_and_a_comb():
    plain = gaussian(14, 4, noise=12.0)
    gaps = [np.where(f % 4 == 3, f - 1, f).astype(np.uint16) for f in plain]
    smooth, rough = values_of(codes, plain), values_of(codes, gaps)
    assert smooth["unused_codes"].value == 0
    assert rough["unused_codes"].value == pytest.approx(0.25, abs=0.03)
    assert rough["code_roughness"].value == pytest.approx(1 / math.sqrt(2), rel=0.15)
    assert rough["code_comb_period"].value == pytest.approx(4.0, rel=0.1)
    assert smooth["code_comb"].value < 0.05 < 0.5 < rough["code_comb"].value


@pytest.mark.parametrize("share", [0.005, 0.01, 0.02])
def test_a_gap_before_a_peak_of_hot_pixels_is_no_lack_of_codes(share):
    rng = np.random.default_rng(15)
    hot = 300.0 * (rng.random(SHAPE) < share)
    frames = [np.rint(100 + hot + 4 * rng.normal(size=SHAPE)).astype(np.uint16) for _ in range(4)]
    assert values_of(codes, frames)["unused_codes"].value == 0


def test_a_long_tail_makes_no_histogram_rough_and_hides_no_missing_codes():
    """Counts alone make it rough by the square root of codes over counts."""
    rng = np.random.default_rng(18)
    far = [np.where(rng.random(SHAPE) < 0.1, rng.lognormal(4.5, 1.2, SHAPE), 0) for _ in range(4)]
    frames = [f + t.astype(int) for f, t in zip(gaussian(19, 4, noise=14.0), far, strict=True)]
    gaps = [np.where(f % 4 == 3, f - 1, f) for f in frames]
    smooth, rough = (values_of(codes, [f.astype(np.uint16) for f in s]) for s in (frames, gaps))
    body = np.quantile(frames, [0.01, 0.99])
    chance = math.sqrt(np.ptp(body) / np.size(frames))
    value = smooth["code_roughness"]
    assert abs(math.log(value.value / chance)) < 4 * value.se
    assert rough["code_roughness"].value == pytest.approx(1 / math.sqrt(2), rel=0.15)
    assert rough["code_comb_period"].value == pytest.approx(4.0, rel=0.1)


def test_clipping_shows_as_spikes():
    plain = gaussian(15, 3, noise=6.0)
    clipped = [np.clip(f, 95, 108) for f in plain]
    values = values_of(codes, clipped)
    assert values["low_spike"].value > 2
    assert values["high_spike"].value > 1.5
    assert values["lowest_code"].value == 95
    assert values["clipped_low"].value == pytest.approx(np.mean(np.array(plain) <= 95), rel=1e-9)
    assert values_of(codes, plain)["low_spike"].value < 2


@pytest.mark.parametrize(("end", "name"), [(1, "low_spike"), (-1, "high_spike")])
def test_whether_a_few_pixels_reach_one_code_farther_hardly_changes_the_spike(end, name):
    frames = [f.astype(int) for f in gaussian(17, 3, noise=0.8)]
    last = min if end > 0 else max
    edge = last(f.min() if end > 0 else f.max() for f in frames) + 2 * end  # held by many pixels
    without = [np.where((f - edge) * end < 0, edge, f).astype(np.uint16) for f in frames]
    with_few = [f.copy() for f in without]
    with_few[0].flat[:5] = edge - end
    seen = [values_of(codes, f)[name] for f in (without, with_few)]
    apart = abs(math.log(seen[0].value / seen[1].value))
    assert apart < 5 * math.hypot(seen[0].se, seen[1].se)
    assert apart < 0.5


@pytest.mark.parametrize(
    ("counts", "strays"),
    [
        ((1500, 145_000), (1, 0)),
        ((1500, 145_000), (5, 0, 0)),
        ((3300, 8000), (1,)),
        ((40, 300, 3000), (2,)),
    ],
)
def test_strays_beyond_the_last_code_hardly_move_the_spike(counts, strays):
    """In no code of theirs does a pixel stay for all of the frames."""
    few = 0, 0  # codes within, for the short ones
    seen = [codes._spike(np.array(n), 6, 1.0) for n in ((*counts, *few), (*strays, *counts, *few))]
    assert abs(math.log(seen[0].value / seen[1].value)) < seen[0].se


def test_a_pixel_that_stays_far_out_is_a_spike():
    assert codes._spike(np.array([6, 0, 0, 40, 300]), 6, 1.0).value == pytest.approx(7.0)


def test_a_spike_goes_from_the_last_codes_ratio_to_the_next_as_counts_get_few():
    """Half way, in logs, where the last code has thirty counts more than there are frames."""
    last, second, third = 6 + codes.TAIL_COUNTS, 300, 3000
    seen = codes._spike(np.array([last, second, third]), 6, 1.0)
    ratios = (last + 1) / (second + 1), (last + second + 1) / (third + 1)
    assert seen.value == pytest.approx(math.sqrt(ratios[0] * ratios[1]), rel=1e-9)
    many = codes._spike(10_000 * np.array([9, 1, 50]), 6, 1.0)
    assert many.value == pytest.approx(9.0, rel=0.01)
    assert many.se == pytest.approx(0.02)
    fewer = codes._spike(np.array([1000, 100, 100]), 6, 1.0)
    assert fewer.se == pytest.approx(math.sqrt(1 / 1000 + 1 / 100), rel=0.1)


@given(
    last=st.integers(7, 400), more=st.floats(1.0, 20.0), fall=st.floats(1.0, 20.0),
    frames=st.integers(1, 6),
)  # fmt: skip
def test_no_count_makes_the_spike_jump(last, more, fall, frames):
    next_to = (int(last * more), int(last * more * fall), 1_000_000)
    seen = [codes._spike(np.array([n, *next_to]), frames, 1.0) for n in (last, last + 1)]
    assert abs(math.log(seen[0].value / seen[1].value)) < min(s.se for s in seen)


def test_spikes_of_normal_codes_scatter_as_they_say():
    """Of any noise at any level. Which code is the last one is chance, and allowed for."""
    rng = np.random.default_rng(23)
    pulls = [_pull(rng, sigma) for sigma in rng.uniform(0.4, 5.0, 600)]
    assert max(map(abs, pulls)) < 4.5
    assert 0.4 < np.std(pulls) < 1.1


def _pull(rng, sigma):
    """Difference of two draws of a histogram of 10^5 normal codes, over its error."""
    level, code = rng.uniform(), np.arange(-40, 3)
    share = np.diff(norm.cdf((np.append(code, 3) - 0.5 - level) / sigma))
    seen = []
    for drawn in rng.poisson(1e5 * share, (2, code.size)):
        seen.append(codes._spike(drawn[np.argmax(drawn > 0) :], 6, 1.0))
    return math.log(seen[0].value / seen[1].value) / math.hypot(seen[0].se, seen[1].se)


def test_lattice_and_entropy():
    assert values_of(codes, gaussian(16, 2))["lattice"].value == 1.0
    loose = codes.finish(accumulate(dark_frames(16, 2, SHAPE, codes=False)).finish())
    assert loose.values["lattice"].value < 0.05
    assert "whole codes" in loose.missing["code_comb"]
    flat = [np.random.default_rng(17).integers(0, 16, SHAPE).astype(np.uint16)]
    assert values_of(codes, flat)["effective_bits"].value == pytest.approx(4.0, abs=0.01)


@pytest.mark.parametrize("width", [5, 33, 129])
def test_a_histogram_is_smoothed_by_the_filter_of_savitzky_and_golay(width):
    counts = np.random.default_rng(4).poisson(50, 300).astype(float)
    expected = signal.savgol_filter(counts, width, 3, mode="constant")
    np.testing.assert_allclose(codes.smoothed(counts, width), np.maximum(expected, 0.5), rtol=1e-9)


def test_a_steep_end_of_a_narrow_histogram_is_not_rough():
    """A cubic falls through 0 there; a second population beyond makes the end part of the body."""
    counts = np.array([20, 205, 1279, 5641, 18879, 44976, 77357, 97184, 88952, 59024, 28768, 10298,
                       2716, 558, 97, 11, *[0] * 30, 900, 2200, 2400, 900])  # fmt: skip
    other = counts.copy()
    other[12:16] = 2792, 546, 90, 13
    seen = [values_of(codes, frames_of(n))["code_roughness"] for n in (counts, other)]
    assert abs(math.log(seen[0].value / seen[1].value)) < seen[0].se


def frames_of(counts):
    """One frame with so many pixels of every code, up to a part of a row."""
    values = np.repeat(np.arange(counts.size) + 94, counts).astype(np.uint16)
    return [values[: values.size // 320 * 320].reshape(-1, 320)]
