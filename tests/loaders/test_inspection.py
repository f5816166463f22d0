"""What inspect says, and what it says is missing."""

import json

import numpy as np
import pytest
from frame_files import noise

from dnanalyze.loaders import inspect, load


def folder(root, **files):
    for name, array in files.items():
        path = root / (name.replace("__", "/") + ".npy")
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, array)
    return load(root)


def test_plain_data_for_json(tmp_path):
    found = inspect(folder(tmp_path, T20C_exp_1s__a=noise(0), T20C_exp_1s__b=noise(1)))
    assert json.loads(json.dumps(found)) == found
    assert found["frames"] == 2
    assert found["format"] == "NumPy"
    assert found["dtype"] == "uint16"
    assert found["shape"] == [16, 20]
    assert found["tolerance_c"] == 1.5
    (point,) = found["operating_points"]
    assert point["temperature_span_c"] == [20.0, 20.0]
    assert point["frames"] == 2


def test_effective_bits_see_through_a_shift(tmp_path):
    shifted = np.random.default_rng(0).integers(0, 4096, (64, 64)).astype(np.uint16) << 4
    codes = inspect(folder(tmp_path, a=shifted))["codes"]
    assert codes["step"] == 16
    assert codes["effective_bits"] == 12


def test_floats_have_no_codes(tmp_path):
    codes = inspect(folder(tmp_path, a=noise().astype(np.float32) + 0.5))["codes"]
    assert codes["step"] is None
    assert codes["largest"] == noise().max() + 0.5


A, B, C = "T20C_exp_1s__a", "T40C_exp_1s__b", "T20C_exp_0s__a"


@pytest.mark.parametrize(
    ("names", "said", "unsaid"),
    [
        (["a"], ["single frame", "No temperature", "No exposure"], ["At most"]),
        (
            [A, "T20C_exp_1s__b"],
            ["At most 2 frames", "One temperature", "separated not at all"],
            ["single frame"],
        ),
        ([A, B], ["single frame", "by temperature alone"], ["One temperature"]),
        ([A, "T40C__b"], ["1 of 2 operating points have no exposure"], ["No exposure"]),
        ([C], ["Bias frames only"], ["One exposure"]),
        (
            [C, "T40C_exp_1s__a", B],
            ["A single frame at 1 of 2 operating points"],
            ["One exposure", "One temperature"],
        ),
    ],
)
def test_missing(tmp_path, names, said, unsaid):
    found = inspect(folder(tmp_path, **{n: noise(k) for k, n in enumerate(names)}))
    text = " ".join(found["missing"])
    assert all(s in text for s in said), text
    assert not any(s in text for s in unsaid), text


def test_where_each_quantity_was_taken_from(tmp_path):
    from dnanalyze.report.capture_facts import sources

    folder(tmp_path, T20C__a_1s=noise(0), T20C__b_2s=noise(1))
    (tmp_path / "manifest.csv").write_text("file,exposure_s\nT20C/a_1s.npy,3\nT20C/b_2s.npy,\n")
    captures = load(tmp_path)
    assert sources(inspect(captures)) == [
        ("temperature", "name", "T20C in T20C/a_1s.npy"),
        ("exposure", "manifest.csv, 1 frame", "T20C/a_1s.npy"),
        ("exposure", "name, 1 frame", "2s in T20C/b_2s.npy"),
    ]


def test_the_terminal_lists_the_sources(tmp_path):
    from dnanalyze.report.results.inspection import sections
    from dnanalyze.report.terminal import as_text, print_sections

    captures = folder(tmp_path, T20C__a_1s=noise(0), T20C__b_1s=noise(1))
    text = as_text(lambda console: print_sections(console, sections(captures, inspect(captures))))
    assert "temperature   name         T20C in T20C/a_1s.npy" in text
    assert len(text.splitlines()) < 40
