"""What is written is read back, code for code, in every format."""

import numpy as np
import pytest

from dnanalyze.errors import InputError
from dnanalyze.loaders import load, planes, write_captures
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window
from dnanalyze.loaders.writers import FORMATS, RAW, as_codes, atomic

SHAPE = (21, 34)
POINTS = (OperatingPoint(-10.5, 0.05, 2.0, "hcg"), OperatingPoint(65.0, 0.05, 2.0, "hcg"))


def array_of(setting: int, frame: int) -> np.ndarray:
    rng = np.random.default_rng([setting, frame])
    array = rng.normal(100.0, 40.0, SHAPE).astype(np.float32)
    array[0, :2] = (-7.0, 1e6)  # both ends are clipped
    return array


def virtual(bits: int | None = 12, frames: int = 3, cfa: object = None) -> CaptureSet:
    def frame(k: int, n: int) -> Frame:
        def read(window: Window | None) -> np.ndarray:
            return array_of(k, n)[(window or Window.whole(SHAPE)).slices]

        return Frame(f"{k}/{n}", POINTS[k], read)

    settings = tuple(
        Setting(p, tuple(frame(k, n) for n in range(frames))) for k, p in enumerate(POINTS)
    )
    return CaptureSet("virtual", Sensor(SHAPE, bits, 64.0, 4095.0, cfa, 3.45), settings)


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_gives_back_codes_points_and_sensor(tmp_path, name):
    done = []
    write_captures(virtual(), tmp_path / "out", name, progress=lambda *n: done.append(n))
    back = load(tmp_path / "out")
    bits = RAW[name][0] if name in RAW else 12
    assert done == [(n, 6) for n in range(1, 7)]
    assert [s.point for s in back.settings] == list(POINTS)
    assert back.sensor == Sensor(SHAPE, bits, 64.0, 4095.0, None, 3.45)
    for k, setting in enumerate(back.settings):
        assert len(setting.frames) == 3
        for n, frame in enumerate(setting.frames):
            expected = np.clip(np.rint(array_of(k, n)), 0, 2**bits - 1)
            got = frame.read()
            assert got.dtype == (np.uint8 if bits == 8 else np.uint16)
            assert got.flags.c_contiguous
            assert got.dtype.isnative
            assert np.array_equal(got, expected)
            for window in (Window(3, 9, 5, 12), Window(20, 21, 33, 34), Window(0, 21, 1, 34)):
                assert np.array_equal(frame.read(window), expected[window.slices])


def test_layout_is_like_the_samples(tmp_path):
    write_captures(virtual(), tmp_path, "tif")
    files = sorted(p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*.tif"))
    assert files == [f"T{t}C/dark_{n:03d}.tif" for t in ("+065", "-010.5") for n in range(3)]
    table = (tmp_path / "manifest.csv").read_text().splitlines()
    assert table[0] == "file,temperature_c,exposure_s,gain,channel,frame"
    assert table[1] == "T-010.5C/dark_000.tif,-10.5,0.05,2.0,hcg,0"


@pytest.mark.parametrize("name", ["tif", "fits", "raw12-mipi"])
def test_names_alone_bring_back_the_points(tmp_path, name):
    write_captures(virtual(), tmp_path, name)
    (tmp_path / "manifest.csv").unlink()
    assert [s.point.temperature_c for s in load(tmp_path).settings] == [-10.5, 65.0]


def test_interrupt_leaves_no_half_written_file(tmp_path):
    good = virtual()

    def stop(window: Window | None) -> np.ndarray:
        raise KeyboardInterrupt

    first = good.settings[0]
    broken = Setting(first.point, (*first.frames[:2], Frame("x", first.point, stop)))
    with pytest.raises(KeyboardInterrupt):
        write_captures(CaptureSet("v", good.sensor, (broken,)), tmp_path, "tif")
    left = [p.name for p in tmp_path.rglob("*") if p.is_file()]
    assert sorted(left) == ["dark_000.tif", "dark_001.tif"]

    def half():
        with atomic(tmp_path / "half") as file:
            file.write(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half()
    assert not [p for p in tmp_path.iterdir() if "half" in p.name]


def test_a_second_capture_is_not_mixed_in(tmp_path):
    write_captures(virtual(), tmp_path, "npy")
    with pytest.raises(InputError, match="holds a capture already"):
        write_captures(virtual(), tmp_path, "npy")


def test_unknown_format_names_the_valid_ones(tmp_path):
    with pytest.raises(InputError, match=r"valid formats: tif, fits.*raw12-mipi"):
        write_captures(virtual(), tmp_path, "jpg")
    assert not list(tmp_path.iterdir())


def test_codes_are_rounded_to_even_and_clipped():
    assert as_codes(np.array([-1.0, 0.5, 1.5, 2.49, 300.0]), 8).tolist() == [0, 0, 2, 2, 255]


@pytest.mark.parametrize(
    ("cfa", "names"),
    [
        ((("R", "G"), ("G", "B")), ["R", "Gr", "Gb", "B"]),
        ((("G", "B"), ("R", "G")), ["Gb", "B", "R", "Gr"]),
        ((("R", "C"), ("C", "B")), ["R", "C1", "C2", "B"]),
    ],
)
def test_planes_are_the_pixels_of_one_colour(cfa, names):
    captures = virtual(cfa=cfa)
    assert captures.sensor.cfa == cfa
    whole = captures.settings[0].frames[1].read()
    found = planes(captures)
    assert [name for name, _ in found] == names
    for (_, plane), (row, column) in zip(found, [(0, 0), (0, 1), (1, 0), (1, 1)], strict=True):
        expected = whole[row::2, column::2]
        frame = plane.settings[0].frames[1]
        assert plane.sensor.shape == expected.shape
        assert plane.sensor.cfa is None
        assert np.array_equal(frame.read(), expected)
        window = Window(2, 7, 3, 16)
        assert np.array_equal(frame.read(window), expected[window.slices])


def test_monochrome_is_one_plane(tmp_path):
    captures = virtual()
    assert planes(captures) == [("", captures)]
