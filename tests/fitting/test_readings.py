"""What a fit reads off the statistics."""

import numpy as np
import pytest

from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.residual import Residual
from dnanalyze.fitting.simulated import BLOCKS
from dnanalyze.fitting.state import start
from dnanalyze.loaders.arrays import from_arrays
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel


def test_a_step_in_a_single_frame_is_no_noise_of_its_pixels():
    rng = np.random.default_rng(2)
    frame = 100.0 + 3.0 * rng.standard_normal((128, 128))
    frame[:, 64:] += 40.0
    captures = from_arrays({OperatingPoint(20.0, 1.0): np.rint(frame).astype(np.uint16)[None]})
    (noise,) = Readings(fit_problem(design(captures)).measured[0]).noise
    # rounding adds 1/12 DN^2; of 64 x 128 pixels a band holds a third
    assert noise == pytest.approx(np.sqrt(9.0 + 1 / 12), rel=0.06)


def test_curves_over_blocks_are_of_both_halves():
    rng = np.random.default_rng(3)
    stack = np.rint(100.0 + 3.0 * rng.standard_normal((3, 256, 128))).astype(np.uint16)
    problem = fit_problem(design(from_arrays({OperatingPoint(20.0, 1.0): stack})))
    seen = Residual(problem, start(problem, NoiseModel((ReadNoise(3.0),), 100.0), []))
    shapes = {seen.curve(name, 0).shape for name in BLOCKS}
    assert BLOCKS == ("block_means", "noise_blocks", "scatter_blocks")
    assert shapes == {(32, 16)}
