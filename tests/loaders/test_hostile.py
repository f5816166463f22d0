"""Hostile files and arguments: one line, at once, before anything large is built."""

import gzip
import os
import signal
import struct
import zipfile
import zlib

import h5py
import numpy as np
import pytest
import tifffile
from astropy.io import fits
from frame_files import noise, tif

from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.checks import MAX_CODE


@pytest.fixture(autouse=True)
def at_once():
    """What hangs fails, and is not waited for, where the system has an alarm."""
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def ring(*_):
        raise TimeoutError("took more than 20 s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def refused(path, pattern, **options):
    def attempt():
        return [frame.read() for frame in load(path, **options).frames()]

    with pytest.raises(InputError, match=pattern) as caught:
        attempt()
    assert "\n" not in str(caught.value)


def npy_header(shape):
    text = f"{{'descr': '<u2', 'fortran_order': False, 'shape': {shape}, }}".encode().ljust(117)
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text) + 1) + text + b"\n"


def fits_header(**cards):
    text = b"".join(f"{k:8s}= {v!s:>20s}".encode().ljust(80) for k, v in cards.items())
    text += b"END".ljust(80)
    return text.ljust(-(-len(text) // 2880) * 2880)


IMAGE = {"SIMPLE": "T", "BITPIX": 16, "NAXIS": 2, "NAXIS1": 20, "NAXIS2": 16}


# --- declared sizes --------------------------------------------------------------------------


@pytest.mark.parametrize("count", [10**9, 10**30])
def test_npy_of_many_frames(tmp_path, count):
    (tmp_path / "a.npy").write_bytes(npy_header((count, 16, 16)) + bytes(900))
    refused(tmp_path, rf"^a\.npy: declares {count} frames; valid: 1 to 100000")


@pytest.mark.parametrize("chunks", [None, (1, 16, 16)])
def test_hdf5_of_many_frames(tmp_path, chunks):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("x", (10**9, 16, 16), "u2", chunks=chunks)
    refused(tmp_path, r"^a\.h5: x: declares 1000000000 frames")


@pytest.mark.parametrize("where", ["primary", "extension"])
def test_fits_of_many_axes(tmp_path, where):
    many = {**IMAGE, "NAXIS": 999999999}
    data = fits_header(**many)
    if where == "extension":
        many = {"XTENSION": "'IMAGE   '", **many, "PCOUNT": 0, "GCOUNT": 1}
        del many["SIMPLE"]
        data = fits_header(SIMPLE="T", BITPIX=16, NAXIS=0) + fits_header(**many)
    (tmp_path / "a.fits").write_bytes(data + bytes(2880))
    refused(tmp_path, r"^a\.fits: NAXIS = 999999999; valid: 0 to 999")


def test_frames_below_the_least_size_are_told_when_they_are_loaded(tmp_path):
    np.save(tmp_path / "a.npy", noise(0, (15, 20)))
    refused(tmp_path, r"15 x 20 pixels are too few .*at least 16 rows x 8 columns")
    np.save(tmp_path / "a.npy", noise(0, (20, 20)))
    (tmp_path / "dnanalyze.yaml").write_text("cfa: RGGB\n")
    refused(tmp_path, r"20 x 20 pixels are too few .*colour filter of at least 32 rows x 16 col")


def test_compressed_pixels_that_can_hold_no_noise(tmp_path):
    rows, columns = 8000, 8000  # 128 MB from 130 kB
    zeros = zlib.compress(bytes(rows * (2 * columns + 1)), 9)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + bytes(4)

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", columns, rows, 16, 0, 0, 0, 0))
    png = b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zeros) + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(png)
    with zipfile.ZipFile(tmp_path / "b.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x.npy", npy_header((rows, columns)) + bytes(2 * rows * columns))
    large = fits_header(**{**IMAGE, "NAXIS1": columns, "NAXIS2": rows})
    (tmp_path / "c.fits.gz").write_bytes(gzip.compress(large + bytes(2 * rows * columns)))
    for name in ("a.png", "b.npz", "c.fits.gz"):
        refused(tmp_path / name, rf"^{name}: .*less than 0\.04 bit each; such frames hold no noise")


def test_a_compressed_npy_header_is_not_read_to_its_declared_end(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x.npy", b"\x93NUMPY\x02\x00\xff\xff\xff\x7f" + bytes(1000))
    refused(tmp_path, "declares a header of 2147483647 bytes")


# --- kinds of files --------------------------------------------------------------------------


def test_link_to_itself(tmp_path):
    (tmp_path / "a.fits").symlink_to("a.fits")
    refused(tmp_path, r"^a\.fits: cannot be read \(Too many levels of symbolic links\)")
    refused(tmp_path / "a.fits", "link that leads nowhere")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes on this system")
def test_pipes_are_never_waited_for(tmp_path):
    os.mkfifo(tmp_path / "a.fits")
    refused(tmp_path, r"^a\.fits: is a pipe, socket or device")
    refused(tmp_path / "a.fits", "is a pipe")
    (tmp_path / "a.fits").unlink()
    tif(tmp_path / "a.tif")
    os.mkfifo(tmp_path / "pipe")
    refused(tmp_path, "pipe: is a pipe", config=tmp_path / "pipe")
    os.mkfifo(tmp_path / "manifest.csv")
    refused(tmp_path, r"manifest\.csv: is a pipe")


# --- manifests and sidecars ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("file\n" + "x" * 300, r"row 2: x{77}\.\.\. is not in the folder"),
        ("file\n" + "x/" * 5000, r"row 2: (x/)+x?\.\.\. is not in the folder"),
        ("file,gain,gain\na.tif,1,2", "column 'gain' occurs twice"),
        ("file\n" + "a.tif\n" * 100_001, "more than 100000 rows"),
        ("file,temperature_c\na.tif,1001", "temperature_c 1001 is out of range"),
        ("file,temperature_c\na.tif,-273.15", "temperature_c -273.15 is out of range"),
        ("file,gain\na.tif,0", "gain 0 is out of range; valid: above 0"),
        ("file,gain\na.tif,-2", "gain -2 is out of range"),
        ("file,exposure_s\na.tif,1e300", "exposure_s 1e[+]300 is out of range; valid: 0 to 1e8"),
    ],
)
def test_manifest(tmp_path, text, pattern):
    tif(tmp_path / "a.tif")
    (tmp_path / "manifest.csv").write_text(text)
    refused(tmp_path, pattern)


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("[" * 100_000, r"nested more than 32 deep \(line 1\)"),
        ("{" * 100_000, "nested more than 32 deep"),
        ("- " * 100_000, "nested more than 32 deep"),
        ("width: 1" + ":1" * 100_000, "a value of more than 10000 characters"),
        ("width: 1" + ":1" * 1000 + ".5", "is not YAML: int too large"),
        ("width: " + "9" * 30, "width: .*less than or equal to"),
        ("temperature_c: -300", "temperature_c -300 is out of range"),
        ("temperature_c: .nan", "temperature_c 'nan' is no number"),
        ("gain: 0", "gain 0 is out of range"),
        ("exposure_s: -1", "exposure_s -1 is out of range"),
        ("name_regex: " + "a" * 2000, "name_regex: .*at most 1000 characters"),
    ],
)
def test_sidecar(tmp_path, text, pattern):
    tif(tmp_path / "a.tif")
    (tmp_path / "dnanalyze.yaml").write_text(text)
    refused(tmp_path, pattern)


def test_an_expression_that_backtracks_without_end(tmp_path):
    tif(tmp_path / ("a" * 40 + ".tif"))
    (tmp_path / "dnanalyze.yaml").write_text("name_regex: '(a+)+(?P<gain>b)'\n")
    refused(tmp_path, r"^name_regex '\(a\+\)\+.*takes more than 1 s over the file names; avoid")


def test_an_expression_that_finds_what_cannot_be(tmp_path):
    tif(tmp_path / "5000C.tif")
    (tmp_path / "dnanalyze.yaml").write_text("name_regex: '(?P<temperature_c>[0-9]+)C'\n")
    refused(tmp_path, r"^5000C\.tif: name_regex: temperature_c 5000 is out of range")


# --- headers ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("card", "field", "text"),
    [
        ({"CCD-TEMP": -999}, "temperature_c", "CCD-TEMP = -999 is no temperature"),
        ({"CCD-TEMP": 2000}, "temperature_c", "CCD-TEMP = 2000 is no temperature"),
        ({"GAIN": 0}, "gain", "gain 0 is out of range"),
        ({"EXPTIME": -5}, "exposure_s", "exposure_s -5 is out of range"),
    ],
)
def test_a_header_that_cannot_be_is_unknown_and_said(tmp_path, card, field, text):
    for seed, name in enumerate(("a.fits", "b.fits")):
        data = noise(seed, dtype=">i2").tobytes().ljust(2880, b"\0")
        (tmp_path / name).write_bytes(fits_header(**IMAGE, **card) + data)
    captures = load(tmp_path)
    assert getattr(captures.settings[0].point, field) is None
    (note,) = captures.notes
    assert text in note
    assert "taken as unknown" in note
    assert "a.fits and 1 more" in note


def test_a_header_that_cannot_be_leaves_the_name_to_speak(tmp_path):
    hdu = fits.PrimaryHDU(noise())
    hdu.header["CCD-TEMP"] = -999.0
    (tmp_path / "T+065C").mkdir()
    hdu.writeto(tmp_path / "T+065C" / "a.fits")
    assert load(tmp_path).settings[0].point.temperature_c == 65.0


# --- pixels ----------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", ["u4", "i8", "u8", "f8"])
def test_codes_beyond_single_precision_are_refused(tmp_path, dtype):
    array = noise().astype(dtype)
    array[3, 4] = MAX_CODE
    np.save(tmp_path / "a.npy", array)
    assert next(load(tmp_path).frames()).read()[3, 4] == MAX_CODE
    array[3, 4] = MAX_CODE + 2
    np.save(tmp_path / "a.npy", array)
    refused(tmp_path, r"^a\.npy: values from 90 to 1\.67772e\+07 DN; valid: -16777216 to 16777216")


def test_codes_over_the_full_range_of_64_bits(tmp_path):
    rng = np.random.default_rng(0)
    np.save(tmp_path / "a.npy", rng.integers(0, 2**64 - 1, (16, 20), np.uint64, endpoint=True))
    refused(tmp_path, r"^a\.npy: values from .* to 1\.8\d*e\+19 DN")


def test_colour_images_that_differ_by_one_code(tmp_path):
    array = np.stack([noise(dtype="u1")] * 3, -1)
    array[7, 8, 2] += 1
    tifffile.imwrite(tmp_path / "a.tif", array, photometric="rgb")
    refused(tmp_path, r"^a\.tif: is a colour image whose channels differ")


# --- messages --------------------------------------------------------------------------------


def test_a_message_is_one_bounded_printable_line(tmp_path):
    tif(tmp_path / "a.tif")
    (tmp_path / "manifest.csv").write_text('file\n"\x1b[2J\u202e"\n')
    refused(tmp_path, r"\?\[2J\? is not in the folder")
    message = str(InputError("a\nb" + "x" * 5000))
    assert message.startswith("a bxx")
    assert len(message) < 700


def test_names_that_are_no_text_or_move_the_cursor_are_shown_harmless(tmp_path):
    names = b"\xff.npy", b"\x1b[2J.npy", "n\u00fcll.npy".encode()
    for seed, name in enumerate(names):
        with open(os.fsencode(tmp_path) + b"/" + name, "wb") as file:
            np.save(file, noise(seed))
    assert sorted(f.name for f in load(tmp_path).frames()) == ["?.npy", "?[2J.npy", "n\u00fcll.npy"]
