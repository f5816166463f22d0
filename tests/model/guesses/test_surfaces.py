import numpy as np
import pytest

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effects.amp_glow import AmpGlow, glow
from dnanalyze.model.effects.dark_gradient import DarkGradient
from dnanalyze.model.effects.offset_gradient import OffsetGradient
from dnanalyze.model.guesses.surfaces import over_frame
from dnanalyze.model.surface import legendre

FRAME = 400, 600
WINDOWS = [Window(0, 400, 0, 600), Window(0, 100, 0, 150), Window(220, 400, 310, 560)]


class Shaded:
    """Block means of a window, in proportion to the exposure or not; nothing else is known."""

    reference = OperatingPoint(20.0, 1.0)
    field = FRAME

    def __init__(self, image, window, exposures, proportional):
        self.points = [OperatingPoint(20.0, e) for e in exposures]
        self.area, self.shape = window, (window.shape[0] // 2, window.shape[1])
        rows, columns = window.slices
        blocks = image[rows, columns].reshape(10, window.shape[0] // 10, 10, -1).mean(axis=(1, 3))
        self._blocks = [blocks * (e if proportional else 1.0) for e in exposures]

    def z(self, name):
        return np.full(len(self.points), 20.0 if name.startswith("shading") else 0.0)

    def measured(self, name):
        return np.full(len(self.points), np.nan)

    simulated = measured

    def curve(self, name, setting):
        assert name == "block_means"
        return self._blocks[setting]

    def lines(self, axis, setting):
        return np.empty(0, int), np.empty(0)


def surface(terms, window, size):
    """Value of the five terms over a window of ``size`` pixels that have their own coordinates."""
    px, qx = legendre(np.arange(window.left, window.right), size[1])
    py, qy = legendre(np.arange(window.top, window.bottom), size[0])
    x, y, xx, yy, xy = terms
    return x * px + y * py[:, None] + xx * qx + yy * qy[:, None] + xy * px * py[:, None]


@pytest.mark.parametrize("window", WINDOWS)
def test_a_surface_over_a_window_is_one_over_the_frame_but_for_a_constant(window):
    terms = 1.0, -0.7, 0.3, 0.2, -0.4
    clues = Shaded(np.zeros(FRAME), window, [1.0], False)
    here = surface(terms, Window.whole(window.shape), window.shape)
    there = surface(over_frame(np.array(terms), clues), window, FRAME)
    assert np.ptp(here - there) < 1e-9 * np.ptp(here)


@pytest.mark.parametrize("window", WINDOWS)
def test_gradients_are_guessed_from_a_window_as_from_the_frame(window):
    terms = np.array([2.0, -1.5, 0.0, 0.0, 0.0])
    image = surface(terms, Window.whole(FRAME), FRAME)
    (fixed,) = OffsetGradient.guess(Shaded(image, window, [0.5, 1.0, 2.0], False))
    assert (fixed.x, fixed.y) == pytest.approx((2.0, -1.5), rel=1e-6)
    grown = DarkGradient.guess(Shaded(image, window, [0.5, 1.0, 2.0], True))[0]
    assert (grown.x, grown.y) == pytest.approx((2.0, -1.5), rel=1e-6)


@pytest.mark.parametrize("window", WINDOWS[:2])
def test_a_glow_is_guessed_from_a_window_as_from_the_frame(window):
    light = 5.0 * glow("nw", 0.06, np.arange(FRAME[0]), np.arange(FRAME[1]), FRAME)
    for grows, exposure in ((True, "proportional"), (False, "none")):
        found = AmpGlow.guess(Shaded(light, window, [0.5, 1.0, 2.0], grows))[0]
        assert (found.location, found.length, found.exposure) == ("nw", 0.06, exposure)
        assert found.amplitude == pytest.approx(5.0, rel=0.1)  # of block means
