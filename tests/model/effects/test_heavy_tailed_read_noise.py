import numpy as np
import pytest
from readout_bench import POINT, Given, added
from scipy.stats import norm, t, tukeylambda

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.heavy_tailed_read_noise import (
    FAR_ERROR,
    QUARTILE,
    HeavyTailedReadNoise,
    student,
    tukey_lambda,
)

SHAPE = (256, 256)


def noise(tail, **more):
    return added(HeavyTailedReadNoise(2.0, tail), count=4, shape=SHAPE, **more)


@pytest.mark.parametrize("tail", [0.14, 0.0, -0.1, -0.2])
def test_quantiles_are_those_of_the_tukey_lambda_distribution(tail):
    x = noise(tail).ravel()
    scale = 2.0 * 0.6744898 / tukeylambda.ppf(0.75, tail)
    for p in (0.001, 0.1, 0.25, 0.5, 0.75, 0.9, 0.999):
        q = tukeylambda.ppf(p, tail)
        density = 1.0 / (p ** (tail - 1.0) + (1.0 - p) ** (tail - 1.0)) / scale
        se = np.sqrt(p * (1 - p) / x.size) / density
        assert np.quantile(x, p) == pytest.approx(q * scale, abs=5 * se)


@pytest.mark.parametrize("tail", [0.14, 0.0, -0.1])
def test_variance_has_its_closed_form(tail):
    x = noise(tail).ravel()
    kurtosis = 3.0 + tukeylambda.stats(tail, moments="k")
    expected = HeavyTailedReadNoise(2.0, tail).variance(POINT)
    assert x.var() == pytest.approx(expected, rel=5 * np.sqrt((kurtosis - 1) / x.size))


def test_smooth_in_the_tail_through_zero():
    below, at, above = (noise(t) for t in (-2e-4, 0.0, 2e-4))
    assert np.abs(below - at).max() < 0.05
    assert np.abs(above - at).max() < 0.05


def test_new_in_every_frame_and_follows_gain():
    x = noise(-0.1)
    n = x[0].size
    assert abs(np.corrcoef(x[0].ravel(), x[1].ravel())[0, 1]) < 5 / np.sqrt(n)
    loud = noise(-0.1, point=OperatingPoint(85.0, 5.0, 3.0))
    assert np.median(np.abs(loud)) / np.median(np.abs(x)) == pytest.approx(3.0, rel=0.02)


def test_guess_reads_the_tail_off_the_quantile():
    tail = -0.2
    ratio = 0.6744898 * tukeylambda.ppf(0.999, tail) / tukeylambda.ppf(0.75, tail)
    clues = Given(
        seen={"temporal_noise_core": 2.0, "temporal_q0.999": 2.0 * ratio},
        off={"temporal_kurtosis": 30.0},
    )
    alone, beside, student = HeavyTailedReadNoise.guess(clues)
    assert alone.tail == pytest.approx(tail, abs=0.01)
    assert beside.tail < alone.tail
    assert beside.sigma < alone.sigma < 2.0
    # a quantile of t / quartile at 99.9 % of 6.8 is that of 5.0 degrees of freedom or so
    reach = QUARTILE * t.ppf(0.999, student.freedom) / t.ppf(0.75, student.freedom)
    assert student.form == "student"
    assert reach == pytest.approx(ratio, rel=0.05)  # a grid of factors of 1.05
    assert HeavyTailedReadNoise.guess(Given(off={"temporal_kurtosis": -9.0})) == []


def test_noise_of_pixels_that_repeats_less_than_in_the_model_is_a_sign_of_tails():
    """A fit took the tails for a spread of sigma: neither kurtosis nor quantiles are left."""
    seen = {"temporal_noise_core": 2.0, "temporal_q0.999": 12.0}
    assert HeavyTailedReadNoise.guess(Given(seen=seen, off={"blink_repeat": -10.0}))
    assert HeavyTailedReadNoise.guess(Given(seen=seen, off={"blink_repeat": 10.0})) == []


def test_the_quietest_setting_is_asked_first():
    points = tuple(OperatingPoint(t, 1.0, 1.0) for t in (25.0, 65.0, 105.0))
    clues = Given(
        points=points,
        seen={
            "temporal_noise_core": np.array([0.5, 1.0, 2.0]),
            "temporal_q0.999": np.array([1.8, 5.0, 10.0]),
        },
        off={"temporal_kurtosis": 30.0},
    )
    quiet, typical, *_ = HeavyTailedReadNoise.guess(clues)
    assert quiet.sigma == pytest.approx(0.45)
    assert typical.tail < quiet.tail - 0.05


@pytest.mark.parametrize("tail", [0.14, 0.0, -0.2])
def test_each_deviate_is_exact_in_single_precision(tail):
    z = np.array([-5.5, -2.0, -1e-3, 1e-3, 0.7, 3.0, 6.0], np.float32)
    p = norm.cdf(z.astype(float))
    exact = tukeylambda.ppf(p, tail) if tail else np.log(p) - norm.logsf(z.astype(float))
    np.testing.assert_allclose(tukey_lambda(z, tail), exact, rtol=2.0**-23)


@pytest.mark.parametrize("freedom", [2.1, 5.0, 30.0])
def test_student_deviates_have_their_exact_quantiles(freedom):
    z = np.array([-6.2, -2.0, -0.01, 0.01, 0.7, 3.0, 6.2], np.float32)
    exact = np.sign(z) * t.isf(norm.sf(np.abs(z.astype(float))), freedom)
    np.testing.assert_allclose(student(z, freedom), exact, rtol=1e-5, atol=2e-6)


@pytest.mark.parametrize("freedom", [4.0, 8.0, 30.0])
def test_student_noise_has_the_stated_quartile_and_variance(freedom):
    effect = HeavyTailedReadNoise(2.0, form="student", freedom=freedom)
    x = added(effect, count=4, shape=SHAPE)
    scale = 2.0 * QUARTILE / t.ppf(0.75, freedom)
    assert effect.variance(POINT) == pytest.approx(scale**2 * freedom / (freedom - 2), rel=1e-5)
    for p in (0.01, 0.25, 0.5, 0.75, 0.99):
        q = t.ppf(p, freedom)
        se = np.sqrt(p * (1 - p) / x.size) / t.pdf(q, freedom) * scale
        assert np.quantile(x, p) == pytest.approx(q * scale, abs=5 * se)
    if freedom > 4.0:
        kurtosis = 3.0 + 6.0 / (freedom - 4.0)
        error = 5 * np.sqrt((kurtosis - 1) / x.size)
        assert x.var() == pytest.approx(effect.variance(POINT), rel=error)


def test_tails_that_so_few_deviates_do_not_tell_from_gaussian_ones_are_not_shown():
    pixels = 128 * 256
    far = norm.ppf(0.999)
    error = np.sqrt(0.999 * 0.001) / norm.pdf(far) / far
    assert pytest.approx(FAR_ERROR, rel=1e-3) == error
    assert not HeavyTailedReadNoise(4.0, 0.1373).shows_in(6, pixels)
    assert HeavyTailedReadNoise(4.0, 0.1).shows_in(6, pixels)
    assert not HeavyTailedReadNoise(4.0, 0.1).shows_in(1, 1000)
    students = HeavyTailedReadNoise(4.0, form="student", freedom=30.0)
    assert students.shows_in(6, pixels)
    assert not students.shows_in(1, 1000)


@pytest.mark.parametrize(
    "effect",
    [HeavyTailedReadNoise(2.0, -0.1), HeavyTailedReadNoise(2.0, form="student", freedom=6.0)],
)
def test_beside_it_the_noise_has_the_variance_and_the_correlation_of_a_fit_without(effect):
    """The Gaussian noise of the model without is all of the noise."""
    noise, serial = 5.0, -0.08
    factors = {
        name: effect.nuisance_bias(f"read_noise.{name}", unit, noise)
        for name, unit in (("sigma", "DN"), ("serial", "1"))
    }
    assert all(shift == 0.0 for _, shift in factors.values())
    left = (factors["sigma"][0] * noise) ** 2
    assert left + effect.variance(OperatingPoint()) == pytest.approx(noise**2)
    assert left * factors["serial"][0] * serial == pytest.approx(noise**2 * serial)


def test_of_the_gaussian_noise_some_is_left_beside_tails_that_are_all_of_it():
    factor, _ = HeavyTailedReadNoise(9.0, -0.2).nuisance_bias("read_noise.sigma", "DN", 5.0)
    assert factor == pytest.approx(0.3)
    unknown, _ = HeavyTailedReadNoise(9.0, -0.2).nuisance_bias("read_noise.sigma", "DN")
    assert unknown == factor
