"""What the fit looks at, and what it is judged by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dnanalyze.demo import VirtualSensor, generate
from dnanalyze.errors import InputError
from dnanalyze.fitting.design import ALIGNED, BAND, BUDGET_PIXELS, PART_FROM_PIXELS, design
from dnanalyze.fitting.fit import baseline_model, with_seed
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window
from dnanalyze.model.simulate import simulate

BAYER = (("R", "G"), ("G", "B"))


def captures(shape, temperatures=1, frames=2, cfa=None):
    def load(window):
        return np.zeros(shape if window is None else window.shape, np.uint16)

    def setting(number):
        point = OperatingPoint(20.0 + 10.0 * number, 1.0, 1.0)
        empty = Frame("empty", point, load)
        return Setting(point, (empty,) * frames)

    found = tuple(setting(n) for n in range(temperatures))
    return CaptureSet("made up", Sensor(shape, cfa=cfa), found)


@settings(deadline=None)
@given(
    rows=st.integers(32, 5000),
    columns=st.integers(32, 5000),
    frames=st.integers(1, 40),
    temperatures=st.integers(1, 12),
    cfa=st.sampled_from([None, BAYER]),
)
def test_halves_share_the_columns_and_no_pixel(rows, columns, frames, temperatures, cfa):
    plan = design(captures((rows, columns), temperatures, frames, cfa))
    upper, lower = plan.windows
    assert upper.shape == lower.shape
    assert (upper.left, upper.right) == (lower.left, lower.right)
    assert 0 <= upper.top < upper.bottom <= lower.top < lower.bottom <= rows
    assert 0 <= upper.left < upper.right <= columns
    if cfa:
        assert not any(w.top % 2 or w.left % 2 or w.shape[0] % 2 for w in plan.windows)
    seen = sum(count for _, count in plan.settings)
    assert seen * 2 * upper.shape[0] * upper.shape[1] <= 1.01 * BUDGET_PIXELS


def test_a_small_capture_set_is_looked_at_whole():
    plan = design(captures((64, 48), temperatures=3, frames=4))
    assert plan.train.shape == (32, 48)
    assert plan.test.bottom == 64
    assert [count for _, count in plan.settings] == [4, 4, 4]


@pytest.mark.parametrize(
    ("side", "frames", "kept", "share"),
    [(512, 12, 8, 1.0), (650, 8, 5, 1.0), (650, 3, 3, 1.0), (2000, 8, 3, 0.2)],
)
def test_frames_are_spared_before_area(side, frames, kept, share):
    """Never more than eight, nor fewer than three: 2000 x 2000 x 3 x 5 is 60 million."""
    plan = design(captures((side, side), 5, frames))
    assert [count for _, count in plan.settings] == [kept] * 5
    assert 2 * np.prod(plan.train.shape) / side**2 == pytest.approx(share, abs=0.01)


@settings(deadline=None)
@given(
    rows=st.integers(32, 3000),
    columns=st.integers(32, 3000),
    frames=st.integers(1, 10),
    cfa=st.sampled_from([None, BAYER]),
)
def test_a_large_one_has_a_band_in_the_middle_of_either_half(rows, columns, frames, cfa):
    plan = design(captures((rows, columns), 2, frames, cfa))
    if plan.pixels < PART_FROM_PIXELS or plan.train.shape[0] < 4 * BAND:
        assert plan.part is None
        return
    assert plan.part.settings == plan.settings
    for whole, part in zip(plan.windows, plan.part.windows, strict=True):
        assert (whole.left, whole.right) == (part.left, part.right)
        assert (part.top - whole.top) % ALIGNED == 0  # so that a mosaic keeps its colours
        assert 0 <= whole.shape[0] / 4 - part.shape[0] < ALIGNED
        assert abs((part.top - whole.top) - (whole.bottom - part.bottom)) < 2 * ALIGNED


@pytest.mark.parametrize("factor", [16.0, 257.0, 1 / 65535])
def test_a_fit_sees_stored_codes_as_codes(factor):
    """The statistics are the same numbers, and a model writes frames in the files' unit."""
    codes = generate(VirtualSensor(), {}, (64, 64), (40.0, 70.0), frames=3, seed=2)

    def stored(frame: Frame) -> Frame:
        def load(window: Window | None) -> np.ndarray:
            kind = np.uint32 if factor > 1 else np.float32
            return (frame.read(window) * factor).astype(kind)

        return replace(frame, load=load)

    settings = tuple(replace(s, frames=tuple(map(stored, s.frames))) for s in codes.settings)
    plain, scaled = (
        fit_problem(design(codes)),
        fit_problem(design(replace(codes, settings=settings))),
    )
    assert scaled.plan.unit == pytest.approx(factor, rel=1e-6)
    np.testing.assert_array_equal(plain.train.coordinates, scaled.train.coordinates)
    np.testing.assert_array_equal(plain.test.stated, scaled.test.stated)
    model = baseline_model(scaled)
    points = [(s.point, 1) for s in codes.settings]
    made = simulate(model, (64, 64), points).settings[0].frames[0].read()
    own = simulate(replace(model, unit=1.0), (64, 64), points).settings[0].frames[0].read()
    np.testing.assert_allclose(made, factor * own, rtol=1e-6)


def test_a_model_of_another_unit_is_refused():
    codes = generate(VirtualSensor(), {}, (64, 64), (40.0, 70.0), frames=3, seed=2)
    problem = fit_problem(design(codes))
    with pytest.raises(InputError, match="one DN of it is 16 in files"):
        with_seed(problem, replace(baseline_model(problem), unit=16.0), None)
