"""One small sensor of the independent generator, with what is hidden in it."""

import numpy as np

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.loaders.captures import CaptureSet

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
