import numpy as np
import pytest

import dnanalyze
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.loaders.code_unit import in_codes
from dnanalyze.model.effect import Stage
from dnanalyze.workbench import frames, tiles
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.measuring import Superseded
from dnanalyze.workbench.pictures import Pictures


def test_the_difference_is_that_of_the_means_shown_and_a_model_may_lack(folder, fitted):
    pictures = Pictures(dnanalyze.load(str(folder)))
    view, window = View(setting=1), Window(0, 96, 0, 90)
    found = pictures.picture(view, window, fitted, 48, True)
    assert (found.side, found.measured.shape) == (3, (32, 30))
    np.testing.assert_array_equal(found.difference, found.measured - found.simulated)
    blocks = pictures.measured(view)[:, :90].reshape(32, 3, 30, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(found.measured, blocks, rtol=1e-5)
    assert set(found.outliers) == {"measured", "simulated"}
    alone = pictures.picture(view, window, None, 48, False)
    assert np.isnan(alone.simulated).all()
    assert not alone.outliers


def test_images_are_forgotten_beyond_the_memory(folder):
    pictures = Pictures(dnanalyze.load(str(folder)), measured=3 * 4 * 96 * 144)
    for number in range(6):
        pictures.measured(View(setting=number % 2, frame=number // 2))
    assert len(pictures._measured._held) == 3


@pytest.mark.parametrize("kind", frames.KINDS)
def test_a_simulated_image_in_tiles_is_that_of_whole_frames(folder, fitted, kind, monkeypatch):
    monkeypatch.setattr(tiles, "SIDE", 40)
    captures = in_codes(dnanalyze.load(str(folder)), fitted.unit)
    made = frames.image(dnanalyze.simulate(fitted.in_codes, like=captures), View(1, kind))
    pictures = Pictures(captures)
    for window in (Window(0, 96, 0, 144), Window(31, 77, 50, 143)):
        found = pictures.picture(View(1, kind), window, fitted, 48, False)
        cut = made[found.window.slices]
        assert found.window.top <= window.top < window.bottom <= found.window.bottom
        np.testing.assert_allclose(
            found.simulated, frames.block_means(cut, found.side), rtol=1e-5, equal_nan=True
        )
        far = pictures.picture(View(1, kind), window, fitted, 48, True)
        np.testing.assert_allclose(far.simulated, found.simulated, rtol=1e-5)
        there = far.outliers["simulated"]
        np.testing.assert_allclose(there.values, made[there.rows, there.columns], rtol=1e-5)


def test_where_a_window_moves_to_only_new_tiles_are_simulated(folder, fitted, monkeypatch):
    monkeypatch.setattr(tiles, "SIDE", 24)
    pictures, looks = Pictures(dnanalyze.load(str(folder))), []

    def seen(window):
        looks.clear()
        picture = pictures.picture(View(), window, fitted, 24, False, lambda: looks.append(0))
        return picture, len(looks)

    first, count = seen(Window(0, 72, 0, 72))
    assert (first.side, count) == (3, 1 + 9)  # the measured frame, and 3 x 3 tiles
    moved, count = seen(Window(0, 72, 24, 95))
    assert (moved.window, count) == (Window(0, 72, 24, 96), 3)
    np.testing.assert_array_equal(moved.simulated[:, :16], first.simulated[:, 8:])
    assert seen(Window(0, 72, 0, 72))[1] == 0


def test_a_picture_is_given_up_within_a_frame_and_begun_anew(folder, fitted):
    pictures, left = Pictures(dnanalyze.load(str(folder))), [3]

    def look():
        left[0] -= 1
        if left[0] < 0:
            raise Superseded

    asked = View(0, "mean"), Window(0, 96, 0, 144), fitted, 96, False
    with pytest.raises(Superseded):
        pictures.picture(*asked, look)
    assert left == [-1]
    assert np.isfinite(pictures.picture(*asked).simulated).all()


def test_an_image_of_a_colour_plane_in_tiles_has_its_pixels(monkeypatch):
    monkeypatch.setattr(tiles, "SIDE", 8)
    cfa = (("R", "Gr"), ("Gb", "B"))
    settings = [(OperatingPoint(25.0, 0.1), 3)]
    model = dnanalyze.NoiseModel((dnanalyze.catalogue()["read_noise"](sigma=2.0),), pedestal=64.0)
    captures = dnanalyze.simulate(model, (27, 37), settings, sensor=Sensor((27, 37), cfa=cfa))
    view = View(0, "mean", 0, "Gr01")
    found = Pictures(captures).picture(view, Window(0, 14, 0, 18), model, 99, False)
    np.testing.assert_allclose(found.simulated, found.measured, rtol=1e-6)
    assert found.simulated.shape == (14, 18)


def test_what_spans_the_field_is_drawn_once_for_all_tiles(monkeypatch):
    monkeypatch.setattr(tiles, "SIDE", 16)
    drawn = []

    class Wide(dnanalyze.Effect):
        name = "wide"
        stage = Stage.PIXEL_READ

        def apply(self, signal, site):
            return signal + site.share("level", lambda: drawn.append(0) or 1.0)

    model = dnanalyze.NoiseModel((Wide(),), pedestal=64.0)
    captures = dnanalyze.simulate(model, (64, 64), [(OperatingPoint(25.0, 0.1), 3)])
    pictures = Pictures(captures)
    pictures.measured(View(0, "mean"))
    drawn.clear()
    pictures.picture(View(0, "mean"), Window(0, 64, 0, 64), model, 64, False)
    assert len(drawn) == 1


def test_a_pixel_has_a_value_for_every_frame(folder, fitted):
    captures = dnanalyze.load(str(folder))
    found = Pictures(captures).pixel(3, 7, fitted)
    assert [len(x) for x in found["measured"]] == [len(s.frames) for s in captures.settings]
    assert [len(x) for x in found["simulated"]] == [len(s.frames) for s in captures.settings]
    assert found["measured"][1][2] == captures.settings[1].frames[2].read()[3, 7]
