from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting
from dnanalyze.workbench import curves
from dnanalyze.workbench.curves import Address, Curve, residual

POINT = OperatingPoint(25.0, 0.1)
NOISE = 6.0


def _statistics(stack):
    made = tuple(
        Frame(f"{i}", POINT, lambda w, x=x: x if w is None else x[w.slices])
        for i, x in enumerate(stack)
    )
    return analyze(CaptureSet("white", Sensor(stack[0].shape), (Setting(POINT, made),)))


@pytest.fixture(scope="module")
def white():
    """White noise of 6 DN, 8 frames of 128 x 128."""
    stack = np.random.default_rng(5).normal(200, NOISE, (8, 128, 128))
    return _statistics(stack.round().astype(np.uint16))


SHOWN = {
    "temporal_psd_0.08_0.16": "spatial frequency",
    "temporal_u_0.1_0.3": "horizontal frequency",
    "temporal_v_0.1_0.3": "vertical frequency",
    "temporal_columns_0.1_0.3": "horizontal frequency",
    "temporal_rows_0.1_0.3": "vertical frequency",
    "temporal_row_noise": "vertical frequency",
}


@pytest.mark.parametrize("name", SHOWN)
def test_the_power_of_white_noise_is_its_variance_within_the_band(white, name):
    address = Address(name, POINT)
    assert SHOWN[name] in curves.axes(address, white).x
    found = curves.curve(white, address, white)
    variance = NOISE**2 + 1 / 12
    inside = (found.low < variance) & (variance < found.high)
    assert inside.mean() > 0.8  # two standard errors hold 95 %
    assert np.mean(found.y) == pytest.approx(variance, rel=3 / np.sqrt(7 * len(found.y)))


def test_a_peak_on_an_axis_is_shown_in_the_spectrum_of_its_lines():
    """Columns of period 4 in white noise."""
    wave = 20.0 * np.cos(np.pi / 2 * np.arange(128))
    stack = np.random.default_rng(7).normal(200, NOISE, (3, 128, 128)) + wave
    statistics = _statistics(stack.round().astype(np.uint16))
    address = Address("pattern_axis_line", POINT)
    found = curves.curve(statistics, address, statistics)
    assert "column means" in curves.axes(address, statistics).x
    assert found.x[np.argmax(found.y)] == pytest.approx(0.25, abs=1 / 128)


def test_a_histogram_is_a_density(white):
    found = curves.curve(white, Address("pattern_q0.99", POINT), white)
    width = np.diff(found.x)[0]
    assert np.nansum(found.y) * width == pytest.approx(1.0, abs=1e-3)
    peak = np.nanmax(found.y)
    assert peak == pytest.approx(1 / (NOISE * np.sqrt(2 * np.pi)), rel=0.05)


def test_a_statistic_over_operating_points_has_its_error(white):
    labels, found = curves.over_points(white, Address("mean", POINT), white)
    value = white.settings[0].values["mean"]
    assert labels == ["25 °C, 0.1 s"]
    assert found.y[0] == value.value
    assert found.high[0] - found.low[0] == pytest.approx(4 * value.se)


def test_values_keep_the_place_of_their_operating_point(white):
    here = white.settings[0]
    warm = replace(here, point=OperatingPoint(45.0, 0.1))
    both = replace(white, settings=[here, warm])
    alone = replace(white, settings=[warm])
    labels, found = curves.over_points(alone, Address("mean", POINT), both)
    assert labels == ["25 °C, 0.1 s", "45 °C, 0.1 s"]
    np.testing.assert_array_equal(found.x, [1.0])


@pytest.fixture(scope="module")
def windows():
    """White noise of 6 and of 12 DN with the same random numbers, 3 frames of 64 x 64."""
    stack = np.random.default_rng(6).normal(0, NOISE, (3, 64, 64))
    return _statistics(stack + 200), _statistics(2 * stack + 200)


def test_a_change_in_a_window_moves_the_whole_spectrum_by_its_ratio(white, windows):
    address = Address("temporal_psd_0.08_0.16", POINT)
    whole = curves.curve(white, address, white)
    moved = curves.curve(white, address, white, windows)
    np.testing.assert_allclose(moved.y / whole.y, 4.0, rtol=1e-3)


def test_a_change_in_a_window_moves_a_value_on_its_scale(white, windows):
    address = Address("temporal_noise", POINT)
    _, whole = curves.over_points(white, address, white)
    _, moved = curves.over_points(white, address, white, windows)
    assert moved.y[0] / whole.y[0] == pytest.approx(2.0, rel=1e-3)


def test_a_histogram_is_that_after_the_change(white, windows):
    address = Address("pattern_q0.99", POINT)
    found = curves.curve(white, address, white, windows)
    width = np.diff(found.x)[0]
    inside = np.nansum(found.y[np.abs(found.x - 200) < NOISE]) * width
    assert inside == pytest.approx(0.383, rel=0.08)  # half a standard deviation to either side


def test_hot_pixels_do_not_make_the_bins_of_a_histogram_wider(white):
    stack = np.random.default_rng(7).normal(200, NOISE, (3, 64, 64))
    stack[:, ::16, ::16] = 9000.0
    hot = _statistics(stack)
    found = curves.curve(hot, Address("pattern_q0.99", POINT), hot)
    assert np.diff(found.x).max() < NOISE
    assert found.x.max() < 200 + 30 * NOISE


def test_what_a_family_cannot_draw_is_none(white):
    assert curves.axes(Address("mean", POINT), white) is None
    assert curves.curve(white, Address("mean", POINT), white) is None
    assert curves.curve(white, Address("pattern_q0.99", OperatingPoint(99.0)), white) is None


def test_a_residual_is_the_difference_over_the_error_of_both():
    x = np.array([1.0, 2.0, 3.0])
    measured = Curve(x, np.array([10.0, 20.0, 30.0]), x * 10 - 6, x * 10 + 6)  # sd 3
    model = Curve(x, np.array([5.0, 20.0, 40.0]), x * 0 - 8, x * 0 + 8)  # sd 4
    found = residual(measured, model, log=False)
    assert found.y == pytest.approx([1.0, 0.0, -2.0])  # 5, 0 and -10 over 5


def test_a_residual_on_a_logarithmic_axis_is_that_of_the_logarithms():
    x = np.array([0.1, 0.2])
    y = np.array([1.0, np.e])
    measured = Curve(x, y, y * np.exp(-2.0), y * np.exp(2.0))  # sd 1 of the logarithm
    exact = Curve(x, np.ones(2), np.ones(2), np.ones(2))
    assert residual(measured, exact, log=True).y == pytest.approx([0.0, 1.0])


def test_no_residual_without_an_error_or_beyond_the_model_s_abscissas():
    x = np.array([1.0, 2.0])
    bare = Curve(x, x, x, x)
    assert residual(bare, bare, log=False) is None
    banded = Curve(x, x, x - 1, x + 1)
    there = Curve(x[:1], x[:1], x[:1], x[:1])
    assert residual(banded, there, log=False).x.tolist() == [1.0]
