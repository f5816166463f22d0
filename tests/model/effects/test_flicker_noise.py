import numpy as np
import pytest
from readout_bench import POINT, Given, added
from scipy.signal import welch

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.flicker_noise import FlickerNoise


def modes(count, alpha):
    """Shares of the variance in the modes k = 1 ... count / 2."""
    p = np.arange(1, count // 2 + 1) ** -alpha
    return p / p.sum()


@pytest.mark.parametrize("alpha", [0.5, 1.0, 2.0])
def test_power_law_over_two_decades_of_the_raster(alpha):
    d = added(FlickerNoise(1.0, alpha), count=12, shape=(128, 256))
    f, s = welch(d.reshape(12, -1), nperseg=8192, noverlap=4096, detrend="linear")
    s = s.mean(axis=0)
    use = (f > 0.002) & (f < 0.2)
    # weights: modes a log interval
    slope = np.polyfit(np.log(f[use]), np.log(s[use]), 1, w=1 / np.sqrt(f[use]))[0]
    assert slope == pytest.approx(-alpha, abs=0.05)


@pytest.mark.parametrize("alpha", [0.5, 1.0, 2.0])
def test_rms_over_a_frame(alpha):
    d = added(FlickerNoise(3.0, alpha), count=60, shape=(64, 96))
    variance = d.var(axis=(1, 2))
    spread = np.sqrt(np.sum(modes(64 * 96, alpha) ** 2) / 60)
    assert variance.mean() == pytest.approx(9.0, rel=5 * spread)


def test_smooth_along_rows_and_new_in_every_frame():
    d = added(FlickerNoise(1.0, 1.0), count=2, shape=(128, 256))
    along = np.corrcoef(d[0, :, 1:].ravel(), d[0, :, :-1].ravel())[0, 1]
    across = np.corrcoef(d[0, 1:].ravel(), d[0, :-1].ravel())[0, 1]
    assert along > across + 0.2
    # the lowest modes dominate: a frame has about 1 / sum p^2 independent ones
    assert abs(np.corrcoef(d[0].ravel(), d[1].ravel())[0, 1]) < 5 * np.sqrt(
        np.sum(modes(128 * 256, 1.0) ** 2)
    )


def test_row_blanking_loosens_the_seam_between_rows():
    near, far = (
        added(FlickerNoise(1.0, 1.0, overhead), count=8, shape=(256, 64)) for overhead in (0, 2000)
    )
    seam = [np.mean((d[:, 1:, 0] - d[:, :-1, -1]) ** 2) for d in (near, far)]
    assert seam[1] > 1.5 * seam[0]


def test_follows_gain_but_not_temperature():
    plain = added(FlickerNoise(1.0), shape=(64, 64))
    loud = added(FlickerNoise(1.0), shape=(64, 64), point=OperatingPoint(25.0, 1.0, 3.0))
    assert loud.std() / plain.std() == pytest.approx(3.0, rel=0.5)
    assert FlickerNoise(0.4).variance(POINT) == pytest.approx(0.16)


@pytest.mark.parametrize("alpha", [0.6, 1.0, 1.5])
def test_guess_from_rows_and_along_rows(alpha):
    rows, columns, rms = 128, 256, 0.5
    f = np.arange(1, rows * columns // 2 + 1) / (rows * columns)
    constant = rms**2 * rows * columns / (2 * np.sum(f**-alpha))
    seen, model, off = {}, {}, {}
    bands = {"0_0.02": 0.0089, "0.02_0.1": 0.045, "0.1_0.3": 0.173, "0.3_0.5": 0.387}
    for band, v in bands.items():
        seen[f"temporal_rows_{band}"] = 4.0 + constant * (v / columns) ** -alpha
    for band, u in {
        "0_0.03": 0.0134,
        "0.03_0.1": 0.0548,
        "0.1_0.3": 0.173,
        "0.3_0.5": 0.387,
    }.items():
        seen[f"temporal_u_{band}"] = 4.0 + constant * u**-alpha
    for name in seen:
        model[name], off[name] = 4.0, 8.0
    (effect,) = FlickerNoise.guess(Given((rows, columns), seen=seen, model=model, off=off))
    assert effect.alpha == pytest.approx(alpha, abs=0.03)
    assert effect.rms == pytest.approx(rms, rel=0.15)
