import numpy as np
import pytest

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.worst import worst_view

POINTS = OperatingPoint(25.0, 0.1), OperatingPoint(65.0, 0.1)


def _captures(frames=4):
    def setting(point):
        made = tuple(Frame("f", point, lambda _: np.zeros((4, 4))) for _ in range(frames))
        return Setting(point, made)

    return CaptureSet("made", Sensor((4, 4)), tuple(setting(p) for p in POINTS))


def _row(name, family, z, point):
    keys = ("temperature_c", "exposure_s", "gain", "channel")
    return {"name": name, "family": family, "discrepancy": z} | {k: getattr(point, k) for k in keys}


@pytest.mark.parametrize(
    ("name", "family", "kind"),
    [
        ("pattern_columns_0.1_0.3", "spectrum", "mean"),
        ("temporal_r1", "time", "temporal noise"),
        ("noise_at_90", "time", "temporal noise"),
        ("shading_0_1", "shading", "mean"),
        ("column_periodic_2", "lines", "mean"),
        ("temporal_row_noise", "lines", "temporal noise"),
        ("hot_count_5", "tails", "frame"),
    ],
)
def test_the_image_is_of_the_kind_in_which_the_statistic_shows(name, family, kind):
    rows = [
        _row(name, family, -30.0, POINTS[1]),
        _row("frame_kurtosis", "distribution", 9.0, POINTS[0]),
    ]
    assert worst_view(rows, _captures()) == View(1, kind)
    assert worst_view(rows, _captures(frames=1)) == View(1, "frame")


def test_codes_and_levels_have_no_image_and_named_statistics_come_first():
    rows = [
        _row("lattice", "codes", 90.0, POINTS[1]),
        _row("mean", "level", 80.0, POINTS[1]),
        _row("temporal_r1", "time", 7.0, POINTS[1]),
        _row("pattern_columns_0.1_0.3", "spectrum", 5.0, POINTS[0]),
    ]
    assert worst_view(rows, _captures()) == View(1, "temporal noise")
    assert worst_view(rows, _captures(), ["pattern_columns_0.1_0.3"]) == View(0, "mean")
    assert worst_view(rows[:2], _captures()) is None
