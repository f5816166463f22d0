"""Sums come in one order of additions, whatever the vectors of the processor: to the last bit."""

import numpy as np
import pytest

from dnanalyze.analyzers.kernels import mode_loops, neighbour_loops, pixel_loops
from dnanalyze.analyzers.kernels.pixel_loops import LANES

SHAPE = (37, 205)  # no multiple of the number of partial sums


@pytest.fixture(scope="module")
def image():
    return np.random.default_rng(5).normal(3.0, 2.0, SHAPE).astype(np.float32)


def summed(values):
    """Interleaved partial sums, then these one after another."""
    rows = -(-values.size // LANES)
    lanes = np.zeros((rows + 1, LANES), values.dtype)
    lanes[1:].reshape(-1)[: values.size] = values.reshape(-1)
    return one_by_one(np.add.accumulate(lanes, axis=0)[-1])


def one_by_one(values):
    return np.add.accumulate(values)[-1]


def test_sums_of_powers(image):
    d = image.reshape(-1).astype(np.float64) - 3.1
    q, r = d * d, (d * d) * (d * d)
    powers = (d, q, q * d, r, r * d, r * q, r * q * d, r * r)
    assert pixel_loops.power_sums(image.reshape(-1), 3.1) == tuple(summed(p) for p in powers)


def test_sums_of_products(image):
    x = image.reshape(-1)
    a, b = x[1:].astype(np.float64), x[:-1].astype(np.float64)
    found = pixel_loops.products(np.ascontiguousarray(x[1:]), np.ascontiguousarray(x[:-1]))
    assert found == tuple(summed(v) for v in (a, b, a * a, b * b, a * b))


def test_sums_of_a_frame_and_the_one_before(image):
    y, past = image[:20].reshape(-1), image[17:].reshape(-1)[: 20 * SHAPE[1]]
    centre, cut = np.float32(3.0), np.float32(4.0)
    w, x = np.clip(y - centre, -cut, cut), np.clip(past - np.float32(2.0), -cut, cut)
    out = np.zeros(7)
    pixel_loops.seam_sums(y, past, 3.0, 2.0, 4.0, 5.0, out)
    parts = [slice(k, k + pixel_loops.CHUNK) for k in range(0, y.size, pixel_loops.CHUNK)]
    for place, product in enumerate((w, w * w, w * x)):
        assert out[place] == one_by_one(np.array([summed(product[p]) for p in parts], float))


def test_sums_of_three_frames(image):
    one, two, three = (image[k : k + 30].reshape(-1) for k in (0, 3, 7))
    cut = np.float32(3.0)
    u = np.clip(two - one - np.float32(0.5), -cut, cut)
    v = np.clip(three - two - np.float32(-0.25), -cut, cut)
    twice, third, sixth = np.float32(2), np.float32(1 / 3), np.float32(1 / 6)
    out = np.zeros(2)
    pixel_loops.cumulants(one, two, three, 0.5, -0.25, 3.0, out)
    parts = [slice(k, k + pixel_loops.CHUNK) for k in range(0, u.size, pixel_loops.CHUNK)]
    terms = (u * u + u * v + v * v) * third, (twice * u + v) * (v - u) * (u + twice * v) * sixth
    for found, term in zip(out, terms, strict=True):
        assert found == one_by_one(np.array([summed(term[p]) for p in parts], float))


def test_sums_below_thresholds(image):
    thresholds = np.array([2.0, 4.0], np.float32)
    rows, columns = np.array([0, 20, 37]), np.array([0, 100, 205])
    out = np.zeros((2, 2, 3))
    pixel_loops.sum_below(image, image, thresholds, rows, columns, out)
    for a in range(2):
        for b in range(2):
            part = image[rows[a] : rows[a + 1], columns[b] : columns[b + 1]].astype(float)
            for k, below in enumerate((*thresholds, np.inf)):
                by_column = np.add.accumulate(np.where(part < below, part, 0.0), axis=0)[-1]
                assert out[a, b, k] == one_by_one(by_column)


def test_sums_of_lines(image):
    y = np.clip(image - np.float32(3.0), np.float32(-4), np.float32(4)).astype(float)
    by_column, by_row, square = mode_loops.line_sums(image, np.float32(3), np.float32(4))
    np.testing.assert_array_equal(by_column, np.add.accumulate(y, axis=0)[-1])
    np.testing.assert_array_equal(by_row, [summed(row) for row in y])
    assert square == one_by_one(np.array([summed(row * row) for row in y]))
    rows, columns = neighbour_loops.line_means(image, 4.0)
    cut = np.clip(image, np.float32(-4), np.float32(4))
    np.testing.assert_array_equal(rows, [summed(row) / np.float32(SHAPE[1]) for row in cut])
    whole = np.add.accumulate(cut.astype(float), axis=0)[-1]
    np.testing.assert_array_equal(columns, (whole / SHAPE[0]).astype(np.float32))


def test_waves_of_blocks(image):
    phase = np.arange(SHAPE[1])
    cosine, sine = (f(phase).astype(np.float32) for f in (np.cos, np.sin))
    out = mode_loops.block_waves(image, cosine, sine, 2)
    for b in range(2):
        part = slice(b * 102, (b + 1) * 102)
        for wave, held in enumerate((cosine, sine)):
            expected = [summed(row[part] * held[part]) for row in image]
            np.testing.assert_array_equal(out[:, b, wave], expected)


def test_sums_of_pixels_are_not_fused():
    """A fused multiply-add would keep bits of the product that single precision rounds off."""
    rng = np.random.default_rng(8)
    x = rng.normal(0.0, 1.0, (40, 70)).astype(np.float32)
    rows, columns = np.array([0, 40]), np.array([0, 70])
    out = np.zeros((1, 1, 6))
    by_row, by_column = np.zeros(40, np.float32), np.zeros(70, np.float32)
    neighbour_loops.lag_sums(x, 100.0, by_row, by_column, rows, columns, out)
    by_pixel = np.add.accumulate(x * x, axis=0)[-1]
    assert out[0, 0, 0] == one_by_one(by_pixel.astype(float))
