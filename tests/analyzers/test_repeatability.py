"""Repeatability against further captures of the same sensor, and against closed forms."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.analyzers.repeatability import jackknife_variance, repeatability
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting

SHAPE, FRAMES, NOISE, PATTERN = (96, 96), 8, 3.0, 5.0
POINT = OperatingPoint(25.0, 0.1)
FIXED = 100.0 + PATTERN * np.random.default_rng(1).standard_normal(SHAPE)
GLOW = 40.0 * np.exp(-np.arange(SHAPE[1]) / 20.0)


def frame(name: str, pixels: np.ndarray) -> Frame:
    return Frame(name, POINT, lambda w: pixels if w is None else pixels[w.slices])


def captures(seed: int, frames: int = FRAMES) -> CaptureSet:
    """The same sensor, with glow at its edge, at another time."""
    rng = np.random.default_rng(seed)
    made = [FIXED + GLOW + NOISE * rng.standard_normal(SHAPE) for _ in range(frames)]
    taken = tuple(frame(str(n), y.astype(np.float32)) for n, y in enumerate(made))
    return CaptureSet("same sensor", Sensor(SHAPE), (Setting(POINT, taken),))


def stated(seed: int, name: str) -> tuple[float, float | None]:
    made = captures(seed)
    value = repeatability(made, analyze(made)).settings[0].values[name]
    return value.value, value.repeatability


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("mean", NOISE / math.sqrt(SHAPE[0] * SHAPE[1] * FRAMES)),
        ("temporal_noise", 1 / math.sqrt(2 * SHAPE[0] * SHAPE[1] * (FRAMES - 1))),  # of its log
    ],
)
def test_it_is_that_of_the_temporal_noise_whatever_the_fixed_pattern(name, expected):
    """Of 6 captures, 7 degrees of freedom each: within 3 / sqrt(2 * 42) of the closed form."""
    found = [stated(seed, name)[1] for seed in range(6)]
    assert None not in found
    rms = math.sqrt(np.mean(np.square(found)))
    assert abs(math.log(rms / expected)) < 3.0 / math.sqrt(2 * 6 * (FRAMES - 1))


def test_a_capture_of_two_frames_has_none():
    made = captures(3, frames=2)
    values = repeatability(made, analyze(made)).settings[0].values
    assert all(v.repeatability is None for v in values.values())


@pytest.mark.parametrize(("frames", "within"), [(6, 1.15), (8, 1.15)])
def test_products_of_two_frames_count_once(frames, within):
    """Mean of variances: 2 sigma^4 / (pixels (n - 1)); leaving out single frames overstates it."""
    pixels, trials = 200, 200
    rng = np.random.default_rng(5)
    found = []
    for _ in range(trials):
        stack = rng.standard_normal((frames, pixels))
        out = [o for k in (1, 2) for o in itertools.combinations(range(frames), k)]
        without = {o: np.delete(stack, o, axis=0).var(axis=0, ddof=1).mean() for o in out}
        found.append(jackknife_variance(stack.var(axis=0, ddof=1).mean(), without))
    assert 1 / within < np.mean(found) / (2 / (pixels * (frames - 1))) < within


def test_a_linear_statistic_keeps_the_variance_of_the_mean():
    """Of the mean of n numbers: s^2 / n, to rounding."""
    x = np.random.default_rng(6).standard_normal(7)
    out = [o for k in (1, 2) for o in itertools.combinations(range(7), k)]
    variance = jackknife_variance(x.mean(), {o: np.delete(x, o).mean() for o in out})
    assert variance == pytest.approx(x.var(ddof=1) / 7)
