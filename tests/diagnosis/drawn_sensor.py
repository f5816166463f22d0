"""One small sensor of the independent generator, with what is hidden in it."""

import numpy as np

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate

SENSOR = draw_sensor(np.random.default_rng(11))


def captures_with(hidden, every=2, seed=3) -> CaptureSet:
    """4 frames of 128 x 128 pixels at each ``every``-th of the sensor's five temperatures.

    The cost of a simulation is proportional to the number of operating points. With seed 3 the
    halves of two operating points differ by 4 standard deviations, by chance.
    """
    return generate(SENSOR, hidden, (128, 128), SENSOR.temperatures_c[::every], frames=4, seed=seed)


def problem_with(hidden) -> FitProblem:
    """The fit problem of `captures_with`."""
    return fit_problem(design(captures_with(hidden)))


def with_random_codes(read_noise: float, seed: int) -> CaptureSet:
    """A sensor whose codes have widths of their own, rms 0.5; no simulated one has the same."""
    known = built_in()
    effects = (
        known["convolved_lognormal"](mu=1.0, delta=0.5),
        known["dark_shot_noise"](0.5),
        known["read_noise"](read_noise),
        known["missing_codes"](0.5),
    )
    points = [(OperatingPoint(celsius, 0.1), 4) for celsius in (25.0, 45.0, 65.0)]
    return simulate(NoiseModel(effects, 100.0, seed=seed), (128, 128), points, "made")
