"""Where a line lies, against the truth and the bound of Cramer and Rao."""

from __future__ import annotations

import math

import numpy as np
import pytest
from structure_frames import values, white

from dnanalyze.analyzers.families import spectrum
from dnanalyze.analyzers.spectra.location import UNIFORM, located

ROWS, COLUMNS = 96, 120
Y, X = np.indices((ROWS, COLUMNS))


def wave(u: float, v: float, phase: float) -> np.ndarray:
    return np.sin(2 * np.pi * (u * X + v * Y + phase))


def nearest(u: float, v: float) -> tuple[float, float]:
    return round(u * COLUMNS) / COLUMNS, round(v * ROWS) / ROWS


@pytest.mark.parametrize("amplitude", [0.15, 0.5, 2.0])
def test_places_scatter_by_the_bound_and_the_error_says_so(amplitude):
    rng = np.random.default_rng(1)
    pulls, errors = [], []
    for _ in range(60):
        u, v = rng.uniform(0.05, 0.45), rng.uniform(-0.45, 0.45)
        image = amplitude * wave(u, v, rng.random()) + rng.normal(size=(ROWS, COLUMNS))
        found = located([image.astype(np.float32)], *nearest(u, v), 1.0)
        pulls += [(found.u - u) / found.u_error, (found.v - v) / found.v_error]
        errors.append(found.u_error * COLUMNS)
    # var(omega) = 24 sigma^2 / (A^2 N^2 pixels) of one row or many, in modes 3 / (2 pi^2 R)
    bound = math.sqrt(1.5 / math.pi**2 / (amplitude**2 * ROWS * COLUMNS / 4))
    assert np.median(errors) == pytest.approx(bound, rel=0.15)
    # 120 pulls: 5 sigma of their scatter, and the errors' own of about 10 %
    assert np.std(pulls) == pytest.approx(1.0, abs=0.4)
    assert np.mean(np.abs(pulls) < 3) >= 0.95


@pytest.mark.parametrize("place", [(2.2, 3.3), (0.0, 30.4), (59.6, -2.3), (60.0, 24.0)])
def test_waves_beside_their_mirror_frequency_are_not_moved(place):
    u, v = place[0] / COLUMNS, place[1] / ROWS
    for phase in np.arange(8) / 8:
        found = located([wave(u, v, phase)], *nearest(u, v), 1.0)
        forms = [
            (s * found.u - u + n, s * found.v - v + m)
            for s in (1, -1) for n in (-1, 0, 1) for m in (-1, 0, 1)
        ]  # fmt: skip
        du, dv = min(forms, key=lambda f: math.hypot(*f))
        assert abs(du) * COLUMNS < 0.003
        assert abs(dv) * ROWS < 0.003


def test_a_line_that_tells_no_more_is_anywhere_in_its_mode():
    image = np.random.default_rng(2).normal(size=(ROWS, COLUMNS))
    found = located([image], 12 / COLUMNS, 9 / ROWS, 1.0)
    assert (found.u, found.v) == pytest.approx((12 / COLUMNS, 9 / ROWS), rel=1e-12)
    assert (found.u_error, found.v_error) == (UNIFORM / COLUMNS, UNIFORM / ROWS)


def test_lines_of_frames_are_where_they_were_planted_as_far_as_their_errors_say():
    """From just seen to as strong as the noise, phases new, 2 to 8 frames, also under row noise."""
    rng = np.random.default_rng(3)
    right, seen = 0, 0
    for n in range(48):
        count, on_axis = int(rng.integers(2, 9)), n % 4 == 0
        u, v = rng.uniform(0.04, 0.46), rng.uniform(0.04, 0.46) * rng.choice([-1, 1])
        u = 0.2 / COLUMNS if on_axis else u
        amplitude = 10 ** rng.uniform(-1.0, 0.0)
        frames = [
            f + amplitude * wave(u, v, rng.random()) + 0.1 * rng.normal(size=(ROWS, 1))
            for f in white(rng, (ROWS, COLUMNS), count)
        ]
        found = values(spectrum, frames)
        name = "temporal_axis_line" if on_axis else "temporal_line"
        if f"{name}_u" not in found or found[f"{name}_u"].se > 0.1:
            continue  # too weak for this peak
        at_u, at_v = found[f"{name}_u"], found[f"{name}_v"]
        sign = 1 if at_v.value * v > 0 else -1
        seen += 1
        right += (
            abs(sign * at_u.value - u) < 3 * at_u.se and abs(sign * at_v.value - v) < 3 * at_v.se
        )
    assert seen > 30
    assert right >= 0.95 * seen


def test_without_a_line_no_axis_has_one():
    found = values(spectrum, white(np.random.default_rng(4), (ROWS, COLUMNS), 4))
    assert not [name for name in found if "axis_line" in name]
