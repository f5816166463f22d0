"""Shot noise, read noise, pixel offsets and rounding against their closed forms."""

import numpy as np
import pytest
from charge_bench import HERE, LONG, LOUD, WARM, MadeUpClues, flat, frames

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulator import Simulator

N = 256 * 256


@pytest.mark.parametrize("level", [0.5, 8.0, 300.0])
@pytest.mark.parametrize("k", [0.25, 4.0])
def test_shot_noise_has_mean_h_and_variance_k_h(level, k):
    y = frames((flat(level), DarkShotNoise(dn_per_e=k)), count=4)
    n = y.size
    assert abs(y.mean() - level) < 5 * np.sqrt(k * level / n)
    # variance of the sample variance of k Pois(m): k^4 (2 m^2 + m)/n
    m = level / k
    assert abs(y.var() - k * level) < 5 * k**2 * np.sqrt((2 * m**2 + m) / n)
    assert np.allclose(y / k, np.rint(y / k), atol=1e-3)
    # independent frames: correlation 0 +- 1/sqrt(N)
    assert abs(np.corrcoef(y[0].ravel(), y[1].ravel())[0, 1]) < 5 / np.sqrt(N)


def test_shot_noise_follows_exposure_by_the_signal_and_gain_by_k():
    shot = (flat(50.0), DarkShotNoise(dn_per_e=0.5))
    spread = 5 * np.sqrt(2 / (4 * N))  # of a relative variance, mean counts far above 1
    assert abs(frames(shot, count=4, point=LONG).var() / (0.5 * 150) - 1) < spread + 0.01
    assert abs(frames(shot, count=4, point=LOUD).var() / (1.0 * 50) - 1) < spread + 0.02


def test_shot_noise_is_guessed_from_the_photon_transfer_line():
    points = tuple(OperatingPoint(t, 1.0) for t in (25.0, 45.0, 65.0))
    mean = np.array([100.0, 120.0, 200.0])
    clues = MadeUpClues(
        points,
        seen={"mean": mean, "s2_temporal": 4 + 0.4 * (mean - 95)},
        stands_out=("temporal_noise",),
    )
    (guess,) = DarkShotNoise.guess(clues)
    assert guess.dn_per_e == pytest.approx(0.4, rel=0.02)
    single = MadeUpClues(
        seen={"noise_at_50": 5.0, "noise_at_99": 25.0, "pattern_q0.99": 40.0},
        stands_out=("noise_at_99",),
    )
    (guess,) = DarkShotNoise.guess(single)
    assert guess.dn_per_e == pytest.approx(0.5)


@pytest.mark.parametrize(("point", "factor"), [(HERE, 1), (LOUD, 2), (LONG, 1), (WARM, 1)])
def test_read_noise_scales_with_gain_alone(point, factor):
    effect = ReadNoise(sigma=3.0)
    y = frames(effect, count=4, point=point)
    assert abs(y.std() / (3 * factor) - 1) < 5 / np.sqrt(2 * y.size)
    assert abs(y.mean()) < 5 * 3 * factor / np.sqrt(y.size)
    assert abs(np.corrcoef(y[0].ravel(), y[1].ravel())[0, 1]) < 5 / np.sqrt(N)
    assert effect.variance(HERE) == 9.0


def test_spread_of_read_noise_keeps_its_rms_and_stays_with_the_pixel():
    s = 0.4
    y = frames(ReadNoise(sigma=3.0, spread=s), count=16)
    each = y.var(axis=0)
    # E sigma_i^2 = sigma^2; relative variance of sigma_i^2: e^(4 s^2) - 1, its estimate 2/16 more
    scatter = np.sqrt(((1 + 2 / 16) * np.exp(4 * s**2) - 1) / N)
    assert abs(np.mean(y**2) / 9 - 1) < 5 * scatter
    # log of a chi-square over 16 frames has variance psi1(7.5) = .142; log sigma_i^2 has (2 s)^2
    assert np.var(np.log(each)) == pytest.approx(4 * s**2 + 0.1426, rel=0.05)
    first, second = np.log(y[:8].var(axis=0)).ravel(), np.log(y[8:].var(axis=0)).ravel()
    # share of the common part: 4 s^2 / (4 s^2 + psi1(3.5) = .330)
    assert np.corrcoef(first, second)[0, 1] == pytest.approx(0.64 / (0.64 + 0.330), abs=0.03)


def test_read_noise_is_guessed_from_the_unexplained_temporal_variance():
    clues = MadeUpClues(
        seen={"temporal_noise_core": 5.0},
        model={"temporal_noise_core": 3.0},
        stands_out=("temporal_noise_core",),
    )
    (guess,) = ReadNoise.guess(clues)
    assert guess.sigma == pytest.approx(4.0)


@pytest.mark.parametrize(("point", "factor"), [(HERE, 1), (LOUD, 2), (LONG, 1), (WARM, 1)])
def test_pixel_offsets_repeat_and_scale_with_gain_alone(point, factor):
    effect = PixelFpn(sigma=2.0)
    a, b = frames(effect, count=2, point=point)
    np.testing.assert_array_equal(a, b)
    assert abs(a.std() / (2 * factor) - 1) < 5 / np.sqrt(2 * N)
    assert abs(np.mean(a[:, 1:] * a[:, :-1]) / (2 * factor) ** 2) < 5 / np.sqrt(N)
    assert effect.variance(HERE) == 4.0
    other = frames(effect, seed=1)[0]
    assert abs(np.corrcoef(a.ravel(), other.ravel())[0, 1]) < 5 / np.sqrt(N)


def test_pixel_offsets_are_guessed_from_the_unexplained_pattern():
    clues = MadeUpClues(
        (HERE, LOUD),
        seen={"pattern_noise_core": [5.0, 10.0]},
        model={"pattern_noise_core": [3.0, 6.0]},
        stands_out=("pattern_noise_core",),
    )
    (guess,) = PixelFpn.guess(clues)
    assert guess.sigma == pytest.approx(4.0)


@pytest.mark.parametrize("step", [1, 4])
def test_rounding_adds_a_twelfth_and_leaves_whole_codes(step):
    smooth = (flat(100.0), ReadNoise(sigma=5.0 * step))
    a = frames(smooth, count=2)
    b = frames((*smooth, Quantization(step=step)), count=2)
    np.testing.assert_array_equal(b % step, 0)
    error = (b - a)[(b > 0) & (b < 65535)]
    assert np.abs(error).max() <= step / 2
    # uniform error: variance of its square is q^4 / 180
    assert abs(np.mean(error**2) - step**2 / 12) < 5 * step**2 / np.sqrt(180 * error.size)
    assert Quantization(step=step).variance(HERE) == pytest.approx(step**2 / 12)


def test_codes_end_where_the_converter_does():
    y = frames((flat(250.0), ReadNoise(sigma=200.0), Quantization(bits=8)))
    assert y.min() == 0
    assert y.max() == 255


def test_quantization_is_guessed_from_the_codes():
    def guess(codes, counts):
        clues = MadeUpClues(
            stands_out=("lattice",),
            curves={"histogram_codes": [np.array(codes)], "histogram_counts": [np.array(counts)]},
        )
        (found,) = Quantization.guess(clues)
        return found

    assert guess([60, 61, 62, 300], [5, 9, 5, 1]) == Quantization(bits=16)
    assert guess([60, 61, 4095], [5, 9, 7]) == Quantization(bits=12)
    assert guess([64, 65, 66, 67, 68, 72], [5, 0, 0, 0, 9, 7]) == Quantization(step=4)


@pytest.mark.parametrize(
    ("serial", "serial2"), [(-0.3, 0.0), (-0.02, 0.0), (0.2, 0.0), (-0.17, 0.12), (0.0, -0.2)]
)
def test_serial_read_noise_is_correlated_with_the_next_pixels_of_the_row_alone(serial, serial2):
    y = frames(ReadNoise(3.0, serial=serial, serial2=serial2), (256, 256), 4)
    n, z = y.size, y / 3.0
    five = 5 / np.sqrt(n)
    assert z.var() == pytest.approx(1.0, abs=2 * five)
    assert np.mean(z[:, :, 1:] * z[:, :, :-1]) == pytest.approx(serial, abs=2 * five)
    assert np.mean(z[:, :, 2:] * z[:, :, :-2]) == pytest.approx(serial2, abs=2 * five)
    assert abs(np.mean(z[:, :, 3:] * z[:, :, :-3])) < 2 * five
    assert (z[:, :, :2].std() - 1) < 5 / np.sqrt(2 * z[:, :, :2].size)
    assert abs(np.mean(z[:, 1:] * z[:, :-1])) < 2 * five
    assert abs(np.mean(z[1:] * z[:-1])) < five
    idle = ReadNoise(3.0, serial=serial, serial2=serial2).inactive_parameters()
    assert ("serial" in idle, "serial2" in idle) == (serial == 0, serial2 == 0)


def test_windows_of_serial_noise_are_parts_of_the_whole():
    noise = ReadNoise(3.0, serial=-0.17, serial2=0.12)
    simulator = Simulator(NoiseModel((noise,), 0.0, HERE), (64, 96))
    whole = simulator.frame(HERE, 0)
    for left in (0, 1, 2, 40):
        part = simulator.frame(HERE, 0, Window(8, 40, left, left + 30))
        assert np.array_equal(part, whole[8:40, left : left + 30])


def test_correlations_that_no_noise_has_together_are_made_smaller():
    y = frames(ReadNoise(3.0, serial=0.45, serial2=-0.45), (256, 256), 4) / 3.0
    both = [np.mean(y[:, :, k:] * y[:, :, :-k]) for k in (1, 2)]
    assert both[0] == pytest.approx(-both[1], abs=10 / np.sqrt(y.size))
    assert 0.2 < both[0] < 0.45
