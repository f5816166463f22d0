import numpy as np
import pytest

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window
from dnanalyze.report.fields import side_of
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


def test_a_large_image_is_shown_by_block_means_and_its_hot_pixels_apart():
    pixels = np.random.default_rng(2).normal(0, 1, (512, 1024)).astype(np.float32)
    pixels[301, 777] = 900.0
    whole = Window.whole(pixels.shape)
    side = side_of(pixels.shape, 128)
    assert side == 9
    shown = frames.block_means(pixels, side)
    blocks = pixels[:504, :1017].reshape(56, 9, 113, 9).mean(axis=(1, 3))
    np.testing.assert_allclose(shown[:56, :113], blocks, atol=1e-4)
    far = frames.outliers(pixels, whole, 10)
    assert (far.rows[0], far.columns[0], far.values[0]) == (301, 777, 900.0)
    assert far.count == np.sum(np.abs(pixels) > 5 * np.diff(np.quantile(pixels, [0.16, 0.84])) / 2)
    low, high = frames.contrast([shown])
    assert -0.75 < low < high < 0.75  # 9 x 9 pixels of unit noise, the hot one at 14


def test_block_means_show_a_pattern_of_two_columns():
    pixels = np.tile(np.float32([9.0, -9.0]), (64, 32))
    shown = frames.block_means(pixels, side_of(pixels.shape, 32))
    np.testing.assert_allclose(np.abs(shown[:, :-1]), 3.0)


def test_blocks_at_the_edges_are_means_of_the_pixels_that_they_hold():
    pixels = np.random.default_rng(5).normal(0, 1, (70, 33))
    shown = frames.block_means(pixels[1:], 3)
    assert shown.shape == (23, 11)
    assert shown[-1, -1] == pytest.approx(pixels[67:70, 30:33].mean())
    shown = frames.block_means(pixels[:, :32], 3)
    assert shown[-1, -1] == pytest.approx(pixels[69:70, 30:32].mean())


def test_the_most_outliers_are_the_farthest():
    pixels = np.zeros((50, 50))
    pixels[::2] = 1.0
    pixels[10, :5] = 100.0, 500.0, 300.0, -400.0, 200.0
    far = frames.outliers(pixels, Window(5, 50, 1, 50), 3)
    assert list(far.values) == [500.0, -400.0, 300.0]
    assert (list(far.rows), list(far.columns), far.count) == ([10] * 3, [1, 3, 2], 4)


def test_contrast_is_never_empty_and_no_hot_pixel_widens_it():
    assert frames.contrast([np.full((4, 4), np.nan)]) == (0.0, 1.0)
    assert frames.contrast([np.full((4, 4), 7.0)]) == (6.5, 7.5)
    noise = np.random.default_rng(6).normal(50, 2, (300, 300))
    hot = noise.copy()
    hot.flat[:900] = 4000.0
    np.testing.assert_allclose(frames.contrast([hot]), (50 - 3.09 * 2, 58), atol=0.4)


def test_a_pixel_is_read_from_every_frame():
    stack = np.random.default_rng(4).integers(0, 99, (5, 16, 16)).astype(np.uint16)
    (values,) = frames.pixel(_captures(stack), 3, 7)
    np.testing.assert_array_equal(values, stack[:, 3, 7])
