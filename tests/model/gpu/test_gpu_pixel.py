"""What the CUDA source does to a pixel is what the compiled loops do, bit for bit."""

import ctypes

import numpy as np
import pytest
from host_device import COMPILER, compiled

from dnanalyze.loaders.captures import Window
from dnanalyze.model import draws, kernels
from dnanalyze.model.gpu.source import prelude

KEY, SHAPE = 0x0123456789ABCDEF, (211, 307)
WHOLE = Window.whole(SHAPE)

LOOPS = """
extern "C" void each(int what, const u32* words, const float* x, float k, float* out, u32 n) {
    for (u32 i = 0; i < n; ++i)
        out[i] = what == 0 ? normal(words[i]) : what == 1 ? uniform(words[i])
               : what == 2 ? exponential(x[i]) : counts(x[i], k, words[i]);
}
extern "C" void words(u64 key, u32* out, u32 n) {
    for (u32 i = 0; i < n; ++i) out[i] = word(key, i);
}
"""
NORMAL, UNIFORM, EXPONENTIAL, COUNTS = range(4)


@pytest.fixture(scope="module")
def library():
    if COMPILER is None:
        pytest.skip("no C++ compiler on this machine")
    return compiled(prelude() + LOOPS)


def pointer(array):
    return ctypes.c_void_p(array.ctypes.data)


def each(library, what, words, x=None, k=1.0):
    words = np.ascontiguousarray(words, np.uint32)
    x = np.zeros(words.shape, np.float32) if x is None else np.ascontiguousarray(x, np.float32)
    out = np.empty(words.shape, np.float32)
    number = ctypes.c_uint32(out.size)
    library.each(what, pointer(words), pointer(x), ctypes.c_float(k), pointer(out), number)
    return out


def same_bits(a, b):
    return np.array_equal(a.view(np.uint32), b.view(np.uint32))


def test_words_are_those_of_the_stream(library):
    out = np.empty(SHAPE, np.uint32)
    library.words(ctypes.c_uint64(KEY), pointer(out), ctypes.c_uint32(out.size))
    assert np.array_equal(out, draws.bits(KEY, WHOLE, SHAPE[1]))


def test_deviates_have_the_bits_of_the_stream(library):
    words = draws.bits(KEY, WHOLE, SHAPE[1])
    assert same_bits(each(library, NORMAL, words), draws.normal(KEY, WHOLE, SHAPE[1]))
    assert same_bits(each(library, UNIFORM, words), draws.uniform(KEY, WHOLE, SHAPE[1]))


def test_the_ends_of_the_distribution_have_the_same_bits(library):
    words = np.r_[0:4, 2**31 - 2 : 2**31 + 2, 2**32 - 4 : 2**32].astype(np.uint32)
    expected = np.array([kernels._normal(w) for w in words.view(np.int32)], np.float32)
    assert same_bits(each(library, NORMAL, words), expected)
    assert np.abs(expected).max() > 6.3


def test_the_exponential_has_the_same_bits(library):
    x = np.r_[np.linspace(-100, 100, 4001), 0].astype(np.float32)
    expected = np.array([kernels.exp(v) for v in x], np.float32)
    assert same_bits(each(library, EXPONENTIAL, np.zeros(x.size), x), expected)


@pytest.mark.parametrize("k", [1.0, 0.37])
def test_counts_are_the_same_from_none_to_many(library, k):
    # from below zero over the change of method at INVERTED_BELOW to thousands of electrons
    signal = np.geomspace(1e-3, 5e3, SHAPE[0] * SHAPE[1]).astype(np.float32).reshape(SHAPE)
    signal[::7] = kernels.INVERTED_BELOW * np.float32(k)
    signal[::11] *= -1
    expected = draws.counts(signal.copy(), k, KEY, WHOLE, SHAPE[1])
    words = draws.bits(KEY, WHOLE, SHAPE[1])
    assert same_bits(each(library, COUNTS, words, signal, k), expected)
    assert len(np.unique(np.rint(expected / k))) > 1000
