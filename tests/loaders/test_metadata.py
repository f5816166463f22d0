"""Which source a frame's metadata come from: manifest, header, name, sidecar."""

import pytest
from astropy.io import fits
from frame_files import noise, tif

from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.loaders.headers import from_header, from_text, image_type
from dnanalyze.loaders.recording import Metadata


def fits_file(path, **cards):
    path.parent.mkdir(parents=True, exist_ok=True)
    hdu = fits.PrimaryHDU(noise())
    for key, value in cards.items():
        hdu.header[key.replace("_", "-")] = value
    hdu.writeto(path)
    return path


def only_point(captures):
    (setting,) = captures.settings
    return setting.point


def test_first_found_wins_for_each_field_by_itself(tmp_path):
    fits_file(tmp_path / "T+065C_gain4" / "a_exp_9s.fits", CCD_TEMP=20.0, EXPTIME=3.0)
    root = tmp_path
    # name alone gives what the header lacks
    assert only_point(load(root)) == OperatingPoint(20.0, 3.0, 4.0)
    # the sidecar gives what nothing else says
    (root / "dnanalyze.yaml").write_text("temperature_c: -1\nexposure_s: 8\nchannel: lcg\n")
    assert only_point(load(root)) == OperatingPoint(20.0, 3.0, 4.0, "lcg")
    # the manifest outranks the header, in the fields that it fills
    (root / "manifest.csv").write_text("file,exposure_s,gain\nT*/*.fits,7,\n")
    assert only_point(load(root)) == OperatingPoint(20.0, 7.0, 4.0, "lcg")


def test_the_users_expression_outranks_the_built_in_patterns(tmp_path):
    tif(tmp_path / "T+065C" / "cold_12.tif")
    (tmp_path / "dnanalyze.yaml").write_text("name_regex: cold_(?P<temperature_c>\\d+)\n")
    assert only_point(load(tmp_path)).temperature_c == 12.0


def test_set_point_counts_only_without_a_measured_temperature():
    assert from_header({"SET-TEMP": -5, "CCD-TEMP": -4.8}).temperature_c == -4.8
    assert from_header({"SET-TEMP": -5}).temperature_c == -5.0


@pytest.mark.parametrize(
    ("key", "value"),
    [("CCD-TEMP", 1.5), ("CCDTEMP", 1.5), ("SENSTEMP", 1.5), ("DET-TEMP", "1.5 C")],
)
def test_temperature_keys(key, value):
    assert from_header({key: value}) == Metadata(temperature_c=1.5)


def test_units_of_text_and_comments():
    assert from_header({"DET-TEMP": 300.15}, {"DET-TEMP": "[K] detector"}).temperature_c == (
        pytest.approx(27.0)
    )
    assert from_header({"EXPTIME": 20}, {"EXPTIME": "[ms]"}).exposure_s == pytest.approx(0.02)
    assert from_header({"exposure": "20 ms"}).exposure_s == pytest.approx(0.02)
    assert from_header({"ExposureTime": (1, 400)}).exposure_s == 0.0025
    assert from_header({"GAIN": "High", "ISO": 800}).gain == 800.0
    assert from_header({"EXPTIME": "x", "CCD-TEMP": float("nan")}) == Metadata()


def test_text_is_json_or_lines():
    expected = Metadata(25.0, 0.5, None)
    assert from_text('{"temperature_c": 25, "exposure_s": 0.5}') == expected
    assert from_text("camera: x\nTemperature = 25 C\nExposure: 500 ms\n") == expected
    assert from_text("nothing at all") == Metadata()
    assert from_text(f'{{"exposure": [{10**400}, 3]}}') == Metadata()
    assert from_text('{"exposure": [[1], 5], "gain": ["a", 2], "temperature": {}}') == Metadata()
    assert from_text("Exposure (ms): 125\nSensor temperature [C]: -7,5\n") == Metadata(-7.5, 0.125)
    assert from_text('{"Exposure [us]": 50, "Temperature (K)": 250}') == Metadata(
        pytest.approx(-23.15), pytest.approx(5e-5)
    )


def test_tiff_description_and_exif_tag(tmp_path):
    tif(tmp_path / "a.tif", description='{"temperature_c": 25.0}',
        extratags=[(33434, 5, 1, (1, 20), True)])  # fmt: skip
    assert only_point(load(tmp_path)) == OperatingPoint(25.0, 0.05)


def test_bias_frames_have_exposure_zero_and_light_frames_are_left_out(tmp_path):
    fits_file(tmp_path / "a.fits", IMAGETYP="Bias Frame", CCD_TEMP=-10.0)
    fits_file(tmp_path / "b.fits", IMAGETYP="Light Frame", EXPTIME=5.0)
    captures = load(tmp_path)
    assert only_point(captures) == OperatingPoint(-10.0, 0.0)
    assert captures.notes == ("1 files are left out: its header says light frame.",)
    (tmp_path / "a.fits").unlink()
    with pytest.raises(InputError, match="no dark frames; its header says light frame"):
        load(tmp_path)
    assert image_type({"IMAGETYP": "Dark Frame"}) == "dark"


def test_manifest_yaml_globs_and_frame_order(tmp_path):
    for k in range(3):
        tif(tmp_path / f"d{k}.tif", k)
    (tmp_path / "manifest.yaml").write_text(
        "- {file: d0.tif, frame: 2}\n- {file: d1.tif, frame: 1}\n- {file: 'd*.tif', gain: 2}\n"
    )
    (setting,) = load(tmp_path).settings
    assert setting.point.gain == 2.0
    assert [f.name for f in setting.frames] == ["d1.tif", "d0.tif", "d2.tif"]


def test_files_beside_the_manifest_are_left_out_and_said(tmp_path):
    tif(tmp_path / "a.tif")
    tif(tmp_path / "b.tif")
    (tmp_path / "manifest.csv").write_text("file;temperature_c\na.tif;25\n")
    captures = load(tmp_path)
    assert captures.frame_count == 1
    assert captures.notes == ("1 files that the manifest does not name are left out.",)
    assert load(tmp_path / "manifest.csv").frame_count == 1
    # a file named by itself is wanted, whatever the manifest says
    assert only_point(load(tmp_path / "b.tif")) == OperatingPoint()
    assert only_point(load(tmp_path / "a.tif")) == OperatingPoint(25.0)


def test_skip_and_tolerance_of_the_sidecar(tmp_path):
    for t in (20, 22, 24):
        tif(tmp_path / f"T+0{t}C" / "a.tif", seed=t)
    tif(tmp_path / "bad" / "x.tif")
    sidecar = tmp_path.parent / "side.yaml"
    sidecar.write_text("skip: ['bad/*']\ntolerance_c: 4\n")
    captures = load(tmp_path, config=sidecar)
    assert [len(s.frames) for s in captures.settings] == [3]
    assert captures.source.tolerance_c == 4.0
    assert len(load(tmp_path, config=sidecar, tolerance_c=2.0).settings) == 2
    assert len(load(tmp_path, config=sidecar, tolerance_c=1.0).settings) == 3


def test_a_name_that_contradicts_the_header_is_told(tmp_path):
    for k, exposure in enumerate((30.0, 30.0, 10.2)):
        name = f"dark_{k}_10s_-10C.fits"
        fits_file(tmp_path / name, EXPTIME=exposure, CCD_TEMP=-9.1, IMAGETYP="Dark")
    captures = load(tmp_path)
    (note,) = (n for n in captures.notes if "the name says" in n)
    assert note.startswith(
        "dark_0_10s_-10C.fits and 1 more: the name says 10s, the header EXPTIME 30.0; the header"
    )
    assert {s.point.exposure_s for s in captures.settings} == {30.0, 10.2}


def test_a_number_without_unit_in_a_name_contradicts_nothing(tmp_path):
    fits_file(tmp_path / "expos1_t20.fits", EXPTIME=30.0, CCD_TEMP=-10.0)
    fits_file(tmp_path / "bias_1s.fits", EXPTIME=0.0, CCD_TEMP=-10.0, IMAGETYP="Bias")
    assert not [n for n in load(tmp_path).notes if "the name says" in n]


def test_two_thermometers_of_one_sensor_that_differ_are_told():
    said = from_header({"CCD-TEMP": -10.0, "DET-TEMP": 20.0})
    assert said.temperature_c == -10.0
    (doubt,) = said.doubts
    assert doubt.text == "DET-TEMP = 20.0 contradicts CCD-TEMP, which is used: -10 C"
    assert not from_header({"CCD-TEMP": -10.0, "DET-TEMP": -8.5, "AMBTEMP": 20.0}).doubts
