"""The paper's model against its exact moments and spectrum, and against nine normals a pixel."""

import math
from dataclasses import replace

import numpy as np
import pytest
from charge_bench import HERE, LONG, MadeUpClues, frames

from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.laws import ArrheniusLaw

SETS = [(2.0, 0.4, 0.05, 0.02), (1.0, 0.7, 0.01, 0.1), (3.0, 0.25, 0.1, 0.3), (0.0, 0.5, 0.0, 0.05)]
LAGS = ((0, 1), (1, 0), (1, 1), (0, 2), (2, 0), (1, 2), (2, 1), (2, 2), (0, 3))


def closed_form(mu, delta, phi, sigma):
    """Mean, variance, third and fourth cumulant, covariances, and the parts of the spectrum."""
    q = math.exp(delta**2)
    m1 = math.exp(mu + delta**2 / 2)
    m2, m3, m4 = m1**2 * q, m1**3 * q**3, m1**4 * q**6
    v, t = m1**2 * (q - 1), m1**3 * (q - 1) ** 2 * (q + 2)
    k2, k3, k4 = ((1 - 8 * phi) ** n + 8 * phi**n for n in (2, 3, 4))
    fourth = m4 - 4 * m1 * m3 + 6 * m1**2 * m2 - 3 * m1**4 - 3 * v**2
    covariances = {
        (0, 1): v * (2 * phi - 12 * phi**2),
        (1, 1): v * (2 * phi - 14 * phi**2),
        (0, 2): 3 * v * phi**2,
        (1, 2): 2 * v * phi**2,
        (2, 2): v * phi**2,
        (0, 3): 0.0,
    }
    return {
        "mean": m1,
        "variance": v * k2 + 9 * sigma**2 * m2,
        "third": t * k3 + 3 * sigma**2 * (m3 - m1 * m2),
        "fourth": fourth * k4
        + 6 * sigma**2 * k2 * (m4 - 2 * m1 * m3 + 2 * m1**2 * m2 - m2**2)
        + 27 * sigma**4 * (m4 - m2**2),
        "covariance": lambda dy, dx: covariances[tuple(sorted((dy, dx)))],
        "seed": v,
        "white": 9 * sigma**2 * m2,
    }


def moments(y):
    """Sample mean and cumulants 2 to 4 of a frame, then its covariances at LAGS."""
    d = y - y.mean()
    s2 = np.mean(d**2)
    out = [y.mean(), s2, np.mean(d**3), np.mean(d**4) - 3 * s2**2]
    rows, columns = y.shape
    for dy, dx in LAGS:
        out.append(np.mean(d[: rows - dy, : columns - dx] * d[dy:, dx:]))
    return np.array(out)


@pytest.mark.parametrize("at_c", [5.0, 45.0])
def test_a_spread_with_a_law_makes_the_moments_of_the_spread_it_has_there(at_c):
    law = ArrheniusLaw(0.2, 25.0, -0.35)
    spread = 0.2 * math.exp(0.35 / 8.617333e-5 * (1 / (at_c + 273.15) - 1 / 298.15))
    exact = closed_form(2.0, spread, 0.0, 1e-6)
    point = replace(HERE, temperature_c=at_c)
    light = ConvolvedLognormal(2.0, law, 0.0, 1e-6)
    assert light.variance(point) == pytest.approx(exact["variance"], rel=1e-9)
    (y,) = frames(light, point=point)
    count = y.size
    assert y.mean() == pytest.approx(exact["mean"], abs=4 * math.sqrt(exact["variance"] / count))
    fourth = exact["fourth"] / exact["variance"] ** 2 + 2
    assert y.var() == pytest.approx(exact["variance"], rel=4 * math.sqrt(fourth / count))


def nine_normals(mu, delta, phi, sigma, shape, rng):
    """The model as written: an own random 3x3 kernel at every pixel (periodic)."""
    light = np.exp(mu + delta * rng.normal(size=shape))
    out = np.zeros(shape)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            tap = phi if dy or dx else 1 - 8 * phi
            out += (tap + sigma * rng.normal(size=shape)) * np.roll(light, (dy, dx), (0, 1))
    return out


def samples(parameters, count, seed):
    effect = ConvolvedLognormal(*parameters, seed="redrawn")
    return frames(effect, (258, 258), count, seed=seed)[:, 1:-1, 1:-1]


@pytest.mark.parametrize("parameters", SETS)
def test_every_moment_and_covariance_of_the_closed_form(parameters):
    got = np.array([moments(y) for y in samples(parameters, 40, 1)])
    truth = closed_form(*parameters)
    expected = [truth[n] for n in ("mean", "variance", "third", "fourth")]
    expected += [truth["covariance"](*lag) for lag in LAGS]
    error = got.std(axis=0, ddof=1) / np.sqrt(len(got))
    z = (got.mean(axis=0) - expected) / error
    # 13 values, Student with 39 degrees of freedom, skewed for the fourth cumulant: 5 sigma
    assert np.abs(z).max() < 5


@pytest.mark.parametrize("parameters", SETS[:2])
def test_one_normal_a_pixel_is_nine(parameters):
    rng = np.random.default_rng(11)
    ours = np.array([moments(y) for y in samples(parameters, 24, 2)])
    direct = np.array([moments(nine_normals(*parameters, (256, 256), rng)) for _ in range(24)])
    error = np.sqrt(ours.var(axis=0, ddof=1) / 24 + direct.var(axis=0, ddof=1) / 24)
    assert np.abs((ours.mean(axis=0) - direct.mean(axis=0)) / error).max() < 5


def test_spectrum_is_the_kernel_s_over_a_white_floor():
    parameters = SETS[0]
    truth = closed_form(*parameters)
    phi = parameters[2]
    y = samples(parameters, 60, 3)
    y = y - y.mean(axis=(1, 2), keepdims=True)
    power = (np.abs(np.fft.fft2(y)) ** 2).mean(axis=0) / (256 * 256)
    u = np.cos(2 * np.pi * np.fft.fftfreq(256))
    k = 1 - 9 * phi + phi * (1 + 2 * u[:, None]) * (1 + 2 * u[None, :])
    ratio = power / (truth["seed"] * k**2 + truth["white"])
    bands = np.hypot(*np.meshgrid(np.fft.fftfreq(256), np.fft.fftfreq(256)))
    for low, high in ((0.02, 0.05), (0.05, 0.2), (0.2, 0.35), (0.35, 0.5), (0.5, 0.71)):
        inside = (bands > low) & (bands <= high)
        modes = inside.sum() / 2 * 60
        # exponential modes, and the common part of a heavy tail: (fourth cumulant / variance^2) / N
        common = truth["fourth"] / truth["variance"] ** 2 / y.size
        assert abs(ratio[inside].mean() - 1) < 5 * np.sqrt(1 / modes + common)


def test_fixed_seed_repeats_and_its_random_part_does_not():
    mu, delta, phi, sigma = SETS[1]
    fixed = frames(ConvolvedLognormal(mu, delta, phi, sigma), (256, 256), 2)
    truth = closed_form(mu, delta, phi, sigma)
    r = np.corrcoef(fixed[0].ravel(), fixed[1].ravel())[0, 1]
    assert r == pytest.approx(1 - truth["white"] / truth["variance"], abs=0.05)
    half = (fixed[0] - fixed[1]).var() / 2
    assert half == pytest.approx(truth["white"], rel=0.1)  # heavy tails: var(L^2) over 65536 pixels
    redrawn = frames(ConvolvedLognormal(mu, delta, phi, sigma, "redrawn"), (256, 256), 2)
    assert abs(np.corrcoef(redrawn[0].ravel(), redrawn[1].ravel())[0, 1]) < 5 / 256


def test_a_hot_pixel_leaves_the_kernel_around_it():
    y = frames(ConvolvedLognormal(0.0, 1.8, 0.04, 1e-6), (256, 256))[0]
    r, c = np.unravel_index(np.argmax(y[2:-2, 2:-2]), (252, 252))
    r, c = r + 2, c + 2
    around = np.delete(y[r - 1 : r + 2, c - 1 : c + 2].ravel(), 4)
    assert around.min() / y[r, c] > 0.9 * 0.04 / (1 - 8 * 0.04)


def test_signal_follows_exposure_only_where_told():
    proportional, none = (
        ConvolvedLognormal(2.0, 0.4, 0.01, 0.05, exposure=e) for e in ("proportional", "none")
    )
    # the frames' own noise is keyed by the point: compare the mean over pixels
    a, b, c = (
        frames(e, (256, 256), point=p).mean()
        for e, p in ((proportional, HERE), (proportional, LONG), (none, LONG))
    )
    assert b / a == pytest.approx(3, rel=1e-2)
    assert c / a == pytest.approx(1, rel=1e-2)


def test_variance_is_the_closed_form():
    for parameters in SETS:
        effect = ConvolvedLognormal(*parameters)
        assert effect.variance(HERE) == pytest.approx(closed_form(*parameters)["variance"])
    assert ConvolvedLognormal.guess(MadeUpClues()) == []


def test_extreme_parameters_stay_finite():
    for effect in (
        ConvolvedLognormal(-20.0, 1e-4, 0.0, 1e-6),
        ConvolvedLognormal(12.0, 4.0, 0.125, 1.0),
    ):
        assert np.isfinite(frames(effect, (64, 64))).all()
