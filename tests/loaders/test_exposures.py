"""Exposures that are one operating point, and those that are several."""

import pytest
from frame_files import tif

from dnanalyze.loaders import load
from dnanalyze.loaders.exposures import states


def count(exposures, tolerance_s=None):
    return len(set(states(exposures, tolerance_s)))


@pytest.mark.parametrize(
    ("exposures", "points"),
    [
        ([60 + 0.001 * k for k in range(12)], 1),  # a clock's milliseconds
        ([0.0301, 0.0305, 0.0309], 1),  # measured, within 1 ms
        ([0.033, 0.0333] * 4, 1),  # rounded: 1 %
        ([0.010, 0.011, 0.012] * 2, 3),  # set, in steps of 1 ms
        ([0.0001, 0.0002, 0.0005], 3),  # short ones stay apart
        ([0.0, 0.0005, 0.0], 2),  # bias is no exposure
        ([1.0, 1.02, 1.04], 3),
        ([1.0, None, 1.0], 2),
        ([], 0),
    ],
)
def test_exposures_that_are_one(exposures, points):
    assert count(exposures) == points


def test_a_tolerance_replaces_the_rules():
    assert count([1.0, 1.5, 2.5], 0.5) == 2
    assert count([60.0, 60.001], 0.0) == 2


def test_a_folder_says_what_it_took_as_one(tmp_path):
    rows = [f"{k}.tif,{60 + 0.001 * k}" for k in range(4)]
    for k in range(4):
        tif(tmp_path / f"{k}.tif", k)
    (tmp_path / "manifest.csv").write_text("file,exposure_s\n" + "\n".join(rows))
    captures = load(tmp_path)
    (setting,) = captures.settings
    assert setting.point.exposure_s == pytest.approx(60.0015)
    assert [f.point.exposure_s for f in setting.frames] == [60.0, 60.001, 60.002, 60.003]
    assert "Exposures from 60 to 60.003 s are one operating point" in " ".join(captures.notes)
    (tmp_path / "dnanalyze.yaml").write_text("tolerance_s: 0\n")
    assert len(load(tmp_path).settings) == 4
