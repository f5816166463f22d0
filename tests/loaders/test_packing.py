"""Packed pixels: known bytes, and the exact inverse for any content."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from dnanalyze.loaders.packing import PACKINGS, group_of, pack, row_bytes, unpack

LAYOUTS = [(how, bits) for how, known in PACKINGS.items() for bits in known]


@st.composite
def images(draw):
    packing, bits = draw(st.sampled_from(LAYOUTS))
    shape = draw(st.tuples(st.integers(1, 5), st.integers(1, 23)))
    return packing, bits, draw(arrays(np.uint16, shape, elements=st.integers(0, 2**bits - 1)))


@settings(max_examples=200, deadline=None)
@given(images())
def test_unpack_is_the_inverse_of_pack(image):
    packing, bits, array = image
    packed = pack(array, bits, packing)
    assert packed.shape == (len(array), row_bytes(array.shape[1], bits, packing))
    assert np.array_equal(unpack(packed, array.shape[1], bits, packing), array)


@settings(max_examples=100, deadline=None)
@given(st.sampled_from([10, 12, 14]), st.sampled_from(["mipi", "lsb", "msb"]), st.data())
def test_pack_is_the_inverse_of_unpack(bits, packing, data):
    pixels, size = group_of(bits, packing)
    packed = data.draw(arrays(np.uint8, (2, 3 * size)))
    assert np.array_equal(pack(unpack(packed, 3 * pixels, bits, packing), bits, packing), packed)


@pytest.mark.parametrize(
    ("bits", "pixels", "expected"),
    [
        # CSI-2: the high eight bits of each pixel, then the low bits, first pixel lowest
        (10, [0x3FF, 0x000, 0x001, 0x202], [0xFF, 0x00, 0x00, 0x80, 0b10_01_00_11]),
        (12, [0xABC, 0x123], [0xAB, 0x12, 0x3C]),
        (14, [0x3FFF, 0, 0x0001, 0x2AAA], [0xFF, 0, 0, 0xAA, 0x3F, 0x10, 0xA8]),
    ],
)
def test_mipi_bytes(bits, pixels, expected):
    packed = pack(np.array([pixels], np.uint16), bits, "mipi")
    assert packed.tolist() == [expected]


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_lsb_is_one_little_endian_number(bits):
    pixels, size = group_of(bits, "lsb")
    values = [(7919 * (k + 1)) % (1 << bits) for k in range(pixels)]
    number = sum(v << (bits * k) for k, v in enumerate(values))
    packed = pack(np.array([values], np.uint16), bits, "lsb")
    assert packed.tobytes() == number.to_bytes(size, "little")


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_msb_is_one_big_endian_number(bits):
    pixels, size = group_of(bits, "msb")
    values = [(7919 * (k + 1)) % (1 << bits) for k in range(pixels)]
    number = int("".join(f"{v:0{bits}b}" for v in values), 2)
    packed = pack(np.array([values], np.uint16), bits, "msb")
    assert packed.tobytes() == number.to_bytes(size, "big")


@pytest.mark.parametrize(
    ("bits", "pixels", "expected"),
    [
        # GigE Vision 1.2, 16.2: high bits, both low parts, high bits
        (12, [0xABC, 0x123], [0xAB, 0x3C, 0x12]),
        (10, [0x3FE, 0x001], [0xFF, 0x12, 0x00]),
    ],
)
def test_genicam_bytes(bits, pixels, expected):
    packed = pack(np.array([pixels], np.uint16), bits, "genicam")
    assert packed.tolist() == [expected]


def test_a_very_wide_row():
    array = np.random.default_rng(1).integers(0, 1 << 10, (3, 16384), np.uint16)
    assert np.array_equal(unpack(pack(array, 10, "mipi"), 16384, 10, "mipi"), array)
