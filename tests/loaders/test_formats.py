"""Every layout of every format, against the array that was stored."""

import pickle

import h5py
import numpy as np
import pytest
import tifffile
from astropy.io import fits
from frame_files import noise, tif

from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.packing import pack
from dnanalyze.loaders.plain import PlainPixels

STACK = np.stack([noise(k) for k in range(3)])
WINDOW = Window(2, 9, 3, 8)


def check(folder, expected, dtype=None, **options):
    """The frames of the folder are the expected arrays, whole and in windows."""
    captures = load(folder, **options)
    frames = list(captures.frames())
    assert len(frames) == len(expected)
    for frame, array in zip(frames, expected, strict=True):
        frame = pickle.loads(pickle.dumps(frame))  # frames travel to worker processes
        got = frame.read()
        assert np.array_equal(got, array)
        assert got.dtype == (dtype or array.dtype)
        assert got.dtype.isnative
        assert got.flags.c_contiguous
        part = frame.read(WINDOW)
        assert part.dtype == got.dtype
        assert np.array_equal(part, array[WINDOW.slices])
    return captures


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"byteorder": ">"},
        {"compression": "zlib"},
        {"compression": "zlib", "predictor": True},
        {"rowsperstrip": 4},
        {"tile": (16, 16)},
        {"bigtiff": True},
        {"metadata": None},
        {"metadata": None, "contiguous": False},
        {"truncate": True},
        {"imagej": True, "byteorder": ">"},
    ],
    ids=str,
)
def test_tiff(tmp_path, options):
    options = {"photometric": "minisblack", **options}
    writer = {k: options.pop(k) for k in ("byteorder", "bigtiff", "imagej") if k in options}
    tifffile.imwrite(tmp_path / "a.tif", STACK, **writer, **options)
    check(tmp_path, STACK)


def test_tiff_single_page_is_read_without_decoding(tmp_path):
    tif(tmp_path / "a.tif")
    captures = check(tmp_path, [noise(0)])
    assert isinstance(next(captures.frames()).load.read, PlainPixels)


def test_tiff_float_and_signed(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", noise().astype(np.float64) / 3)
    assert np.allclose(next(load(tmp_path).frames()).read(), noise() / 3, rtol=1e-7)
    tifffile.imwrite(tmp_path / "a.tif", noise().astype(np.int16) - 100)
    check(tmp_path, [noise().astype(np.int16) - 100])


def test_tiff_lzw(tmp_path):
    from PIL import Image

    pages = [Image.fromarray(a) for a in STACK]
    pages[0].save(
        tmp_path / "a.tif", compression="tiff_lzw", save_all=True, append_images=pages[1:]
    )
    check(tmp_path, STACK)


@pytest.mark.parametrize("dtype", ["uint8", "int16", "uint16", "int32", "uint32", "float32"])
def test_fits(tmp_path, dtype):
    fits.PrimaryHDU(STACK.astype(dtype)).writeto(tmp_path / "cube.fits")
    captures = check(tmp_path, STACK.astype(dtype))
    assert [f.name for f in captures.frames()] == [f"cube.fits[{k}]" for k in range(3)]


def test_fits_extension_scale_sections_and_bayer(tmp_path):
    array = noise(0, (32, 24))
    hdu = fits.ImageHDU(array)
    for key, value in {
        "DATASEC": "[3:20,1:32]", "BIASSEC": "[21:24,1:32]", "BAYERPAT": "RGGB", "XPIXSZ": 3.76,
    }.items():  # fmt: skip
        hdu.header[key] = value
    fits.HDUList([fits.PrimaryHDU(), hdu]).writeto(tmp_path / "a.fits")
    captures = check(tmp_path, [array[:, 2:20]])
    assert captures.sensor.cfa == (("R", "G"), ("G", "B"))
    assert captures.sensor.pixel_pitch_um == 3.76
    assert np.array_equal(next(captures.frames()).masked(), array[:, 20:24])
    assert np.array_equal(next(load(tmp_path, include_masked=True).frames()).read(), array)
    with pytest.raises(InputError, match="32 x 4 pixels are too few"):
        load(tmp_path, region="masked")


def test_fits_overlapping_sections_are_said(tmp_path):
    hdu = fits.PrimaryHDU(noise(0, (16, 24)))
    hdu.header["DATASEC"], hdu.header["BIASSEC"] = "[1:16,1:16]", "[1:8,1:16]"
    hdu.writeto(tmp_path / "a.fits")
    captures = load(tmp_path, region="masked")
    assert "overlaps DATASEC" in captures.notes[0]
    assert np.array_equal(next(captures.frames()).read(), noise(0, (16, 24))[:, 16:])


def test_fits_scaled_becomes_float(tmp_path):
    hdu = fits.PrimaryHDU(noise().astype(np.int16))
    hdu.writeto(tmp_path / "a.fits")
    fits.setval(tmp_path / "a.fits", "BSCALE", value=0.5)
    fits.setval(tmp_path / "a.fits", "BZERO", value=10.0)
    check(tmp_path, [(noise() * 0.5 + 10).astype(np.float32)])


@pytest.mark.parametrize("dtype", ["uint8", "<u2", ">u2", "<i4", "<f4"])
def test_npy(tmp_path, dtype):
    np.save(tmp_path / "a.npy", STACK.astype(dtype))
    check(tmp_path, STACK.astype(dtype), np.dtype(dtype).newbyteorder("="))


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_npz_holds_frames_and_facts(tmp_path, save):
    save(tmp_path / "a.npz", temperature_c=25.0, first=STACK, second=noise(9))
    captures = check(tmp_path, [*STACK, noise(9)])
    assert captures.settings[0].point.temperature_c == 25.0


@pytest.mark.parametrize("options", [{}, {"chunks": (1, 8, 8), "compression": "gzip"}])
def test_hdf5(tmp_path, options):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.attrs["gain"] = 2.0
        group = file.create_group("cold")
        group.attrs["temperature_c"] = -10.0
        group.create_dataset("frames", data=STACK, **options).attrs["exposure_s"] = [1.0, 1.0, 2.0]
        file.create_dataset("warm", data=noise(9)).attrs["temperature_c"] = 30.0
        file.create_dataset("curve", data=np.arange(5.0))
    captures = check(tmp_path, [*STACK, noise(9)])
    points = [s.point for s in captures.settings]
    assert [(p.temperature_c, p.exposure_s, p.gain) for p in points] == [
        (-10.0, 1.0, 2.0), (-10.0, 2.0, 2.0), (30.0, None, 2.0),
    ]  # fmt: skip


@pytest.mark.parametrize(("top", "dtype"), [(255, "u1"), (4095, ">u2")])
def test_pgm(tmp_path, top, dtype):
    head = f"P5\n# exposure_s = 0.25\n20 16\n# made by hand\n{top}\n".encode()
    (tmp_path / "a.pgm").write_bytes(head + noise().astype(dtype).tobytes())
    captures = check(tmp_path, [noise()], np.dtype(dtype).newbyteorder("="))
    assert captures.sensor.bits == top.bit_length()
    assert captures.settings[0].point.exposure_s == 0.25


@pytest.mark.parametrize("bits", [8, 16])
def test_png(tmp_path, bits):
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    facts = PngInfo()
    facts.add_text("temperature_c", "-7.5")
    array = noise(0, dtype=f"uint{bits}") + (1000 if bits == 16 else 0)
    Image.fromarray(array).save(tmp_path / "a.png", pnginfo=facts)
    assert check(tmp_path, [array]).settings[0].point.temperature_c == -7.5


SIDE = "width: 20\nheight: 16\nbits: {bits}\n"


@pytest.mark.parametrize("bits", [8, 10, 12, 14, 16])
@pytest.mark.parametrize("order", ["little", "big"])
def test_headerless_plain_with_header_and_several_frames(tmp_path, bits, order):
    dtype = "u1" if bits == 8 else {"little": "<u2", "big": ">u2"}[order]
    (tmp_path / "a.raw").write_bytes(b"head" * 8 + STACK.astype(dtype).tobytes())
    (tmp_path / "dnanalyze.yaml").write_text(
        SIDE.format(bits=bits) + f"byte_order: {order}\nheader_offset: 32\n"
    )
    captures = check(tmp_path, STACK, np.uint8 if bits == 8 else np.uint16)
    assert captures.sensor.bits == bits


@pytest.mark.parametrize("bits", [10, 12, 14])
@pytest.mark.parametrize("packing", ["mipi", "lsb"])
@pytest.mark.parametrize("padding", [0, 7])
def test_headerless_packed_and_padded(tmp_path, bits, packing, padding):
    packed = np.pad(pack(STACK.reshape(-1, 20), bits, packing), ((0, 0), (0, padding)))
    (tmp_path / "a.raw").write_bytes(packed.tobytes())
    (tmp_path / "dnanalyze.yaml").write_text(
        SIDE.format(bits=bits) + f"packing: {packing}\nrow_bytes: {packed.shape[1]}\n"
    )
    check(tmp_path, STACK)


def test_headerless_padded_plain_rows(tmp_path):
    (tmp_path / "a.bin").write_bytes(np.pad(noise(), ((0, 0), (0, 3))).tobytes())
    (tmp_path / "dnanalyze.yaml").write_text(SIDE.format(bits=12) + "row_bytes: 46\n")
    check(tmp_path, [noise()])


def test_sidecar_cuts_areas_and_shifts_the_colour_filter(tmp_path):
    array = noise(0, (40, 40))
    np.save(tmp_path / "a.npy", array)
    (tmp_path / "dnanalyze.yaml").write_text(
        "active_rows: [3, 40]\nactive_columns: [20, 40]\noptical_black_columns: [0, 18]\n"
        "cfa: RGGB\nblack_level: 64\nwhite_level: 4095\nbits: 12\n"
    )
    captures = check(tmp_path, [array[3:, 20:]])
    assert captures.sensor.cfa == (("G", "B"), ("R", "G"))
    assert (captures.sensor.black_level, captures.sensor.bits) == (64.0, 12)
    assert np.array_equal(next(captures.frames()).masked(), array[:, :18])
    masked = load(tmp_path, region="masked")
    assert masked.sensor.shape == (40, 18)
    assert masked.sensor.cfa == (("R", "G"), ("G", "B"))


def test_load_reads_headers_only(tmp_path, monkeypatch):
    tif(tmp_path / "a.tif")
    tif(tmp_path / "b.tif", 1, compression="zlib")
    monkeypatch.setattr(np, "fromfile", None)
    monkeypatch.setattr(tifffile.TiffPage, "asarray", None)
    assert load(tmp_path).frame_count == 2


def test_nothing_is_written_beside_the_captures(tmp_path):
    tif(tmp_path / "a.tif")
    before = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*")}
    for frame in load(tmp_path).frames():
        frame.read()
    assert {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*")} == before
