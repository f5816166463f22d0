"""Header values as cameras and their drivers write them: right, or with the doubt said."""

import pytest
from astropy.io import fits
from frame_files import noise

from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.headers import electrons_per_dn, from_header, image_type
from dnanalyze.loaders.units import SECONDS, read_number, unit_in


def doubts(metadata):
    return " ".join(d.text for d in metadata.doubts)


def write(folder, *headers):
    for k, cards in enumerate(headers):
        hdu = fits.PrimaryHDU(noise(k))
        for key, value in cards.items():
            hdu.header[key] = value
        hdu.writeto(folder / f"f{k}.fits")
    return load(folder)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0,5", 0.5), ("-9,8 C", -9.8), ("1/30 s", 1 / 30), ("1.5D+01", 15.0), ("\u221210", -10.0),
        (",25", 0.25), ("1,5e-3", 0.0015), (b"7.5", 7.5), ((1, 20), 0.05), (True, None),
        ("NaN", None), ("1,234.5", None), ("1/0", None), ("x", None), (1e999, None),
    ],
)  # fmt: skip
def test_numbers(text, value):
    reading = read_number(text)
    assert (reading and reading.value) == value


@pytest.mark.parametrize(
    ("comment", "seconds"),
    [
        ("Exposure time (ms)", 1e-3), ("[us] exposure", 1e-6), ("exposure in ms", 1e-3),
        ("in units of 10 us", 1e-5), ("exposure time, milliseconds", 1e-3), ("total [s]", 1.0),
        ("set by the user", None), ("time that the shutter is open", None),
    ],
)  # fmt: skip
def test_units_in_comments(comment, seconds):
    named = unit_in(comment, SECONDS)
    assert (named and named[0] * named[1]) == (seconds and pytest.approx(seconds))


def test_a_comma_before_three_digits_is_doubted():
    said = from_header({"EXPTIME": "1,250"})
    assert said.exposure_s == 1.25
    assert "may be 1250" in doubts(said)
    assert not from_header({"EXPTIME": "0,250"}).doubts


@pytest.mark.parametrize(
    ("cards", "seconds"),
    [
        ({"XPOSURE": 2.5}, 2.5), ({"EXPTIME": 250.0, "TIMEUNIT": "ms"}, 0.25),
        ({"EXPOSURE_MS": 20}, 0.02), ({"Exposure-ms": 20}, 0.02), ({"EXP_TIME_US": 7}, 7e-6),
        ({"ExposureTime_us": "20000"}, 0.02), ({"EXPTIME": 0.0, "DARKTIME": 300.0}, 300.0),
        ({"EXPOINUS": 250000}, 0.25), ({"DARKTIME": 300.0}, 300.0),
        ({"EXPTIME": 5.0, "DARKTIME": 0.0}, 5.0),
    ],
)  # fmt: skip
def test_exposures(cards, seconds):
    assert from_header(cards).exposure_s == (seconds and pytest.approx(seconds))


@pytest.mark.parametrize(
    ("cards", "text"),
    [
        ({"EXPTIME": 0.0, "DARKTIME": 300.0}, "DARKTIME = 300.0 is the exposure"),
        ({"EXPTIME": 10.0, "DARKTIME": 300.0}, "DARKTIME = 300.0 differs"),
        ({"EXPOSURE": 250000}, "has no unit"),
        ({"EXPTIME": "long"}, "is no number"),
        ({"EXPTIME": 500, "EXPOSURE": 0.5}, "EXPOSURE = 0.5 contradicts EXPTIME"),
        (
            {
                "EXPTIME": 500,
                "DATE-OBS": "2024-01-01T00:00:00",
                "DATE-END": "2024-01-01T00:00:01.2",
            },
            "more than the 1.2 s from DATE-OBS to DATE-END",
        ),
        ({"CCD-TEMP": 180.2}, "is taken as kelvin, -92.95 C"),
        ({"SET-TEMP": -10}, "is the set point"),
        ({"AmbientTemperature": (50, 10)}, "is that of the air"),
        ({"CCD-TEMP": 21.5, "SET-TEMP": -10}, "31.5 C off the set point"),
        ({"CCD-TEMP": "NaN"}, "is no number"),
    ],
)
def test_what_is_ambiguous_is_said(cards, text):
    assert text in doubts(from_header(cards))


def test_ordinary_values_raise_no_doubt():
    said = from_header(
        {
            "CCD-TEMP": -9.8,
            "SET-TEMP": -10,
            "EXPTIME": 300.0,
            "EXPOSURE": 300.0,
            "DARKTIME": 300.5,
            "TIMEUNIT": "s",
            "DATE-OBS": "2024-01-01T00:00:00",
            "DATE-END": "2024-01-01T00:05:00",
        }
    )
    assert (said.temperature_c, said.exposure_s, said.doubts) == (-9.8, 300.0, ())
    assert said.taken["temperature_c"] == ("header CCD-TEMP", "-9.8")


@pytest.mark.parametrize(
    ("card", "comment", "celsius"),
    [
        (163.2, "CCD temperature (K)", -109.95), (163.2, "temperature in Kelvin", -109.95),
        ("263.15 K", "", -10.0), (50.0, "[degF]", 10.0), (300.0, "", 26.85), (65.0, "", 65.0),
        (105.0, "[C]", 105.0), (-273.0, "", None), (-273.15, "", None), (999.0, "", None),
        (0.0, "[K]", None), (-1000.0, "", None), (8.5, "ambient / focuser temperature", None),
    ],
)  # fmt: skip
def test_temperatures(card, comment, celsius):
    said = from_header({"TEMP": card}, {"TEMP": comment})
    assert said.temperature_c == (celsius and pytest.approx(celsius))
    assert celsius is not None or said.doubts


def test_a_warm_temperature_without_unit_is_doubted_in_fits():
    assert "in kelvin it would be -153.15" in doubts(from_header({"CCD-TEMP": 120.0}, {}))
    assert not from_header({"temperature_c": 105.0}).doubts


def test_names_that_drivers_extend():
    assert from_header({"Andor sCMOS Camera-SensorTemperature": "0.50"}).temperature_c == 0.5
    assert from_header({"ESO DET CHIP1 TEMP": 173.15}).temperature_c == pytest.approx(-100.0)
    assert from_header({"CCDTEMP1": 5.0}).temperature_c == 5.0
    assert from_header({"TEMP_CCD": 5.0}).temperature_c == 5.0
    assert from_header({"SensorTemperatureSetPoint": 1.0}).temperature_c is None


def test_gain_in_electrons_per_dn_is_inverted():
    comments = {"GAIN": "[e-/ADU] gain"}
    said = from_header({"GAIN": 18.69}, comments)
    assert said.gain == pytest.approx(1 / 18.69)
    assert "e-/DN" in doubts(said)
    assert electrons_per_dn({"GAIN": 2.0}, comments) == 2.0
    assert electrons_per_dn({"GAIN": 2.0}, {"GAIN": "camera gain"}) is None
    assert from_header({"GAIN": "12 dB"}).gain == pytest.approx(10**0.6)
    assert from_header({"GAIN": 120}, {"GAIN": "[0.1 dB]"}).gain == pytest.approx(10**0.6)
    assert from_header({"GAIN": 0, "INSTRUME": "ZWO ASI2600MM Pro"}).gain == 1.0


def test_several_gains_without_unit_are_doubted_or_told_by_egain(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    doubted = write(tmp_path / "a", {"GAIN": 100.0}, {"GAIN": 300.0})
    assert [s.point.gain for s in doubted.settings] == [100.0, 300.0]
    assert "100, 300 have no unit and are taken as linear factors" in " ".join(doubted.notes)
    told = write(tmp_path / "b", {"GAIN": 100.0, "EGAIN": 1.0}, {"GAIN": 300.0, "EGAIN": 0.1})
    assert [s.point.gain for s in told.settings] == [1.0, 10.0]
    assert "EGAIN" in " ".join(told.notes)


def test_two_gains_by_word_are_two_channels(tmp_path):
    assert write(tmp_path, {"GAIN": "High"}, {"GAIN": "Low"}).channels == ["High", "Low"]


def test_light_frames_of_all_drivers_are_left_out(tmp_path):
    assert image_type({"FRAME": "Light"}) == image_type({"FRAMETYP": "Light Frame"}) == "light"
    assert image_type({"ESO DPR TYPE": "OBJECT"}) == "light"
    assert image_type({"FRAME": 12}) == ""
    with pytest.raises(InputError, match="image_type: dark in the sidecar"):
        write(tmp_path, {"FRAME": "Light"})
    (tmp_path / "dnanalyze.yaml").write_text("image_type: dark\n")
    assert load(tmp_path).frame_count == 1


def test_sources_are_told_with_an_example(tmp_path):
    captures = write(tmp_path, {"CCD-TEMP": "-9,8", "EXPTIME": (250.0, "exposure (ms)")})
    told = {t.quantity: (t.source, t.example, t.file, t.frames) for t in captures.source.taken}
    assert told == {
        "temperature_c": ("header CCD-TEMP", "-9,8", "f0.fits", 1),
        "exposure_s": ("header EXPTIME", "250.0 / exposure (ms)", "f0.fits", 1),
    }
