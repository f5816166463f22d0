import numpy as np
import pytest
from readout_bench import POINT, Flat, Given, frames

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.column_gain import ColumnGain


def test_stripes_are_a_share_of_the_signal_above_black():
    shape = (4, 8192)
    faint, bright = (
        frames(Flat(level), ColumnGain(0.01), shape=shape) - 64.0 for level in (50.0, 500.0)
    )
    gain = bright[0, 0] / 500.0 - 1.0
    assert gain.std() == pytest.approx(0.01, rel=5 / np.sqrt(2 * gain.size))
    np.testing.assert_allclose(bright, np.broadcast_to(bright[0, 0], bright.shape))
    np.testing.assert_allclose(faint[0, 0] / 50.0 - 1.0, gain, atol=1e-6)


def test_nothing_without_signal():
    np.testing.assert_allclose(frames(ColumnGain(0.1)), 64.0)


def clues(power):
    points = (POINT, OperatingPoint(45.0, 1.0, 1.0), OperatingPoint(65.0, 1.0, 1.0))
    bands = [f"pattern_columns_{b}" for b in ("0_0.02", "0.02_0.1", "0.1_0.3", "0.3_0.5")]
    return Given(
        points=points,
        seen={"mean": [64.0, 100.0, 300.0], **dict.fromkeys(bands, power)},
        model=dict.fromkeys(bands, 2.0),
        off=dict.fromkeys(bands, 9.0),
    )


def test_guess_needs_power_that_grows_with_the_level():
    signal = np.array([0.0, 36.0, 236.0])
    (effect,) = ColumnGain.guess(clues(2.0 + 256 * (0.004 * signal) ** 2))
    assert effect.sigma == pytest.approx(0.004, rel=1e-6)
    assert ColumnGain.guess(clues(np.full(3, 60.0))) == []
