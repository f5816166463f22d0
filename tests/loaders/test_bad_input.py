"""Every bad input: one line that names the file and the remedy."""

import builtins
import os
import re
import struct
import sys
import zlib
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import tifffile
from astropy.io import fits
from frame_files import noise, tif

from dnanalyze.errors import InputError
from dnanalyze.loaders import checks, load


def refused(path, pattern, read=False, **options):
    """Loading (and reading) fails with one line that matches."""

    def attempt():
        captures = load(path, **options)
        return [frame.read() for frame in captures.frames()] if read else captures

    with pytest.raises(InputError, match=pattern) as caught:
        attempt()
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 600
    assert len(re.split("[;:,] ", message)) > 1, "names the file, then says what to do"
    return message


# --- folders ---------------------------------------------------------------------------------


def test_no_frames(tmp_path):
    (tmp_path / "notes.txt").write_text("nothing here")
    refused(tmp_path, "no frames; give a folder with files of")


def test_nothing_there(tmp_path):
    refused(tmp_path / "absent", r"absent: no such file or folder")


def test_a_file_of_no_known_format(tmp_path):
    (tmp_path / "notes.txt").write_text("nothing here")
    refused(tmp_path / "notes.txt", r"^notes\.txt: unknown format; valid: \.3fr")


def test_a_file_named_in_a_roundabout_way(tmp_path, monkeypatch):
    tif(tmp_path / "a.tif")
    tif(tmp_path / "b.tif")
    (tmp_path / "manifest.csv").write_text("file\na.tif\n")
    monkeypatch.chdir(tmp_path)
    assert load("./b.tif").frame_count == 1
    assert load("b.tif").frame_count == 1


def test_empty_file(tmp_path):
    (tmp_path / "a.tif").touch()
    refused(tmp_path, r"^a\.tif: is empty")


def test_mixed_shapes_and_types(tmp_path):
    tif(tmp_path / "a.tif")
    tifffile.imwrite(tmp_path / "b.tif", noise(0, (16, 24)))
    refused(tmp_path, r"^b\.tif: has 16 x 24 pixels of uint16, a\.tif has 16 x 20")
    tifffile.imwrite(tmp_path / "b.tif", noise(dtype="uint8"))
    refused(tmp_path, r"^b\.tif: .*uint8")


def test_mixed_shapes_in_one_file(tmp_path):
    with tifffile.TiffWriter(tmp_path / "a.tif") as writer:
        writer.write(noise(), metadata=None)
        writer.write(noise(0, (16, 24)), metadata=None)
    refused(tmp_path, r"^a\.tif: page 1 is \(16, 24\)")
    np.savez(tmp_path / "b.npz", a=noise(), b=noise(0, (16, 24)))
    refused(tmp_path / "b.npz", r"^b\.npz: b\.npy: is \(16, 24\)")


def test_link_that_leaves_the_folder(tmp_path):
    secret = tif(tmp_path / "outside" / "a.tif")
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.tif").symlink_to(secret)
    refused(tmp_path / "in", "leads outside the capture folder")
    (tmp_path / "in" / "a.tif").unlink()
    (tmp_path / "in" / "more").symlink_to(secret.parent)
    refused(tmp_path / "in", "leads outside the capture folder")


def test_link_within_the_folder_is_a_frame_that_counts_once(tmp_path):
    (tmp_path / "b.tif").symlink_to(tif(tmp_path / "a.tif"))
    captures = load(tmp_path)
    assert captures.frame_count == 1
    assert "b.tif has the same pixels as a.tif" in captures.notes[0]


def test_unreadable(tmp_path, monkeypatch):
    path = tif(tmp_path / "a.tif")
    real = Path.open

    def guarded(self, *args, **options):  # root may read anything, so the refusal is faked
        if self == path:
            raise PermissionError(13, "Permission denied", str(path))
        return real(self, *args, **options)

    monkeypatch.setattr(Path, "open", guarded)
    refused(tmp_path, r"^a\.tif: cannot be read \(Permission denied\); check its permissions")


@pytest.mark.skipif(getattr(os, "geteuid", lambda: 0)() == 0, reason="root may read anything")
def test_unreadable_folder(tmp_path):
    (tmp_path / "closed").mkdir(mode=0)
    refused(tmp_path, "cannot be read .*check its permissions")


# --- manifests and sidecars ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("file\nabsent.tif\n", r"row 2: absent\.tif is not in the folder"),
        ("file\nx/*.tif\n", r"row 2: x/\*\.tif is not in the folder"),
        ("file\n../a.tif\n", r"row 2: \.\./a\.tif leads outside"),
        ("file\n/etc/passwd\n", r"row 2: /etc/passwd leads outside"),
        ("file\nsub\n", r"row 2: sub is a folder; write sub/\*"),
        ("file,temp\na.tif,3\n", "unknown column 'temp'; valid columns: file, temperature_c"),
        ("gain\n3\n", "no column 'file'"),
        ("file,gain\na.tif,high\n", r"row 2: gain 'high' is no number"),
        ("file,temperature_c\na.tif,nan\n", "temperature_c 'nan' is no number"),
        ("file,exposure_s\na.tif,-1\n", "exposure_s -1 is out of range; valid: 0 to"),
        (
            "file,temperature_c\na.tif,-300\n",
            "temperature_c -300 is out of range; valid: above -273.15",
        ),
        ("file,gain\n,3\n", "no file named"),
        ("file,gain\na.tif,3,4\n", "more values than columns"),
        ("file\n", "has no rows"),
        ("", "is empty"),
        ('file\n"a.tif\n', "is no CSV table"),
    ],
)
def test_manifest(tmp_path, text, pattern):
    tif(tmp_path / "a.tif")
    (tmp_path / "sub").mkdir()
    (tmp_path / "manifest.csv").write_text(text)
    assert "manifest.csv" in refused(tmp_path, pattern)


def test_manifest_size_and_encoding(tmp_path):
    tif(tmp_path / "a.tif")
    (tmp_path / "manifest.csv").write_bytes(b"file\n" + b"a.tif\n" * (2 << 20))
    refused(tmp_path, r"manifest\.csv: larger than 8 MB")
    (tmp_path / "manifest.csv").write_bytes(b"file\n\xff\xfe.tif\n")
    refused(tmp_path, r"manifest\.csv: is not UTF-8")


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("witdh: 20\n", "unknown key 'witdh'; valid keys: width, height"),
        ("width: wide\n", r"width: .*integer.*given: wide"),
        ("width: 0\n", "width: .*greater than 0"),
        ("packing: zip\n", "packing: .*'plain', 'mipi', 'lsb', 'msb' or 'genicam'"),
        ("cfa: RGB\n", "cfa: must be 4, 16 or 36 letters"),
        ("name_regex: '('\n", "name_regex: is no regular expression"),
        ("name_regex: (?P<heat>x)\n", "name_regex: needs named groups out of: temperature_c"),
        ("active_rows: [9, 3]\n", "active_rows must be"),
        ("active_rows: [0, 99]\n", "the file has 16 x 20 pixels"),
        ("- 3\n", "must be 'key: value' lines"),
        ("a: [1\n", r"is not YAML \(line 2\)"),
        ("width: !!python/object/apply:os.system ['true']\n", "is not YAML"),
        ("a: &x [1]\nb: *x\n", "aliases"),
    ],
)
def test_sidecar(tmp_path, text, pattern):
    tif(tmp_path / "a.tif")
    (tmp_path / "dnanalyze.yaml").write_text(text)
    refused(tmp_path, pattern)


def test_config_that_is_a_folder_or_absent(tmp_path):
    tif(tmp_path / "a.tif")
    refused(tmp_path, "is a folder; give a file", config=tmp_path)
    refused(tmp_path, r"no\.yaml: no such file", config=tmp_path / "no.yaml")


def test_unknown_masked_area_and_region(tmp_path):
    tif(tmp_path / "a.tif")
    refused(tmp_path, "no masked area is known; give optical_black", region="masked")
    refused(tmp_path, "region 'dark': valid", region="dark")
    refused(tmp_path, "tolerance_c -1", tolerance_c=-1.0)


def test_headerless_needs_its_sidecar(tmp_path):
    (tmp_path / "a.raw").write_bytes(noise().tobytes())
    refused(tmp_path, r"^a\.raw: headerless; describe it in dnanalyze\.yaml")
    sidecar = tmp_path / "dnanalyze.yaml"
    sidecar.write_text("width: 19\nheight: 16\nbits: 12\n")
    refused(tmp_path, r"640 bytes of pixels are not a multiple of the 608")
    sidecar.write_text("width: 20\nheight: 32\nbits: 12\n")
    refused(tmp_path, r"^a\.raw: truncated, 640 bytes of the 1280")
    sidecar.write_text("width: 20\nheight: 16\nbits: 11\n")
    refused(tmp_path, "bits 11 in the sidecar; valid: 8, 10")
    sidecar.write_text("width: 20\nheight: 16\nbits: 12\nrow_bytes: 39\n")
    refused(tmp_path, "row_bytes 39 in the sidecar is too few")


# --- truncated and damaged files -------------------------------------------------------------


def stored(path):
    """A file of each format with pixels in it."""
    kind = path.suffix
    if kind == ".tif":
        tif(path)
    elif kind == ".fits":
        fits.PrimaryHDU(noise(0, (64, 64))).writeto(path)
    elif kind == ".npy":
        np.save(path, noise())
    elif kind == ".npz":
        np.savez(path, noise())
    elif kind == ".h5":
        with h5py.File(path, "w") as file:
            file["frames"] = noise()
    elif kind == ".pgm":
        path.write_bytes(b"P5 20 16 65535\n" + noise().astype(">u2").tobytes())
    elif kind == ".png":
        from PIL import Image

        Image.fromarray(noise()).save(path)
    return path


SUFFIXES = [".tif", ".fits", ".npy", ".npz", ".h5", ".pgm", ".png"]


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("keep", [0.9, 0.5, 0.01])
def test_truncated(tmp_path, suffix, keep):
    path = stored(tmp_path / f"a{suffix}")
    load(tmp_path)
    data = path.read_bytes()
    path.write_bytes(data[: max(1, int(keep * len(data)))])
    refused(tmp_path, rf"^a\{suffix}: ")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_something_else_under_that_name(tmp_path, suffix):
    (tmp_path / f"a{suffix}").write_bytes(bytes(range(256)) * 64)
    refused(tmp_path, rf"^a\{suffix}: ")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_folder_with_the_name_of_a_file(tmp_path, suffix):
    (tmp_path / f"a{suffix}").mkdir()
    refused(tmp_path, "no frames")


def test_damaged_compressed_pixels_are_seen_when_read(tmp_path):
    path = tif(tmp_path / "a.tif", compression="zlib")
    data = bytearray(path.read_bytes())
    with tifffile.TiffFile(path) as file:
        start = file.pages[0].dataoffsets[0]
    data[start + 4 : start + 60] = bytes(56)
    path.write_bytes(data)
    refused(tmp_path, r"^a\.tif: cannot be decoded", read=True)


def test_file_that_shrinks_after_load(tmp_path):
    path = stored(tmp_path / "a.npy")
    captures = load(tmp_path)
    os.truncate(path, 300)
    with pytest.raises(InputError, match=r"a\.npy: truncated"):
        next(captures.frames()).read()
    path.unlink()
    with pytest.raises(InputError, match=r"a\.npy: cannot be decoded"):
        next(captures.frames()).read()


def test_objects_are_never_unpickled(tmp_path):
    np.save(tmp_path / "a.npy", np.array([[print]], object), allow_pickle=True)
    refused(tmp_path, r"^a\.npy: holds Python objects")


def test_colour_images(tmp_path):
    tifffile.imwrite(
        tmp_path / "a.tif", np.eye(16 * 20, 3, dtype="u1").reshape(16, 20, 3), photometric="rgb"
    )
    refused(tmp_path, r"^a\.tif: .*colour")
    np.save(tmp_path / "b.npy", np.zeros((16, 20, 3)))
    refused(tmp_path / "b.npy", r"^b\.npy: .*colour")


@pytest.mark.parametrize("dtype", ["bool", "complex64", "U3"])
def test_pixels_that_are_no_counts(tmp_path, dtype):
    np.save(tmp_path / "a.npy", np.zeros((16, 16), dtype))
    refused(tmp_path, r"^a\.npy: pixels of type")


# --- bombs -----------------------------------------------------------------------------------


def test_declared_size_is_checked_before_anything_is_decoded(tmp_path):
    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    side = 60000  # 3.6 Gpx from a few hundred bytes
    head = struct.pack(">IIBBBBB", side, side, 16, 0, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + body)
    refused(tmp_path, r"^a\.png: declares 60000 x 60000 pixels")

    (tmp_path / "b.pgm").write_bytes(b"P5 60000 60000 65535\n" + bytes(100))
    refused(tmp_path / "b.pgm", r"^b\.pgm: declares")

    with h5py.File(tmp_path / "c.h5", "w") as file:
        file.create_dataset("frames", (side, side), "u2", chunks=(100, 100))
    refused(tmp_path / "c.h5", r"^c\.h5: frames: declares")

    header = fits.Header({"SIMPLE": True, "BITPIX": 16, "NAXIS": 2, "NAXIS1": side, "NAXIS2": side})
    (tmp_path / "d.fits").write_bytes(header.tostring().encode() + bytes(2880))
    refused(tmp_path / "d.fits", r"^d\.fits: declares")


def test_frame_beyond_the_free_memory(tmp_path, monkeypatch):
    tif(tmp_path / "a.tif", compression="zlib")
    monkeypatch.setattr(checks, "available_memory", lambda: 100)
    refused(tmp_path, r"^a\.tif: needs .* GB to decode")


def test_header_without_end(tmp_path):
    card = b"SIMPLE  =                    T".ljust(80)
    (tmp_path / "a.fits").write_bytes(card + b"COMMENT junk".ljust(80) * 36 * 2001)
    refused(tmp_path, r"^a\.fits: its header has no END")


def test_gigantic_npy_header(tmp_path):
    text = b"{'descr': '<u2', 'fortran_order': False, 'shape': (16, 20), }".ljust(1 << 20) + b"\n"
    magic = b"\x93NUMPY\x02\x00" + struct.pack("<I", len(text))
    (tmp_path / "a.npy").write_bytes(magic + text + noise().tobytes())
    refused(tmp_path, r"^a\.npy: ")


# --- pixels ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("array", "pattern"),
    [
        (np.zeros((16, 20), np.uint16), r"^a\.npy: all pixels are zero; .*pedestal"),
        (np.full((16, 20), 64, np.uint16), r"^a\.npy: all pixels equal 64; .*leave the file out"),
        (np.full((16, 20), np.nan, np.float32), r"^a\.npy: 320 pixels are NaN"),
        (np.where(np.eye(16) > 0, np.inf, noise(0, (16, 16))), r"^a\.npy: 16 pixels are NaN"),
    ],
)
def test_pixels_are_refused_when_read(tmp_path, array, pattern):
    np.save(tmp_path / "a.npy", array)
    refused(tmp_path, pattern, read=True)


def test_windows_are_checked_too(tmp_path):
    from dnanalyze.loaders.captures import Window

    array = noise(0, (32, 32))
    array[:16, :16] = 7  # constant here, not everywhere: fine
    np.save(tmp_path / "a.npy", array)
    frame = next(load(tmp_path).frames())
    assert np.ptp(frame.read(Window(0, 16, 0, 16))) == 0
    np.save(tmp_path / "a.npy", np.full((32, 32), 7, np.uint16))
    with pytest.raises(InputError, match="all pixels equal 7"):
        frame.read(Window(0, 16, 0, 16))


@pytest.mark.parametrize("shape", [(1, 1), (1, 500), (7, 500)])
def test_too_small(tmp_path, shape):
    np.save(tmp_path / "a.npy", np.ones(shape))
    refused(tmp_path, rf"^a\.npy: {shape[0]} x {shape[1]} pixels are too few")


# --- remote ----------------------------------------------------------------------------------


def test_remote_without_fsspec(monkeypatch):
    monkeypatch.setitem(sys.modules, "fsspec", None)
    refused("s3://bucket/darks", r"s3://bucket/darks: remote captures need fsspec; pip install")


class FakeSystem:
    """As much of an fsspec file system as is used."""

    def __init__(self, files):
        self.files = files

    def find(self, root, detail=False):
        return {n: {"size": len(d)} for n, d in self.files.items() if n.startswith(root)}

    def get_file(self, name, local):
        with builtins.open(local, "wb") as file:
            file.write(self.files[name])


def test_remote_folder_and_file(tmp_path, monkeypatch):
    data = tif(tmp_path / "a.tif").read_bytes()
    system = FakeSystem({"bucket/T25C/a.tif": data, "bucket/T65C/a.tif": data})
    core = SimpleNamespace(url_to_fs=lambda url: (system, url.partition("://")[2]))
    monkeypatch.setitem(sys.modules, "fsspec", SimpleNamespace(core=core))
    captures = load("memory://bucket")
    assert captures.name == "memory://bucket"
    assert [s.point.temperature_c for s in captures.settings] == [25.0, 65.0]
    assert np.array_equal(next(captures.frames()).read(), noise())
    assert load("memory://bucket/T65C/a.tif").settings[0].point.temperature_c == 65.0
    refused("memory://elsewhere", "no such file or folder; check the address")
    system.files["bucket/../../evil.tif"] = data
    refused("memory://bucket", "leads outside")
