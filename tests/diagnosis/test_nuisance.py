"""Parameters that a missing effect has biased."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.diagnosis.nuisance import (
    from_moments,
    least_noise,
    other_strengths,
    unbiased,
)
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.dark_current_steps import DarkCurrentSteps
from dnanalyze.model.effects.denoise import Denoise
from dnanalyze.model.effects.digital_gain import DigitalGain
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.effects.temporal_denoise import TemporalDenoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, built_in
from dnanalyze.model.simulate import simulate

POINT = OperatingPoint(25.0, 1.0, 1.0)
SIGMA, SHARE = 1.2, 0.45


def of_noise(sigma: float, *more) -> NoiseModel:
    return NoiseModel((ReadNoise(sigma), PixelFpn(1.0), Quantization(12), *more), 64.0, POINT, 1)


@pytest.fixture(scope="module")
def problem() -> FitProblem:
    model = of_noise(SIGMA, TemporalDenoise(SHARE))
    return fit_problem(design(simulate(model, (128, 128), [(POINT, 8)])))


def test_the_least_noise_is_that_of_the_frames(problem):
    after = np.sqrt((SIGMA**2 + 1 / 12) * (1 - SHARE) / (1 + SHARE) + 1 / 12)
    assert least_noise(problem) == pytest.approx(
        after, rel=0.1
    )  # eight frames, the first unfiltered


def test_parameters_are_corrected_by_factor_and_shift():
    gain, other = (DigitalGain(g, 20.0) for g in (1.6, 1.25))
    model = NoiseModel((ReadNoise(2.0),), 100.0, POINT)
    right = unbiased(model, gain, np.inf)
    assert right.get("read_noise").sigma == pytest.approx(2.0 / 1.6)
    assert right.pedestal == pytest.approx(20.0 + 80.0 / 1.6)
    changed = unbiased(model, gain, np.inf, other)  # fitted with the other in the model
    assert changed.get("read_noise").sigma == pytest.approx(2.0 * 1.25 / 1.6)
    assert changed.pedestal == pytest.approx(20.0 + 80.0 * 1.25 / 1.6)
    assert unbiased(model, gain, np.inf, gain) is None


@pytest.mark.parametrize("name", ["heavy_tailed_read_noise", "noisy_pixels", "rts"])
def test_a_spread_is_shared_with_a_second_population(name):
    spread = 0.4
    model = NoiseModel((ReadNoise(2.0, spread=spread),), 100.0, POINT)
    right = unbiased(model, built_in()[name](), 2.0)
    assert right.get("read_noise").spread ** 2 == pytest.approx(spread**2 / 2)


def test_an_effect_that_biases_nothing_leaves_the_model():
    assert unbiased(of_noise(SIGMA), RowNoise(1.0), 1.0) is None


def test_a_bilateral_filter_far_wider_than_the_noise_is_a_gaussian():
    noise = NoiseModel((ReadNoise(0.01),), 64.0, POINT)
    filtered, other = (
        unbiased(noise, Denoise(kind=k, space=1.0), 0.01) for k in ("bilateral", "gaussian")
    )
    assert filtered == other
    # a Gaussian of 1 pixel keeps 1 / (4 pi) of the variance of white noise
    assert filtered.get("read_noise").sigma == pytest.approx(0.01 * np.sqrt(4 * np.pi), rel=0.05)


@pytest.mark.parametrize("kind", ["bilateral", "nlm"])
def test_noise_far_beyond_the_range_of_a_filter_is_left(kind):
    noise = NoiseModel((ReadNoise(100.0, 0.3),), 64.0, POINT)
    there = unbiased(noise, Denoise(kind=kind, space=1.0), 100.0).get("read_noise")
    assert there.sigma == pytest.approx(100.0, rel=0.05)
    assert there.spread == 0.0
    assert unbiased(noise, Denoise(kind=kind, space=1.0), np.inf) is None


def test_another_strength_keeps_the_noise_that_is_measured():
    """Of noise sigma, a recursive filter of share a leaves sigma sqrt((1 - a) / (1 + a))."""
    tried = list(other_strengths(of_noise(SIGMA, TemporalDenoise(0.4)), "temporal_denoise", 1.0))
    assert len(tried) == 4
    for model in tried:
        share, sigma = model.get("temporal_denoise").share, model.get("read_noise").sigma
        left = sigma * np.sqrt((1 - share) / (1 + share))
        assert left == pytest.approx(SIGMA * np.sqrt(0.6 / 1.4), rel=1e-6)
    assert list(other_strengths(of_noise(SIGMA, RowNoise(1.0)), "row_noise", 1.0)) == []


def test_the_baseline_starts_from_the_moments_less_what_an_effect_adds(problem):
    model, steps = baseline_model(problem), DarkCurrentSteps(step=5.0, mean_number=0.3)
    begun, wanted = from_moments(problem, model, steps), baseline_model(problem, steps)
    for name in (BASE, "dark_shot_noise", "read_noise"):
        assert begun.get(name) == wanted.get(name)
    assert begun.pedestal == wanted.pedestal
    assert wanted.get(BASE) != model.get(BASE)
    assert from_moments(problem, model, RowNoise(1.0)) is None
