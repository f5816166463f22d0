"""The sample captures: what their headers and names say, and a few pixels."""

import numpy as np
import pytest

from dnanalyze.loaders import inspect, load, planes
from dnanalyze.loaders.config import Config


def test_fp30_cooling(captures_root):
    captures = load(captures_root / "real" / "fp30_cooling")
    assert captures.sensor.shape == (1024, 1024)  # DATASEC; 26 overscan columns beside it
    assert captures.frame_count == 42
    darks = captures.select(lambda p: p.exposure_s == 20.0)
    temperatures = [f.point.temperature_c for f in darks.frames()]
    assert len(temperatures) == 28
    assert min(temperatures) < -90 < -17 < max(temperatures)
    assert all(len(s.frames) == 2 for s in darks.settings)
    assert next(captures.frames()).masked().shape == (1024, 26)
    assert any("overlaps DATASEC" in n for n in captures.notes)


def test_stl1001(captures_root):
    captures = load(captures_root / "real" / "stl1001_2017")
    exposures = {s.point.exposure_s for s in captures.settings}
    assert exposures == {0.0, 10.0, 20.0, 30.0, 60.0, 150.0, 300.0}
    bias = captures.select(lambda p: p.exposure_s == 0)
    assert [len(s.frames) for s in bias.settings] == [5, 5]
    assert captures.sensor.pixel_pitch_um == 24.0

    def median(low, exposure):
        found = captures.select(
            lambda p: abs(p.temperature_c - low) < 1.5 and p.exposure_s == exposure
        )
        return np.mean([np.median(f.read()) for f in found.frames()])

    # published slopes: .179 DN/s at -10 C, .356 at -5 C; medians of integers, 1 DN steps
    assert (median(-10, 300.0) - median(-10, 0.0)) / 300 == pytest.approx(0.179, abs=0.01)
    assert (median(-5, 300.0) - median(-5, 0.0)) / 300 == pytest.approx(0.356, abs=0.015)


def test_qsi583(captures_root):
    captures = load(captures_root / "real" / "qsi583_2x2")
    assert [len(s.frames) for s in captures.settings] == [2, 4]
    assert [s.point.temperature_c for s in captures.settings] == pytest.approx([-8.6, -7.0])


def test_st7_is_one_operating_temperature(captures_root):
    captures = load(captures_root / "real" / "st7_2019")  # set to -17 C, read as -17.37 or -16.94
    assert len({s.point.temperature_c for s in captures.settings}) == 1
    assert [s.point.exposure_s for s in captures.settings] == [120.0, 300.0, 900.0]


def test_scmos(captures_root):
    captures = load(captures_root / "real" / "scmos_single")
    array = next(captures.frames()).read()
    assert array.mean() == pytest.approx(100.17, abs=0.01)
    assert array.std() == pytest.approx(2.20, abs=0.01)
    assert captures.settings[0].point.exposure_s == pytest.approx(1e-6)
    assert "single frame" in inspect(captures)["missing"][0]


def test_exposures(captures_root):
    captures = load(captures_root / "real" / "exposures_cc0")
    assert [s.point.exposure_s for s in captures.settings] == [5.0, 10.0, 20.0, 60.0, 120.0]


def test_camera_raw(captures_root):
    folder = captures_root / "real" / "camera_raw"
    captures = load(folder)  # lit photographs: only the masked strip is dark
    assert captures.frame_count == 1
    assert "RAW_CANON_D30_SRGB.CRW" in captures.notes[0]
    assert any("lit" in note for note in captures.notes)
    assert captures.source.region == "masked"
    assert captures.sensor.cfa == (("R", "G"), ("G", "B"))
    assert captures.sensor.bits == 12
    assert captures.settings[0].point.exposure_s == pytest.approx(1 / 400)
    assert captures.settings[0].point.gain == 640.0
    assert [name for name, _ in planes(captures)] == ["R", "Gr", "Gb", "B"]
    strip = next(captures.frames()).read()
    assert strip.shape == (2328, 66)
    assert strip.mean() == pytest.approx(128.03, abs=0.005)
    assert strip.std() == pytest.approx(2.25, abs=0.005)
    assert load(folder, region="active").sensor.shape == (2348, 3522)
    other = load(folder / "RAW_CANON_D30_SRGB.CRW")
    assert other.source.region == "masked"
    assert other.sensor.black_level == pytest.approx(126.23, abs=0.005)  # LibRaw cuts it to 126


def test_headerless(captures_root):
    described = Config(width=1280, height=960, bits=12, byte_order="little", exposure_s=0.1)
    captures = load(captures_root / "real" / "headerless", config=described)
    array = next(captures.frames()).read()
    assert array.shape == (960, 1280)
    assert array.max() == 4095
    assert captures.sensor.bits == 12


@pytest.mark.long
def test_hidden_folders(captures_root):
    folders = [p for p in sorted((captures_root / "hidden").iterdir()) if p.is_dir()]
    assert folders
    for folder in folders:
        captures = load(folder)
        assert [len(s.frames) for s in captures.settings] == [6] * 5
        assert [s.point.temperature_c for s in captures.settings] == [25, 45, 65, 85, 105]
        assert captures.sensor.shape == (384, 384)
        assert not captures.notes
        found = inspect(captures)
        assert found["codes"]["effective_bits"] <= 12
