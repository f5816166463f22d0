"""When the everyday fit lets the noise of next pixels be correlated."""

import numpy as np
import pytest

from dnanalyze.fitting.design import design
from dnanalyze.fitting.moments import serial_correlation
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.readings import Readings
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.crosstalk import Crosstalk
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.denoise import Denoise
from dnanalyze.model.effects.flicker_noise import FlickerNoise
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

HERE = OperatingPoint(25.0, 1.0, 1.0)


def found(*effects, frames=6):
    model = NoiseModel(effects, 100.0, HERE)
    captures = simulate(model, (256, 256), [(HERE, frames)])
    return serial_correlation(Readings(fit_problem(design(captures)).measured[0]))


@pytest.mark.parametrize("serial", [(-0.1, 0.0), (0.05, 0.0), (-0.17, 0.12)])
def test_it_is_read_off_the_neighbours(serial):
    se = 1 / np.sqrt(256 * 128 * 5)
    noise = ReadNoise(4.0, serial=serial[0], serial2=serial[1])
    assert found(noise) == pytest.approx(serial, abs=5 * se)


@pytest.mark.parametrize("serial", [(-0.15, 0.09), (0.08, 0.0)])
def test_it_is_read_off_a_single_frame_too(serial):
    se = 1 / np.sqrt(256 * 128)
    noise = ReadNoise(4.0, serial=serial[0], serial2=serial[1])
    assert found(noise, frames=1) == pytest.approx(serial, abs=5 * se)


@pytest.mark.parametrize("frames", [1, 6])
@pytest.mark.parametrize(
    "others",
    [
        (),
        (RowNoise(1.5),),
        (RowNoise(1.5, alternating=0.5),),
        (FlickerNoise(1.5),),
        (Denoise(1.0, space=0.5, kind="gaussian"),),
        (ConvolvedLognormal(4.0, 0.5, sigma=1e-6), DarkShotNoise(2.0), Crosstalk(0.02)),
    ],
    ids=["white", "row noise", "two converters", "1/f", "filter", "crosstalk"],
)
def test_what_else_correlates_neighbours_is_not_taken_for_it(others, frames):
    assert found(ReadNoise(4.0), *others, frames=frames) == (0.0, 0.0)
