import csv
import json

import numpy as np
import pytest
import tifffile
from demo_stacks import CALM

from dnanalyze.demo import generate, truth, write_folder
from dnanalyze.errors import InputError


def test_folder_holds_the_frames_the_manifest_and_not_the_truth(tmp_path):
    captures = generate(CALM, {"column_fpn": "strong"}, (32, 48), (25, 45.5, -10), 2)
    path = write_folder(captures, tmp_path / "made", truth(CALM, {"column_fpn": "strong"}))
    assert sorted(p.name for p in path.iterdir()) == [
        "T+025C",
        "T+045.5C",
        "T-010C",
        "manifest.csv",
    ]
    with (path / "manifest.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [r["file"] for r in rows] == [f.name for f in captures.frames()]
    for row, frame in zip(rows, captures.frames(), strict=True):
        assert float(row["temperature_c"]) == frame.point.temperature_c
        assert float(row["exposure_s"]) == CALM.exposure_s
        read = tifffile.imread(path / row["file"])
        assert read.dtype == np.uint16
        np.testing.assert_array_equal(read, frame.read())
    told = json.loads((tmp_path / "made.truth.json").read_text())
    e = told["added_to_an_ordinary_sensor"]["column_fpn"]["e"]
    assert e == pytest.approx(0.6 * CALM.noise_e)


def test_an_existing_folder_is_left_alone(tmp_path):
    (tmp_path / "made").mkdir()
    with pytest.raises(InputError, match="exists"):
        write_folder(generate(CALM, shape=(16, 16), frames=1), tmp_path / "made")


def test_nothing_is_left_half_written(tmp_path, monkeypatch):
    def fail(*args, **kwargs):
        raise OSError("disk full")

    monkeypatch.setattr(tifffile, "imwrite", fail)
    with pytest.raises(OSError, match="disk full"):
        write_folder(generate(CALM, shape=(16, 16), frames=1), tmp_path / "made")
    assert list(tmp_path.iterdir()) == []
