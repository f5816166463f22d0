"""Which pixels share an amplifier, measured on frames that NumPy draws."""

import numpy as np
import pytest

from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.moments import shared_pixels
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.readings import Readings
from dnanalyze.loaders.arrays import from_arrays
from dnanalyze.loaders.captures import OperatingPoint

SHAPE, FRAMES = (256, 192), 6


def problem_of(sigma, extra=0.0, seed=3, cfa=None):
    rng = np.random.default_rng(seed)
    frames = [
        100.0 + sigma * rng.normal(0.0, 1.0, SHAPE) + (extra(rng) if callable(extra) else extra)
        for _ in range(FRAMES)
    ]
    stack = np.rint(frames).astype(np.uint16)
    return fit_problem(design(from_arrays({OperatingPoint(20.0, 1.0): stack}, cfa=cfa)))


def found(*drawn):
    return shared_pixels([Readings(half) for half in problem_of(*drawn).measured])


def noise_map(rows, columns, seed=5):
    """sigma, DN: a tenth of the amplifiers are three times as noisy as the others."""
    few = np.random.default_rng(seed).random((SHAPE[0] // rows, SHAPE[1] // columns)) < 0.1
    return np.where(few, 12.0, 4.0).repeat(rows, axis=0).repeat(columns, axis=1)


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (1, 2), (2, 1), (2, 2)])
def test_amplifiers_are_those_whose_pixels_are_noisy_together(rows, columns):
    assert found(noise_map(rows, columns)) == f"{rows}x{columns}"


def test_the_baseline_model_has_them():
    read = baseline_model(problem_of(noise_map(2, 1))).get("read_noise")
    assert read.shared == "2x1"
    assert read.shared_pixels == (2, 1)


def test_colours_of_a_mosaic_are_no_neighbours():
    """Of groups of 4 x 4 pixels every colour plane has groups of 2 x 2."""
    mosaic = problem_of(noise_map(4, 4), cfa=("RG", "GB"))
    for half in mosaic.measured:
        planes = [s.values["noise_shared_rows"] for s in half.settings]
        assert all(plane.value > 5 * plane.se for plane in planes)
    assert shared_pixels([Readings(half) for half in mosaic.measured]) == "1x1"


def clouds(seed=6):
    """Noise that differs from place to place, smoothly over a few pixels."""
    from scipy.ndimage import gaussian_filter

    smooth = gaussian_filter(np.random.default_rng(seed).normal(size=SHAPE), 1.5)
    return 4.0 * np.exp(0.5 * smooth / smooth.std())


def stripes(period):
    """Interference with a period of columns, of a new phase in each frame."""

    def draw(rng):
        place = 2 * np.pi * (np.arange(SHAPE[1]) / period + rng.random())
        return np.broadcast_to(6.0 * np.cos(place), SHAPE)

    return draw


@pytest.mark.parametrize(
    "drawn",
    [
        (clouds(),),
        (np.where(np.arange(SHAPE[1]) % 4 < 2, 4.0, 8.0),),
        (np.where(np.arange(SHAPE[0]) % 4 < 2, 4.0, 8.0)[:, None],),
        (4.0, stripes(8.0)),
        (4.0, stripes(4.0)),
        (np.roll(noise_map(2, 2), (1, 1), axis=(0, 1)),),
        (noise_map(4, 4),),
        (noise_map(8, 8),),
    ],
    ids=[
        "clouds",
        "columns",
        "rows",
        "stripes of 8",
        "stripes of 4",
        "groups at odd lines",
        "groups of 4",
        "blocks of 8",
    ],
)
def test_what_else_makes_neighbours_noisy_together_is_not_taken_for_it(drawn):
    assert found(*drawn) == "1x1"
