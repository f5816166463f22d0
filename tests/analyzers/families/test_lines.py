"""Columns and rows: defects, periods, taps, and noise that lines share."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal
from structure_frames import accumulated, log_pull, scatter_over_error, sensor, values, white

from dnanalyze.analyzers.families import lines
from dnanalyze.analyzers.families.lines import autocorrelation, share_of_period, share_of_taps


def test_defect_columns_are_counted_and_the_worst_is_measured():
    frames = white(np.random.default_rng(1), (200, 180), 3)
    for f in frames:
        f[:, [20, 77, 131]] += np.array([2.0, -1.5, 4.0], np.float32)
        f[60] += 3
    found = values(lines, frames)
    assert found["column_outliers"].value == 3
    assert found["row_outliers"].value == 1
    # a column mean of 3 frames of 200 pixels has a sd of .0408; the running median adds a little
    assert found["column_extreme"].value == pytest.approx(4 / 0.0408, rel=0.3)


@pytest.mark.parametrize("offset", [0.4, 4.0, 40.0, 400.0])  # from 9 sigma on
def test_a_line_far_out_is_no_chance_however_far(offset):
    frames = white(np.random.default_rng(1), (200, 180), 3)
    for f in frames:
        f[60] += offset
    found = values(lines, frames)["row_extreme"]
    normal = values(lines, white(np.random.default_rng(2), (200, 180), 3))["row_extreme"]
    assert np.log(found.value / normal.value) > 4 * np.hypot(found.se, normal.se)


def test_without_defects_the_extreme_is_that_of_a_normal_sample():
    found = values(lines, white(np.random.default_rng(2), (256, 300), 2))
    assert found["column_outliers"].value == 0
    assert abs(log_pull(found["column_extreme"], 3.0)) < 5  # the largest of 300 is 2.9


@pytest.mark.parametrize("period", [2, 3, 4, 8])
def test_a_period_explains_its_share(period):
    rng = np.random.default_rng(period)
    size, share = 600, 0.4
    pattern = rng.normal(size=period)
    pattern = (pattern - pattern.mean()) / pattern.std() * np.sqrt(share)
    means = pattern[np.arange(size) % period] + np.sqrt(1 - share) * rng.normal(size=size)
    value = share_of_period(means, period)
    assert abs(value.value - share) < 4.5 * value.se
    assert value.se < 0.06
    other = share_of_period(means, 5)
    assert abs(other.value) < 4.5 * other.se


def test_columns_of_period_three_are_found_in_frames():
    rng = np.random.default_rng(3)
    frames = white(rng, (150, 240), 4)
    for f in frames:
        f[:, ::3] += 0.3
    found = values(lines, frames)
    # the pattern has a variance of .3^2 2/9, column means of 4 x 150 pixels 1/600
    share = 0.02 / (0.02 + 1 / 600)
    assert abs(found["column_periodic_3"].value - share) < 4.5 * found["column_periodic_3"].se
    assert abs(found["column_periodic_2"].value) < 4.5 * found["column_periodic_2"].se


@pytest.mark.parametrize("taps", [2, 4, 8])
def test_taps_explain_what_no_smooth_trend_can(taps):
    rng = np.random.default_rng(taps)
    size = 800
    x = np.linspace(-1, 1, size)
    smooth = 5 * x + 3 * x**2 - 2 * x**3
    noise = rng.normal(size=size)
    value = share_of_taps(smooth + noise, taps)
    assert abs(value.value) < 4.5 * value.se
    offsets = 3 * (-1.0) ** np.arange(taps)
    value = share_of_taps(smooth + noise + offsets[np.arange(size) * taps // size], taps)
    # a cubic takes up to 7/8 of a single step's variance, and less of many
    assert value.value > 0.45


def test_line_noise_beyond_what_pixels_explain():
    rng = np.random.default_rng(4)
    rows, columns, fixed, noise = 300, 256, 0.2, 0.15
    offsets = fixed * rng.normal(size=(1, columns))
    frames = [
        (f + offsets + noise * rng.normal(size=(rows, 1))).astype(np.float32)
        for f in white(rng, (rows, columns), 6)
    ]
    found = values(lines, frames)
    expected = {
        "column_noise": np.sqrt(1 + fixed**2 * rows),
        "row_noise": np.sqrt(1 + noise**2 * columns),
        "temporal_column_noise": 1.0,
        "temporal_row_noise": np.sqrt(1 + noise**2 * columns),
        "column_mean_sd": np.sqrt(fixed**2 + 1 / rows),
        "row_mean_sd": np.sqrt(noise**2 + 1 / columns),
        "row_mean_explained": np.sqrt(1 / columns),
    }
    for name, value in expected.items():
        assert abs(log_pull(found[name], value)) < 4.5, name


def test_shading_is_no_line_noise():
    ramp = np.linspace(-1, 1, 200)[:, None]
    frames = [(f + ramp).astype(np.float32) for f in white(np.random.default_rng(5), (200, 200), 3)]
    found = values(lines, frames)
    assert abs(log_pull(found["row_noise"], 1.0)) < 4.5
    assert found["row_mean_sd"].value > 0.5


@pytest.mark.parametrize("correlation", [0.0, 0.6, -0.5])
def test_rows_that_move_together_in_time(correlation):
    rng = np.random.default_rng(6)
    rows, frames = 240, []
    for f in white(rng, (rows, 128), 8, 0.5):
        drive = rng.normal(size=rows + 200)
        line = np.empty_like(drive)
        line[0] = drive[0]
        for k in range(1, drive.size):
            step = np.sqrt(1 - correlation**2)
            line[k] = correlation * line[k - 1] + step * drive[k]
        frames.append((f + line[200:, None]).astype(np.float32))
    found = values(lines, frames)
    own = 0.25 / 128  # of the pixels, in the variance of a row mean
    value = found["temporal_row_lag1"]
    # a circular estimate joins the last row to the first: 1/rows
    assert abs(value.value - correlation / (1 + own)) < 4.5 * value.se + 1 / rows
    other = found["temporal_column_lag1"]
    assert abs(other.value) < 4.5 * other.se


def test_autocorrelation_of_white_lines():
    acf = autocorrelation(np.random.default_rng(7).normal(size=4000))
    assert acf[0] == 1
    assert np.abs(acf[1:]).max() < 5 / np.sqrt(4000)


@pytest.mark.parametrize("shape", [(16, 16), (5, 300), (40, 17)])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_small_frames_give_finite_values_or_a_reason(shape, count):
    result = lines.finish(accumulated(sensor(np.random.default_rng(8), shape, count)))
    for name, value in result.values.items():
        assert np.isfinite([value.value, value.se]).all(), name
        assert value.se > 0, name
    if count == 1:
        assert not any(name.startswith("temporal") for name in result.values)
        assert "lines" in result.missing


def test_columns_that_are_all_alike():
    result = lines.finish(accumulated([np.full((64, 64), 7, np.uint16)] * 3))
    assert "column_outliers" in result.missing
    assert result.values["column_periodic_2"].value == 0
    frames = [np.tile(np.arange(64, dtype=np.uint16) % 2 * 10, (64, 1))] * 3
    assert values(lines, frames)["column_periodic_2"].value == pytest.approx(1)


def test_errors_are_those_of_independent_captures():
    captures = [sensor(np.random.default_rng((9, k))) for k in range(100)]
    ratios = scatter_over_error(lines, captures, rare=("column_outliers", "row_outliers"))
    assert len(ratios) == 12
    for name, ratio in ratios.items():  # 7 % sampling error each, honest to 30 %
        assert 0.55 < ratio < 1.5, (name, ratio)


def test_known_line_noise_of_real_sensors(captures_root):
    """Seen with independent code: row-mean sd .199, pixels explain .069; columns 2 to 3 times."""
    tifffile = pytest.importorskip("tifffile")
    fits = pytest.importorskip("astropy.io.fits")
    real = captures_root / "real"
    frame = tifffile.imread(real / "scmos_single" / "balanced_dark_1us-02.tif")
    found = values(lines, [frame])
    assert found["row_mean_sd"].value == pytest.approx(0.199, abs=0.002)
    assert found["row_mean_explained"].value == pytest.approx(0.068, abs=0.002)
    assert found["column_noise"].value == pytest.approx(1, abs=0.1)
    names = sorted((real / "stl1001_2017").glob("bias-Neg10*"))
    found = values(lines, [fits.getdata(n).astype(np.float32) for n in names])
    assert 2 < found["column_noise"].value < 3
    assert found["row_noise"].value < 1.3
    assert found["temporal_column_noise"].value == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize("taps", [4, 8])
def test_steps_that_clouds_make_by_chance_are_within_the_stated_error(taps):
    pulls = []
    for seed in range(100):
        steps = np.random.default_rng([seed, taps]).standard_normal(600)
        clouds = signal.lfilter([1.0], [1.0, -0.9], steps)[200:]
        value = share_of_taps(clouds, taps)
        pulls.append(value.value / value.se)
    # 3.6 and 6.5 if the lines were taken for independent
    assert np.sqrt(np.mean(np.square(pulls))) < 3.0
