"""The register: cumulants of a compound Poisson law, and the exact distribution at high gain."""

import numpy as np
import pytest
from charge_bench import HERE, LONG, LOUD, MadeUpClues, flat, frames, same_from_a_window
from scipy import stats

from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.electron_multiplication import (
    ElectronMultiplication,
    excess_noise,
    poisson,
)
from dnanalyze.model.effects.read_noise import ReadNoise

NONE = 1e-4  # e-, least clock-induced charge


def sensor(level, k, excess=2.0, induced=NONE):
    return flat(level), DarkShotNoise(k), ElectronMultiplication(excess, induced)


@pytest.mark.parametrize("excess", [1.3, 2.0])
@pytest.mark.parametrize("electrons", [0.3, 6.0, 80.0])
def test_cumulants_of_a_multiplied_poisson_number(excess, electrons):
    k = 4.0
    y = frames(sensor(k * electrons, k, excess), (256, 256), 8) / k
    n, more = y.size, excess - 1.0
    # moments of one electron's share: Gamma(1/f) f has E g^r = (1)(1 + f)(1 + 2 f)...
    power = [np.prod(1.0 + more * np.arange(r)) for r in range(1, 7)]
    mean, variance, third = (electrons * p for p in power[:3])
    m4 = electrons * power[3] + 3 * variance**2
    away = y - y.mean()
    assert y.mean() == pytest.approx(mean, abs=5 * np.sqrt(variance / n))
    assert y.var() == pytest.approx(variance, abs=5 * np.sqrt((m4 - variance**2) / n))
    spread = np.sqrt(np.mean(away**6) / n)
    assert np.mean(away**3) == pytest.approx(third, abs=5 * spread + 0.005 * third)


def test_one_and_three_electrons_leave_by_erlangs_law():
    # Basden et al. 2003: n electrons in, x^(n-1) e^-x / (n-1)! out, over the gain, at high gain
    one = frames((flat(1.0), ElectronMultiplication(2.0, NONE)), (256, 256))[0]
    assert stats.kstest(one.ravel(), stats.expon.cdf).pvalue > 1e-3
    three = frames((flat(3.0), ElectronMultiplication(2.0, NONE)), (256, 256))[0]
    assert stats.kstest(three.ravel(), stats.gamma(3).cdf).pvalue > 1e-3


def test_clock_induced_charge_is_the_same_at_any_exposure_and_follows_the_gain():
    k, c = 5.0, 0.4
    for point in (HERE, LONG):
        dark = frames((DarkShotNoise(k), ElectronMultiplication(1.01, c)), (256, 256), 4, point)
        se = k * np.sqrt(1.01 * c / dark.size)
        assert dark.mean() == pytest.approx(k * c, abs=5 * se)
    loud = frames((DarkShotNoise(k), ElectronMultiplication(1.01, c)), (256, 256), 4, LOUD)
    assert loud.mean() == pytest.approx(2 * k * c, abs=10 * se)
    none = frames((DarkShotNoise(k), ElectronMultiplication(2.0, c)), (256, 256))[0]
    share = np.exp(-c)
    assert np.mean(none == 0) == pytest.approx(share, abs=5 * np.sqrt(share / none.size))


def test_counts_are_poissons():
    u = (np.arange(200_000) + 0.5) / 200_000
    for mean in (1e-4, 0.02, 3.0, 200.0):
        n = poisson(mean, u)
        assert n.mean() == pytest.approx(mean, rel=2e-3, abs=5e-6)
        assert n.var() == pytest.approx(mean, rel=5e-3, abs=5e-6)


def test_excess_noise_factor_of_a_register():
    # one electron through a cascade of elements, drawn one by one
    rng = np.random.default_rng(1)
    elements, probability = 20, 0.1
    n = np.ones(200_000, np.int64)
    for _ in range(elements):
        n += rng.binomial(n, probability)
    gain = (1 + probability) ** elements
    assert n.mean() == pytest.approx(gain, rel=0.01)
    assert 1.0 + n.var() / gain**2 == pytest.approx(excess_noise(gain, elements), rel=0.01)
    assert excess_noise(1.0, 500) == pytest.approx(1.0)
    assert excess_noise(1000.0, 536) == pytest.approx(2.0, abs=0.03)


def test_read_noise_is_not_multiplied():
    y = frames((DarkShotNoise(1.0), ElectronMultiplication(2.0, NONE), ReadNoise(3.0)))[0]
    assert y.std() == pytest.approx(3.0, rel=5 / np.sqrt(2 * y.size))


def test_windows_hold_the_pixels_of_the_whole_frame():
    same_from_a_window(sensor(2.0, 1.0, 2.0, 0.3))
    same_from_a_window(sensor(40.0, 1.0, 1.5))


def made_up(ratio):
    """Two settings, 4 frames each, whose third cumulant is ``ratio`` times that of counting."""
    rng = np.random.default_rng(2)
    points, seen = [], {"mean": [], "s2_temporal": [], "temporal_third_cumulant": []}
    for electrons in (20.0, 200.0):
        # a shifted gamma of this mean, variance and third cumulant
        shape = 4 * electrons**3 / (ratio * electrons) ** 2
        noise = rng.gamma(shape, np.sqrt(electrons / shape), (4, 200_000))
        y = 1000 + np.rint(noise - np.sqrt(electrons * shape) + electrons)
        seen["mean"].append(y.mean())
        seen["s2_temporal"].append(y.var(axis=0, ddof=1).mean())
        seen["temporal_third_cumulant"].append(stats.kstat(y, 3, axis=0).mean())
        points.append(HERE)
    return MadeUpClues(tuple(points), seen=seen, stands_out=("temporal_skewness",))


def test_it_is_guessed_from_the_skewness_of_the_noise_alone():
    assert ElectronMultiplication.guess(made_up(1.0)) == []
    guesses = ElectronMultiplication.guess(made_up(1.4))
    assert guesses[0].excess == 2.0
    assert guesses[1].excess == pytest.approx(1 / 0.6, rel=0.1)


def test_skewness_of_no_counted_charge_leaves_high_gain_alone():
    (only,) = ElectronMultiplication.guess(made_up(0.4))
    assert only.excess == 2.0


def test_photon_transfer_without_it_has_the_gain_too_large():
    effect = ElectronMultiplication(1.8)
    assert effect.nuisance_bias("dark_shot_noise.dn_per_e", "DN/e-") == (1 / 1.8, 0.0)
    assert effect.nuisance_bias("read_noise.sigma", "DN") == (1.0, 0.0)
