"""Does the diagnosis name what an independent generator hides? The suite, and its bookkeeping.

The suite itself takes minutes: ``pytest -m slow tests/diagnosis/test_hidden_suite.py``; with more
sensors and all levels, ``python benchmarks/hidden_effects.py``.
"""

import json
import math
import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import hidden_effects as bench
import hidden_scores as scores

from dnanalyze.demo import CATALOGUED, OUTSIDE

REFINE = "dnanalyze.diagnosis.refine:refine"
TINY = bench.Case("column_fpn", "strong", 0, 0, (32, 32), 2)


# Stand-ins for refine, found by name in the child processes.


def _step(added, error, confidence=None):
    return SimpleNamespace(added=added, error=error, confidence=confidence)


def finds_columns(captures):
    steps = [_step(None, 8.0), _step("read_noise", 5.0), _step("row_fpn", 2.0, 0.6),
             _step("column_fpn", 1.1, 0.95), _step("-row_fpn", 1.1)]  # fmt: skip
    return SimpleNamespace(
        effects=["convolved_lognormal", "read_noise", "column_fpn"], verdict="adequate", steps=steps
    )


def breaks(captures):
    raise ValueError("broken")


def dies(captures):
    os._exit(3)


def sleeps(captures):
    time.sleep(600)


def row(effect, named=(), verdict="adequate", level="middling", confidence=0.9):
    return {
        "key": effect, "effect": effect, "level": level, "named": list(named), "verdict": verdict,
        "first": named[0] if named else None, "additions": [[n, confidence] for n in named],
        "error_before": 5.0, "error_after": 1.0, "seconds": 2.0,
    }  # fmt: skip


def test_a_case_is_the_same_each_time_and_levels_share_a_sensor():
    one, told = TINY.made()
    two, _ = TINY.made()
    for a, b in zip(one.frames(), two.frames(), strict=True):
        np.testing.assert_array_equal(a.read(), b.read())
    _, weak = replace(TINY, level="weak").made()
    assert told["sensor"] == weak["sensor"]
    assert told["hidden"]["column_fpn"]["e"] == pytest.approx(6 * weak["hidden"]["column_fpn"]["e"])
    assert replace(TINY, sensor=1).made()[1]["sensor"] != told["sensor"]


def test_a_kind_can_be_asked_for():
    _, told = replace(TINY, effect="denoise:nlm").made()
    assert told["hidden"]["denoise"]["kind"] == "nlm"


def test_two_can_be_hidden_at_once():
    both = "dpc:median+hot_pixels"
    _, told = replace(TINY, effect=both).made()
    assert set(told["hidden"]) == {"dpc", "hot_pixels"}
    assert told["hidden"]["dpc"]["mode"] == "median"
    assert replace(TINY, effect=both).name == "dpc+hot_pixels"


def test_pairs_are_of_two_effects_of_the_catalogue_and_the_same_each_time():
    drawn = bench.pairs(40, seed=3)
    assert drawn == bench.pairs(40, seed=3) != bench.pairs(40, seed=4)
    assert len(set(drawn)) == len(drawn)
    for pair in drawn:
        one, other = pair.split("+")
        assert one != other
        assert {one, other} <= set(CATALOGUED)


def test_rows_survive_errors_deaths_and_json():
    others = [replace(TINY, sensor=n) for n in range(3)]
    found = {}
    for case, using in zip(others, ("finds_columns", "breaks", "dies"), strict=True):
        (found[using],) = bench.run_all([case], f"test_hidden_suite:{using}", 1, 300.0)
    good = json.loads(json.dumps(found["finds_columns"], default=float))
    assert good["key"] == TINY.key
    assert (good["first"], good["named"]) == ("column_fpn", ["column_fpn"])
    assert (good["error_before"], good["error_after"]) == (8.0, 1.1)
    assert good["additions"] == [["row_fpn", 0.6], ["column_fpn", 0.95]]
    assert "broken" in found["breaks"]["failed"]
    assert "died" in found["dies"]["failed"]
    assert scores.report(list(found.values()))


def test_a_case_over_its_time_is_ended():
    (late,) = bench.run_all([TINY], "test_hidden_suite:sleeps", 1, 0.5)
    assert "over 0.5 s" in late["failed"]
    assert not scores.right(late)


def test_a_stored_line_that_was_cut_short_spoils_no_other(tmp_path):
    path = tmp_path / "rows.jsonl"
    bench._store(path, row("hum"))
    with path.open("a") as stream:
        stream.write('\n{"key": "cut')
    bench._store(path, row("row_fpn"))
    assert set(bench._stored(path)) == {"hum", "row_fpn"}


@pytest.mark.parametrize(
    ("made", "is_right", "column"),
    [
        (row("row_fpn", ["row_fpn"]), True, "row_fpn"),
        (row("row_fpn", ["row_noise", "row_fpn"]), False, "row_noise"),
        (row("row_fpn"), False, "nothing"),
        (row("row_fpn", verdict="unexplained"), False, "unexplained"),
        (row("ordinary"), True, "nothing"),
        (row("ordinary", ["rts"]), False, "rts"),
        (row(OUTSIDE[0], ["flicker_fpn"], "unexplained"), True, "unexplained"),
        (row(OUTSIDE[0], ["flicker_fpn"]), False, "flicker_fpn"),
        (row("rts+row_fpn", ["row_fpn", "rts"]), True, "row_fpn"),
        (row("rts+row_fpn", ["row_fpn"]), False, "row_fpn"),
        (row("rts+row_fpn", ["row_noise", "row_fpn", "rts"]), False, "row_noise"),
        ({"effect": "rts", "failed": "over"}, False, "(failed)"),
    ],
)
def test_what_counts_as_right(made, is_right, column):
    assert scores.right(made) is is_right
    assert scores.called(made) == column


def test_reliability_counts_additions_by_their_confidence():
    rows = [row("rts", ["rts"], confidence=0.95)] * 3 + [row("rts", ["row_fpn"], confidence=0.95)]
    (line,) = [x for x in scores.reliability(rows).splitlines() if x.startswith("| 0.9-0.99")]
    assert [c.strip() for c in line.split("|")[2:5]] == ["4", "0.95", "0.75"]


def test_what_stands_beside_two_is_counted():
    rows = [row("rts+row_fpn", ["row_fpn", "rts"]), row("rts+row_fpn", ["rts", "row_fpn", "dpc"])]
    found = {aim: count for aim, count, _ in scores.summary(rows)}
    assert found["two hidden effects, both named, middling"] == "2/2"
    assert found["two hidden effects, nothing false beside them"] == "1/2"
    assert found["one hidden effect, nothing false beside it"] == "-"
    assert "rts, row_fpn, dpc" in scores.report(rows)


# The suite.


def _holds(found: str, wanted: float) -> bool:
    """Whether ``k/n`` is no less than wanted, give or take two standard errors of n draws."""
    right, cases = map(int, found.split("/"))
    return right >= wanted * cases - 2.0 * math.sqrt(cases * wanted * (1 - wanted))


@pytest.mark.slow
def test_middling_effects_are_named_and_ordinary_sensors_left_alone():
    effects = [*CATALOGUED, *OUTSIDE, bench.ORDINARY]
    wanted = bench.cases(effects, ["middling"], sensors=1, ordinary=10, seed=1)
    rows = list(bench.run_all(wanted, REFINE, 2, 600.0))
    for aim, found, share in scores.summary(rows):
        assert _holds(found, share), f"{aim}: {found}\n\n{scores.report(rows)}"


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["column_fpn", "hot_pixels", "digital_gain", "ordinary"])
def test_strong_effects_are_named_on_a_small_sensor(effect):
    case = bench.Case(effect, "strong", 0, 2, (192, 192), 4)
    made = bench.run_case(case, bench.callable_of(REFINE))
    assert scores.right(made), made
