from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from readout_bench import Given, Ramp, frames

from dnanalyze.model.effects.digital_gain import DigitalGain
from dnanalyze.model.effects.missing_codes import MissingCodes
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.guesses.digital_gain import _misfit, _top


@pytest.mark.parametrize(("gain", "offset"), [(1.3, 64.0), (0.8, 10.0), (2.0, 0.0), (3.1, 64.0)])
def test_multiplies_about_the_offset_and_rounds(gain, offset):
    codes = MissingCodes(1e-3)  # rounds the ramp
    x = frames(Ramp(300.0), codes)
    y = frames(Ramp(300.0), codes, DigitalGain(gain, offset))
    exact = (x - offset) * gain + offset
    assert np.abs(y - exact).max() <= 0.5 + 1e-4
    assert np.array_equal(y, np.rint(y))
    seen = np.unique(y)
    if gain > 1:
        unused = 1 - seen.size / np.ptp(seen)
        assert unused == pytest.approx(1 - 1 / gain, abs=0.02)


@pytest.mark.parametrize("gain", ["1.3", "1.14", "1.7", "0.85", "1.06"])
@pytest.mark.parametrize("offset", [0, 64, 65])
def test_halves_go_to_even_codes_though_the_product_is_none_in_floats(gain, offset):
    """As exact fractions have it: which code stays empty hangs on it."""
    whole = np.arange(600)
    effect = DigitalGain(float(gain), float(offset))
    y = effect.apply(whole.astype(np.float32)[None], SimpleNamespace(point=None))[0]
    exact = [round((Fraction(int(x)) - offset) * Fraction(gain) + offset) for x in whole]
    assert sum((Fraction(int(x)) * Fraction(gain)) % 1 == Fraction(1, 2) for x in whole) >= 5
    assert y.tolist() == exact


@pytest.mark.parametrize(("gain", "offset"), [("1.14", 64), ("1.06", 65), ("1.3", 63)])
def test_a_histogram_of_exact_halves_fits_its_factor(gain, offset):
    """The phase of a factor that no float is adds its own error to the product's."""
    codes = [round((x - offset) * Fraction(gain) + offset) for x in range(40, 140)]
    counts = np.bincount(np.array(codes) - codes[0]) * 1000.0
    phase = (offset * (1.0 - float(gain)) - codes[0]) % float(gain)
    inner = counts[5:-5]
    assert _misfit(inner, codes[0] + 5, float(gain), (phase - 5) % float(gain)) < 0.005


def histogram(gain, mean, sigma, offset=64.0, pixels=384 * 384 * 2, seed=0):
    rng = np.random.default_rng(seed)
    x = np.rint(rng.normal(mean, sigma, pixels))
    codes, counts = np.unique(np.rint((x - offset) * gain + offset), return_counts=True)
    return codes, counts


@pytest.mark.long
@pytest.mark.parametrize("gain", [0.6, 0.75, 0.9, 1.1, 1.3, 1.5, 1.77, 2.0, 2.5, 3.3])
def test_guess_finds_the_factor_from_histograms(gain):
    levels = [(70.0, 3.0), (75.0, 4.0), (110.0, 9.0), (250.0, 25.0)]
    made = [histogram(gain, m, s, seed=i) for i, (m, s) in enumerate(levels)]
    clues = Given(
        points=(None,) * 4,
        seen={"mean": [64 + (m - 64) * gain for m, _ in levels]},
        off={"code_comb": 9.0},
        curves={
            "histogram_codes": [c for c, _ in made],
            "histogram_counts": [n for _, n in made],
        },
    )
    (effect,) = DigitalGain.guess(clues)
    assert effect.gain == pytest.approx(gain, rel=0.004)
    # any offset that leads to the same codes will do: the nearest to the level is taken
    n = np.arange(64, 400)
    mine = set(np.rint((n - effect.offset) * effect.gain + effect.offset)) if gain > 1 else set()
    truth = set(np.rint((n - 64) * gain + 64))
    inner = {c for c in mine if 100 < c < 300}
    assert len(inner - truth) <= 0.12 * len(inner)


@pytest.mark.parametrize(
    ("gain", "sigma", "skew"),
    [(1.15, 1.6, 0.64), (0.9, 5.7, 0.4), (0.75, 5.8, 0.8), (1.1, 3.5, 0.8), (2.0, 4.5, 0.0),
     (1.05, 8.7, 0.8)],
)  # fmt: skip
def test_guess_finds_the_factor_under_a_skewed_density(gain, sigma, skew):
    """A line of the spectrum at a gap's own spacing is lost in the slope of the density."""
    rng = np.random.default_rng(5)
    dark = 2.0 * sigma * rng.lognormal(0.0, skew, 440_000) if skew else 0.0
    codes = np.rint(64.0 + dark + sigma * rng.standard_normal(440_000))
    made, counts = np.unique(np.rint((codes - 64.0) * gain + 64.0), return_counts=True)
    clues = Given(
        seen={"mean": 64.0},
        off={"code_comb": 9.0},
        curves={"histogram_codes": [made], "histogram_counts": [counts]},
    )
    (found,) = DigitalGain.guess(clues)
    assert found.gain == pytest.approx(gain, rel=0.004)


@pytest.mark.parametrize("sigma", [2.0, 6.0, 30.0, 70.0])
def test_no_guess_from_a_smooth_histogram(sigma):
    codes, counts = histogram(1.0, 300.0, sigma)
    curves = {"histogram_codes": [codes], "histogram_counts": [counts]}
    assert DigitalGain.guess(Given(off={"code_comb": 3.0}, curves=curves)) == []


def test_no_guess_without_a_sign():
    codes, counts = histogram(1.3, 90.0, 6.0)
    curves = {"histogram_codes": [codes], "histogram_counts": [counts]}
    assert DigitalGain.guess(Given(curves=curves)) == []


def test_saturated_codes_stay_at_the_top_of_the_output():
    codes = np.concatenate([np.arange(60, 160), [160] * 40])
    used, counts = np.unique(codes, return_counts=True)
    curves = {"histogram_codes": [used], "histogram_counts": [counts]}
    assert _top(Given(points=(None,), curves=curves)) == 160.0
    smooth = {"histogram_codes": [used[:-1]], "histogram_counts": [counts[:-1]]}
    assert _top(Given(points=(None,), curves=smooth)) == 65535.0
    y = frames(Ramp(300.0), DigitalGain(1.5, 0.0, 200.0))
    assert y.max() == 200.0


def test_what_comes_before_is_smaller_by_the_gain():
    gain = DigitalGain(1.6, 20.0)
    before, after = ReadNoise(5.0), ReadNoise(5.0 * gain.nuisance_bias("read_noise.sigma", "DN")[0])
    factor, shift = gain.nuisance_bias("pedestal", "DN")
    plain = frames(before, count=4, pedestal=100.0)
    put_in = frames(after, gain, count=4, pedestal=factor * 100.0 + shift)
    n = plain.size
    assert put_in.mean() == pytest.approx(plain.mean(), abs=5 * 5.0 * np.sqrt(2 / n) + 0.05)
    assert put_in.std() == pytest.approx(plain.std(), rel=5 / np.sqrt(n) + 0.01)
    factor, shift = gain.nuisance_bias("convolved_lognormal.mu[0]", "ln DN")
    assert np.exp(factor * 2.0 + shift) == pytest.approx(np.exp(2.0) / 1.6)
    assert gain.nuisance_bias("convolved_lognormal.delta", "ln DN") == (1.0, 0.0)
