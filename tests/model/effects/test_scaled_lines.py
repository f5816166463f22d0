"""Lines with a multiple of the dark charge: what they scale, what they leave, and the guess."""

import numpy as np
import pytest
from charge_bench import HERE, WARM, flat, frames, growth
from readout_bench import Given

from dnanalyze.loaders.captures import Window
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.scaled_lines import ScaledLines

FEW = ScaledLines(0.01, 1.0, lines=(7, 20), offsets=(1.0, -1.0))


@pytest.mark.parametrize("axis", ["columns", "rows"])
def test_named_lines_have_their_share_of_the_dark_charge(axis):
    lines = ScaledLines(0.01, 2.0, axis, (7, 20), (1.0, -1.0))
    for level in (10.0, 200.0):
        y = frames((flat(level), lines), (48, 48))[0]
        y = y if axis == "columns" else y.T
        np.testing.assert_allclose(y[:, 7], 3.0 * level, rtol=1e-3)
        assert not y[:, 20].any()  # 1 - 2, not below 0
        rest = np.delete(y, [7, 20], axis=1)
        np.testing.assert_allclose(rest, level, rtol=1e-3)


def test_a_line_without_charge_has_the_read_noise_alone():
    chain = (flat(400.0), FEW, DarkShotNoise(1.0), ReadNoise(3.0))
    y = frames(chain, (400, 32), 20)
    assert y[:, :, 20].var() == pytest.approx(9.0, rel=5 * np.sqrt(2 / 8000))
    assert y[:, :, 7].var() == pytest.approx(800.0 + 9.0, rel=5 * np.sqrt(2 / 8000))


def test_the_share_of_drawn_lines_is_the_one_stated():
    y = frames((flat(100.0), ScaledLines(0.05, 0.3)), (40, 200))[0, 0] / 100.0 - 1.0
    off = np.abs(y) > 1e-3
    assert off.sum() == 10
    assert np.sqrt(np.mean(y[off] ** 2)) == pytest.approx(0.3, rel=1e-2)


def test_lines_begin_and_end_where_told_and_windows_agree():
    part = ScaledLines(0.01, 1.0, lines=(7,), offsets=(1.0,), begins=(10.0,), ends=(30.0,))
    y = frames((flat(50.0), part), (48, 48))[0]
    np.testing.assert_allclose(y[10:30, 7], 100.0, rtol=1e-3)
    np.testing.assert_allclose(y[:10, 7], 50.0, rtol=1e-3)
    assert not part.lies_in(Window(31, 48, 0, 48))


@pytest.mark.parametrize("grows", [True, False])
def test_lines_that_grow_with_the_level_are_guessed_and_constant_ones_not(grows):
    rng = np.random.default_rng(5)
    levels = np.array([40.0, 40.0 * growth(0.6)])
    means = []
    for level in levels:
        profile = level + 0.02 * level * rng.standard_normal(256)
        height = level if grows else levels[0]
        profile[[30, 90]] += np.array([-1.0, 2.0]) * height
        means.append(profile)
    clues = Given(points=(HERE, WARM), seen={"mean": 64.0 + levels}, profiles={"columns": means})
    found = ScaledLines.guess(clues)
    if not grows:
        assert found == []
        return
    (guess,) = found
    assert guess.lines == (30, 90)
    # 0.02 of the level from column to column, at both settings
    assert guess.sigma * np.array(guess.offsets) == pytest.approx([-1.0, 2.0], abs=0.15)
