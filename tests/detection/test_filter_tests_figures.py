"""Each test of the detection has its figure, drawn from what was kept."""

from __future__ import annotations

import hidden_filters as hidden
import pytest
from virtual_sensor import Traits, VirtualSensor, captures

from dnanalyze.detection import detect
from dnanalyze.report.figures import filter_tests

PICTURES = {
    filter_tests.smoothing: (
        "Spectral corner", "Correlation of neighbours", "Equal neighbours", "Local extremes",
        "Local variance", "Wavelet kurtosis",
    ),
    filter_tests.corrections: (
        "Values capped at a neighbour", "Dynamic threshold", "Static replacement", "Some rows only",
    ),
    filter_tests.remembering: ("Correlation from frame to frame", "Equivalent recursive filter"),
}  # fmt: skip


def _text(made):
    return "".join(panel.svg for panel in made.panels)


@pytest.fixture(scope="module")
def corrected():
    traits = Traits(gain=1.2, hot=5e-3)
    return detect(captures(VirtualSensor(traits, (128, 128), 2), (25.0, 65.0), 6, hidden.clamp()))


@pytest.mark.parametrize("draw", PICTURES)
def test_every_test_is_drawn(corrected, draw):
    made = draw(corrected.findings)
    assert made is not None
    for name in PICTURES[draw]:
        assert f">{name}" in _text(made)
    assert made.caption


def test_flags_show(corrected):
    flagged, clean = (
        {key.label for key in draw(corrected.findings).legend}
        for draw in (filter_tests.corrections, filter_tests.remembering)
    )
    assert "flagged" in flagged
    assert "flagged" not in clean


def test_what_one_frame_does_not_determine_has_no_panel():
    single = detect(captures(VirtualSensor(Traits(gain=1.2), (96, 96), 2), (25.0,), 1))
    assert filter_tests.remembering(single.findings) is None
    assert "Static replacement" not in _text(filter_tests.corrections(single.findings))
