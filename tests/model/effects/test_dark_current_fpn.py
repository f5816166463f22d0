"""Dark current of normal, gamma or exponential law: moments, quantiles, its scale, its guess."""

import numpy as np
import pytest
from charge_bench import HERE, LONG, WARM, MadeUpClues, flat, frames, growth
from scipy import stats

from dnanalyze.diagnosis.nuisance import unbiased
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.dark_current_fpn import LEFT, DarkCurrentFpn
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel

SHAPE = (256, 256)
PIXELS = SHAPE[0] * SHAPE[1]
LAWS = {
    "normal": lambda rms: stats.norm(1.0, rms),
    "gamma": lambda rms: stats.gamma(1 / rms**2, scale=rms**2),
    "exponential": lambda rms: stats.expon(1.0 - rms, rms),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("rms", [0.05, 0.2])
def test_it_has_the_distribution_that_it_states(law, rms):
    """Kolmogorov's distance of so many pixels exceeds 1.95 / sqrt(n) once in a thousand."""
    y = frames((flat(100.0), DarkCurrentFpn(rms, law)), SHAPE)[0] / 100.0
    assert y.mean() == pytest.approx(1.0, abs=4 * rms / np.sqrt(PIXELS))
    assert y.std() == pytest.approx(rms, rel=4 / np.sqrt(2 * PIXELS) * (1 + 3 * rms))
    assert stats.kstest(y.ravel(), LAWS[law](rms).cdf).statistic < 1.95 / np.sqrt(PIXELS)


def test_it_is_a_share_of_the_dark_charge_alone():
    effect = (flat(20.0), DarkCurrentFpn(0.1))
    here, again = frames(effect, SHAPE, 2)
    np.testing.assert_allclose(here, again, rtol=1e-4)
    longer, warmer = frames(effect, SHAPE, point=LONG)[0], frames(effect, SHAPE, point=WARM)[0]
    np.testing.assert_allclose(longer, 3.0 * here, rtol=1e-4)
    np.testing.assert_allclose(warmer / warmer.mean(), here / here.mean(), rtol=1e-4)
    noise = frames((*effect, ReadNoise(5.0)), SHAPE)[0] - here
    assert noise.std() == pytest.approx(5.0, rel=5 / np.sqrt(2 * PIXELS))


@pytest.mark.parametrize("law", LAWS)
def test_its_standard_deviation_has_an_activation_energy_of_its_own(law):
    """Differences of 0.3 eV less than the mean shrink over it as the sensor warms."""
    rms = 0.2
    y = frames((flat(20.0), DarkCurrentFpn(rms, law, ea_ev=-0.3)), SHAPE, point=WARM)[0]
    there = rms / growth(0.3)
    assert y.std() / y.mean() == pytest.approx(there, rel=4 / np.sqrt(2 * PIXELS) * (1 + 9 * rms))
    assert stats.kstest((y / y.mean()).ravel(), LAWS[law](there).cdf).statistic < 2.5 / 256


@pytest.mark.parametrize("law", LAWS)
def test_a_spread_beyond_the_mean_stays_a_charge(law):
    y = frames((flat(20.0), DarkCurrentFpn(2.0, law, ea_ev=1.0)), SHAPE, point=WARM)[0]
    assert np.isfinite(y).all()
    assert y.min() >= 0.0


def test_no_charge_is_negative():
    y = frames((flat(100.0), DarkCurrentFpn(1.0)), SHAPE)[0]
    assert y.min() == 0.0
    assert np.mean(y == 0.0) == pytest.approx(stats.norm.sf(1.0), abs=4 * np.sqrt(0.13 / PIXELS))


def test_beside_it_the_seed_keeps_its_mean_and_spread():
    """The seed that was fitted alone, and the seed with most of its variance taken out of it."""
    alone = ConvolvedLognormal(mu=4.0, delta=0.2, phi=0.0, sigma=1e-6)
    guess = DarkCurrentFpn(0.2 * np.sqrt(1 - LEFT**2))
    model = unbiased(NoiseModel((alone,), 0.0, HERE), guess, 5.0)
    assert model is not None
    before = frames(alone, SHAPE)[0]
    after = frames((*model.effects, guess), SHAPE)[0]
    assert after.mean() == pytest.approx(before.mean(), rel=5 * 0.2 / np.sqrt(PIXELS))
    assert after.std() == pytest.approx(before.std(), rel=0.03)
    assert stats.skew(after.ravel()) < 0.3 * stats.skew(before.ravel())


def test_beside_an_exponential_law_the_median_stays():
    alone = ConvolvedLognormal(mu=4.0, delta=0.2, phi=0.0, sigma=1e-6)
    guess = DarkCurrentFpn(0.2, "exponential")
    model = unbiased(NoiseModel((alone,), 0.0, HERE), guess, 5.0)
    assert model is not None
    before, after = (np.median(frames(m, SHAPE)[0]) for m in (alone, (*model.effects, guess)))
    assert after == pytest.approx(before, rel=0.02)


def clues(relative, offsets=1.0, stands_out=("pattern_q0.99",)):
    level = np.array([5.0, 5.0 * growth(0.6)])
    pattern = np.hypot(offsets, relative * level)
    return MadeUpClues(
        (HERE, WARM), HERE, SHAPE, stands_out=stands_out,
        seen={"mean": 64.0 + level, "pattern_noise_core": pattern},
    )  # fmt: skip


@pytest.mark.parametrize("offsets", [0.1, 2.0])
def test_it_is_guessed_from_the_growth_of_the_pattern(offsets):
    guesses = DarkCurrentFpn.guess(clues(0.15, offsets))
    assert [g.law for g in guesses] == list(LAWS)
    for guess in guesses:
        assert guess.rms == pytest.approx(0.15, rel=0.25)


def test_no_guess_without_a_sign_or_a_growth():
    assert DarkCurrentFpn.guess(clues(0.15, stands_out=())) == []
    assert DarkCurrentFpn.guess(clues(0.0)) == []
