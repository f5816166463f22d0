"""Copies and constant frames: a line that says so, exit 0 or 2, and reports that are whole."""

import json

import numpy as np
import pytest
from dnanalyze_cli.main import main

SHAPE = (48, 64)


def folder(root, **frames):
    for name, frame in frames.items():
        np.save(root / f"{name}.npy", frame)
    return root


def noise(seed):
    return np.random.default_rng(seed).normal(100.0, 5.0, SHAPE).round().astype(np.uint16)


@pytest.mark.parametrize("command", ["inspect", "analyze"])
def test_a_copy_is_told_in_one_line_and_breaks_no_report(command, tmp_path, capsys):
    captures = tmp_path / "captures"
    captures.mkdir()
    folder(captures, T25C_exp_1s_a=noise(0), T25C_exp_1s_b=noise(0))
    out = [f"--json={tmp_path / 'o.json'}", f"--report={tmp_path / 'o.html'}"]
    assert main([command, str(captures), *out]) == 0
    told = [line for line in capsys.readouterr().err.splitlines() if "same pixels" in line]
    (line,) = told
    assert line.startswith("note: T25C_exp_1s_b.npy has the same pixels as T25C_exp_1s_a.npy")
    assert "identical frames count once" in (tmp_path / "o.html").read_text()
    assert json.loads((tmp_path / "o.json").read_text())["schema"].startswith("dnanalyze/")


def test_constant_frames_are_refused_in_one_line(tmp_path, capsys):
    same = np.full(SHAPE, 7, np.uint16)
    folder(tmp_path, T25C_exp_1s_a=same, T25C_exp_1s_b=same, T45C_exp_1s_a=same)
    for command in ("inspect", "analyze", "detect"):
        assert main([command, str(tmp_path)]) == 2
        shown = capsys.readouterr().err
        assert shown.count("\n") == 1
        assert "T25C_exp_1s_a.npy: all pixels equal 7" in shown
