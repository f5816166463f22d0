"""Codes as camera programs store them: multiplied to fill 16 bits, or divided to floats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting
from dnanalyze.loaders.code_unit import code_unit, divided, in_codes

POINT = OperatingPoint(25.0, 0.1)
CODES = np.random.default_rng(2).integers(200, 260, (64, 64)).astype(np.float64)


def captures(values: np.ndarray, **sensor: object) -> CaptureSet:
    frame = Frame("a", POINT, lambda w: values if w is None else values[w.slices])
    return CaptureSet("scaled", Sensor(values.shape, **sensor), (Setting(POINT, (frame,), 3200.0),))


@pytest.mark.parametrize("factor", [4, 16, 64, 257, 1 / 65535, 1 / 4095, 16 / 65535, 3.7e-4])
def test_the_factor_of_stored_codes_is_found(factor):
    kind = np.uint32 if factor > 1 else np.float32
    unit = code_unit(captures((CODES * factor).astype(kind)))
    assert unit == pytest.approx(factor, rel=1e-5)


@pytest.mark.parametrize("values", [CODES, 2 * CODES, 3 * CODES, CODES + 0.3])
def test_codes_and_small_factors_are_left_alone(values):
    """A factor of 2 or 3 may be a digital gain or a sum of pixels."""
    assert code_unit(captures(values.astype(np.float32))) == 1.0


def test_one_value_that_is_no_multiple_denies_the_factor():
    values = 16 * CODES
    values[32, 5] += 1
    assert code_unit(captures(values.astype(np.uint16))) == 1.0


@pytest.mark.parametrize("sigma", [1e-5, 0.01, 1e5])
def test_floats_that_are_no_codes_get_a_unit_near_a_sixteenth_of_their_noise(sigma):
    values = 5.0 * sigma + sigma * np.random.default_rng(4).standard_normal((64, 64))
    unit = code_unit(captures(values))
    assert sigma / 40 < unit < sigma / 12
    assert code_unit(captures(values / sigma)) == 1.0


def test_everything_in_the_unit_of_the_files_is_divided():
    given_at = ((POINT, 1600.0),)
    stored = captures(
        (16 * CODES).astype(np.uint16), bits=16, black_level=3200.0, white_level=65520.0,
        system_gain_dn_e=8.0, black_levels=given_at,
    )  # fmt: skip
    made = in_codes(stored, 16.0)
    np.testing.assert_array_equal(made.settings[0].frames[0].read(), CODES)
    assert made.settings[0].black_level == 200.0
    sensor = made.sensor
    assert (sensor.bits, sensor.black_level, sensor.white_level) == (12, 200.0, 4095.0)
    assert sensor.system_gain_dn_e == 0.5
    assert sensor.black_levels == ((POINT, 100.0),)
    assert in_codes(stored, 1.0) is stored


@given(st.integers(1, 65535), st.sampled_from([1 / 65535, 1 / 4095, 16.0, 257.0]))
def test_a_multiple_of_the_unit_is_a_whole_code(code, unit):
    stored = np.float32(code * unit)
    assert divided(np.array([stored]), unit)[0] == code


def test_frames_of_one_or_two_levels_tell_no_factor():
    assert code_unit(captures(np.full((64, 64), 64.0))) == 1.0
    assert code_unit(captures(np.where(CODES > 230, 64.0, 128.0))) == 1.0


def test_no_frames_have_no_unit():
    assert code_unit(replace(captures(CODES), settings=())) == 1.0
