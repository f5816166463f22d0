"""The figure whose axes change with what is shown."""

import numpy as np
import pytest

pytest.importorskip("panel")

from bokeh.document import Document

from dnanalyze.workbench.curves import Axes, Curve
from dnanalyze.workbench.page.plot import CurvePlot
from dnanalyze.workbench.page.style import LIGHT

X = np.arange(1.0, 6.0)
SPECTRUM = Axes("frequency", "power", True, True)
POINTS = Axes("operating point", "noise", False, False)
LABELS = ["15 C", "35 C", "55 C", "75 C", "95 C"]


@pytest.fixture
def plot():
    made = CurvePlot(LIGHT)
    made.document = Document()
    made.document.add_root(made.figure)
    return made


def curve(middle):
    """The same ends, so that the ranges of the axes are the same."""
    y = X.copy()
    y[2] *= middle
    return Curve(X, y, 0.9 * X, 1.1 * X)


@pytest.mark.parametrize(("axes", "labels"), [(SPECTRUM, []), (POINTS, LABELS)])
def test_a_move_of_a_slider_changes_the_data_of_one_curve_alone(plot, axes, labels):
    plot.show(axes, labels, {"measured": curve(1.0), "present model": curve(1.0)}, "s")
    events = []
    plot.document.on_change(events.append)
    plot.show(axes, labels, {"measured": curve(1.0), "present model": curve(1.02)}, "s")
    assert [e.model.name for e in events] == ["curve of present model"]


def test_the_error_bars_over_operating_points_are_within_the_figure(plot):
    plot.show(POINTS, LABELS, {"measured": curve(1.0)}, "points")
    y = plot.figure.y_range
    assert y.start < 0.9 * X[0]
    assert y.end > 1.1 * X[-1]


def test_axes_change_with_the_statistic_and_come_back(plot):
    def axes():
        x, y = plot.figure.xaxis[0], plot.figure.yaxis[0]
        scales = plot.figure.x_scale, plot.figure.y_scale
        return [type(a).__name__ for a in (*scales, x.ticker, y.ticker, x.formatter)]

    plot.show(SPECTRUM, [], {"measured": curve(1.0)}, "spectrum")
    first = axes()
    assert first[:4] == ["LogScale", "LogScale", "CustomJSTicker", "CustomJSTicker"]
    plot.show(POINTS, LABELS, {"measured": curve(1.0)}, "points")
    assert axes()[:4] == ["LinearScale", "LinearScale", "FixedTicker", "BasicTicker"]
    assert list(plot.figure.xaxis[0].major_label_overrides) == [0, 1, 2, 3, 4]
    plot.show(SPECTRUM, [], {"measured": curve(1.0)}, "spectrum")
    assert axes() == first
    assert not plot.figure.xaxis[0].major_label_overrides
