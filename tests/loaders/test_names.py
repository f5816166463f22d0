"""What names say, and what they do not."""

import pytest

from dnanalyze.errors import InputError
from dnanalyze.loaders.names import from_folder, from_names, from_regex
from dnanalyze.loaders.recording import Metadata


@pytest.mark.parametrize(
    ("name", "temperature"),
    [
        ("T+065C", 65.0),
        ("T-010.5C", -10.5),
        ("T-10C", -10.0),
        ("65C", 65.0),
        ("t025", 25.0),
        ("m10C", -10.0),
        ("dark_253.15K", -20.0),
        ("dark_4K", None),
        ("dark_800K", None),
        ("dark_-230C_10s", -230.0),
        ("neg10C", -10.0),
        ("dark_-10C", -10.0),
        ("temp_25", 25.0),
        ("temp=-7.5", -7.5),
        ("temperature_40C_exp_1s", 40.0),
        ("25degC", 25.0),
        ("DARK_2x2_5.000secs_-7.00C00003216", -7.0),
        ("DARK_2x2_5.000secs_-8.2C00003222", -8.2),
        ("dark_0,5s_20,5C", 20.5),
        ("dark_1s_\u221210C", -10.0),
        ("dark \u221210 °C", -10.0),
        ("dark_25\u2103", 25.0),
        ("10C-5s", 10.0),
        ("dark_003_c", 3.0),
        # no temperatures
        ("20-25C", None),
        ("20C-25C", None),
        ("20..25C", None),
        ("20_to_25C", None),
        ("dark-65C", None),  # minus or dash: not guessed
        ("SN12C3456", None),
        ("00123C", None),
        ("IMG_0025", None),
        ("1C2D", None),
        ("t1", None),
        ("t10s", None),
        ("t2.5ms", None),
        ("20230525", None),
        ("frame_0065", None),
        ("C65", None),
        ("999C", None),
        ("12Cu", None),
        ("a65C", None),
        ("part025", None),
    ],
)
def test_temperature(name, temperature):
    assert from_names([name]).temperature_c == temperature


@pytest.mark.parametrize(
    ("name", "exposure"),
    [
        ("exp_0.05s", 0.05),
        ("exp10s_dc", 10.0),
        ("5.000secs", 5.0),
        ("darks-expos60s-Neg5-Vis.00000000.DARK", 60.0),
        ("darks-expos1-Neg5-Vis.00000003.DARK", 1.0),
        ("DARK_2x2_5.000secs_-7.00C00003216", 5.0),
        ("balanced_dark_1us-02", 1e-6),
        ("exposure_20ms", 0.02),
        ("exptime=0.5", 0.5),
        ("t10s", 10.0),
        ("0p05s", 0.05),
        ("dark_0,5s_20,5C", 0.5),
        ("dark_1e-3s", 1e-3),
        ("exp_2.5E-2s", 0.025),
        ("25C,5s", 5.0),
        ("dark_5min", 300.0),
        ("dark_2h_cold", 7200.0),
        ("dark_500usec", 5e-4),
        ("2024-01-05-10s", 10.0),
        # no exposures
        ("1-5s", None),
        ("1s..5s", None),
        ("0.1s-5s", None),
        ("gain1,5s", None),
        ("exp10", None),
        ("dark_001", None),
        ("10stops", None),
        ("sensors2", None),
        ("SN5s6", None),
        ("1.2.5s", None),
        ("rows", None),
        ("T+065C", None),
    ],
)
def test_exposure(name, exposure):
    found = from_names([name]).exposure_s
    assert found == (None if exposure is None else pytest.approx(exposure, rel=1e-12))


@pytest.mark.parametrize(
    ("name", "gain"),
    [
        ("gain4", 4.0),
        ("Gain_2.5x", 2.5),
        ("gain20dB", 10.0),
        ("ISO800", 800.0),
        ("iso_1600", 1600.0),
        ("again4", None),
        ("isotope99", None),
        ("gains", None),
        ("ISO8", None),
    ],
)
def test_gain(name, gain):
    assert from_names([name]).gain == gain


@pytest.mark.parametrize(
    ("name", "channel"),
    [("dark_HCG_001", "hcg"), ("lofic", "lofic"), ("long", "long"), ("long_exposure", None),
     ("along", None), ("shorts", None)],
)  # fmt: skip
def test_channel(name, channel):
    assert from_names([name]).channel == channel


def test_the_nearest_name_wins_field_by_field():
    found = from_names(["dark_exp_1s", "25C_exp_2s", "T+065C_gain4"])
    assert found == Metadata(25.0, 1.0, 4.0)


def test_regex_reads_named_groups():
    pattern = r"(?P<channel>[a-z]+)_(?P<temperature_c>-?\d+)K_(?P<frame>\d+)"
    assert from_regex(pattern, ["x/dark_300K_07.tif", "other.tif"]) == [
        Metadata(300.0, None, None, "dark", 7.0),
        Metadata(),
    ]
    with pytest.raises(InputError, match=r"a\.tif: name_regex takes gain from 'a'"):
        from_regex(r"(?P<gain>\w)\.tif", ["a.tif"])


def told(metadata):
    return " ".join(d.text for d in metadata.doubts)


def test_an_index_is_no_temperature_where_a_folder_says_one():
    series = from_folder([[f"dark_t{k:03d}", "25C_1s"] for k in range(3)])
    assert [m.temperature_c for m in series] == [25.0] * 3
    assert [m.frame for m in series] == [0.0, 1.0, 2.0]
    assert from_folder([["dark_t040", "25C"]])[0].temperature_c == 25.0
    assert from_folder([["dark_003_c", "25C"], ["dark_007_c", "25C"]])[1].temperature_c == 25.0


@pytest.mark.parametrize("name", ["dark_t{:02d}", "z{}_t{:03d}", "dark_{:03d}_c", "dark_{:03d}_s"])
def test_what_counts_up_by_one_is_an_index(name):
    found = from_folder([[name.format(k, k)] for k in (7, 8, 9)])
    assert [(m.temperature_c, m.exposure_s) for m in found] == [(None, None)] * 3
    assert [m.frame for m in found] == [7.0, 8.0, 9.0]


def test_what_does_not_count_is_a_temperature_with_its_doubt():
    found = from_folder([["dark_t025"], ["dark_t045"]])
    assert [m.temperature_c for m in found] == [25.0, 45.0]
    assert "'t025' in the name has no unit" in told(found[0])
    assert "is read as -3 C" in told(from_names(["m3c"]))
    assert not told(from_names(["m10C"]))
    assert not told(from_folder([["T+025C"], ["T+026C"]])[0])
    assert [m.temperature_c for m in from_folder([["T+025C"], ["T+026C"]])] == [25.0, 26.0]


def test_what_is_not_used_is_said_unless_the_folder_says_it():
    assert "is part of a range" in told(from_names(["20C_to_25C"]))
    assert "a minus or a dash" in told(from_names(["dark-10C"]))
    (found,) = from_folder([["dark_20-25C", "22C"]])
    assert (found.temperature_c, told(found)) == (22.0, "")


def test_what_was_taken_from_the_name_is_kept():
    taken = from_names(["dark_0,5s_20,5C_gain4_hcg"]).taken
    assert taken == {
        "temperature_c": ("name", "20,5C"), "exposure_s": ("name", "0,5s"),
        "gain": ("name", "gain4"), "channel": ("name", "hcg"),
    }  # fmt: skip


def test_two_numbers_that_may_be_one_are_told():
    (said,) = from_folder([["exp1_5s"]])
    assert said.exposure_s == 5.0
    assert "'5s' in the name, behind '1', is taken as 5 s" in said.doubts[0].text
    fractions = from_folder([["dark_1_30s_a"], ["dark_1_60s_b"]])
    assert [len(s.doubts) for s in fractions] == [1, 1]
    counted = from_folder([["dark_1_30s"], ["dark_2_30s"], ["2024-01-05_30s"], ["dark_01_30s"]])
    assert [(s.exposure_s, s.doubts) for s in counted] == [(30.0, ())] * 4
