"""The models on the way to the ordinary sensor: noise without a name is the paper's."""

import numpy as np
import pytest

from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.moments import moments
from dnanalyze.fitting.predictor import bench
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.start import partly_named
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINTS = tuple(OperatingPoint(t, 0.1, 1.0) for t in (25.0, 45.0, 65.0))
LEVELS = (1.0, 2.5, 4.0)
TRUTH = NoiseModel(
    (
        ConvolvedLognormal(TableLaw(POINTS, LEVELS), delta=0.3, sigma=1e-6),
        DarkShotNoise(0.5),
        ReadNoise(3.0),
        PixelFpn(1.0),
    ),
    100.0,
    POINTS[0],
    seed=5,
)


@pytest.mark.parametrize(
    "names", [["read_noise"], ["read_noise", "pixel_fpn"], ["dark_shot_noise", "pixel_fpn"]]
)
def test_the_temporal_variance_is_whole_whatever_has_its_name(names):
    held = bench(design(simulate(TRUTH, (128, 128), [(p, 6) for p in POINTS])))
    found = moments(Readings(held.measured[0]), black_level=100.0)
    part = partly_named(found, paper_start(held), TRUTH, names, TRUTH.pedestal)
    assert set(part.names) == {"convolved_lognormal", *names}
    variance = Readings(held.statistics(part)[0]).value("temporal_noise") ** 2
    expected = 3.0**2 + 0.5 * np.exp(np.array(LEVELS) + 0.3**2 / 2)
    # of 8192 pixels and 5 degrees of freedom: 0.7 %; of the seed's mean square, some 900 kernels
    # apart: 2 %; its noise, squared by the counts of shot noise drawn after it, a little more
    np.testing.assert_allclose(variance, expected, rtol=0.1)
