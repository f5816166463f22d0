"""The black level of each operating point, and black levels that cannot be."""

import numpy as np
import pytest
import tifffile

from dnanalyze import OperatingPoint, analyze
from dnanalyze.emva import evaluate
from dnanalyze.loaders import inspect, load
from dnanalyze.loaders.taps import find_steps

SHAPE = (64, 96)


def dng(path, level, black, iso=100, seed=0):
    pixels = np.random.default_rng(seed).normal(level, 4, SHAPE)
    tags = [
        (50706, 1, 4, b"\x01\x04\x00\x00", True),
        (50708, 2, 0, "Test", True),
        (50713, 3, 2, (1, 1), True),
        (50714, 4, 1, black, True),
        (50717, 4, 1, 4095, True),
        (33421, 3, 2, (2, 2), True),
        (33422, 1, 4, bytes([0, 1, 1, 2]), True),
        (50721, 10, 9, (1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1), True),
        (33434, 5, 1, (1, 10), True),
        (34855, 3, 1, iso, True),
    ]
    tifffile.imwrite(
        path, np.rint(pixels).astype(np.uint16), photometric="cfa", extratags=tags, metadata=None
    )


def darks(root, level, noise=3.0, count=4, exposure=1.0, start=0, step=0.0):
    for k in range(count):
        y = np.random.default_rng(start + k).normal(level, noise, SHAPE)
        y[:, 40:] += step
        np.save(root / f"dark_20C_{exposure:g}s_{start + k}.npy", np.rint(y).astype(np.uint16))
    return root


def stated(root, black):
    (root / "dnanalyze.yaml").write_text(f"black_level: {black}\n")


def test_each_gain_has_the_black_level_of_its_own_files(tmp_path):
    for k in range(6):
        iso, black = ((100, 256), (800, 512))[k % 2]
        dng(tmp_path / f"IMG_{k}.dng", black + 10, black, iso, seed=k)
    captures = load(tmp_path)
    assert [s.black_level for s in captures.settings] == [256, 512]
    assert captures.sensor.black_level is None
    assert [p["black_level"] for p in inspect(captures)["operating_points"]] == [256, 512]
    assert any(
        "The black level differs between operating points (256 DN" in n for n in captures.notes
    )
    groups = evaluate(analyze(captures)).groups
    for group in groups:
        (dark,) = group.dark_currents
        current = dark.quantities["dark_current_mean_dn_s"]
        assert current.value == pytest.approx(100, abs=4)


def test_a_black_level_of_one_file_that_differs_is_told(tmp_path):
    for k in range(4):
        dng(tmp_path / f"IMG_{k}.dng", 270, 256 if k else 200, seed=k)
    captures = load(tmp_path)
    assert captures.sensor.black_level is None
    assert any("state different black levels (200 DN, 256 DN)" in n for n in captures.notes)


@pytest.mark.parametrize(
    ("level", "black", "said"),
    [
        (256, 4096, "256 DN, and dark signal is not negative"),
        (190, 200, "190 DN, and dark signal is not negative"),
        (1024, 64, "1,024 DN, 16 times that: it is of another scale"),
        (256, 0, "they have a pedestal"),
    ],
)
def test_a_black_level_that_cannot_be_is_taken_as_unknown(tmp_path, level, black, said):
    for k in range(3):
        dng(tmp_path / f"IMG_{k}.dng", level, black, seed=k)
    captures = load(tmp_path)
    (note,) = [n for n in captures.notes if "black level" in n]
    assert said in note
    assert "taken as unknown" in note
    assert captures.sensor.black_level is None


@pytest.mark.parametrize("black", [255, 257, 240, 100])
def test_a_black_level_that_may_be_is_believed(tmp_path, black):
    for k in range(3):
        dng(tmp_path / f"IMG_{k}.dng", 256, black, seed=k)
    captures = load(tmp_path)
    assert captures.sensor.black_level == black
    assert not captures.notes


def test_a_wrong_black_level_of_the_sidecar_is_told_and_no_dark_current_is_stated(tmp_path):
    stated(darks(tmp_path, 100), 400)
    captures = load(tmp_path)
    assert captures.sensor.black_level == 400
    (note,) = captures.notes
    assert "black level of the sidecar, 400 DN, cannot be right" in note
    (group,) = evaluate(analyze(captures)).groups
    current = group.dark_currents[0].quantities["dark_current_mean_dn_s"]
    assert current.value is None
    assert "the black level is wrong, or it moves" in current.reason


def test_a_level_that_falls_with_exposure_is_no_dark_current(tmp_path):
    darks(tmp_path, 200, exposure=1.0)
    darks(tmp_path, 150, exposure=10.0, start=4)
    (group,) = evaluate(analyze(load(tmp_path))).groups
    assert "it moves" in group.dark_currents[0].quantities["dark_current_mean_dn_s"].reason


@pytest.mark.parametrize("step", [30.0, -30.0])
def test_two_taps_are_told(tmp_path, step):
    (note,) = load(darks(tmp_path, 200, step=step)).notes
    assert f"The level steps by {step:+g} DN at column 40 (20 °C, 1 s)" in note
    assert "active_columns: [0, 40]" in note


def blocks(levels, axis, shape=(16, 8, 256), noise=3.0):
    y = np.random.default_rng(0).normal(100, noise, shape)
    for k, part in enumerate(np.array_split(np.arange(shape[axis]), len(levels))):
        y[(slice(None),) * axis + (part,)] += levels[k]
    return find_steps(np.rint(y), list(range(0, 160, 10)), 0)


def test_four_taps_and_taps_of_rows_are_found():
    found = blocks((0, 40, 10, 60), 2)
    assert [s.first for s in found] == [64, 128, 192]
    np.testing.assert_allclose([s.height for s in found], [40, -30, 50], atol=1.5)
    (found,) = blocks((0, 25), 0)
    assert (found.axis, found.first, found.within) == ("row", 78, 3)


def test_glow_lines_and_colours_are_no_taps():
    y, x = np.mgrid[:128, :256]
    rng = np.random.default_rng(1)
    for shape in (
        100 * np.exp(-x / 20),
        0.5 * x,
        40 * (x % 2) + 20 * (y % 2),
        40.0 * (x == 100),
        30.0 * (x // 8 % 2),
        80 * np.exp(-((x - 90) ** 2 + (y - 60) ** 2) / 800),
        20 * rng.normal(size=256)[None] + 0 * x,
    ):
        frame = np.rint(100 + shape + rng.normal(0, 3, x.shape))
        assert find_steps(frame.reshape(16, 8, 256), list(range(0, 128, 8)), 0) == []


def test_the_black_level_of_points_is_what_they_share():
    from dnanalyze.loaders.captures import Sensor

    a, b = OperatingPoint(gain=1.0), OperatingPoint(gain=2.0)
    sensor = Sensor(SHAPE, black_levels=((a, 10.0), (b, 20.0)))
    assert sensor.black_level_at([a]) == 10.0
    assert sensor.black_level_at([a, b]) is None
    assert Sensor(SHAPE, black_level=5.0).black_level_at([a, b]) == 5.0
