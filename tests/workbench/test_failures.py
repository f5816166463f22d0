"""The table of statistics that fail: what a click on a cell says."""

import pytest

from dnanalyze.loaders.captures import OperatingPoint

pytest.importorskip("panel")

from dnanalyze.workbench.page.failures import _key, legend_of
from dnanalyze.workbench.page.style import LIGHT


def _row(name, plane="", **point):
    there = OperatingPoint(**point)
    keys = ("temperature_c", "exposure_s", "gain", "channel")
    return {"name": name, "plane": plane} | {k: getattr(there, k) for k in keys}


def test_a_cell_names_its_statistic_and_place():
    one = {"temperature_c": 25.0, "exposure_s": 0.1}
    rows = [
        _row("mean", **one),
        _row("median", **one),
        _row("mean", "r", **one),
        _row("mean", temperature_c=25.0, exposure_s=0.2),
        _row("mean", temperature_c=45.0, exposure_s=0.1),
        _row("mean", channel="low", **one),
        _row("mean", gain=2.0, **one),
    ]
    assert len({_key(r) for r in rows}) == len(rows)
    assert _key(rows[0]) == _key(_row("mean", **one))


def test_marks_that_are_not_there_have_no_legend():
    assert legend_of("Wang 2025 model", {}, LIGHT) == ""
    assert "Wang 2025 model" in legend_of("Wang 2025 model", {"codes": 2.0}, LIGHT)
