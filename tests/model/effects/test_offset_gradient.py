"""An offset surface without charge: its closed form, and its guess beside one of charge."""

import numpy as np
import pytest
from charge_bench import HERE, LONG, LOUD, WARM, MadeUpClues, frames, growth

from dnanalyze.model.effects.offset_gradient import OffsetGradient

TRUTH = OffsetGradient(x=3.0, y=-4.0, xx=2.0, xy=1.0)


def surface(rows, columns):
    """The formula of the page, pixel by pixel."""
    y, x = np.meshgrid(
        (2 * np.arange(rows) + 1) / rows - 1, (2 * np.arange(columns) + 1) / columns - 1,
        indexing="ij",
    )  # fmt: skip
    bowl = np.sqrt(5) * (3 * x**2 - 1) / 2
    return 3 * np.sqrt(3) * x - 4 * np.sqrt(3) * y + 2 * bowl + 3 * x * y


def blocks(frame, size=16):
    rows, columns = frame.shape
    return frame.reshape(rows // size, size, columns // size, size).mean((1, 3))


def test_the_surface_is_that_of_the_formula():
    y = frames(TRUTH, (80, 120))[0]
    np.testing.assert_allclose(y, surface(80, 120), atol=1e-4)
    assert y.var() == pytest.approx(TRUTH.variance(HERE), rel=2e-3)


def test_it_follows_the_gain_alone():
    here = frames(TRUTH, (64, 64))
    for point, factor in ((LONG, 1), (WARM, 1), (LOUD, 2)):
        np.testing.assert_allclose(frames(TRUTH, (64, 64), point=point), factor * here, rtol=1e-6)


def test_only_the_terms_in_use_are_fitted():
    assert TRUTH.inactive_parameters() == ("yy",)
    assert OffsetGradient().inactive_parameters() == ()


def test_it_is_guessed_from_the_block_means():
    rng = np.random.default_rng(8)
    maps = [
        blocks(surface(256, 256)) * gain + rng.normal(0, noise, (16, 16))
        for gain, noise in ((1, 0.05), (1, 0.5), (2, 0.1))
    ]
    clues = MadeUpClues((HERE, WARM, LOUD), HERE, (256, 256), stands_out=("shading_0_1",),
                        curves={"block_means": maps})  # fmt: skip
    guess, after = OffsetGradient.guess(clues)
    assert (guess.added, after.added) == ("before", "after")
    got = [guess.x, guess.y, guess.xx, guess.yy, guess.xy]
    # standard error of a term: 0.05 / 16 on 256 blocks; Legendre polynomials at block centres
    assert got == pytest.approx([3.0, -4.0, 2.0, 0.0, 1.0], abs=0.03)
    assert guess.yy == 0.0


def test_of_a_surface_that_grows_the_quiet_settings_decide():
    """The mean of 1 and G, the growth, weighted by 1 and 1/G: 2 G / (G + 1), not (1 + G) / 2."""
    rng = np.random.default_rng(9)
    factor = growth(0.63)
    maps = [
        blocks(surface(256, 256)) * f + rng.normal(0, 0.02 * np.sqrt(f), (16, 16))
        for f in (1.0, factor)
    ]
    # what is left of the surface in a block's scatter is noise alone: errors as 1 to sqrt(G)
    clues = MadeUpClues((HERE, WARM), HERE, (256, 256), stands_out=("shading_0_1",),
                        curves={"block_means": maps})  # fmt: skip
    (guess,) = OffsetGradient.guess(clues)
    assert guess.x == pytest.approx(3.0 * 2.0 * factor / (factor + 1.0), rel=0.1)


def test_no_guess_where_no_shading_stands_out():
    maps = [blocks(surface(256, 256))]
    clues = MadeUpClues((HERE,), HERE, (256, 256), curves={"block_means": maps})
    assert OffsetGradient.guess(clues) == []
