"""A small simulated series and its problem, for what works on problems."""

from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.loaders.captures import OperatingPoint, Sensor
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate

SHAPE = (96, 80)
POINTS = tuple(OperatingPoint(t, 0.1) for t in (25.0, 45.0, 65.0))
KNOWN = built_in()


def model(**more) -> NoiseModel:
    """What every sensor has; ``more`` are numbers of effects by name."""
    names = ("convolved_lognormal", "dark_shot_noise", "read_noise", "pixel_fpn", "quantization")
    return NoiseModel(tuple(KNOWN[n](**more.get(n, {})) for n in names), 64.0, POINTS[0], seed=4)


def fit_problem_of(cfa=None) -> FitProblem:
    """Three temperatures of four frames."""
    sensor = Sensor(SHAPE, cfa=cfa)
    return fit_problem(design(simulate(model(), SHAPE, [(p, 4) for p in POINTS], sensor=sensor)))
