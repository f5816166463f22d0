"""Rows that are converted at a time, read off the spectrum of the row means."""

from dataclasses import dataclass

import numpy as np
import pytest

from dnanalyze.model.effects.row_noise import TOGETHER
from dnanalyze.model.guesses.row_noise import kernel, rows_together
from dnanalyze.model.serial import sizes

ROWS, COLUMNS, FRAMES = 512, 256, 8
PIXELS = 0.05  # DN^2, of their noise in the power of the row means
FREQUENCY = np.fft.rfftfreq(ROWS)[1:]


@dataclass
class Given:
    """Curves of one operating point, and what the pixels make of the scatter of row means."""

    curves: dict
    shape: tuple = (ROWS, COLUMNS)
    points: tuple = (None,)

    def curve(self, name, setting):
        return self.curves[name][setting]

    def measured(self, name):
        assert name == "temporal_row_mean_explained"
        return np.array([np.sqrt(PIXELS / self.shape[1])])


def offsets(together, rng, count):
    """Rows of groups by repetition, (count, rows)."""
    at_once, banks = sizes(together)
    each = rng.standard_normal((count, ROWS // (at_once * banks), 1, banks))
    return np.repeat(each, at_once, axis=2).reshape(count, ROWS)


def autoregressive(rng, count, share, apart):
    """Each row has a share of the one so far before it."""
    r = rng.standard_normal((count, ROWS))
    for n in range(apart, ROWS):
        r[:, n] = share * r[:, n - apart] + np.sqrt(1 - share**2) * r[:, n]
    return r


def moving_average(rng, count, correlations):
    """Correlations with the row before and the one before that, by the factor of the spectrum."""
    power = 1.0 + 2.0 * sum(
        r * np.cos(2 * np.pi * d * np.fft.rfftfreq(ROWS)) for d, r in enumerate(correlations, 1)
    )
    white = np.fft.rfft(rng.standard_normal((count, ROWS)), axis=1)
    return np.fft.irfft(white * np.sqrt(np.maximum(power, 0.0)), axis=1)


def clues(r, rng):
    """What an analysis shows of row offsets beside pixels."""
    r = r + np.sqrt(PIXELS) * rng.standard_normal(r.shape)
    power = np.mean(np.abs(np.fft.rfft(r, axis=1)[:, 1:]) ** 2, axis=0) / ROWS
    curves = {
        "temporal_row_spectrum": [power],
        "row_spectrum_f": [FREQUENCY],
        "frame_means": [np.zeros(len(r) + 1)],
    }
    return Given(curves)


@pytest.mark.parametrize("together", TOGETHER)
def test_the_kernel_is_the_mean_spectrum_of_groups(together):
    count = 2000
    r = offsets(together, np.random.default_rng(1), count)
    r = np.stack([np.roll(x, n) for n, x in enumerate(r)])  # at any place in the group
    power = np.mean(np.abs(np.fft.rfft(r, axis=1)[:, 1:-1]) ** 2, axis=0) / ROWS
    expected = kernel(FREQUENCY[:-1], together)
    # exponential: a mean of so many scatters by its own size over the root of their number
    error = 6 * (expected + 0.05) / np.sqrt(count)
    assert np.all(np.abs(power - expected) < error + 0.02)  # the ends of 512 rows leak 2 %


@pytest.mark.parametrize("together", TOGETHER)
@pytest.mark.parametrize("seed", range(3))
def test_groups_are_found(together, seed):
    rng = np.random.default_rng(seed)
    assert rows_together(clues(offsets(together, rng, FRAMES - 1), rng)) == together


@pytest.mark.parametrize(("share", "apart"), [(0.3, 1), (0.7, 1), (-0.4, 1), (0.6, 2)])
def test_rows_that_are_alike_without_groups_are_none(share, apart):
    rng = np.random.default_rng(5)
    assert rows_together(clues(autoregressive(rng, FRAMES - 1, share, apart), rng)) == "1x1"


@pytest.mark.parametrize(
    "correlations", [(0.3,), (0.45,), (0.0, 0.3), (0.0, 0.45), (0.3, 0.3), (-0.3,)]
)
@pytest.mark.parametrize("seed", range(3))
def test_a_moving_average_is_no_group(correlations, seed):
    """Two rows of a group beside rows of their own have the spectrum of such a one."""
    rng = np.random.default_rng(seed)
    assert rows_together(clues(moving_average(rng, FRAMES - 1, correlations), rng)) == "1x1"


def test_a_colour_tells_no_groups():
    rng = np.random.default_rng(4)
    curves = clues(offsets("4x1", rng, FRAMES - 1), rng).curves
    assert rows_together(Given(curves)) == "4x1"
    assert rows_together(Given(curves, shape=(2 * ROWS, COLUMNS))) == "1x1"


def test_slow_noise_and_a_line_are_no_groups():
    rng = np.random.default_rng(6)
    white = np.fft.rfft(rng.standard_normal((FRAMES - 1, ROWS)), axis=1)
    white[:, 1:] *= FREQUENCY**-0.5
    slow = np.fft.irfft(white, axis=1)
    assert rows_together(clues(slow, rng)) == "1x1"
    line = 3.0 * np.cos(2 * np.pi * 0.02 * np.arange(ROWS))
    assert rows_together(clues(offsets("1x1", rng, FRAMES - 1) + line, rng)) == "1x1"
    assert rows_together(clues(offsets("4x2", rng, FRAMES - 1) + line, rng)) == "4x2"


def test_a_single_frame_or_a_small_field_tells_nothing():
    seen = clues(offsets("4x1", np.random.default_rng(7), 2), np.random.default_rng(8))
    one = seen.curves | {"frame_means": [np.zeros(1)]}
    assert rows_together(Given(one)) == "1x1"
    small = {name: [values[0][:20]] for name, values in seen.curves.items()}
    assert rows_together(Given(small)) == "1x1"
