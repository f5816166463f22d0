"""Recordings of capture programs: SER, the texts beside them, archives, and what is not read."""

import io
import json
import struct
import tarfile
import zipfile

import numpy as np
import pytest
from astropy.io import fits
from frame_files import noise, tif

from dnanalyze.errors import InputError
from dnanalyze.loaders import load

SHAPE = (32, 40)


def ser(path, codes, *, colour=0, bits=12, little=0, magic=b"LUCAM-RECORDER"):
    count, rows, columns = codes.shape
    head = magic + struct.pack("<7i", 0, colour, little, columns, rows, bits, count)
    path.write_bytes(head + bytes(178 - len(head)) + codes.tobytes() + bytes(8 * count))


def codes(count=3):
    return np.random.default_rng(0).normal(260, 3, (count, *SHAPE)).astype("<u2")


@pytest.mark.parametrize("order", ["<u2", ">u2"])
@pytest.mark.parametrize("little", [0, 1])  # programs write both of both
def test_ser_of_either_byte_order(tmp_path, order, little):
    ser(tmp_path / "a.ser", codes().astype(order), little=little, colour=8)
    captures = load(tmp_path)
    assert (captures.sensor.bits, captures.sensor.cfa) == (12, (("R", "G"), ("G", "B")))
    for frame, expected in zip(captures.frames(), codes(), strict=True):
        assert np.array_equal(frame.read(), expected)


@pytest.mark.parametrize(
    ("keys", "text"),
    [({"colour": 100}, "record RAW or MONO"), ({"magic": b"x" * 14}, "is no SER file"),
     ({"bits": 24}, "24 bits a pixel")],
)  # fmt: skip
def test_ser_that_is_refused(tmp_path, keys, text):
    ser(tmp_path / "a.ser", codes(), **keys)
    with pytest.raises(InputError, match=text):
        load(tmp_path)


@pytest.mark.parametrize(
    ("name", "text", "gain"),
    [
        ("a.txt", "FireCapture v2.7 Settings\n---\nCamera=ZWO ASI290MM\nShutter=20.00ms\n"
                  "Gain=120 (30%)\nSensor temperature= -10,5 \u00b0C\nFrames=3\n", 10**0.6),
        ("a.CameraSettings.txt", "[ZWO ASI178MM]\nBinning=1\nColour Space=MONO16\n"
                                 "Exposure=0.02\nGain=120\nTemperature=-10.5\n", 10**0.6),
        ("CameraSettings.txt", "[QHY5III]\nExposure=20.0000ms\nGain=12\nTemperature=-10.5\n", 12.0),
        ("a.ser.txt", "Exposure = 20000us\nGain = 4\nTemperature = -10.5 C\n", 4.0),
    ],
)  # fmt: skip
def test_texts_of_capture_programs(tmp_path, name, text, gain):
    ser(tmp_path / "a.ser", codes())
    (tmp_path / name).write_bytes(text.encode("cp1252"))
    captures = load(tmp_path)
    (point,) = (s.point for s in captures.settings)
    assert (point.temperature_c, point.exposure_s) == (-10.5, 0.02)
    assert point.gain == pytest.approx(gain)
    assert all(t.source.startswith("text beside it") for t in captures.source.taken)


def test_json_of_picamera_and_micro_manager(tmp_path):
    for k in range(2):
        tif(tmp_path / "a" / f"d{k}.tif", k)
        tif(tmp_path / "b" / f"img_{k}.tif", k)
        said = {"ExposureTime": 20000, "AnalogueGain": 4.0, "SensorTemperature": 31.0,
                "FrameDuration": 33333}  # fmt: skip
        (tmp_path / "a" / f"d{k}.json").write_text(json.dumps(said))
    (point,) = (s.point for s in load(tmp_path / "a").settings)
    assert (point.temperature_c, point.exposure_s, point.gain) == (31.0, 0.02, 4.0)
    table = {"Summary": {"Channels": 1}} | {
        f"FrameKey-{k}-0-0": {
            "FileName": f"Default/img_{k}.tif", "Exposure-ms": 10.0 * (k + 1),
            "Zyla-SensorTemperature": "0.5", "Channel": "Default",
        }
        for k in range(2)
    }  # fmt: skip
    (tmp_path / "b" / "metadata.txt").write_text(json.dumps(table))
    captures = load(tmp_path / "b")
    points = [(s.point.exposure_s, s.point.temperature_c) for s in captures.settings]
    assert points == [(0.01, 0.5), (0.02, 0.5)]
    for bad in ("{", "[1]", '{"a": ' * 2000):
        (tmp_path / "b" / "metadata.txt").write_text(bad)
        assert load(tmp_path / "b").settings[0].point.exposure_s is None


def packed(folder, kind, members):
    path = folder / f"darks{kind}"
    if kind == ".zip":
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in members.items():
                archive.writestr(name, data)
        return path
    with tarfile.open(path, "w:gz" if kind != ".tar" else "w") as archive:
        for name, data in members.items():
            info = tarfile.TarInfo(name)
            info.size = len(data)
            archive.addfile(info, io.BytesIO(data))
    return path


def members(tmp_path, below=""):
    made = {}
    for k in range(3):
        made[f"{below}T+025C/d{k}.tif"] = tif(tmp_path / "x.tif", k).read_bytes()
    (tmp_path / "x.tif").unlink()
    return made | {f"{below}dnanalyze.yaml": b"exposure_s: 2\n", "__MACOSX/._d.tif": b"x"}


@pytest.mark.parametrize("kind", [".zip", ".tar.gz", ".tgz", ".tar"])
@pytest.mark.parametrize("below", ["", "darks/"])
def test_archives_are_read_as_folders(tmp_path, kind, below):
    path = packed(tmp_path, kind, members(tmp_path, below))
    captures = load(path)
    (setting,) = captures.settings
    assert (setting.point.temperature_c, setting.point.exposure_s) == (25.0, 2.0)
    assert np.array_equal(setting.frames[2].read(), noise(2))
    assert captures.name == str(path)


@pytest.mark.parametrize("kind", [".zip", ".tar.gz"])
@pytest.mark.parametrize("name", ["../a.tif", "/etc/a.tif", "x/../../a.tif", "C:\\a.tif"])
def test_archives_that_lead_elsewhere_are_refused(tmp_path, kind, name):
    with pytest.raises(InputError, match="leads elsewhere"):
        load(packed(tmp_path, kind, {name: b"x"}))
    assert not (tmp_path.parent / "a.tif").exists()


def test_archives_with_links_or_bombs_are_refused(tmp_path):
    with tarfile.open(tmp_path / "a.tar.gz", "w:gz") as archive:
        info = tarfile.TarInfo("a.tif")
        info.type, info.linkname = tarfile.SYMTYPE, "/etc/passwd"
        archive.addfile(info)
    with pytest.raises(InputError, match="is a link"):
        load(tmp_path / "a.tar.gz")
    link = zipfile.ZipInfo("a.tif")
    link.external_attr = 0o120777 << 16
    with zipfile.ZipFile(tmp_path / "b.zip", "w") as archive:
        archive.writestr(link, "/etc/passwd")
    with pytest.raises(InputError, match="is a link"):
        load(tmp_path / "b.zip")
    for kind in (".zip", ".tar.gz"):
        with pytest.raises(InputError, match="unpacks to more"):
            load(packed(tmp_path, kind, {"a.tif": bytes(65 << 20)}))
    (tmp_path / "c.zip").write_bytes(b"PK\3\4 no archive")
    with pytest.raises(InputError, match="cannot be unpacked"):
        load(tmp_path / "c.zip")


@pytest.mark.parametrize(
    ("name", "text"),
    [("a.jpg", "1 .jpg file: processed pictures"), ("a.mp4", "ffmpeg"), ("a.nd2", "OME-TIFF"),
     ("a.zip.7z", "unpack them"), ("a.xisf", "save them as FITS")],
)  # fmt: skip
def test_what_is_not_read_says_what_to_do(tmp_path, name, text):
    (tmp_path / name).write_bytes(b"x" * 100)
    for path in (tmp_path, tmp_path / name):
        with pytest.raises(InputError, match=text):
            load(path)


def test_settings_of_the_black_level_are_kept_apart(tmp_path):
    for k, (offset, gain) in enumerate([(10, 1), (10, 1), (50, 1), (50, 1)]):
        hdu = fits.PrimaryHDU(noise(k))
        hdu.header["OFFSET"], hdu.header["GAIN"] = offset, gain
        hdu.writeto(tmp_path / f"{k}.fits")
    captures = load(tmp_path)
    assert captures.channels == ["offset 10", "offset 50"]
    assert "The black level was set to 10, 50" in " ".join(captures.notes)
    for k in (2, 3):  # an offset that goes with the gain is no setting of its own
        with fits.open(tmp_path / f"{k}.fits", mode="update") as hdus:
            hdus[0].header["GAIN"] = 2
    assert load(tmp_path).channels == []
