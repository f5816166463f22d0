"""Each word finds its structure with numbers within their errors, and nothing in white noise."""

import math

import numpy as np
import pytest
from made_layers import COLUMN, DARK, POINTS, READ, ROW, SHAPE, made

from dnanalyze.description.search import by_chance, searched
from dnanalyze.description.words import sentence
from dnanalyze.loaders.captures import OperatingPoint

REFERENCE = OperatingPoint(25.0, 1.0, 1.0)
NULL = by_chance(made(seed=2))


def best(layers):
    return searched(layers, NULL, REFERENCE)[0]


def near(found, sigmas=5.0, **truth):
    for name, value in truth.items():
        error = found.errors[name]
        assert getattr(found.effect, name) == pytest.approx(value, abs=sigmas * error), name
        assert 0 < error < 0.3 * max(abs(value), 1.0), name


def test_white_noise_has_no_structure():
    assert searched(made(seed=3), NULL, REFERENCE) == []


def test_rings():
    r = np.hypot(ROW - 170.0, COLUMN + 30.0)
    pattern = math.sqrt(2) * np.cos(2 * math.pi * r / 11.3)
    found = best(made(lambda n, f, rng: 0.9 * pattern))
    assert (found.effect.where, found.effect.when, found.effect.law) == (
        "rings", "fixed", "constant",
    )  # fmt: skip
    near(found, centre_y=170.0, centre_x=-30.0, period=11.3, amplitude=0.9)


def test_a_checkerboard_that_grows_down_the_frame():
    pattern = math.sqrt(3) * ROW / 127 * (-1.0) ** (ROW + COLUMN)
    seen = made(lambda n, f, rng: 0.9 * pattern)
    found = best(seen)
    assert (found.effect.where, found.effect.envelope) == ("wave", "down")
    near(found, amplitude=0.9)
    assert "checkerboard of single pixels that grows from 0 towards the last row" in sentence(
        found, seen
    )


def test_a_wave_with_an_energy_of_its_own():
    from dnanalyze.thermal import arrhenius

    pattern = math.sqrt(2) * np.cos(2 * math.pi * (0.083 * COLUMN + 0.041 * ROW))
    grown = [0.3 * arrhenius(p.temperature_c, 25.0, 0.3) for p in POINTS]
    found = best(made(lambda n, f, rng: grown[n] * pattern))
    assert (found.effect.where, found.effect.law) == ("wave", "thermal")
    near(found, u=0.083, v=0.041, ea_ev=0.3, amplitude=0.3)


def test_noise_that_is_modulated_along_the_rows():
    sigma = READ * (1 + 0.5 * np.cos(2 * math.pi * COLUMN / 21.0))
    found = best(made(noise=sigma))
    assert (found.effect.what, found.effect.where) == ("noise", "wave")
    assert 1 / abs(found.effect.u) == pytest.approx(21.0, rel=5e-3)
    # the first harmonic of sigma^2 (1 + d cos)^2 is 2 d sigma^2
    assert found.effect.amplitude == pytest.approx(READ, rel=0.1)


@pytest.mark.parametrize("slant", ["down", "up"])
def test_diagonal_stripes(slant):
    value = np.random.default_rng(7).standard_normal(300)
    pattern = value[ROW - COLUMN + 140] if slant == "down" else value[ROW + COLUMN]
    found = best(made(lambda n, f, rng: 0.8 * pattern))
    assert (found.effect.where, found.effect.slant) == ("diagonal", slant)
    near(found, amplitude=0.8)


def test_blocks_of_pixels():
    value = np.random.default_rng(7).standard_normal((40, 40))
    pattern = value[(ROW + 2) // 4, (COLUMN + 1) // 5]
    found = best(made(lambda n, f, rng: 0.8 * pattern))
    e = found.effect
    assert (e.where, e.height, e.width, e.top, e.left) == ("block", 4, 5, 2, 1)
    near(found, amplitude=0.8)


def test_halves_are_told_from_shading():
    shade = 2.0 * (COLUMN / 128 - 0.5) + 1.0 * (ROW / 128 - 0.5) ** 2
    step = np.sign(ROW - 63.5)
    found = best(made(lambda n, f, rng: shade + 1.5 * step))
    assert (found.effect.where, found.effect.axis) == ("halves", "rows")
    assert found.effect.coefficients == (1.0,)
    near(found, amplitude=1.5)


def test_quadrants_that_jitter_with_the_dark_signal():
    quadrant = 2 * (ROW // 64) + COLUMN // 64
    seen = made(lambda n, f, rng: 0.05 * DARK[n] * rng.standard_normal(4)[quadrant], frames=8)
    found = best(seen)
    e = found.effect
    assert (e.what, e.when, e.where) == ("gain", "frame", "quadrants")
    near(found, gain=0.05)
    assert "in proportion to the dark signal" in sentence(found, seen)


def test_a_saddle_of_random_size():
    saddle = (COLUMN / 128 - 0.5) * (ROW / 128 - 0.5)
    saddle = saddle / saddle.std()
    found = best(made(lambda n, f, rng: 0.6 * rng.standard_normal() * saddle))
    e = found.effect
    assert (e.when, e.where) == ("frame", "surface")
    assert abs(e.coefficients[3]) == 1.0
    assert np.abs(np.delete(e.coefficients, 3)).max() < 0.2
    near(found, amplitude=0.6)


def test_a_spot_elsewhere_in_every_frame():
    def spot(n, f, rng):
        y, x = rng.uniform(0, 128, 2)
        return 4.0 * np.exp(-0.5 * ((ROW - y) ** 2 + (COLUMN - x) ** 2) / 12.0**2)

    found = best(made(spot))
    assert (found.effect.when, found.effect.where) == ("frame", "blob")
    assert found.effect.radius == pytest.approx(12.0, rel=0.15)
    assert found.effect.amplitude == pytest.approx(4.0, rel=0.15)


@pytest.mark.parametrize("mask", ["diagonal", "antidiagonal"])
def test_pairs_of_pixels_that_share_a_noise(mask):
    def pairs(n, f, rng):
        shared = rng.standard_normal((66, 66))
        chosen = ((COLUMN % 2) if mask == "diagonal" else (COLUMN + 1) % 2) == (ROW + 1) % 2
        return 1.2 * chosen * shared[(ROW + 1) // 2, COLUMN // 2]

    found = best(made(pairs))
    e = found.effect
    assert (e.when, e.where, e.mask, e.top, e.left) == ("frame", "block", mask, 1, 0)
    near(found, amplitude=1.2)


def test_columns_that_jump_within_a_frame():
    jumping = np.zeros(128, bool)
    jumping[[5, 40, 41, 77, 100, 120]] = True

    def jumps(n, f, rng):
        turn, start = rng.integers(0, 128, 128), rng.choice([-1.0, 1.0], 128)
        return 3.0 * jumping * np.where(turn > ROW, start, -start)

    found = best(made(jumps))
    e = found.effect
    assert (e.where, e.distribution) == ("column_segments", "two_level")
    assert e.share == pytest.approx(6 / 128)
    assert e.amplitude == pytest.approx(3.0, rel=0.15)


def test_bands_of_noisy_rows():
    sigma = np.full((128, 1), READ)
    sigma[30:36] = math.hypot(READ, 1.5)
    found = best(made(noise=sigma * np.ones(SHAPE)))
    e = found.effect
    assert (e.what, e.where, e.share) == ("noise", "row", 6 / 128)
    near(found, amplitude=1.5)


def test_one_operating_point_and_one_frame_are_enough_for_a_fixed_wave():
    pattern = math.sqrt(2) * np.cos(2 * math.pi * (0.11 * COLUMN))
    one = {"frames": 1, "points": POINTS[:1], "dark": DARK[:1]}
    seen = made(lambda n, f, rng: 1.0 * pattern, **one)
    found = searched(seen, by_chance(made(seed=2, **one)), REFERENCE)[0]
    assert found.effect.where == "wave"
    near(found, amplitude=1.0)
    assert "at the only operating point" in sentence(found, seen)


def test_a_size_that_follows_no_law_has_the_scatter_of_the_points_as_its_error():
    """The Birge ratio; the sentence does not say that the size is the same everywhere."""
    sizes, two = (1.3, 0.8), {"points": POINTS[:2], "dark": DARK[:2]}
    pattern = math.sqrt(2) * np.cos(2 * math.pi * (0.11 * COLUMN))
    seen = made(lambda n, f, rng: sizes[n] * pattern, **two)
    found = best(seen)
    assert found.effect.where == "wave"
    weight = found.sizes.errors**-2.0
    mean = np.average(found.sizes.values, weights=weight)
    assert found.sizes.values == pytest.approx(sizes, rel=0.05)
    assert found.effect.amplitude == pytest.approx(mean)
    variance = np.average((found.sizes.values - mean) ** 2, weights=weight)  # of two sizes
    assert found.errors["amplitude"] == pytest.approx(np.sqrt(variance))
    assert "0.8 to 1.3 DN over the temperatures" in sentence(found, seen)
    steady = best(made(lambda n, f, rng: pattern, **two))
    assert "the same at every temperature" in sentence(steady, seen)


def test_the_size_of_a_wave_in_frames_of_few_codes():
    """Half of the pixels of a single frame have the same code."""
    pattern = 0.2 * math.sqrt(2) * np.cos(2 * math.pi * (0.11 * ROW))
    eight_bit = {"frames": 1, "noise": 0.5, "pixel": 0.1, "codes": True}
    seen = made(lambda n, f, rng: pattern, **eight_bit)
    found = searched(seen, by_chance(made(seed=2, **eight_bit)), REFERENCE)[0]
    assert found.effect.where == "wave"
    near(found, amplitude=0.2)


def test_blocks_whose_gain_differs_by_less_than_the_spread_of_the_pixels():
    rng = np.random.default_rng(4)
    charge = np.exp(0.3 * rng.standard_normal(SHAPE) - 0.045)
    tiles = 1.0 + 0.12 * rng.standard_normal((40, 40))[(ROW + 3) // 5, (COLUMN + 1) // 6]
    found = best(made(lambda n, f, rng: DARK[n] * (charge * tiles - 1.0)))
    e = found.effect
    assert (e.what, e.where, e.height, e.width, e.top, e.left) == ("gain", "block", 5, 6, 3, 1)
    near(found, gain=0.12)


def test_a_spot_that_blinks_in_its_place():
    spot = 5.0 * np.exp(-0.5 * ((ROW - 40.0) ** 2 + (COLUMN - 90.0) ** 2) / 15.0**2)
    seen = made(lambda n, f, rng: spot * (rng.random() < 0.5), frames=8)
    found = best(seen)
    e = found.effect
    assert (e.when, e.where, e.distribution) == ("switching", "blob", "on_off")
    near(found, amplitude=5.0, radius=15.0, centre_y=40.0, centre_x=90.0)
    assert "present in half of the frames" in sentence(found, seen)


def test_a_level_that_steps_between_two_sessions_is_no_spot():
    def level(n, f, rng):
        return 12.0 * (f >= 3)

    found = searched(made(level), NULL, REFERENCE)
    assert "blob" not in {e.effect.where for e in found}


def test_a_spot_in_its_place_whose_height_is_new_in_every_frame():
    spot = np.exp(-0.5 * ((ROW - 40.0) ** 2 + (COLUMN - 90.0) ** 2) / 15.0**2)
    found = best(made(lambda n, f, rng: 3.0 * spot * rng.standard_normal(), frames=8))
    e = found.effect
    assert (e.when, e.where, e.distribution) == ("persisting", "blob", "normal")
    near(found, amplitude=3.0, radius=15.0)


def test_columns_that_change_between_two_levels_from_frame_to_frame():
    chosen = np.zeros(128, bool)
    chosen[[5, 40, 41, 77, 100, 120, 121, 122, 60, 61, 62]] = True

    def jumps(n, f, rng):
        return 2.0 * chosen * rng.choice([-1.0, 1.0], 128) + 0.0 * ROW

    found = best(made(jumps, frames=8))
    e = found.effect
    assert (e.when, e.where, e.distribution) == ("frame", "column", "two_level")
    assert e.lines == (5, 5, 40, 41, 60, 62, 77, 77, 100, 100, 120, 122)
    near(found, amplitude=2.0)


def test_rows_that_keep_a_share_of_the_row_before():
    rng = np.random.default_rng(5)
    charge = np.exp(rng.standard_normal(SHAPE))
    noise = np.random.default_rng(6)

    def lag(n, f, rng):
        x = READ * noise.standard_normal(SHAPE) + DARK[n] * charge
        kept = np.round(x)
        kept[1:] = np.round(x[1:] + 0.1 * x[:-1])
        return kept

    seen = made(lag, noise=1e-6)
    found = best(seen)
    assert (found.effect.what, found.effect.where) == ("gain", "row_before")
    near(found, gain=0.1)
    assert "Signal of the row before" in sentence(found, seen)


def test_the_energy_is_told_between_the_steps_of_its_search():
    from dnanalyze.thermal import arrhenius

    pattern = math.sqrt(2) * np.cos(2 * math.pi * (0.083 * COLUMN + 0.041 * ROW))
    grown = [0.3 * arrhenius(p.temperature_c, 25.0, 0.437) for p in POINTS]
    found = best(made(lambda n, f, rng: grown[n] * pattern))
    near(found, ea_ev=0.437, amplitude=0.3)
    assert found.errors["ea_ev"] < 0.01


def test_a_wave_beyond_half_a_cycle_a_pixel_is_its_alias():
    pattern = math.sqrt(2) * np.cos(2 * math.pi * (0.4995 * COLUMN + 0.2 * ROW))
    found = best(made(lambda n, f, rng: pattern))
    assert found.effect.where == "wave"
    assert abs(found.effect.u) <= 0.5
