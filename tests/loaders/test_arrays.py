"""Frames from memory: the same as from files, and refused by name where they cannot be."""

from __future__ import annotations

import numpy as np
import pytest
from astropy.io import fits
from astropy.nddata import CCDData

import dnanalyze
from dnanalyze import InputError, OperatingPoint, Window

COLD, WARM = OperatingPoint(5.0, 0.1), OperatingPoint(25.0, 0.1)


@pytest.fixture
def stack():
    return np.random.default_rng(1).normal(100.0, 3.0, (5, 64, 48)).round().astype(np.uint16)


def test_stacks_and_single_frames_become_settings_in_order(stack):
    found = dnanalyze.from_arrays({WARM: stack, COLD: stack[0] + 1}, bits=12, system_gain=0.5)
    assert [(s.point, len(s.frames)) for s in found.settings] == [(COLD, 1), (WARM, 5)]
    assert (found.sensor.bits, found.sensor.system_gain_dn_e) == (12, 0.5)
    np.testing.assert_array_equal(found.settings[1].frames[2].read(), stack[2])
    part = found.settings[1].frames[2].read(Window(4, 20, 8, 30))
    np.testing.assert_array_equal(part, stack[2, 4:20, 8:30])
    assert part.flags.c_contiguous


def test_statistics_are_those_of_the_files(stack, tmp_path):
    found = dnanalyze.from_arrays({WARM: stack}, bits=12)
    read = dnanalyze.load(found.save(tmp_path / "darks", "npy"))
    one, two = (dnanalyze.analyze(c)["temporal_noise"]["value"][0] for c in (found, read))
    assert one == two == pytest.approx(np.sqrt(stack.var(axis=0, ddof=1).mean()), rel=0.02)
    np.testing.assert_array_equal(next(iter(read.to_numpy().values())), stack)


def test_frames_with_a_header_state_their_operating_point(stack):
    header = fits.Header({"EXPTIME": 0.1, "CCD-TEMP": 25.0})
    frames = [CCDData(frame.astype(np.float32), unit="adu", header=header) for frame in stack]
    (setting,) = dnanalyze.from_arrays(frames).settings
    assert setting.point == WARM
    np.testing.assert_array_equal(setting.frames[1].read(), stack[1])


def test_big_endian_and_float_frames_are_read_in_native_order(stack):
    found = dnanalyze.from_arrays({WARM: stack.astype(">f8")})
    assert found.settings[0].frames[0].read().dtype == np.float32


def test_identical_frames_count_once(stack):
    found = dnanalyze.from_arrays({WARM: np.concatenate((stack, stack[:1]))})
    assert found.frame_count == 5
    assert found.notes


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        ({}, "0 frames"),
        ({WARM: [np.zeros((64, 48)), np.zeros((64, 47))]}, "need one shape"),
        ({WARM: np.zeros((2, 8, 8))}, "too few to analyse"),
        ({WARM: np.array([["a"]])}, "integers or floats"),
        ({"warm": np.zeros((64, 48))}, "no OperatingPoint"),
        ([np.zeros((64, 48))], "no header"),
        ({WARM: np.ma.masked_equal(np.eye(64), 1)}, "masked pixels"),
    ],
)
def test_what_cannot_be_taken_is_named(frames, words):
    with pytest.raises(InputError, match=words):
        dnanalyze.from_arrays(frames)


def test_several_files_are_loaded_as_a_folder_is(stack, tmp_path):
    folder = dnanalyze.from_arrays({WARM: stack}).save(tmp_path / "darks", "fits")
    files = sorted(folder.rglob("*.fits"))
    assert dnanalyze.load(files[:3]).frame_count == 3
    assert dnanalyze.load(map(str, files)).settings[0].point == WARM

    class Collection:
        def files_filtered(self, *, include_path):
            return files if include_path else [f.name for f in files]

    assert dnanalyze.load(Collection()).frame_count == 5
    for wrong, words in (([], "no files"), ([folder / "nothing.fits"], "no such file")):
        with pytest.raises(InputError, match=words):
            dnanalyze.load(wrong)


def test_captures_show_themselves(stack):
    found = dnanalyze.from_arrays({WARM: stack}, name="<lab>")
    assert repr(found) == "<CaptureSet: <lab>, 5 frames of 64 x 48 at 1 operating point>"
    shown = found._repr_html_()
    assert "&lt;lab&gt;" in shown
    assert "<lab>" not in shown
    assert found.to_dataframe()["frames"].tolist() == [5]
