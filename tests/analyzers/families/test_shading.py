"""Shading against surfaces whose cosine coefficients are known."""

from __future__ import annotations

import numpy as np
import pytest
from structure_frames import accumulated, log_pull, scatter_over_error, sensor, values, white

from dnanalyze.analyzers.estimators.line_means import block_means, line_means
from dnanalyze.analyzers.families import shading


def surface(shape: tuple[int, int], across: int, down: int) -> np.ndarray:
    """A cosine of the given orders with an rms of 1 over the field."""
    y = (np.arange(shape[0]) + 0.5)[:, None] / shape[0]
    x = (np.arange(shape[1]) + 0.5)[None, :] / shape[1]
    wave = np.cos(np.pi * down * y) * np.cos(np.pi * across * x)
    return wave * np.sqrt((2 if across else 1) * (2 if down else 1))


@pytest.mark.parametrize(("across", "down"), [(1, 0), (0, 1), (2, 3), (3, 3)])
def test_a_cosine_surface_is_its_own_coefficient(across, down):
    shape, amplitude = (256, 192), 0.3
    frames = [
        (f + amplitude * surface(shape, across, down)).astype(np.float32)
        for f in white(np.random.default_rng(1), shape, 3)
    ]
    found = values(shading, frames)
    # block means of 16 blocks keep sinc(order / 32) of a wave along each axis
    kept = np.sinc(across / 32) * np.sinc(down / 32)
    for name, value in found.items():
        if name.startswith("shading_") and name[-1].isdigit():
            expected = amplitude * kept if name == f"shading_{across}_{down}" else 0.0
            assert abs(value.value - expected) < 4.5 * value.se, name


def test_white_noise_gives_every_order_its_share():
    shape, sd, frames = (256, 256), 2.0, 4
    found = values(shading, white(np.random.default_rng(2), shape, frames, sd))
    share = sd**2 / frames / (shape[0] * shape[1])
    assert found["shading_1_1"].se == pytest.approx(np.sqrt(share), rel=0.3)
    assert abs(log_pull(found["shading_mid"], share)) < 4.5
    assert abs(log_pull(found["shading_high"], share)) < 4.5


@pytest.mark.parametrize(("across", "down"), [(1, 0), (0, 1), (1, 1)])
def test_charge_shades_the_noise_and_an_offset_does_not(across, down):
    shape, frames, share = (256, 192), 6, 0.3
    rng = np.random.default_rng(11)
    charge = 100.0 * (1.0 + share * surface(shape, across, down))
    shot = [rng.poisson(charge).astype(np.float32) for _ in range(frames)]
    offset = [(f + charge).astype(np.float32) for f in white(rng, shape, frames, 10.0)]
    kept = np.sinc(across / 32) * np.sinc(down / 32)
    for made, wanted in ((shot, share * kept), (offset, 0.0)):
        found = values(shading, made)
        for i, j in shading.RELATIVE_ORDERS:
            value = found[f"noise_shading_{i}_{j}"]
            expected = wanted if (i, j) == (across, down) else 0.0
            assert abs(value.value - expected) < 4.5 * value.se, (i, j)
        # variances of 6 Gaussian values scatter by sqrt(2 / 5)
        stated = found["noise_shading_1_1"].se
        assert stated == pytest.approx(np.sqrt(0.4 / (shape[0] * shape[1])), rel=0.3)


@pytest.mark.parametrize(("across", "down"), [(1, 0), (0, 1), (1, 1)])
def test_the_scatter_of_the_pixels_is_shaded_and_offsets_of_lines_are_none_of_it(across, down):
    shape, share = (256, 192), 0.3
    rng = np.random.default_rng(13)
    sigma = np.sqrt(1.0 + share * surface(shape, across, down))
    offsets = 4.0 * sigma * rng.standard_normal(shape)
    offsets += 3.0 * rng.standard_normal((shape[0], 1)) + rng.standard_normal((1, shape[1]))
    found = values(shading, [(f + offsets).astype(np.float32) for f in white(rng, shape, 2, 0.1)])
    kept = np.sinc(across / 32) * np.sinc(down / 32)
    own = 16.0 / 17.0  # columns add their variance in every row
    for i, j in shading.RELATIVE_ORDERS:
        value = found[f"scatter_shading_{i}_{j}"]
        expected = own * share * kept if (i, j) == (across, down) else 0.0
        assert abs(value.value - expected) < 4.5 * value.se, (i, j)
    # squared differences of neighbours share a pixel: their mean scatters by sqrt(3 / n)
    stated = found["scatter_shading_1_1"].se
    assert stated == pytest.approx(np.sqrt(3.0 / (shape[0] * shape[1])), rel=0.35)


def test_noise_of_few_pixels_does_not_shade_it():
    rng = np.random.default_rng(12)
    frames = white(rng, (128, 128), 4)
    for f in frames:
        f[:16, :16][rng.random((16, 16)) < 0.02] += 1e4
    assert abs(values(shading, frames)["noise_shading_1_0"].value) < 0.05


def test_hot_pixels_do_not_shade():
    rng = np.random.default_rng(3)
    frames = white(rng, (128, 128), 2)
    for f in frames:
        f[:16, :16][rng.random((16, 16)) < 0.02] += 1e4
    found = values(shading, frames)
    assert abs(found["shading_1_0"].value) < 0.05


def test_one_frame_is_shaded_too():
    frame = white(np.random.default_rng(4), (64, 64), 1)[0] + surface((64, 64), 1, 0)
    value = values(shading, [frame.astype(np.float32)])["shading_1_0"]
    assert abs(value.value - np.sinc(1 / 16)) < 4.5 * value.se


@pytest.mark.parametrize("shape", [(16, 16), (17, 90), (40, 31)])
def test_small_frames_name_the_orders_they_cannot_tell(shape):
    result = shading.finish(accumulated(sensor(np.random.default_rng(5), shape, 3)))
    names = {info.name for info in shading.INFOS}
    assert set(result.values) | set(result.missing) == names
    assert all(v.se > 0 for v in result.values.values())


def test_too_small_or_constant_frames():
    result = shading.finish(accumulated(sensor(np.random.default_rng(6), (12, 100), 3)))
    assert set(result.missing) == {"shading"}
    result = shading.finish(accumulated([np.full((64, 64), 5, np.uint16)] * 3))
    assert all(v.value == 0 and v.se > 0 for v in result.values.values())


def test_means_of_lines_and_blocks_are_plain_means():
    image = np.random.default_rng(7).normal(size=(37, 52)).astype(np.float32)
    lines = line_means(image)
    exact = image.astype(float)
    np.testing.assert_allclose(lines.columns, exact.mean(axis=0), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(lines.rows, exact.mean(axis=1), rtol=1e-12, atol=1e-14)
    assert lines.variance == pytest.approx(exact.var())
    blocks = block_means(image, (4, 5))
    edges = [0, 9, 18, 27, 37], [0, 10, 20, 31, 41, 52]
    assert blocks[3, 2] == pytest.approx(exact[27:37, 20:31].mean(), rel=1e-5)
    assert blocks[0, 4] == pytest.approx(exact[: edges[0][1], edges[1][4] :].mean(), rel=1e-5)


def test_errors_are_those_of_independent_captures():
    captures = [sensor(np.random.default_rng((8, k)), (160, 192), 3) for k in range(100)]
    ratios = scatter_over_error(shading, captures)
    assert len(ratios) == 27
    for name, ratio in ratios.items():  # 7 % sampling error each, honest to 25 %
        assert 0.6 < ratio < 1.45, (name, ratio)
