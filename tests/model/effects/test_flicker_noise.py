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


def test_below_the_cutoff_the_spectrum_is_flat():
    d = added(FlickerNoise(1.0, 1.5, cutoff=0.05), count=12, shape=(128, 256))
    f, s = welch(d.reshape(12, -1), nperseg=4096, noverlap=2048, detrend="linear")
    s = s.mean(axis=0)
    low, above = (f > 0.001) & (f < 0.04), (f > 0.07) & (f < 0.4)
    # slopes over 1.6 and .75 decades of some 1900 and 16000 independent modes
    assert np.polyfit(np.log(f[low]), np.log(s[low]), 1, w=1 / np.sqrt(f[low]))[0] == pytest.approx(
        0.0, abs=0.15
    )
    assert np.polyfit(np.log(f[above]), np.log(s[above]), 1)[0] == pytest.approx(-1.5, abs=0.1)
    assert d.var() == pytest.approx(1.0, rel=0.1)
    assert FlickerNoise(cutoff=0.1).inactive_parameters() == ()


@pytest.mark.parametrize("width", [256, 255])
def test_chains_are_independent_and_each_has_the_law(width):
    d = added(FlickerNoise(1.0, 1.0, chains=2), count=12, shape=(128, width))
    even, odd = d[:, :, 0::2], d[:, :, 1::2]
    variance = np.sqrt(np.sum(modes(64 * width, 1.0) ** 2) / 12)
    for chain in (even, odd):
        assert chain.var(axis=(1, 2)).mean() == pytest.approx(1.0, rel=5 * variance)
    n = min(even.shape[2], odd.shape[2])
    each = [np.corrcoef(a[:, :n].ravel(), b[:, :n].ravel())[0, 1] for a, b in
            zip(even, odd, strict=True)]  # fmt: skip
    assert abs(np.mean(each)) < 5 * variance
    near = np.corrcoef(even[:, :, 1:].ravel(), even[:, :, :-1].ravel())[0, 1]
    assert near > 0.4


def band_clues(law):
    bands = ("0_0.02", "0.02_0.1", "0.1_0.3", "0.3_0.5")
    places = {f"temporal_rows_{b}": c / 256 for b, c in zip(bands, (0.01, 0.06, 0.2, 0.4),
                                                            strict=True)}  # fmt: skip
    along = {"0_0.03": 0.015, "0.03_0.1": 0.065, "0.1_0.3": 0.2, "0.3_0.5": 0.4}
    places |= {f"temporal_u_{b}": f for b, f in along.items()}
    seen = {name: law(f) for name, f in places.items()}
    return Given(seen=seen, model=dict.fromkeys(seen, 0.0), off=dict.fromkeys(seen, 9.0))


def test_guess_finds_the_cutoff_where_the_rows_are_white():
    cut, plain = FlickerNoise.guess(band_clues(lambda f: 0.3 * max(f, 0.01) ** -1.2))
    assert cut.cutoff == pytest.approx(0.01, rel=0.2)
    assert cut.alpha == pytest.approx(1.2, abs=0.05)
    assert plain.cutoff == 0.0
    (law,) = FlickerNoise.guess(band_clues(lambda f: 0.3 * f**-1.2))
    assert (law.cutoff, law.chains) == (0.0, 1)


def test_guess_tells_two_chains_by_power_that_rises_again():
    two, one = FlickerNoise.guess(band_clues(lambda f: 0.3 / min(f, abs(0.5 - f))))
    assert (two.chains, one.chains) == (2, 1)
