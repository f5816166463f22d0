"""The tutorial's effect: it does what its page says, and the story told with it holds."""

import docs_tree as tree
import numpy as np
import pytest

import dnanalyze
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.registry import catalogue
from dnanalyze.model.simulator import Simulator

FILE = tree.ROOT / "sample_configs" / "own_effect.py"
POINT = OperatingPoint(25.0, 1.0, 1.0)


def model(sigma: float, read: float) -> dnanalyze.NoiseModel:
    known = catalogue((FILE,))
    effects = known["read_noise"](sigma=read), known["shared_amplifier"](sigma=sigma)
    return dnanalyze.NoiseModel(effects, 64.0, POINT, 5)


def test_correlation_of_diagonals_is_as_stated():
    """sigma^2/8 over the variance read^2 + sigma^2/2, within 5 standard errors."""
    sigma, read = 1.5, 1.0
    captures = dnanalyze.simulate(model(sigma, read), (256, 256), [(POINT, 6)])
    found = dnanalyze.analyze(captures).settings[0].values["temporal_corr_11"]
    expected = sigma**2 / 8 / (read**2 + sigma**2 / 2)
    assert found.value == pytest.approx(expected, abs=5 * found.se)
    assert found.se < 0.1 * expected


def test_a_window_has_the_pixels_of_the_frame():
    simulator = Simulator(model(1.5, 0.01), (64, 60))
    whole = simulator.frame(POINT, 2)
    for window in (Window(7, 30, 3, 41), Window(0, 64, 11, 12), Window(33, 34, 0, 60)):
        np.testing.assert_array_equal(simulator.frame(POINT, 2, window), whole[window.slices])


def test_the_page_shows_the_file():
    page = tree.DOCS / "own-effect.md"
    assert FILE.read_text() in [b.text for b in tree.blocks(page, "python")]


@pytest.mark.slow
def test_unexplained_until_the_effect_is_known():
    from dnanalyze.demo import VirtualSensor, generate

    sensor = VirtualSensor(temperatures_c=(25.0, 45.0, 65.0))
    captures = generate(sensor, {"pair_noise": "strong"}, (192, 192), frames=6, seed=3)
    before = dnanalyze.refine(captures)
    assert before.verdict == "unexplained"
    after = dnanalyze.refine(captures, effects=(FILE,))
    assert after.verdict == "adequate"
    assert "shared_amplifier" in after.effects
    assert after.steps[-1].error < before.steps[-1].error
