import numpy as np
import pytest

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window
from dnanalyze.workbench import frames
from dnanalyze.workbench.frames import View


def _captures(stack, cfa=None):
    point = OperatingPoint(25.0, 0.1)

    def frame(pixels):
        def load(window):
            return pixels if window is None else pixels[window.slices]

        return Frame("f", point, load)

    made = Setting(point, tuple(frame(x) for x in stack))
    return CaptureSet("made", Sensor(stack[0].shape, cfa=cfa), (made,))


def test_mean_and_temporal_noise_are_those_of_numpy():
    stack = np.random.default_rng(1).normal(100, 5, (6, 20, 30)).astype(np.float32)
    captures = _captures(stack)
    np.testing.assert_allclose(
        frames.image(captures, View(kind="mean")), stack.mean(axis=0), rtol=1e-5
    )
    np.testing.assert_allclose(
        frames.image(captures, View(kind="temporal noise")), stack.std(axis=0, ddof=1), rtol=1e-4
    )
    assert np.isnan(frames.image(_captures(stack[:1]), View(kind="temporal noise"))).all()


def test_a_colour_plane_has_its_own_sampling():
    pixels = np.arange(48.0, dtype=np.float32).reshape(6, 8)
    cfa = (("R", "Gr"), ("Gb", "B"))
    shown = frames.image(_captures(pixels[None], cfa), View(plane="Gb10"))
    np.testing.assert_array_equal(shown, pixels[1::2, 0::2])
    assert frames.planes(cfa) == ["", "R00", "Gr01", "Gb10", "B11"]


def test_a_hot_pixel_survives_the_reduction_and_noise_is_averaged():
    pixels = np.random.default_rng(2).normal(0, 1, (512, 1024)).astype(np.float32)
    pixels[301, 777] = 900.0
    shown = frames.for_screen(pixels, Window.whole(pixels.shape), 128)
    assert max(shown.shape) <= 128
    assert shown.max() == 900.0
    typical = np.median(np.abs(shown)) * 1.4826
    assert typical == pytest.approx(1 / 8, rel=0.1)  # 8 x 8 pixels of unit noise


def test_a_window_that_fits_is_shown_as_it_is():
    pixels = np.random.default_rng(3).normal(0, 1, (64, 64))
    window = Window(10, 20, 5, 25)
    np.testing.assert_array_equal(frames.for_screen(pixels, window, 64), pixels[10:20, 5:25])


def test_contrast_is_never_empty():
    assert frames.contrast([np.full((4, 4), np.nan)]) == (0.0, 1.0)
    assert frames.contrast([np.full((4, 4), 7.0)]) == (6.5, 7.5)


def test_a_pixel_is_read_from_every_frame():
    stack = np.random.default_rng(4).integers(0, 99, (5, 16, 16)).astype(np.uint16)
    (values,) = frames.pixel(_captures(stack), 3, 7)
    np.testing.assert_array_equal(values, stack[:, 3, 7])
