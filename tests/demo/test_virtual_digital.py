"""Hidden converters and filters against what they are defined to do."""

import math
from dataclasses import replace

import numpy as np
import pytest
from demo_stacks import CALM, COLD, HOT, stack

from dnanalyze.demo import filters


def test_missing_codes_have_their_widths():
    x = stack({"missing_codes": {"shift": 0.6, "period": 8}}, HOT)
    counts = np.bincount(x.astype(int).ravel(), minlength=4096)
    smooth = np.bincount(stack(None, HOT).astype(int).ravel(), minlength=4096)
    at = np.arange(304, 560, 8)  # where the histogram is tall
    n = smooth[at].sum()
    tolerance = 5 * math.sqrt(2 / n)
    assert counts[at].sum() / n == pytest.approx(0.4, abs=tolerance)
    assert counts[at - 1].sum() / smooth[at - 1].sum() == pytest.approx(1.6, abs=tolerance + 0.02)
    assert counts[at + 1].sum() / smooth[at + 1].sum() == pytest.approx(1.0, abs=tolerance)
    gone = stack({"missing_codes": {"shift": 1.0, "period": 8}}, HOT)
    assert not np.any(gone % 8 == 0)


@pytest.mark.parametrize("gain", [1.3, 0.8])
def test_digital_gain_maps_codes_about_the_pedestal(gain):
    x = stack({"digital_gain": {"gain": gain}})
    np.testing.assert_array_equal(
        x, np.rint((stack() - CALM.pedestal_dn) * gain + CALM.pedestal_dn)
    )


def test_black_clipping_clips():
    x, bare = stack({"black_clipping": {"black_dn": 196.0}}), stack()
    np.testing.assert_array_equal(x, np.maximum(bare, 196.0))


def test_digital_gain_comes_before_dpc():
    both = stack(
        {"dpc": {"mode": "clamp", "threshold_dn": 0.0}, "digital_gain": {"gain": 1.3}}, HOT
    )
    for frame in both:
        assert np.all(frame <= filters.neighbours(frame).max(0))


def test_dpc_median_leaves_nothing_far_above_its_neighbours():
    hot = {"hot_pixels": {"fraction": 0.01, "e": 300.0, "activation_ev": 0.5}}
    x = stack(hot | {"dpc": {"mode": "median", "threshold_dn": 40.0}}, HOT)
    bare = stack(hot, HOT)
    for after, before in zip(x, bare, strict=True):
        around = filters.neighbours(before)
        defective = before > around.max(0) + 40.0
        assert defective.sum() > 100
        np.testing.assert_array_equal(after[~defective], before[~defective])
        np.testing.assert_array_equal(after[defective], np.rint(np.median(around, 0))[defective])


def test_dpc_by_ratio_spares_the_cold_and_dim():
    x, bare = stack({"dpc": {"mode": "ratio", "ratio": 2.0}}, HOT), stack(None, HOT)
    changed = x != bare
    median = np.median(filters.neighbours(bare[0]), 0) - CALM.pedestal_dn
    assert 1e-3 < changed.mean() < 0.2
    assert np.all((bare[0] - CALM.pedestal_dn)[changed[0]] > 2.0 * median[changed[0]])


def test_dpc_static_corrects_the_same_pixels_everywhere():
    hidden = {"dpc": {"mode": "static", "fraction": 0.01}}
    changed = [(stack(hidden, t) != stack(None, t)).any(axis=0) for t in (COLD, HOT)]
    assert changed[1].mean() == pytest.approx(0.01, abs=1e-3)
    assert np.mean(changed[1][changed[0]]) > 0.99
    # Mean of four independent neighbours: a quarter of the temporal variance.
    v = stack(hidden, COLD, frames=12).var(axis=0, ddof=1)
    assert v[changed[1]].mean() / v[~changed[1]].mean() == pytest.approx(0.25, abs=0.05)


def _white(kind: str, setting: dict[str, float], shape=(192, 256)) -> np.ndarray:
    sensor = replace(CALM, dark_e_s=1e-3, pixel_offset_e=0.0)
    return stack({"denoise": {"kind": kind} | setting}, COLD, 2, shape, sensor)


def test_gaussian_denoise_has_the_variance_of_its_kernel():
    x = _white("gaussian", {"sigma_px": 1.0})
    taps = np.exp(-0.5 * np.arange(-4, 5) ** 2)
    taps /= taps.sum()
    expected = CALM.noise_dn**2 * np.sum(taps**2) ** 2 + 1 / 12
    inner = x[:, 5:-5, 5:-5]
    assert inner.var() == pytest.approx(expected, rel=0.04)  # 5 sigma at 1/11 of the pixels


def test_median_denoise_repeats_its_neighbour():
    x = _white("median", {"mix": 1.0})
    # .210 for continuous values, besides what equal codes of noise 3 DN give by chance.
    d = np.diff(x, axis=2)
    sd = x.std()
    chance = 1 / (2 * sd * math.sqrt(math.pi))
    assert np.mean(d == 0) > 0.21
    assert np.mean(d == 0) < 0.21 + 2.0 * chance


@pytest.mark.parametrize("kind", ["bilateral", "nlm", "wavelet"])
def test_edge_preserving_denoise_smooths_noise_and_keeps_steps(kind):
    rng = np.random.default_rng(0)
    step = np.where(np.arange(128) < 60, 100.0, 400.0) * np.ones((96, 1))
    noisy = step + 5.0 * rng.standard_normal(step.shape)
    smooth = filters.DENOISERS[kind](noisy, 12.0)
    flat = (smooth - step)[:, 68:]
    assert flat.std() < 0.7 * 5.0
    assert abs(flat.mean()) < 0.5
    middle = smooth[:, 59:61].mean(axis=0)
    assert middle[1] - middle[0] > 250.0


def test_non_local_means_and_wavelet_are_those_of_other_packages():
    import pywt
    from skimage.restoration import denoise_nl_means

    rng = np.random.default_rng(1)
    image = np.rint(rng.normal(100.0, 5.0, (64, 96)))
    image[rng.random(image.shape) < 0.01] += 80.0
    other = denoise_nl_means(image, patch_size=3, patch_distance=3, h=6.0, fast_mode=True)
    np.testing.assert_allclose(filters.nlm(image, 6.0), other, atol=0.3)  # its exponential is rough
    low, *bands = pywt.wavedec2(image, "db2", mode="periodization", level=3)
    soft = [tuple(pywt.threshold(b, 6.0, "soft") for b in level) for level in bands]
    other = pywt.waverec2([low, *soft], "db2", mode="periodization")
    np.testing.assert_allclose(filters.wavelet(image, 6.0), other, atol=1e-9)


def test_bilateral_with_a_wide_range_is_a_gaussian_window():
    image = np.zeros((11, 11))
    image[5, 5] = 1.0
    spread = filters.bilateral(image, 1e6)
    assert spread.sum() == pytest.approx(1.0, abs=1e-6)
    assert spread[5, 6] / spread[5, 5] == pytest.approx(math.exp(-0.5 / 1.5**2), rel=1e-6)


def test_temporal_denoise_is_a_recursive_filter():
    a = 0.6
    x = stack({"temporal_denoise": {"past": a}}, frames=60)
    bare = stack(frames=60)
    temporal = bare.var(axis=0, ddof=1).mean()
    # Stationary AR(1) of x: variance (1-a)/(1+a), correlation a^k; half squared differences.
    for lag in (1, 3):
        half = np.mean((x[lag:] - x[:-lag]) ** 2) / 2
        expected = temporal * (1 - a) / (1 + a) * (1 - a**lag) + 1 / 12
        assert half == pytest.approx(expected, rel=0.02)
