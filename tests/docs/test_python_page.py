"""The lines of the page on Python run one after another, as a reader pastes them."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from dnanalyze.demo import tiny

PAGE = Path(__file__).resolve().parents[2] / "docs" / "python.md"


@pytest.mark.slow
def test_every_block_runs(tmp_path, monkeypatch, capsys):
    tiny().save(tmp_path / "captures")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in re.findall(
        r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S
    ):
        exec(compile(block, PAGE.name, "exec"), names)
    plt.close("all")
    assert "DN" in capsys.readouterr().out
    assert (tmp_path / "model.yaml").exists()
    assert (tmp_path / "simulated" / "manifest.csv").exists()
    assert names["frames"].shape == (3, 64, 64)
    assert names["noisy"].mean() > 200.0
