import numpy as np
import pytest
from readout_bench import POINT, Given, added, frames

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effects.defect_lines import DefectLines
from dnanalyze.model.effects.read_noise import ReadNoise

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


@pytest.mark.parametrize("axis", ["columns", "rows"])
def test_a_line_may_be_off_along_a_part_of_it(axis):
    lines = DefectLines(0.01, 3.0, axis, (7, 20), (1, 1), begins=(10, 0), ends=(50, 60))
    d = added(lines, shape=SIZE)[0]
    d = d if axis == "columns" else d.T
    np.testing.assert_allclose(d[10:50, 7], 3.0, atol=1e-4)
    assert not d[:10, 7].any()
    assert not d[50:, 7].any()
    np.testing.assert_allclose(d[:60, 20], 3.0, atol=1e-4)
    assert set(np.flatnonzero(d.any(axis=0))) == {7, 20}


def test_parts_of_lines_are_the_same_in_any_window():
    lines = DefectLines(0.01, 3.0, lines=(7, 20), offsets=(1, -2), begins=(10, 0), ends=(50, 60))
    window = Window(8, 40, 4, 30)
    whole, part = (frames(ReadNoise(1.0), lines, shape=SIZE, window=w) for w in (None, window))
    np.testing.assert_array_equal(whole[:, 8:40, 4:30], part)


@pytest.mark.parametrize("name", ["begins", "ends"])
def test_parts_of_other_lines_than_named_are_refused(name):
    with pytest.raises(InputError, match=rf"defect_lines\.{name}: 2 numbers for 1 lines"):
        DefectLines(lines=(3,), offsets=(1.0,), **{name: (1.0, 2.0)})


def test_guess_names_the_lines_that_stand_out():
    seen = Given(standing_out={"rows": [(17, 4.0, 0, 256), (200, -2.0, 0, 256)]})
    (effect,) = DefectLines.guess(seen)
    assert (effect.axis, effect.lines) == ("rows", (17, 200))
    assert effect.sigma == pytest.approx(np.sqrt(10.0))
    assert effect.offsets[0] / effect.offsets[1] == pytest.approx(-2.0, rel=1e-3)
    assert effect.begins == effect.ends == ()
    assert "fraction" in effect.inactive_parameters()
    assert effect.variance(POINT) is None


def test_lines_that_stand_out_by_nothing_are_not_named():
    assert DefectLines.guess(Given(standing_out={"rows": [(17, 0.0, 0, 256)]})) == []


def test_guess_says_along_which_part_a_line_is_off():
    (effect,) = DefectLines.guess(Given(standing_out={"columns": [(17, 4.0, 100, 256)]}))
    assert (effect.axis, effect.begins, effect.ends) == ("columns", (100.0,), (256.0,))
