"""Ticks and labels of logarithmic axes, as a browser computes them."""

from __future__ import annotations

import re

import pytest

pytest.importorskip("panel", reason="the extra workbench is not installed")


@pytest.mark.parametrize(
    "ends", [(0.0188, 0.566), (0.31, 0.42), (0.4001, 0.4002), (80, 1500), (3e-7, 0.2), (2, 9e7)]
)
def test_labels_of_a_logarithmic_axis_are_the_values_of_its_ticks(browser, ends):
    from dnanalyze.workbench.page.log_axis import LABEL, TICKS

    run = """([ticks, label, start, end]) => new Function("cb_data", ticks)({start, end})
      .map((t) => [t, new Function("tick", label)(t)])"""
    page = browser.new_page()
    found = page.evaluate(run, [TICKS, LABEL, *ends])
    between = page.evaluate(run, [TICKS, LABEL, -0.5, 4.5])
    page.close()
    assert between == []  # of a range of the axis before, as that changes
    assert 2 <= len(found) <= 9
    plain = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    for tick, label in found:
        power = re.fullmatch("(?:([0-9.]+)·)?10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", label)
        said = float(label if power is None else f"{power[1] or 1}e{power[2].translate(plain)}")
        assert ends[0] <= tick <= ends[1]
        assert said == pytest.approx(tick, rel=1e-6)
