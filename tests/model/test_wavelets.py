import numpy as np
import pytest
import pywt
from hypothesis import given, settings
from hypothesis import strategies as st

from dnanalyze.model import wavelets

RNG = np.random.default_rng(3)
NOISE = RNG.normal(100.0, 5.0, (60, 75)).astype(np.float32)


def test_wavelet_is_orthonormal_haar_shrinkage_averaged_over_shifts():
    y = RNG.normal(0.0, 5.0, (64, 64))
    expected = np.zeros_like(y)
    for dy in range(8):
        for dx in range(8):
            moved = np.roll(y, (dy, dx), (0, 1))
            coarse, *details = pywt.wavedec2(moved, "haar", mode="periodization", level=3)
            shrunk = [tuple(pywt.threshold(b, 4.0, "soft") for b in level) for level in details]
            back = pywt.waverec2([coarse, *shrunk], "haar", mode="periodization")
            expected += np.roll(back, (-dy, -dx), (0, 1)) / 64
    inner = slice(8, -8), slice(8, -8)  # the edges are mirrored here, wrapped there
    found = wavelets.over_all_shifts(y.astype(np.float32), 4.0)
    np.testing.assert_allclose(found[inner], expected[inner], atol=1e-4)


@pytest.mark.parametrize(
    ("name", "basis", "begins"), [("haar", wavelets.HAAR, 0), ("db2", wavelets.DB2, 7)]
)
def test_wavelet_on_a_grid_is_the_decimated_transform(name, basis, begins):
    """That of the package begins a tap before each pair: 1 + 2 + 4 pixels on three levels."""
    y = RNG.normal(0.0, 5.0, (96, 128))
    coarse, *details = pywt.wavedec2(y, name, mode="periodization", level=3)
    shrunk = [tuple(pywt.threshold(b, 4.0, "soft") for b in level) for level in details]
    expected = pywt.waverec2([coarse, *shrunk], name, mode="periodization")
    found = wavelets.on_grid(y.astype(np.float32), 4.0, basis, (begins, begins))
    far = wavelets.reach(basis) + 8  # the edges are mirrored here, wrapped there
    inner = slice(far, -far), slice(far, -far)
    np.testing.assert_allclose(found[inner], expected[inner], atol=1e-4)


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from([wavelets.HAAR, wavelets.DB2]),
    st.tuples(st.integers(0, 40), st.integers(0, 40)),
    st.tuples(st.integers(1, 30), st.integers(1, 30)),
)
def test_a_window_has_the_grid_of_the_frame(basis, corner, size):
    whole = wavelets.on_grid(NOISE, 4.0, basis)
    far = wavelets.reach(basis)
    inside = [slice(a, min(a + n, m)) for a, n, m in zip(corner, size, NOISE.shape, strict=True)]
    grown = [slice(max(s.start - far, 0), s.stop + far) for s in inside]
    part = wavelets.on_grid(NOISE[tuple(grown)], 4.0, basis, (grown[0].start, grown[1].start))
    cut = [slice(s.start - g.start, s.stop - g.start) for s, g in zip(inside, grown, strict=True)]
    np.testing.assert_allclose(part[tuple(cut)], whole[tuple(inside)], atol=1e-4)


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (2, 3), (37, 50)])
def test_wavelets_without_threshold_change_nothing(shape):
    y = NOISE[: shape[0], : shape[1]]
    np.testing.assert_allclose(wavelets.over_all_shifts(NOISE, 0.0), NOISE, atol=1e-4)
    for basis in (wavelets.HAAR, wavelets.DB2):
        np.testing.assert_allclose(wavelets.on_grid(y, 0.0, basis), y, atol=1e-4)
