"""Raw layouts that the codes contradict: the line names the right one; right ones pass."""

import numpy as np
import pytest
from astropy.io import fits

from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.packing import PACKINGS, pack

SHAPE = (32, 40)


def dark(level=260.0, noise=3.0, bits=12):
    codes = np.random.default_rng(0).normal(level, noise, SHAPE)
    return np.clip(np.rint(codes), 0, 2**bits - 1).astype("<u2")


def raw(folder, data, **keys):
    (folder / "a.raw").write_bytes(data if isinstance(data, bytes) else data.tobytes())
    keys = {"width": SHAPE[1], "height": SHAPE[0], "bits": 12} | keys
    (folder / "dnanalyze.yaml").write_text("".join(f"{k}: {v}\n" for k, v in keys.items()))
    return load(folder)


@pytest.mark.parametrize("level", [5, 63, 260, 900])
@pytest.mark.parametrize("noise", [0.7, 5.0, 40.0])
@pytest.mark.parametrize("stated", PACKINGS)
def test_packings_are_told_apart(tmp_path, level, noise, stated):
    codes = dark(level, noise)
    for packing in PACKINGS:
        data = pack(codes, 12, packing)
        if packing == stated:
            assert np.array_equal(raw(tmp_path, data, packing=stated).settings[0].frames[0].read(),
                                  codes)  # fmt: skip
        else:
            with pytest.raises(InputError, match=f"set packing: {packing} in the sidecar"):
                raw(tmp_path, data, packing=stated)


@pytest.mark.parametrize(
    ("data", "keys", "remedy"),
    [
        (dark().byteswap(), {}, "set byte_order: big"),
        (dark(40).byteswap(), {"bits": 16}, "set byte_order: big"),
        (dark(), {"byte_order": "big"}, "set byte_order: little"),
        (dark() << 4, {}, "left-justified; set bits: 16"),
        (dark(8000, bits=14), {}, "beyond 12 bits; set bits: 14"),
        (dark(60).astype("u1").repeat(2), {"bits": 12}, "set bits: 8"),
        (np.r_[dark(60).astype("u1"), dark(60).astype("u1")], {"bits": 16}, "set bits: 8"),
        (dark(), {"bits": 8}, "byte_order: little"),
        (dark().byteswap(), {"bits": 8}, "byte_order: big"),
        (pack(dark(1000, 20, 10), 10, "genicam"), {"packing": "genicam"}, "set bits: 10"),
        (np.tile(pack(dark(), 12, "lsb"), (4, 1)), {}, "set packing: lsb"),
        (np.tile(pack(dark(), 12, "genicam"), (2, 1)), {"bits": 8}, "packing: genicam, bits: 12"),
        (
            np.tile(pack(dark(500, 5, 10), 10, "genicam"), (5, 1)),
            {"bits": 10, "packing": "mipi"},
            "packing: genicam, bits: 10",
        ),
        (pack(dark(), 12, "lsb"), {}, "truncated"),
        (np.tile(pack(dark(), 12, "msb"), (2, 1)), {}, "packing .*msb.* would fit"),
        (b"HEAD" * 16 + dark().tobytes(), {}, "set header_offset: 64"),
        (dark().tobytes() + b"TAIL" * 16, {}, "set footer_bytes: 64"),
    ],
)
def test_a_wrong_layout_is_refused_with_the_right_one(tmp_path, data, keys, remedy):
    with pytest.raises(InputError, match=remedy):
        raw(tmp_path, data, **keys)


@pytest.mark.parametrize("turned", [True, False])
def test_height_and_width_exchanged_are_told_by_a_pattern_of_columns(tmp_path, turned):
    rng = np.random.default_rng(4)
    shape = (96, 120)
    codes = rng.normal(260, 3, shape) + rng.normal(0, 3, shape[1]) + np.linspace(0, 9, 96)[:, None]
    sides = {"width": 96, "height": 120} if turned else {"width": 120, "height": 96}
    if turned:
        with pytest.raises(InputError, match="set width: 120 and height: 96"):
            raw(tmp_path, codes.astype("<u2"), **sides)
    else:
        assert raw(tmp_path, codes.astype("<u2"), **sides).sensor.shape == shape


@pytest.mark.parametrize("shape", [(96, 40), (40, 96), (64, 256), (256, 64), (128, 96)])
@pytest.mark.parametrize(("row", "column"), [(0, 8), (8, 0), (8, 3)])
def test_a_mosaic_of_either_shape_is_not_exchanged(tmp_path, shape, row, column):
    codes = np.random.default_rng(5).normal(260, 3, shape)
    codes[:, ::2] += column
    codes[::2] += row
    captures = raw(tmp_path, codes.astype("<u2"), width=shape[1], height=shape[0])
    assert captures.sensor.shape == shape


def test_bytes_behind_the_pixels_are_left_out(tmp_path):
    captures = raw(tmp_path, dark().tobytes() + b"TAIL" * 16, footer_bytes=64)
    assert np.array_equal(captures.settings[0].frames[0].read(), dark())


def test_bytes_too_many_beside_embedded_rows_may_be_at_either_end(tmp_path):
    codes = dark()
    codes[0] = np.arange(SHAPE[1]) * 997 % 4096
    with pytest.raises(InputError, match="header_offset: 64 or footer_bytes: 64, whichever end"):
        raw(tmp_path, codes.tobytes() + bytes(64))


def test_embedded_rows_are_said(tmp_path):
    codes = dark()
    codes[0] = np.arange(SHAPE[1]) * 97 % 4096
    codes[-2:] = 0
    (note,) = raw(tmp_path, codes).notes
    assert "1 row at the top and 2 rows at the bottom" in note
    assert "active_rows: [1, 30]" in note
    # a gradient at the edge and rows that all differ are no embedded data
    assert not raw(tmp_path, dark() + np.arange(32, dtype="<u2")[:, None]).notes


def test_swapped_words_of_other_formats_are_refused(tmp_path):
    (tmp_path / "a.pgm").write_bytes(b"P5\n40 32\n4095\n" + dark().tobytes())
    with pytest.raises(InputError, match="little-endian, and those of PGM are big-endian"):
        load(tmp_path)
    (tmp_path / "a.pgm").unlink()
    (tmp_path / "a.raw").write_bytes(dark().tobytes())
    header = "ENVI\nsamples = 40\nlines = 32\nbands = 1\ndata type = 12\nbyte order = 1\n"
    (tmp_path / "a.hdr").write_text(header)
    with pytest.raises(InputError, match="set byte order = 0"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("stored", "offset", "text"),
    [
        ((dark() - 32768).astype("i2"), None, "lacked BZERO"),
        (dark().astype("i2"), 32768, "Every code is 32768 or more"),
        ((dark(0, 9) + 32760).astype("i2"), None, "lacked BZERO"),
        (dark().astype("i2"), None, ""),
        ((dark() - 32768).astype("i2"), 32768, ""),
    ],
)
def test_a_wrong_offset_of_fits_is_doubted(tmp_path, stored, offset, text):
    header = fits.Header()
    hdu = fits.PrimaryHDU(stored, header)
    if offset:
        hdu.header["BSCALE"], hdu.header["BZERO"] = 1, offset
    hdu.writeto(tmp_path / "a.fits")
    data = (tmp_path / "a.fits").read_bytes()
    if offset:  # astropy drops the offset of data that it did not apply to
        card = f"{'BZERO   =':10s}{offset:>20d}".ljust(80).encode()
        at = data.index(b"END" + b" " * 77)
        (tmp_path / "a.fits").write_bytes(data[:at] + card + data[at : at + 80] + data[at + 160 :])
    notes = " ".join(load(tmp_path).notes)
    assert text in notes
    assert text or not notes
