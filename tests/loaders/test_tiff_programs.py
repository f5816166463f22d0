"""TIFF as acquisition programs write it: packed samples, Micro-Manager, OME-XML, ImageJ."""

import json
import struct

import numpy as np
import pytest
import tifffile

from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.formats.tiff_metadata import ome


def codes(frames=1, shape=(24, 33), top=4096):
    return np.random.default_rng(0).integers(0, top, (frames, *shape)).astype(np.uint16)


def write_packed(path, frame, bits, fill=1, compression=1):
    """A TIFF of packed samples, each row from a byte on, by the bits of its numbers."""
    rows = ["".join(f"{v:0{bits}b}" for v in row) for row in frame]
    size = -(-len(rows[0]) // 8)
    data = b"".join(int(r.ljust(8 * size, "0"), 2).to_bytes(size, "big") for r in rows)
    tags = [(256, 4, frame.shape[1]), (257, 4, frame.shape[0]), (258, 3, bits),
            (259, 3, compression), (262, 3, 1), (266, 3, fill), (273, 4, 8), (277, 3, 1),
            (278, 4, frame.shape[0]), (279, 4, len(data))]  # fmt: skip
    head = b"II*\0" + struct.pack("<I", 8 + len(data)) + data + struct.pack("<H", len(tags))
    entries = b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in tags)
    path.write_bytes(head + entries + bytes(4))


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_packed_samples(tmp_path, bits):
    (frame,) = codes(top=1 << bits)
    write_packed(tmp_path / "a.tif", frame, bits)
    captures = load(tmp_path)
    read = captures.settings[0].frames[0].read
    assert captures.sensor.bits == bits
    assert np.array_equal(read(), frame)
    assert np.array_equal(read(Window(3, 20, 5, 32)), frame[3:20, 5:32])


def test_packed_samples_that_are_not_read_say_what_to_do(tmp_path):
    write_packed(tmp_path / "a.tif", codes()[0], 12, fill=2)
    with pytest.raises(InputError, match="store them as 16-bit TIFF"):
        load(tmp_path)


def test_micro_manager_pages(tmp_path):
    with tifffile.TiffWriter(tmp_path / "a.tif") as file:
        for k, frame in enumerate(codes(4)):
            said = {
                "Exposure-ms": 10.0 if k < 2 else 500.0,
                "Zyla-SensorTemperature": "0,50",
                "Channel": "Default",
            }
            tag = (51123, 2, 0, json.dumps(said).encode(), True)
            file.write(frame, contiguous=False, metadata=None, extratags=[tag])
    captures = load(tmp_path)
    points = [(s.point.exposure_s, s.point.temperature_c) for s in captures.settings]
    assert points == [(0.01, 0.5), (0.5, 0.5)]
    assert captures.channels == []
    assert captures.source.taken[0].source == "Micro-Manager Zyla-SensorTemperature"


def test_ome_planes_with_units_and_channels(tmp_path):
    plane = {"ExposureTime": [250.0, 1000.0] * 3, "ExposureTimeUnit": ["ms"] * 6}
    tifffile.imwrite(
        tmp_path / "a.ome.tif", codes(6).reshape(3, 2, 24, 33), ome=True,
        metadata={"axes": "TCYX", "Plane": plane, "Channel": {"Name": ["long", "short"]}},
    )  # fmt: skip
    captures = load(tmp_path)
    points = [(s.point.channel, s.point.exposure_s, len(s.frames)) for s in captures.settings]
    assert points == [("long", 0.25, 3), ("short", 1.0, 3)]


def test_hostile_ome_is_no_metadata():
    assert ome('<!DOCTYPE x [<!ENTITY a "b">]><OME>&a;</OME>', 1) == []
    assert ome("<OME><Pixels></OME>", 1) == []
    odd = '<OME><Pixels SizeC="9"><Plane ExposureTime="1"/><Plane ExposureTime="2"/></Pixels></OME>'
    (said,) = ome(odd, 1)
    assert said.exposure_s is None
    assert "several exposures" in said.doubts[0].text


def test_imagej_channels_are_not_one_point(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", codes(6).reshape(3, 1, 2, 24, 33), imagej=True,
                     metadata={"axes": "TZCYX"})  # fmt: skip
    assert load(tmp_path).channels == ["channel 1", "channel 2"]
