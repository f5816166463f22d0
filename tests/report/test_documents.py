import json
import math

import pytest
import report_fakes as fakes

from dnanalyze.fitting.level import Level
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.registry import built_in
from dnanalyze.report import statistic_rows
from dnanalyze.report.plain import to_json
from dnanalyze.report.results import (
    classification,
    comparison,
    detection,
    diagnosis,
    effects,
    fit,
    refinement,
    statistics,
)

ROW = {
    "name", "family", "temperature_c", "exposure_s", "gain", "channel", "measured", "simulated",
    "floor", "discrepancy", "relative",
}  # fmt: skip

WITH_A_LEVEL = "comparison", "diagnosis", "refinement", "addition"
MADE = {
    "analyze": lambda: statistics.document(fakes.statistics()),
    "fit": lambda: fit.document(fakes.fit()),
    "compare": lambda: comparison.document(fakes.comparison()),
    "diagnose": lambda: diagnosis.document(fakes.diagnosis()),
    "refine": lambda: refinement.document(fakes.refinement()),
    "add": lambda: refinement.document(fakes.addition()),
    "detect": lambda: detection.document(fakes.detection()),
    "classify": lambda: classification.document(fakes.classification()),
    "effects": lambda: effects.document(built_in()),
}


def numbers(value):
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [n for v in value for n in numbers(v)]
    return [value] if isinstance(value, float) else []


@pytest.mark.parametrize("command", MADE)
def test_every_document_has_its_head_and_only_finite_numbers(command):
    made = json.loads(to_json(MADE[command]()))
    assert made["schema"] == f"dnanalyze/{command}/1"
    assert isinstance(made["captures"], str)
    assert isinstance(made["version"], str)
    assert all(math.isfinite(n) for n in numbers(made))


@pytest.mark.parametrize("command", ["compare", "diagnose", "refine", "add"])
def test_the_mean_level_stands_in_each_document_that_judges_a_model(command, monkeypatch):
    assert MADE[command]()["level"] is None
    level = Level(False, OperatingPoint(-5.0, 300.0), "", -12.3, -0.031, 41.2)
    found = {made: getattr(fakes, made)() for made in WITH_A_LEVEL}
    for made, result in found.items():
        result.level = level
        monkeypatch.setattr(fakes, made, lambda result=result: result)
    assert MADE[command]()["level"] == {
        "temperature_c": -5.0, "exposure_s": 300.0, "gain": None, "channel": None,
        "plane": "", "statistic": "mean",
        "kept": False, "difference_dn": -12.3, "relative": -0.031, "standard_errors": 41.2,
    }  # fmt: skip


def test_the_keys_are_those_of_the_contract():
    compare = MADE["compare"]()
    assert {"error", "baselines", "statistics"} <= set(compare)
    assert {"gaussian", "paper"} <= set(compare["baselines"])
    assert all(set(row) >= ROW for row in compare["statistics"])
    diagnose = MADE["diagnose"]()
    assert {"error", "verdict", "candidates", "unexplained"} <= set(diagnose)
    assert set(diagnose["candidates"][0]) == {
        "effect", "error_after", "explained", "confidence", "confused_with", "evidence", "leaves",
    }  # fmt: skip
    refine = MADE["refine"]()
    assert {"steps", "effects", "verdict", "unexplained", "parameters", "model"} <= set(refine)
    assert all(
        {"added", "error", "confidence", "confused_with", "evidence"} <= set(step)
        for step in refine["steps"]
    )
    assert refine["parameters"][1] == {
        "effect": "pedestal", "name": "pedestal", "value": 64.0, "se": None,
        "low": None, "high": None, "unit": "DN", "determined": True, "upper": None,
    }  # fmt: skip
    assert refine["model"] is None  # without a file
    detect = MADE["detect"]()
    assert {"filtered", "kind", "findings"} <= set(detect)
    assert set(detect["findings"][0]) >= {
        "test", "kind", "temperature_c", "p_value", "effect_size", "flagged",
    }  # fmt: skip


def test_steps_name_what_was_added_and_what_was_taken_out():
    steps = MADE["refine"]()["steps"]
    assert [s["added"] for s in steps] == [None, "row_fpn", "column_fpn", None]
    assert steps[3]["removed"] == "row_fpn"
    added = MADE["add"]()
    assert (added["error_before"], added["error_after"]) == (6.5, 1.1)


def test_every_effect_is_described():
    for effect in MADE["effects"]()["effects"]:
        assert effect["summary"] or effect["name"] == "convolved_lognormal"
        assert all(p["doc"] for p in effect["parameters"].values())


def test_tables_have_a_row_a_number():
    measured = fakes.statistics()
    table = statistics.table(measured)
    assert len(table) == sum(len(s.values) for s in measured.settings)
    assert {"temperature_c", "plane", "name", "value", "se", "unit"} <= set(table.columns)
    assert len(comparison.table(fakes.comparison())) == len(fakes.comparison().statistics)
    assert list(refinement.table(fakes.refinement())["error"]) == [6.5, 4.0, 1.1, 1.05]
    assert list(diagnosis.table(fakes.diagnosis())["effect"]) == ["column_fpn", "column_gain"]
    assert len(detection.table(fakes.detection())) == 2
    assert len(fit.table(fakes.fit())) == 2
    assert list(fakes.captures().to_dataframe()["frames"]) == [4, 4, 4]


def test_statistics_are_said_in_words():
    assert statistic_rows.named("temporal_noise").endswith("(temporal_noise)")
    assert statistic_rows.named("a sentence") == "a sentence"


def test_the_worst_rows_name_each_statistic_once():
    rows = fakes.comparison().statistics
    shown = statistic_rows.worst(rows, most=5)
    sizes = [abs(r["discrepancy"]) for r in shown]
    assert sizes == sorted(sizes, reverse=True)
    assert len({r["name"] for r in shown}) == len(shown)
    assert sizes[0] == max(abs(r["discrepancy"]) for r in rows if math.isfinite(r["discrepancy"]))
    assert all(r["family"] == "spectrum" for r in statistic_rows.worst(rows, "spectrum"))


def test_all_operating_points_together_stand_beside_each_of_them():
    found = classification.document(fakes.classification())
    assert [c["auc"] for c in found["points"]] == [0.5, 0.55, 0.76]
    assert [(c["view"], c["auc"]) for c in found["together"]] == [("mean", 0.6)]
    table = classification.table(fakes.classification())
    assert table["auc"].tolist() == [0.5, 0.55, 0.76, 0.6]
    assert table["temperature_c"].isna().tolist() == [False, False, False, True]


def test_the_classifier_stands_where_a_model_is_judged_by_it():
    judged = fakes.classification()
    for made in (
        comparison.document(fakes.comparison(), judged),
        refinement.document(fakes.refinement(classification=judged)),
    ):
        found = made["classifier"]
        assert found["auc"] == 0.76
        assert found["control"] == 0.51
        assert found["tells"]
        assert found["points"][2]["view"] == "mean"
        assert found["points"][2]["temperature_c"] == 105.0
        assert (
            "at 105 °C by the upper tail and the excess kurtosis of the mean" in found["sentence"]
        )
    assert "classifier" not in comparison.document(fakes.comparison())


def test_errors_of_statistics_are_in_the_unit_of_the_value():
    """Of a logarithmic scale se is relative; of the value it is an error bar."""
    measured = fakes.statistics()
    document = statistics.document(measured)
    table = statistics.table(measured)
    rows = [row for s in document["settings"] for row in s["statistics"]]
    logs = [r for r in rows if r["scale"] == "log" and r["value"] > 0 and r["se_scaled"]]
    assert logs
    for row in logs:
        assert row["se"] == pytest.approx(row["value"] * row["se_scaled"])
        assert row["low"] * row["high"] == pytest.approx(row["value"] ** 2)
    assert list(table["se"].dropna()) == pytest.approx(
        [r["se"] for r in rows if r["se"] is not None]
    )
