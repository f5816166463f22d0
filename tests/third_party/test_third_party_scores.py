"""Scores of the truth suite: intervals and tests against known values, and what counts as right."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from third_party.score import (
    accepted,
    by_generator,
    detected_right,
    falsely_sure,
    hidden_only,
    mcnemar,
    paired,
    right,
    wilson,
)


def row(**more):
    """A case with nothing hidden and nothing added."""
    return {
        "key": "plain/a",
        "generator": "plain",
        "hides": [],
        "named": [],
        "first": None,
        "verdict": "adequate",
        "additions": [],
        "detected": "none",
        "error_before": 3.0,
        "error_after": 1.0,
        "seconds": 10.0,
        "catalogue": ["row_noise", "hot_pixels", "dpc", "column_fpn"],
    } | more


def named(*names, confidence=0.95, **more):
    """A case in which these were added."""
    additions = [[n, confidence] for n in names]
    return row(named=list(names), first=names[0], additions=additions, **more)


@pytest.mark.parametrize(
    ("count", "total", "low", "high"),
    [
        # Newcombe 1998, Statistics in Medicine 17, table I, method 3 (score, no correction)
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_wilson_interval_is_the_published_one(count, total, low, high):
    assert wilson(count, total) == pytest.approx((low, high), abs=6e-5)


def test_wilson_interval_of_nothing_is_everything():
    assert wilson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("gained", "lost", "p"),
    [(0, 0, 1.0), (5, 5, 1.0), (0, 5, 0.0625), (6, 0, 0.03125), (2, 10, 158 / 4096)],
)
def test_mcnemar_is_the_two_sided_binomial(gained, lost, p):
    assert mcnemar(gained, lost) == pytest.approx(p)
    assert mcnemar(lost, gained) == pytest.approx(p)


def test_an_ordinary_sensor_is_right_without_an_addition():
    assert right(row())
    assert not right(named("row_noise"))


def test_what_every_sensor_of_a_generator_has_is_neither_right_nor_false():
    both = named("dark_current_fpn", "row_noise", generator="pyxel", hides=["row_noise"])
    scored = hidden_only(both)
    assert (scored["named"], scored["first"]) == (["row_noise"], "row_noise")
    assert right(scored)
    assert right(hidden_only(named("dark_current_fpn", generator="pyxel")))
    assert not right(hidden_only(named("dark_current_fpn", generator="plain")))


def test_the_right_name_has_to_come_first():
    assert right(named("row_noise", hides=["row_noise"]))
    assert right(named("row_noise", "column_fpn", hides=["row_noise"]))
    assert not right(named("column_fpn", "row_noise", hides=["row_noise"]))


def test_of_two_hidden_effects_both_are_wanted():
    hides = ["row_noise", "narrow_hot_pixels"]
    assert right(named("hot_pixels", "row_noise", hides=hides))
    assert not right(named("hot_pixels", hides=hides))


def test_what_the_baseline_model_has_a_parameter_for_needs_no_addition():
    assert right(row(hides=["read_noise_spread"]))
    assert not right(named("row_noise", hides=["read_noise_spread"]))
    assert right(named("row_noise", hides=["read_noise_spread", "row_noise"]))


def test_what_no_effect_explains_is_to_be_unexplained():
    ringed = row(hides=["concentric_rings"])
    assert not right(ringed)
    assert right(ringed | {"verdict": "unexplained"})


def test_a_kind_is_outside_a_catalogue_that_lacks_its_name():
    old = row(hides=["row_noise"], catalogue=["hot_pixels"], verdict="unexplained")
    assert accepted(old) == [set()]
    assert right(old)


def test_a_false_addition_counts_where_it_is_said_for_certain():
    assert falsely_sure(named("column_fpn", hides=["row_noise"]))
    assert not falsely_sure(named("column_fpn", hides=["row_noise"], confidence=0.6))
    assert not falsely_sure(named("row_noise", hides=["row_noise"]))
    taken_back = named("column_fpn", hides=["row_noise"]) | {"named": []}
    assert not falsely_sure(taken_back)


def test_detection_is_right_by_the_filter_that_is_there():
    assert detected_right(row())
    assert not detected_right(row(detected="dpc"))
    assert detected_right(row(hides=["dpc", "hot_pixels"], detected="dpc"))


def test_a_case_that_failed_is_never_right():
    failed = row(failed="over 900 s")
    assert not right(failed)
    assert not detected_right(failed)


def test_the_table_has_a_line_for_each_generator_and_one_for_all():
    rows = [row(), named("row_noise", hides=["row_noise"], generator="pyxel", key="pyxel/b")]
    lines = by_generator(rows)
    assert [line[0] for line in lines] == ["plain", "pyxel", "all"]
    assert lines[1][1].startswith("1/1")
    assert lines[2][3].startswith("1/1")


def test_two_results_are_compared_on_the_cases_of_both():
    after = [row(key=f"plain/{n}") for n in range(8)]
    before = {f"plain/{n}": named("row_noise", key=f"plain/{n}") for n in range(6)}
    title, other, this, gained, lost, p = paired(after, before)[0]
    assert (title, other, this, gained, lost) == ("right", "0/6", "6/6", "6", "0")
    assert float(p) == pytest.approx(0.0312, abs=1e-4)
