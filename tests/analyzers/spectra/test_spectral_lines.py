"""All significant lines of a spectrum, in frames made without the package's simulator."""

from __future__ import annotations

import numpy as np
import pytest
from dark_frames import capture_of
from hypothesis import given, settings
from hypothesis import strategies as st
from structure_frames import accumulated, white

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.families import spectrum

ROWS, COLUMNS = 144, 160
TWO = ((0.1312, -0.2207, 0.5), (0.3719, 0.1483, 0.3))


def hummed(rng, lines, count=12, noise=1.0, shape=(ROWS, COLUMNS)):
    """White frames with sines (u, v, amplitude) whose phases are new in every frame."""
    y, x = np.indices(shape)
    frames = white(rng, shape, count, noise)
    for frame in frames:
        for u, v, amplitude in lines:
            frame += amplitude * np.sin(2 * np.pi * (u * x + v * y + rng.random()))
    return frames


def found_in(frames, part="temporal"):
    return spectrum.finish(accumulated(frames)).curves[f"{part}_lines"]


def nearest(found, u, v):
    """The row next to a frequency or its mirror, and the distance along u and v in errors."""
    sign = np.where(found[:, 0] * u + found[:, 1] * v < 0, -1.0, 1.0)
    away = np.stack([sign * found[:, 0] - u, sign * found[:, 1] - v])
    n = int(np.argmin(np.hypot(*away)))
    return found[n], np.abs(away[:, n]) / found[n, 2:4]


def test_two_lines_are_found_where_they_are_with_their_amplitudes():
    found = found_in(hummed(np.random.default_rng(1), TWO))
    assert found.shape == (2, 7)
    for u, v, amplitude in TWO:
        row, pulls = nearest(found, u, v)
        assert max(pulls) < 4
        # 12 random phases scatter the power by 1 / sqrt(12 x 11) = 9 %, the amplitude by half of it
        assert row[4] == pytest.approx(amplitude, rel=4 * 0.045)
        assert row[6] == 0


def test_rows_have_a_fundamental_and_its_harmonic():
    lines = [(0.0, 0.077, 0.4), (0.0, 0.154, 0.2), (0.0, 0.308, 0.1)]
    found = found_in(hummed(np.random.default_rng(2), lines))
    on_axis = found[found[:, 6] == 1]
    assert len(on_axis) == 3
    for _, v, amplitude in lines:
        row, pulls = nearest(on_axis, 0.0, v)
        assert pulls[1] < 4
        assert row[4] == pytest.approx(amplitude, rel=4 * 0.05)


def test_rows_beat_slowly_where_nothing_shades_them():
    """Below .02 cycles a row the pattern is shading, what changes in time is not."""
    lines = [(0.0, 0.0138, 0.3), (0.0, 0.0291, 0.15)]
    frames = hummed(np.random.default_rng(3), lines, shape=(600, 96))
    found = found_in(frames)
    assert np.sort(np.abs(found[found[:, 6] == 1, 1])) == pytest.approx([0.0138, 0.0291], abs=2e-4)


def test_white_noise_has_no_line():
    """Chance makes one in a thousand spectra, three of which are searched twice each stack."""
    for seed in range(20):
        frames = white(np.random.default_rng(seed), (96, 112), 4)
        curves = spectrum.finish(accumulated(frames)).curves
        assert curves["temporal_lines"].shape == (0, 7)
        assert curves["pattern_lines"].shape == (0, 7)


@settings(max_examples=12, deadline=None)
@given(
    u=st.floats(0.05, 0.45),
    v=st.floats(0.05, 0.45),
    mirrored=st.booleans(),
    amplitude=st.floats(0.3, 30.0),
)
def test_what_a_line_between_two_modes_spreads_is_no_other_line(u, v, mirrored, amplitude):
    line = (u, -v if mirrored else v, amplitude)
    found = found_in(hummed(np.random.default_rng(1), [line], count=4))
    others = [row for row in found if max(nearest(row[None], *line[:2])[1]) > 5 and not row[6]]
    assert others == []


def test_the_strongest_lines_are_those_of_the_values():
    lines = [*TWO, (0.0, 0.1312, 0.2)]
    result = spectrum.finish(accumulated(hummed(np.random.default_rng(4), lines)))
    rows = result.curves["temporal_lines"]
    for name, row in zip(("temporal_line", "temporal_axis_line"), rows, strict=False):
        for n, what in ((0, "_u"), (1, "_v"), (4, "_amplitude"), (5, "")):
            assert result.values[f"{name}{what}"].value == row[n]


def test_lines_that_change_in_time_are_none_of_the_pattern():
    """Of a random phase a Kth of the power is left in the mean of K frames."""
    frames = hummed(np.random.default_rng(5), TWO, count=6)
    assert len(found_in(frames, "temporal")) == 2
    assert len(found_in(frames, "pattern")) <= 1  # the strongest is shown whatever it is
    y, x = np.indices((ROWS, COLUMNS))
    for frame in frames:
        frame += 0.4 * np.sin(2 * np.pi * (0.21 * x + 0.087 * y) + 1)
        frame += 0.3 * np.sin(2 * np.pi * (0.402 * x - 0.11 * y) + 2)
    found = found_in(frames, "pattern")
    for u, v, amplitude in ((0.21, 0.087, 0.4), (0.402, -0.11, 0.3)):
        row, pulls = nearest(found, u, v)
        assert max(pulls) < 4
        assert row[4] == pytest.approx(amplitude, rel=0.1)


def test_a_fit_searches_for_none():
    captures = capture_of(hummed(np.random.default_rng(6), TWO))
    full, quick = (
        analyze_windows(captures, (None,), workers=1, errors=e)[0].settings[0].curves
        for e in (True, False)
    )
    assert len(full["temporal_lines"]) == 2
    assert not [name for name in quick if name.endswith("_lines")]
