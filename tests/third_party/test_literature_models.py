"""The noise models of the literature in the truth suite, against their formulas."""

import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from scipy import stats
from scipy.constants import physical_constants

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from third_party.answers import ANSWERS
from third_party.cases import of_generator
from third_party.generators import literature
from third_party.verify import measure

CAMERA = literature.Camera(1.5, 2.0, 100.0, 1.2, 300.0, 1.0, (0.0, 30.0))
BOLTZMANN = physical_constants["Boltzmann constant in eV/K"][0]
DARK = np.zeros(literature.SHAPE)


@pytest.mark.parametrize("case", of_generator("literature"), ids=lambda c: c.key)
def test_the_frames_show_what_a_case_claims(case):
    drawn = case.drawn()
    measured = measure(drawn.stacks, [asdict(c) for c in drawn.claims])
    assert measured
    assert all(m.holds for m in measured), [str(m) for m in measured]
    assert set(case.recipe.hides) <= set(ANSWERS)


@pytest.mark.parametrize("lam", [0.14, -0.2])
def test_read_noise_is_tukeys_law_of_its_deviation(lam):
    x = literature.tukey(np.random.default_rng(1), lam, 3.0).ravel()
    law = stats.tukeylambda(lam, scale=3.0 / stats.tukeylambda(lam).std())
    assert stats.kstest(x, law.cdf).pvalue > 1e-4


def test_pink_noise_has_unit_variance_and_power_one_over_f():
    rng = np.random.default_rng(2)
    made = np.array([literature.pink(rng, 4096) for _ in range(200)])
    power = np.mean(np.abs(np.fft.rfft(made)) ** 2, axis=0)
    assert made.var() == pytest.approx(1.0)
    ratio = np.mean(power[16:24]) / np.mean(power[256:384])
    assert np.log(ratio) / np.log(16) == pytest.approx(1.0, abs=0.08)


def test_every_other_output_of_the_array_is_mirrored():
    camera = literature.Camera(1.5, 1e-9, 100.0, 1.2, 300.0, 1.0, (0.0, 30.0))
    frame = literature.h2rg(camera, 1.0, 0.0)(DARK, np.random.default_rng(3))
    strips = np.split(frame, literature.OUTPUTS, axis=1)
    np.testing.assert_allclose(strips[0], strips[2], atol=1e-6)
    np.testing.assert_allclose(strips[0], strips[1][:, ::-1], atol=1e-6)


def test_the_wave_of_four_columns_has_that_period():
    read = literature.starlight(CAMERA, 0.0, DARK, 1.0)
    profile = read(DARK, np.random.default_rng(4)).mean(axis=0)
    power = np.abs(np.fft.rfft(profile)) ** 2
    assert np.argmax(power[1:]) + 1 == literature.COLUMNS // 4


def test_dark_charge_grows_by_half_the_gap():
    kelvin = np.array([273.15, 303.15])
    rate = kelvin**1.5 * np.exp(-1.2 / (2 * BOLTZMANN * kelvin))
    assert CAMERA.charge(0.0) / CAMERA.charge(30.0) == pytest.approx(rate[0] / rate[1])
