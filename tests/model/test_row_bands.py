"""A window cut into bands of rows."""

from dnanalyze.loaders.captures import Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.row_bands import band_rows, bands


def test_bands_cover_the_window_once_and_are_wider_than_what_effects_look_beyond():
    window = Window(3, 40, 5, 9)
    assert bands(window, 16) == [Window(3, 19, 5, 9), Window(19, 35, 5, 9), Window(35, 40, 5, 9)]
    model = NoiseModel((built_in()["denoise"](),))
    assert band_rows(model, 1 << 24) >= 8 * model.effects[0].reach
