"""FITS packed by gzip or in tiles, ENVI, and colour pictures that are grey."""

import gzip

import numpy as np
import pytest
import tifffile
from astropy.io import fits
from frame_files import noise
from PIL import Image

from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.captures import Window

STACK = np.stack([noise(k, (24, 40)) for k in range(3)])
WINDOW = Window(3, 20, 5, 31)


def check(path, expected, dtype=np.uint16):
    captures = load(path)
    frames = list(captures.frames())
    assert len(frames) == len(expected)
    for frame, array in zip(frames, expected, strict=True):
        found = frame.read()
        assert found.dtype == dtype
        assert np.array_equal(found, array)
        assert np.array_equal(frame.read(WINDOW), array[WINDOW.slices])
    return captures


@pytest.mark.parametrize("suffix", [".fits.gz", ".fit.gz", ".fts.gz", ".FITS.GZ"])
def test_gzipped_fits(tmp_path, suffix):
    hdu = fits.PrimaryHDU(STACK)
    hdu.header["EXPTIME"] = 20.0
    hdu.writeto(tmp_path / "a.fits")
    data = (tmp_path / "a.fits").read_bytes()
    (tmp_path / "a.fits").unlink()
    (tmp_path / f"a{suffix}").write_bytes(gzip.compress(data))
    captures = check(tmp_path, STACK)
    assert captures.settings[0].point.exposure_s == 20.0
    (tmp_path / f"a{suffix}").write_bytes(gzip.compress(data)[:-400])
    with pytest.raises(InputError, match=r"cannot be decoded .*copy the file again"):
        list(load(tmp_path).frames())[-1].read()


@pytest.mark.parametrize("how", ["RICE_1", "GZIP_1", "GZIP_2"])
@pytest.mark.parametrize("dtype", ["int16", "uint16"])
def test_tiled_fits(tmp_path, how, dtype):
    array = STACK[0].astype(dtype)
    image = fits.CompImageHDU(array, compression_type=how)
    image.header["CCD-TEMP"] = -10.0
    fits.HDUList([fits.PrimaryHDU(), image]).writeto(tmp_path / "a.fits.fz")
    captures = check(tmp_path, [array], np.dtype(dtype))
    assert captures.settings[0].point.temperature_c == -10.0


@pytest.mark.parametrize("how", ["HCOMPRESS_1", "PLIO_1"])
def test_an_algorithm_without_a_safe_decoder_is_refused(tmp_path, how):
    image = fits.CompImageHDU(STACK[0].astype(np.int16), compression_type=how)
    fits.HDUList([fits.PrimaryHDU(), image]).writeto(tmp_path / "a.fits.fz")
    with pytest.raises(InputError, match=rf"ZCMPTYPE = '{how}'; valid: RICE_1.*funpack"):
        load(tmp_path)


def test_tiled_cube_and_scaled_tiles(tmp_path):
    cube = fits.CompImageHDU(STACK.astype(np.int16), compression_type="RICE_1")
    fits.HDUList([fits.PrimaryHDU(), cube]).writeto(tmp_path / "a.fz")
    check(tmp_path, STACK, np.int16)


def test_tiles_that_do_not_cover_the_image(tmp_path):
    image = fits.CompImageHDU(STACK[0].astype(np.int16))
    fits.HDUList([fits.PrimaryHDU(), image]).writeto(tmp_path / "a.fz")
    data = (tmp_path / "a.fz").read_bytes()
    changed = data.replace(b"ZNAXIS2 =                   24", b"ZNAXIS2 =                   99")
    assert changed != data
    (tmp_path / "a.fz").write_bytes(changed)
    with pytest.raises(InputError, match=r"holds 24 tiles where its image has 99"):
        load(tmp_path)


def envi(path, stack, interleave, dtype, order, **more):
    """Write the pixels and the header beside them."""
    axes = {"bsq": (0, 1, 2), "bil": (1, 0, 2), "bip": (1, 2, 0)}[interleave]
    path.write_bytes(b"head" + stack.transpose(axes).astype(order + dtype).tobytes())
    kinds = {"u1": 1, "i2": 2, "i4": 3, "f4": 4, "f8": 5, "u2": 12, "u4": 13, "i8": 14, "u8": 15}
    fields = {
        "description": "{two\nlines = 7}", "samples": stack.shape[2], "lines": stack.shape[1],
        "bands": stack.shape[0], "header offset": 4, "data type": kinds[dtype],
        "interleave": interleave, "byte order": int(order == ">"), **more,
    }  # fmt: skip
    text = "ENVI\n" + "".join(f"{k} = {v}\n" for k, v in fields.items())
    path.with_suffix(".hdr").write_text(text)


@pytest.mark.parametrize("interleave", ["bsq", "bil", "bip"])
@pytest.mark.parametrize(
    ("dtype", "order"), [("u2", "<"), ("u2", ">"), ("i4", ">"), ("f4", "<"), ("u1", "<")]
)
def test_envi(tmp_path, interleave, dtype, order):
    envi(tmp_path / "a.img", STACK, interleave, dtype, order, **{"exposure time": "20 ms"})
    captures = check(tmp_path, STACK.astype(dtype), np.dtype(dtype))
    assert captures.settings[0].point.exposure_s == pytest.approx(0.02)
    assert captures.source.formats == ("ENVI",)


def test_envi_header_outranks_the_sidecar_and_others_are_no_frames(tmp_path):
    envi(tmp_path / "a.raw", STACK[:1], "bsq", "u2", "<")
    (tmp_path / "dnanalyze.yaml").write_text("width: 8\nheight: 16\nbits: 16\n")
    (tmp_path / "notes.dat").write_text("not a frame")
    check(tmp_path, STACK[:1])


@pytest.mark.parametrize(
    ("field", "value", "pattern"),
    [
        ("lines", "x", r"a\.hdr: lines = 'x'; valid: a whole number"),
        ("data type", 6, r"a\.hdr: data type = 6; valid: 1, 2, 3"),
        ("interleave", "zip", "interleave = zip; valid: bsq, bil, bip"),
        ("byte order", 2, "byte order = 2; valid: 0, 1"),
        ("file compression", 1, "file compression = 1; valid: 0"),
        ("bands", 999999999, "declares 999999999 frames"),
        ("lines", 25, "truncated, 5764 bytes of the 6004"),
        ("header offset", 10**17, "truncated"),
    ],
)
def test_envi_headers_that_cannot_be(tmp_path, field, value, pattern):
    envi(tmp_path / "a.dat", STACK, "bil", "u2", "<")
    header = tmp_path / "a.hdr"
    lines = [line for line in header.read_text().split("\n") if not line.startswith(field)]
    header.write_text("\n".join([*lines, f"{field} = {value}"]))
    with pytest.raises(InputError, match=pattern):
        load(tmp_path)


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_a_grey_colour_picture_is_read_and_said(tmp_path, suffix, channels):
    grey = STACK[0].astype(np.uint8)
    array = np.stack([grey] * 3 + [np.full_like(grey, 255)] * (channels - 3), -1)
    path = tmp_path / f"a{suffix}"
    if suffix == ".png":
        Image.fromarray(array).save(path)
    else:
        tifffile.imwrite(path, array, photometric="rgb")
    captures = check(tmp_path, [grey], np.uint8)
    assert "processed pictures, not raw frames" in captures.notes[0]


def test_planar_colour_of_16_bit(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", np.stack([STACK[0]] * 3), photometric="rgb",
                     planarconfig="separate")  # fmt: skip
    check(tmp_path, [STACK[0]])


@pytest.mark.parametrize(
    ("card", "field", "value"),
    [("TEMPDET", "temperature_c", -104.5), ("IMG_EXP", "exposure_s", 3.5)],
)
def test_key_words_of_lick_and_others(tmp_path, card, field, value):
    hdu = fits.PrimaryHDU(noise())
    hdu.header[card] = value
    hdu.header["TEMPDETE"] = 0.0  # written at the end of an exposure, and not by all
    hdu.writeto(tmp_path / "a.fits")
    assert getattr(load(tmp_path).settings[0].point, field) == value
