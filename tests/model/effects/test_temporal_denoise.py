import numpy as np
import pytest
from readout_bench import Given, frames
from scipy.signal import lfilter

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effects.missing_codes import MissingCodes
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.rts import Rts
from dnanalyze.model.effects.temporal_denoise import TemporalDenoise

SENSOR = (ReadNoise(4.0),)


def test_the_recursion_from_the_first_frame():
    y = frames(*SENSOR, count=8, shape=(32, 32))
    z = frames(*SENSOR, TemporalDenoise(0.4, before="empty"), count=8, shape=(32, 32))
    expected = lfilter([0.6], [1.0, -0.4], y, axis=0, zi=0.4 * y[:1])[0]
    np.testing.assert_allclose(z, expected, atol=1e-4)


def test_variance_and_correlation_in_the_long_run():
    a, shape = 0.4, (64, 64)
    z = frames(*SENSOR, TemporalDenoise(a), count=24, shape=shape, pedestal=0.0)[8:]
    n = z.size * (1 - a * a) / (1 + a * a)
    assert z.var() == pytest.approx(16 * (1 - a) / (1 + a), rel=5 * np.sqrt(2 / n))
    assert np.mean(z[1:] * z[:-1]) / z.var() == pytest.approx(a, abs=5 / np.sqrt(n))
    spatial = np.mean(z[:, :, 1:] * z[:, :, :-1]) / z.var()
    assert abs(spatial) < 5 / np.sqrt(n)


def test_in_a_running_camera_the_first_frame_is_filtered_as_the_last():
    a, shape = 0.4, (128, 128)
    z = frames(*SENSOR, TemporalDenoise(a), count=3, shape=shape, pedestal=0.0)
    pixels = shape[0] * shape[1]
    for frame in z:  # all but a fiftieth of the memory, squared
        assert frame.var() == pytest.approx(16 * (1 - a) / (1 + a), rel=5 * np.sqrt(2 / pixels))
    assert np.mean(z[1] * z[0]) / z.var() == pytest.approx(a, abs=5 / np.sqrt(pixels))


def test_blinking_pixels_before_a_running_camera_filters_them():
    rts = Rts(0.5, 50.0, occupancy=0.5, dwell_frames=4.0, ea_ev=0.0, amplitudes="fixed")
    z = frames(rts, TemporalDenoise(0.3), count=4, shape=(64, 64))
    level = [frame.mean() for frame in z]
    # 2048 pixels, up or down half of the time: a mean of 12.5, known to 25 / sqrt(4096) DN
    np.testing.assert_allclose(np.array(level) - 64.0, 12.5, atol=5 * 0.4)


def test_a_moving_pixel_starts_anew():
    y = frames(*SENSOR, count=4, shape=(64, 64))
    z = frames(*SENSOR, TemporalDenoise(0.5, 5.0, "on", "empty"), count=4, shape=(64, 64))
    state = y[0]
    for n in range(1, 4):
        state = np.where(np.abs(state - y[n]) > 5.0, y[n], 0.5 * (state + y[n]))
        np.testing.assert_allclose(z[n], state, atol=1e-4)


def test_codes_stay_codes_and_windows_agree():
    model = (*SENSOR, MissingCodes(1e-3), TemporalDenoise(0.3))
    z = frames(*model, count=3)
    assert np.array_equal(z, np.rint(z))
    window = Window(11, 50, 20, 90)
    np.testing.assert_array_equal(frames(*model, count=3, window=window), z[:, 11:50, 20:90])


@pytest.mark.parametrize(("share", "count"), [(0.2, 6), (0.4, 8), (0.3, 16)])
def test_guess_from_the_autocorrelation(share, count):
    y = frames(*SENSOR, TemporalDenoise(share), count=count, shape=(128, 128))
    d = y - y.mean(axis=0)
    r1 = np.median(np.sum(d[1:] * d[:-1], axis=0) / np.sum(d * d, axis=0)) + 1 / count
    clues = Given(
        seen={"temporal_r1": r1, "temporal_noise": 2.0}, off={"temporal_r1": 40.0},
        curves={"frame_means": [y.mean(axis=(1, 2))]},
    )  # fmt: skip
    plain, moving = TemporalDenoise.guess(clues)
    assert plain.share == pytest.approx(share, abs=0.07)
    assert (plain.motion, moving.motion) == ("off", "on")
    assert plain.inactive_parameters() == ("threshold",)
    assert TemporalDenoise.guess(Given(off={"temporal_r1": -9.0})) == []


def test_where_rounding_hides_the_memory_it_is_guessed_where_noise_is_most():
    """Codes of .29 and .69 DN of noise, rounded anew after the recursion."""
    share, count = 0.4, 8
    seen = [_rounded(sigma, TemporalDenoise(share), count) for sigma in (0.44, 0.44, 1.05)]
    r1, noise = np.array(seen).T
    clues = Given(
        seen={"temporal_r1": r1, "temporal_noise": noise}, off={"temporal_r1": 40.0},
        curves={"frame_means": [np.zeros(count)] * 3}, points=(OperatingPoint(),) * 3,
    )  # fmt: skip
    hidden, plain, _ = TemporalDenoise.guess(clues)
    assert hidden.share < 0.5 * share
    assert plain.share == pytest.approx(share, abs=0.1)


def _rounded(sigma, memory, count):
    """Lag-1 autocorrelation, as the statistic has it, and noise of rounded frames."""
    y = frames(ReadNoise(sigma), PixelFpn(0.3), Quantization(), count=count, shape=(256, 256))
    z = [y[0]]
    for present in y[1:]:
        z.append((1 - memory.share) * present + memory.share * z[-1])
    d = np.rint(z)
    d = d - d.mean(axis=0)
    return np.sum(d[1:] * d[:-1]) / np.sum(d * d) + 1 / count, d.std() * (
        count / (count - 1)
    ) ** 0.5


def test_a_fit_without_it_takes_the_noise_for_smaller_by_what_the_recursion_leaves():
    share, noise = 0.4, 3.0
    y = frames(ReadNoise(noise), TemporalDenoise(share), count=40, shape=(64, 64))
    factor = TemporalDenoise(share).nuisance_bias("read_noise.sigma", "DN")[0]
    # 40 frames in a row are correlated: (1 + a)/(1 - a) times fewer count
    n = y.size * (1 - share) / (1 + share)
    assert y.std(axis=0, ddof=1).mean() * factor == pytest.approx(
        noise, rel=5 / np.sqrt(2 * n) + 0.03
    )
