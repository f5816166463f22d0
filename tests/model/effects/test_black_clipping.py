import numpy as np
import pytest
from readout_bench import Given, frames
from scipy.stats import norm

from dnanalyze.model.effects.black_clipping import BlackClipping
from dnanalyze.model.effects.read_noise import ReadNoise


@pytest.mark.parametrize("level", [60.0, 64.0, 66.0])
def test_mean_and_share_of_clipped_gaussian_noise(level):
    y = frames(ReadNoise(2.0), BlackClipping(level), shape=(256, 256))
    a = (level - 64.0) / 2.0
    mean = 64.0 + 2.0 * (a * norm.cdf(a) + norm.pdf(a))
    assert y.min() == level
    assert y.mean() == pytest.approx(mean, abs=5 * 2 / np.sqrt(y.size))
    assert np.mean(y == level) == pytest.approx(norm.cdf(a), abs=5 * 0.5 / np.sqrt(y.size))


def test_what_lies_above_stays():
    x, y = frames(ReadNoise(2.0)), frames(ReadNoise(2.0), BlackClipping(63.0))
    np.testing.assert_array_equal(y, np.maximum(x, 63.0))


def test_guess_from_the_spike_in_the_first_bin():
    curves = {
        "histogram_codes": [np.arange(10, 20)],
        "histogram_counts": [np.r_[0, 90, np.ones(8)]],
    }
    (effect,) = BlackClipping.guess(Given(off={"low_spike": 9.0}, curves=curves))
    assert effect.level == 11.0
    deep = Given(seen={"clipped_low": 0.3}, model={"clipped_low": 1e-6}, curves=curves)
    assert BlackClipping.guess(deep) == [effect]
    assert BlackClipping.guess(Given(curves=curves)) == []
