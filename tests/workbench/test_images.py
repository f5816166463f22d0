"""The images of the sensor are sent no finer than a screen shows them."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("panel")

from dnanalyze.loaders.captures import Window
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.page.images import Images, blocks
from dnanalyze.workbench.page.style import LIGHT
from dnanalyze.workbench.pictures import Picture


def test_screen_pixels_along_a_pixel_follow_from_what_is_shown():
    asked: list[int] = []
    images = Images(LIGHT, (400, 600), lambda row, column: None, lambda: asked.append(1))
    assert images.dense == 0.0  # the browser has told nothing
    images._resized("inner_width", None, 300)
    images._resized("inner_height", None, 200)
    assert images.dense == 0.5
    images.range_x.update(start=0.0, end=150.0)
    images.range_y.update(start=100.0, end=0.0)
    assert images.dense == 2.0
    assert asked


def test_a_title_says_what_a_value_is_the_mean_of():
    image = np.zeros((2, 3))
    for side, said in ((1, ""), (4, ", means of 4 × 4 pixels")):
        window = Window.whole((2 * side, 3 * side))
        assert blocks(Picture(View(), window, side, image, image, {})) == said
