"""FITS files with several images, amplifiers, sections, colours and orders of rows."""

import gzip
import io

import numpy as np
import pytest
from astropy.io import fits
from frame_files import noise

from dnanalyze.errors import InputError
from dnanalyze.loaders import load


def write(path, data, **cards):
    hdu = fits.PrimaryHDU(data)
    for key, value in cards.items():
        hdu.header[key.replace("_", "-")] = value
    hdu.writeto(path)


def several(path, *images, primary=None):
    """A file whose primary header alone has the metadata; ``images`` are (data, cards)."""
    units = [fits.PrimaryHDU()]
    for key, value in (primary or {"EXPTIME": 60.0, "CCD-TEMP": -20.0}).items():
        units[0].header[key] = value
    for data, cards in images:
        units.append(fits.ImageHDU(data))
        for key, value in cards.items():
            units[-1].header[key] = value
    fits.HDUList(units).writeto(path)


def points(captures):
    return [(s.point.channel, s.point.temperature_c, s.point.exposure_s) for s in captures.settings]


def test_extensions_inherit_the_primary_header_and_are_channels(tmp_path):
    several(
        tmp_path / "a.fits",
        (noise(1), {"EXTNAME": "BLUE"}),
        (noise(2), {"EXTNAME": "RED", "EXPTIME": 30.0}),
        (noise(3), {"EXTNAME": "NONE", "INHERIT": False}),
    )
    captures = load(tmp_path)
    assert points(captures) == [("BLUE", -20.0, 60.0), ("NONE", None, None), ("RED", -20.0, 30.0)]
    frames = {s.point.channel: s.frames[0] for s in captures.settings}
    assert np.array_equal(frames["RED"].read(), noise(2))
    assert "taken as channels by name: BLUE, RED, NONE" in " ".join(captures.notes)


def test_a_light_frame_is_told_by_the_primary_header(tmp_path):
    several(tmp_path / "a.fits", (noise(), {}), primary={"IMAGETYP": "Light"})
    with pytest.raises(InputError, match="light frame"):
        load(tmp_path)


def test_images_beside_the_frames_are_left_out_and_said(tmp_path):
    several(
        tmp_path / "a.fits",
        (noise(1), {"EXTNAME": "SCI"}),
        (noise(2).astype("f4"), {"EXTNAME": "ERR"}),
        (noise(3, (24, 20)), {"EXTNAME": "GUIDE"}),
        (noise(4, (24, 20)), {"EXTNAME": "BPM"}),
    )
    captures = load(tmp_path)
    assert (captures.frame_count, captures.channels) == (1, [])
    assert "left out: ERR, GUIDE, BPM" in " ".join(captures.notes)


@pytest.mark.parametrize("name", ["DQ", "MASK", "BPM", "BADPIX", "PIXELDQ", "quality"])
@pytest.mark.parametrize("suffix", [".fits", ".fits.gz", ".fits.fz"])
def test_masks_of_data_quality_are_left_out(tmp_path, name, suffix):
    flags = np.zeros((24, 20), "i2")
    flags[10:12] = 4
    path = tmp_path / f"a{suffix}"
    frame = noise(1, (24, 20)).astype("i2")
    image = fits.CompImageHDU if suffix == ".fits.fz" else fits.ImageHDU
    units = [fits.PrimaryHDU(), image(frame, name="SCI"), image(flags, name=name)]
    data = io.BytesIO()
    fits.HDUList(units).writeto(data)
    path.write_bytes(gzip.compress(data.getvalue()) if suffix == ".fits.gz" else data.getvalue())
    captures = load(tmp_path)
    assert captures.notes[0].startswith(f"Masked by {path.name}: 2 rows.")
    np.testing.assert_array_equal(next(captures.frames()).read(), np.delete(frame, (10, 11), 0))


def test_masks_of_several_chips_are_joined(tmp_path):
    flags = np.zeros((2, 24, 20), "u1")
    flags[0, 3], flags[1, :, 7] = 1, 8
    units = [
        (x, {"EXTNAME": name, "EXTVER": k + 1})
        for k in range(2)
        for name, x in ((f"CHIP{k}", noise(k, (24, 20))), ("DQ", flags[k]))
    ]
    several(tmp_path / "a.fits", *units)
    captures = load(tmp_path)
    assert captures.channels == ["CHIP0", "CHIP1"]
    assert captures.sensor.shape == (23, 19)


def test_a_mask_of_most_pixels_is_told_and_not_used(tmp_path):
    good = np.ones((16, 20), "u1")  # 1 is good here
    good[3, 3] = 0
    several(tmp_path / "a.fits", (noise(1), {"EXTNAME": "SCI"}), (good, {"EXTNAME": "MASK"}))
    captures = load(tmp_path)
    assert captures.sensor.shape == (16, 20)
    assert "MASK marks 99.7 % of the pixels, too many to leave out; not used" in captures.notes[0]


def test_images_without_name_that_differ_in_time_are_frames(tmp_path):
    images = [(noise(k), {"DATE-OBS": f"2024-01-01T00:0{k}:00"}) for k in (1, 2, 3)]
    several(tmp_path / "a.fits", *images)
    captures = load(tmp_path)
    assert (captures.channels, len(captures.settings[0].frames)) == ([], 3)
    assert "successive frames: they differ in DATE-OBS" in " ".join(captures.notes)
    (tmp_path / "a.fits").unlink()
    several(tmp_path / "b.fits", (noise(1), {}), (noise(2), {}))
    assert load(tmp_path).channels == ["image 1", "image 2"]


def test_images_of_a_gzipped_file(tmp_path):
    several(tmp_path / "a.fits", (noise(1), {"EXTNAME": "A"}), (noise(2), {"EXTNAME": "B"}))
    data = (tmp_path / "a.fits").read_bytes()
    (tmp_path / "a.fits").unlink()
    (tmp_path / "a.fits.gz").write_bytes(gzip.compress(data))
    captures = load(tmp_path)
    assert captures.channels == ["A", "B"]
    assert np.array_equal(captures.settings[1].frames[0].read(), noise(2))


AMPLIFIERS = {
    "DATASECA": "[1:12, 1:16]",
    "BIASSECA": "[13:16, 1:16]",
    "BIASSECB": "[17:20, 1:16]",
    "DATASECB": "[32:21, 1:16]",  # read from the other side
}


def test_amplifiers_are_channels_with_their_own_overscan(tmp_path):
    data = noise(1, (16, 32))
    write(tmp_path / "a.fits", data, **AMPLIFIERS)
    captures = load(tmp_path)
    assert captures.channels == ["A", "B"]
    assert captures.sensor.shape == (16, 12)
    left, right = (s.frames[0] for s in captures.settings)
    assert np.array_equal(right.read(), data[:, 20:32])
    assert np.array_equal(left.masked(), data[:, 12:16])
    assert np.array_equal(right.masked(), data[:, 16:20])
    whole = load(tmp_path, region="all")
    assert (whole.frame_count, whole.sensor.shape) == (1, (16, 32))
    (tmp_path / "dnanalyze.yaml").write_text("active_columns: [0, 20]\n")
    assert load(tmp_path).frame_count == 1


def test_blanks_in_sections_and_an_overscan_alone(tmp_path):
    write(tmp_path / "a.fits", noise(), TRIMSEC="[   5:  20,   1:  16]", BIASSEC="[ 1:4, 1:16]")
    captures = load(tmp_path)
    assert captures.sensor.shape == (16, 16)
    assert captures.settings[0].frames[0].masked().shape == (16, 4)
    (tmp_path / "a.fits").unlink()
    write(tmp_path / "b.fits", noise(), BIASSEC="[17:20, 1:16]")
    captures = load(tmp_path)
    assert captures.sensor.shape == (16, 16)
    assert "BIASSEC [17:20, 1:16] without DATASEC" in " ".join(captures.notes)
    (tmp_path / "b.fits").unlink()
    write(tmp_path / "c.fits", noise(), DATASEC="[1:4000,1:16]")
    assert "does not fit the image" in " ".join(load(tmp_path).notes)


@pytest.mark.parametrize("card", [("CTYPE3", "rgb"), ("COLORSPC", "RGB"), ("COLORTYP", "RGB")])
def test_cubes_of_colours_are_refused(tmp_path, card):
    write(tmp_path / "a.fits", np.stack([noise(k) for k in range(3)]), **dict([card]))
    with pytest.raises(InputError, match="3 planes are colours"):
        load(tmp_path)


def test_three_planes_without_a_word_are_doubted(tmp_path):
    write(tmp_path / "a.fits", np.stack([noise(k) for k in range(3)]))
    captures = load(tmp_path)
    assert captures.frame_count == 3
    assert "where they are colours" in " ".join(captures.notes)


@pytest.mark.parametrize(("rows", "cfa"), [(32, "GBRG"), (33, "RGGB")])
def test_the_colour_filter_of_rows_from_the_bottom(tmp_path, rows, cfa):
    write(tmp_path / "a.fits", noise(0, (rows, 20)), BAYERPAT="RGGB", ROWORDER="BOTTOM-UP")
    captures = load(tmp_path)
    assert "".join("".join(row) for row in captures.sensor.cfa) == cfa
    assert "BOTTOM-UP" in " ".join(captures.notes)
