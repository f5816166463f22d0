import numpy as np
import pytest
from readout_bench import POINT, Given, added

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.defect_lines import DefectLines

SIZE = (60, 80)


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


@pytest.mark.parametrize("axis", ["columns", "rows"])
def test_named_lines_are_where_they_were_measured(axis):
    d = added(DefectLines(sigma=3.0, axis=axis, lines=(7, 20, 900), offsets=(1, -2, 1)), shape=SIZE)
    line = d[0, 0] if axis == "columns" else d[0, :, 0]
    assert set(np.flatnonzero(line)) == {7, 20}
    assert line[20] / line[7] == pytest.approx(-2.0)
    assert line[7] == pytest.approx(3.0 / np.sqrt(2.0))


def test_lines_without_offsets_are_refused():
    with pytest.raises(InputError, match=r"defect_lines\.offsets: 0 numbers for 1 lines"):
        DefectLines(lines=(3,))


def test_guess_names_the_lines_that_stand_out_of_a_profile():
    rng = np.random.default_rng(6)
    profile = 0.1 * rng.standard_normal(256)
    profile[[17, 200]] += (4.0, -2.0)
    seen = Given(off={"row_outliers": 9.0}, profiles={"rows": [profile]})
    (effect,) = DefectLines.guess(seen)
    assert (effect.axis, effect.lines) == ("rows", (17, 200))
    # an offset is known to the scatter of a line and of the median of its neighbours, .13 DN
    assert effect.sigma == pytest.approx(np.sqrt(10.0), abs=0.5)
    assert effect.offsets[0] / effect.offsets[1] == pytest.approx(-2.0, rel=0.3)
    assert "fraction" in effect.idle()
    assert effect.variance(POINT) is None
