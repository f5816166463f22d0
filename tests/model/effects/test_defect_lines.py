import numpy as np
import pytest
from readout_bench import POINT, Given, added

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.defect_lines import DefectLines


@pytest.mark.parametrize("axis", ["columns", "rows"])
def test_a_few_whole_lines_are_off_by_the_stated_rms(axis):
    d = added(DefectLines(0.05, 4.0, axis), shape=(200, 200))
    line = d[0, 0] if axis == "columns" else d[0, :, 0]
    full = line[None, None, :] if axis == "columns" else line[None, :, None]
    np.testing.assert_allclose(d, np.broadcast_to(full, d.shape), atol=1e-4)
    bad = np.abs(line) > 1e-3
    assert bad.sum() == 10
    assert np.sqrt(np.mean(line[bad] ** 2)) == pytest.approx(4.0, rel=1e-4)
    assert np.mean(line**2) == pytest.approx(DefectLines(0.05, 4.0).variance(POINT), rel=1e-4)


def test_none_where_the_share_is_less_than_half_a_line():
    assert np.abs(added(DefectLines(0.001, 4.0), shape=(50, 200))).max() == 0


def test_a_greater_share_keeps_the_lines_that_were_bad():
    few, many = (np.abs(added(DefectLines(f), shape=(4, 400))[0, 0]) > 1e-3 for f in (0.01, 0.05))
    assert np.all(many[few])


def test_follows_gain_but_not_temperature():
    plain = added(DefectLines(0.02, 2.0))
    loud = added(DefectLines(0.02, 2.0), point=OperatingPoint(85.0, 9.0, 2.0))
    np.testing.assert_allclose(loud, 2 * plain, atol=1e-4)


def test_guess_from_outlying_lines():
    clues = Given(
        seen={"column_outliers": 4.0, "column_extreme": 40.0},
        model={"column_outliers": 0.0, "pattern_columns_0.3_0.5": 0.04 * 256},
        off={"column_outliers": 6.0},
    )
    (effect,) = DefectLines.guess(clues)
    assert effect.axis == "columns"
    assert effect.fraction == pytest.approx(4 / 256)
    assert 2.0 < effect.sigma < 8.0
    assert DefectLines.guess(Given()) == []
