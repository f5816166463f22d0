"""Each test of the detection has its figure, drawn from what was kept."""

from __future__ import annotations

import hidden_filters as hidden
import pytest
from virtual_sensor import Traits, VirtualSensor, captures

from dnanalyze.detection import detect
from dnanalyze.report.figures import filter_tests

PICTURES = {
    filter_tests.smoothing: (
        "spectral corner", "crosstalk or denoise", "median equality", "rank exceedance",
        "local variance", "wavelet kurtosis",
    ),
    filter_tests.corrections: (
        "cap to neighbours", "dynamic threshold", "ratio rule", "ratio and threshold",
        "static replacement", "row phase",
    ),
    filter_tests.remembering: ("temporal autocorrelation", "as a recursive memory"),
}  # fmt: skip


def _text(made):
    return "".join(panel.svg for panel in made.panels)


@pytest.fixture(scope="module")
def corrected():
    traits = Traits(gain=1.2, hot=5e-3)
    return detect(captures(VirtualSensor(traits, (128, 128), 2), (25.0, 65.0), 6, hidden.clamp()))


@pytest.mark.parametrize("draw", PICTURES)
def test_every_test_is_drawn(corrected, draw):
    made = draw(corrected.answers)
    assert made is not None
    for name in PICTURES[draw]:
        assert f">{name}<" in _text(made)
    assert "not asked" not in _text(made)
    assert made.caption


def test_all_findings_have_a_picture(corrected):
    names = {name.replace(" ", "_") for some in PICTURES.values() for name in some}
    assert {f.test for f in corrected.findings} <= names


def test_flags_show(corrected):
    assert ">flagged<" in _text(filter_tests.corrections(corrected.answers))
    assert ">flagged<" not in _text(filter_tests.remembering(corrected.answers))


def test_what_one_frame_does_not_tell_is_said():
    single = detect(captures(VirtualSensor(Traits(gain=1.2), (96, 96), 2), (25.0,), 1))
    assert filter_tests.remembering(single.answers) is None
    assert filter_tests.corrections(single.answers).svg.count("not asked of these frames") >= 2
