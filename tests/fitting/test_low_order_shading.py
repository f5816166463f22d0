"""Low-order shading from one colour of a checkerboard."""

import numpy as np
import pytest

from dnanalyze.analyzers.families import shading
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.analyzers.streaming.accumulation import accumulate
from dnanalyze.fitting.shading import shading_values
from dnanalyze.fitting.vectors import target
from dnanalyze.loaders.captures import OperatingPoint, Sensor


def halves(blocks, **more):
    middle = blocks.shape[0] // 2
    curves = {"block_means": blocks} | more
    return [
        SettingStatistics(
            OperatingPoint(), "", 4, (128, 256), {}, {k: v[part] for k, v in curves.items()}
        )
        for part in (slice(None, middle), slice(middle, None))
    ]


def cosine(across, down, shape=(16, 16)):
    x = np.cos(np.pi * across * (np.arange(shape[1]) + 0.5) / shape[1])
    y = np.cos(np.pi * down * (np.arange(shape[0]) + 0.5) / shape[0])
    return np.outer(y, x) * np.sqrt((2 if across else 1) * (2 if down else 1))


def test_a_surface_is_found_in_dn_rms_on_either_colour():
    blocks = 64.0 + 0.7 * cosine(1, 2) - 0.3 * cosine(3, 0)
    for parity in (0, 1):
        found = shading_values(*halves(blocks), parity)
        assert abs(found["shading_1_2"].value - 0.7) < 1e-9
        assert abs(found["shading_3_0"].value + 0.3) < 1e-9
        assert abs(found["shading_2_2"].value) < 1e-9


def test_errors_are_those_of_white_blocks():
    rng = np.random.default_rng(1)
    made = [shading_values(*halves(rng.normal(size=(16, 16))), 0) for _ in range(300)]
    for name in ("shading_1_0", "shading_2_3"):
        values = np.array([m[name].value for m in made])
        stated = np.mean([m[name].se for m in made])
        # 300 deviates tell a spread within 4 %; the stated error also allows for power above white
        assert 0.5 < values.std() / stated < 1.2


def test_floors_are_told_by_both_colours():
    """Few coefficients tell an error: of one colour alone it may be a third of the other's."""
    whole = halves(np.random.default_rng(3).normal(size=(16, 16)))
    alone = [shading_values(*whole, parity) for parity in (0, 1)]
    statistics = [Statistics("", Sensor((256, 256)), (half,)) for half in whole]
    seen = [target(statistics, parity) for parity in (0, 1)]
    assert seen[0].keys == seen[1].keys
    assert len(seen[0].keys) == 15
    for i, key in enumerate(seen[0].keys):
        both = np.mean([found[key.name].se ** 2 for found in alone])
        for found, values in zip(seen, alone, strict=True):
            assert found.reproducibility_sd[i] == pytest.approx((2.0 * both) ** 0.5)
            assert found.coordinates[i] == pytest.approx(values[key.name].value)


def test_random_rows_do_not_pass_for_shading():
    rng = np.random.default_rng(2)
    pulls = []
    for _ in range(200):
        blocks = rng.normal(size=(16, 16)) * 0.1 + rng.normal(size=(16, 1))
        found = shading_values(*halves(blocks), 0)
        pulls.append(found["shading_0_1"].value / found["shading_0_1"].se)
    assert np.std(pulls) < 1.2


def test_orders_are_named_as_the_statistics_of_a_whole_frame_are():
    blocks = 64.0 + cosine(2, 1)
    frame = np.repeat(np.repeat(blocks, 16, axis=0), 16, axis=1).astype(np.float32)
    whole = shading.finish(accumulate([frame, frame]).finish()).values
    for parity in (0, 1):
        found = shading_values(*halves(blocks), parity)
        for name in found:
            assert found[name].value == pytest.approx(whole[name].value, abs=1e-4), name


@pytest.mark.parametrize("what", ["noise", "scatter"])
def test_shading_of_a_variance_is_relative_to_its_mean_over_the_field(what):
    blocks = 50.0 * (1.0 + 0.2 * cosine(0, 1) - 0.1 * cosine(1, 1))
    for parity in (0, 1):
        found = shading_values(*halves(np.zeros((16, 16)), **{f"{what}_blocks": blocks}), parity)
        assert found[f"{what}_shading_0_1"].value == pytest.approx(0.2, abs=1e-9)
        assert found[f"{what}_shading_1_1"].value == pytest.approx(-0.1, abs=1e-9)
        assert found[f"{what}_shading_2_0"].value == pytest.approx(0.0, abs=1e-9)


def test_halves_of_different_level_are_shaded_and_not_wrong_in_level():
    rng = np.random.default_rng(4)
    blocks = 64.0 + 0.01 * rng.normal(size=(16, 16))
    blocks[8:] += 3.0
    tail = 0.5  # of the mean over the median: no matter of shading
    parts = halves(blocks)
    for part in parts:
        level = float(part.curves["block_means"].mean())
        part.values.update(mean=Value(level + tail, 0.02), median=Value(level, 0.03))
    for parity in (0, 1):
        found = shading_values(*parts, parity)
        # 128 blocks of each colour: .01 / sqrt(128), and as much of the level that is taken off
        assert abs(found["median"].value - 65.5) < 5 * 0.01 * np.sqrt(2 / 128)
        # but for the share of the shift that may be scatter: two errors' square over that of 1.5 DN
        assert abs(found["mean"].value - found["median"].value - tail) < 4e-4 / 128 / 1.5 * 1.1
        assert found["mean"].se == 0.02
        assert found["median"].se == pytest.approx(np.hypot(0.03, 0.01 / np.sqrt(128)), rel=1e-4)


def test_the_median_is_moved_by_no_scatter_of_few_bright_pixels():
    """They scatter the means of blocks; where these move it, it has the error of that."""
    rng = np.random.default_rng(6)
    stayed, pulls = 0, []
    for _ in range(100):
        bright = 0.6 * rng.poisson(4.0, (16, 16))
        for step in (0.0, 3.0):
            parts = halves(64.0 + bright + step * (np.arange(16) > 7)[:, None])
            for part, level in zip(parts, (64.0, 64.0 + step), strict=True):
                part.values.update(median=Value(level, 0.001))
            seen = [shading_values(*parts, parity)["median"] for parity in (0, 1)]
            if step:
                pulls += [(v.value - 65.5) / v.se for v in seen]
            else:
                stayed += sum((v.value, v.se) == (64.0, 0.001) for v in seen)
    assert stayed > 180  # beyond two standard errors lie 9 of 200
    assert np.std(pulls) == pytest.approx(1.0, abs=0.2)
