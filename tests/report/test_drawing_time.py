"""The time that a report takes is foreseen from one panel."""

from itertools import accumulate

import pytest

from dnanalyze.report import drawing_time


def test_it_is_that_of_the_slowest_panel_times_their_number(monkeypatch):
    ticks = accumulate([0.0, 0.1, 1.0, 0.3, 1.0, 0.2])
    monkeypatch.setattr(drawing_time, "monotonic", lambda: next(ticks))
    assert drawing_time.drawing_time() == pytest.approx(drawing_time.PANELS * 0.3)
