"""One view at one or all operating points: its area, controls and standard error."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.classifier import training
from dnanalyze.classifier.cells import Judged, Pool, pools
from dnanalyze.classifier.curve import EXCHANGED, Area
from dnanalyze.classifier.views import VIEWS, Cuts
from dnanalyze.loaders.captures import OperatingPoint


def judged(setting, influence, controls, view=VIEWS[0], value=0.6):
    point = OperatingPoint(20.0 + setting, 0.1)
    cuts = Cuts((16, 16), influence.shape, {}, {})
    tested = training.Tested(Area(value, influence), {})
    return Judged(setting, point, view, cuts, 1.0, {}, {}, tested, tuple(controls))


def test_each_operating_point_then_each_view_of_several():
    rng = np.random.default_rng(1)
    one, two = (judged(n, rng.normal(size=(4, 4)), [0.5]) for n in (0, 1))
    other = judged(0, rng.normal(size=(4, 4)), [0.5], VIEWS[1])
    assert [p.parts for p in pools([one, two, other])] == [(one,), (two,), (other,), (one, two)]


def test_independent_operating_points_together_have_half_the_variance():
    rng = np.random.default_rng(2)
    maps = rng.normal(0.0, 1e-3, (2, 64, 64))
    alone, other = (judged(n, m, [0.5]) for n, m in enumerate(maps))
    together = Pool((alone, other)).se
    expected = np.sqrt(EXCHANGED * 64 * 64 / 2) * 1e-3
    # by rows and by columns of 64 each the variance is known to sqrt(2 / 64)
    assert together == pytest.approx(expected, rel=0.3)
    assert Pool((alone,)).se == pytest.approx(np.sqrt(2) * expected, rel=0.3)


def test_the_same_places_at_both_have_the_error_of_one():
    influence = np.random.default_rng(3).normal(0.0, 1e-3, (8, 8))
    pair = [judged(n, influence, [0.5]) for n in (0, 1)]
    assert Pool(tuple(pair)).se == pytest.approx(Pool((pair[0],)).se)


def test_controls_that_scatter_more_than_the_places_are_the_error():
    calm = np.zeros((4, 4))
    controls = [0.4, 0.5, 0.6]
    alone = Pool((judged(0, calm, controls),))
    assert alone.se == pytest.approx(0.1 * np.sqrt(4 / 3))
    both = Pool((judged(0, calm, controls), judged(1, calm, [0.6, 0.5, 0.4, 0.9])))
    assert both.controls == pytest.approx((0.5, 0.5, 0.5))
    assert both.se == pytest.approx(0.0, abs=1e-12)
