"""The conversion gain, from how the noise of one setting varies over the field."""

import numpy as np
import pytest

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.fitting.design import design
from dnanalyze.fitting.photon_transfer import gain_over_field
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.column_fpn import ColumnFpn
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.dark_gradient import DarkGradient
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINT = OperatingPoint(25.0, 1.0, 1.0)
K, CHARGE, READ = 2.5, 60.0, 8.0
CHARGED = (ConvolvedLognormal(mu=np.log(CHARGE), delta=0.01, sigma=1e-6), DarkShotNoise(K))
SETTLING = ColumnFpn(1e-4, settle=80.0, length=60.0)


def gain(*effects, points=(POINT,), frames=4):
    model = NoiseModel((*CHARGED, ReadNoise(READ), *effects), 64.0, POINT, seed=4)
    series = simulate(model, (256, 256), [(p, frames) for p in points])
    plan = design(series)
    return gain_over_field(analyze_windows(series, plan.windows), POINT)


def test_shaded_charge_tells_its_gain():
    found = gain(DarkGradient(y=10.0))
    # 512 blocks of 128 pixels x 3 degrees of freedom; the level varies by 10 DN rms over them
    noise = K * CHARGE + READ**2
    error = noise * np.sqrt(2.0 / (128 * 3)) / (10.0 * np.sqrt(512))
    assert found == pytest.approx(K, abs=5 * error)


def test_settings_of_another_gain_tell_it_at_the_reference():
    points = (POINT, OperatingPoint(25.0, 1.0, 4.0))
    assert gain(DarkGradient(y=10.0), points=points) == pytest.approx(K, rel=0.15)


def test_even_charge_tells_nothing():
    assert gain() is None


def test_a_shaded_offset_has_no_noise_to_tell():
    assert gain(SETTLING) is None
    both = gain(DarkGradient(y=10.0), SETTLING)
    assert both is None or both < K


def test_single_frames_tell_nothing():
    assert gain(DarkGradient(y=10.0), frames=1) is None
