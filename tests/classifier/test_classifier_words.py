"""The verdict in words."""

from types import SimpleNamespace

import pytest

from dnanalyze.classifier.result import Cell
from dnanalyze.classifier.words import sentence
from dnanalyze.loaders.captures import OperatingPoint

POINT = OperatingPoint(20.0, 0.1)


def result(*cells):
    told = [c for c in cells if c.tells]
    return SimpleNamespace(
        cells=cells, together=[], reason="", tells=bool(told), telling=[], best=(told or cells)[0]
    )


def cell(name, auc, half, control=0.5, confirmed=False):
    return Cell(POINT, "mean", name, auc, auc - half, auc + half, control, confirmed)


def test_areas_at_chance_say_that_the_frames_are_not_told():
    said = sentence(result(cell("mean frame", 0.46, 0.05), cell("tall strips", 0.53, 0.04)))
    assert said == (
        "A classifier cannot tell the simulated frames from the measured ones "
        "(AUC .46 to .53; control .50)."
    )


def test_an_area_below_chance_is_a_difference_that_is_reversed_over_the_field():
    told = cell("single frame", 0.53, 0.03), cell("tall strips", 0.22, 0.04, control=0.48)
    assert [c.reversed for c in told] == [False, True]
    said = sentence(result(*told))
    assert "(AUC .22 to .53; control .50). In the tall strips" in said
    assert "the AUC of .22 is below chance" in said
    assert said.endswith("differ from the model in opposite ways.")


@pytest.mark.parametrize(
    ("auc", "half", "control"),
    [(0.44, 0.07, 0.5), (0.46, 0.01, 0.5), (0.4, 0.02, 0.44), (0.4, 0.05, 0.41)],
    ids=["within its limits", "a patch in ten", "as its control", "above its control"],
)
def test_what_chance_or_the_control_shows_is_no_difference(auc, half, control):
    assert not cell("mean frame", auc, half, control).reversed
