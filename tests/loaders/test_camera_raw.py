"""DNG as LibRaw reads it: active area, masked strip, levels, phase of the colour filter."""

import numpy as np
import pytest
import tifffile

from dnanalyze.errors import InputError
from dnanalyze.loaders import load, planes
from dnanalyze.loaders.captures import OperatingPoint, Window

ARRAY = np.random.default_rng(0).integers(0, 4096, (120, 160)).astype(np.uint16)


def dng(path, array=ARRAY, active=None, iso=400, extra=()):
    """A minimal DNG; its CFAPattern (RGGB) begins at the active area (DNG 1.6, CFAPattern)."""
    unity = (1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1)
    tags = [
        (50706, 1, 4, b"\x01\x04\x00\x00", True),
        (50708, 2, 0, "Test Camera", True),
        (33421, 3, 2, (2, 2), True),
        (33422, 1, 4, b"\x00\x01\x01\x02", True),
        (50714, 4, 1, 64, True),
        (50717, 4, 1, 4095, True),
        (50721, 10, 9, unity, True),
        (33434, 5, 1, (1, 20), True),
        (34855, 3, 1, iso, True),
    ]
    tags += extra
    if active:
        tags.append((50829, 4, 4, active, True))
    path.parent.mkdir(exist_ok=True)
    tifffile.imwrite(path, array, photometric="cfa", metadata=None, extratags=tags)
    return path


def test_facts_and_pixels(tmp_path):
    dng(tmp_path / "a.dng")
    dng(tmp_path / "b.dng", ARRAY[::-1])
    captures = load(tmp_path)
    assert captures.sensor.black_level == 64.0
    assert captures.sensor.white_level == 4095.0
    assert captures.sensor.bits == 12
    (setting,) = captures.settings
    assert setting.point == OperatingPoint(None, 0.05, 400.0)
    assert np.array_equal(setting.frames[0].read(), ARRAY)
    assert np.array_equal(setting.frames[1].read(), ARRAY[::-1])
    window = Window(3, 40, 7, 90)
    assert np.array_equal(setting.frames[0].read(window), ARRAY[window.slices])


@pytest.mark.parametrize("corner", [(8, 30), (9, 31), (9, 30), (8, 31)])
def test_phase_follows_the_visible_area(tmp_path, corner):
    # code the colour into the pixel: every plane must come out constant but for one pixel
    rows, columns = np.indices(ARRAY.shape)
    coded = (2 * ((rows - corner[0]) % 2) + (columns - corner[1]) % 2).astype(np.uint16)
    coded[60:64, 80:84] = 99
    dng(tmp_path / "a.dng", coded, (*corner, 120, 160))
    found = dict(planes(load(tmp_path)))
    for name, code in {"R": 0, "Gr": 1, "Gb": 2, "B": 3}.items():
        values = np.unique(next(found[name].frames()).read())
        assert values.tolist() == [code, 99]


def test_masked_strip(tmp_path):
    dng(tmp_path / "a.dng", active=(8, 30, 120, 160))
    strip = ARRAY[16:-16, 4:26]  # a rim of 16 rows and 4 columns is left out
    captures = load(tmp_path)
    assert captures.sensor.shape == (112, 130)
    assert np.array_equal(next(captures.frames()).read(), ARRAY[8:, 30:])
    assert np.array_equal(next(captures.frames()).masked(), strip)
    assert "region 'masked' loads it" in captures.notes[0]
    assert np.array_equal(next(load(tmp_path, region="masked").frames()).read(), strip)
    assert np.array_equal(next(load(tmp_path, include_masked=True).frames()).read(), ARRAY)


def test_lit_frames_give_their_masked_strip(tmp_path):
    rng = np.random.default_rng(1)
    dark = np.rint(rng.normal(64.0, 3.0, ARRAY.shape)).astype(np.uint16)
    warm = dark.copy()
    warm[8:, 30:] += 30  # 10 sd, but under a percent of the range: dark current, not light
    lit = dark.copy()
    lit[8:, 30:] += 60
    for array, region in ((dark, "active"), (warm, "active"), (lit, "masked")):
        dng(tmp_path / "a.dng", array, active=(8, 30, 120, 160))
        captures = load(tmp_path)
        assert captures.source.region == region
        assert any("lit" in n for n in captures.notes) == (region == "masked")
    assert load(tmp_path, region="active").sensor.shape == (112, 130)


def test_two_cameras_are_told_apart(tmp_path):
    dng(tmp_path / "a.dng", ARRAY[:100])
    dng(tmp_path / "b.dng")
    dng(tmp_path / "c.dng", ARRAY[::-1])
    captures = load(tmp_path)
    assert [f.name for f in captures.frames()] == ["b.dng", "c.dng"]
    assert "left out: a.dng" in captures.notes[0]


def test_truncated_files_are_seen_at_load(tmp_path):
    dng(tmp_path / "a.dng")
    whole = (tmp_path / "a.dng").read_bytes()
    (tmp_path / "b.dng").write_bytes(whole[:-5000])
    with pytest.raises(InputError, match=r"^b\.dng: truncated, \d+ bytes of the \d+"):
        load(tmp_path)
    (tmp_path / "b.dng").write_bytes(b"not a raw file" * 100)
    with pytest.raises(InputError, match=r"^b\.dng: LibRaw cannot open it"):
        load(tmp_path)


def test_the_black_level_of_masked_pixels_is_not_cut_to_whole_codes(tmp_path):
    codes = np.random.default_rng(1).normal(64.7, 2.0, (160, 200)).round().astype(np.uint16)
    masks = (50830, 4, 4, (0, 0, 160, 60), True)
    dng(tmp_path / "a.dng", codes, (0, 64, 160, 200), extra=[masks])
    captures = load(tmp_path)
    assert captures.settings[0].black_level == pytest.approx(64.7, abs=0.1)


def test_expanded_and_floating_codes_are_told(tmp_path):
    table = tuple(int(k) ** 2 // 16 for k in range(256))
    dng(tmp_path / "a" / "a.dng", (ARRAY // 16).astype(np.uint8),
        extra=[(50712, 3, 256, table, True)])  # fmt: skip
    captures = load(tmp_path / "a")
    assert "expand their codes by a table" in captures.notes[0]
    frame = captures.settings[0].frames[0].read()
    np.testing.assert_array_equal(frame, np.array(table)[ARRAY // 16])
    dng(tmp_path / "b" / "a.dng", (ARRAY / 4096).astype(np.float32))
    assert "floating-point pixels, which LibRaw scales" in load(tmp_path / "b").notes[0]
