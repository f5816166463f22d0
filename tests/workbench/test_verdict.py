from __future__ import annotations

from types import SimpleNamespace

import pytest

from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.workbench.history import History
from dnanalyze.workbench.verdict import verdict


def _row(name, measured, simulated, z, temperature=25.0, family="spectrum"):
    return {
        "name": name, "family": family, "unit": "DN^2", "plane": "", "temperature_c": temperature,
        "exposure_s": 0.1, "gain": None, "channel": None, "measured": measured,
        "simulated": simulated, "floor": 0.1, "discrepancy": z,
    }  # fmt: skip


def _candidate(effect, confidence, after, evidence=(), rivals=()):
    return {
        "effect": effect, "confidence": confidence, "error_after": after,
        "evidence": list(evidence), "confused_with": list(rivals), "explained": 0.5,
    }  # fmt: skip


def _diagnosis(verdict, candidates=(), finished=True, ordinary=(), **more):
    return {
        "node": 0, "error": 11.5, "verdict": verdict, "finished": finished,
        "ordinary": list(ordinary), "candidates": list(candidates), "unexplained": [], **more,
    }  # fmt: skip


def _session(**more):
    history = History.begun(NoiseModel(()), "begun").measured(0, 4.0, {})
    rows = [_row("pattern_columns_0.1_0.3", 76.0, 2.0, 30.0)]
    known = {
        "problem": object(), "history": history, "evaluation": SimpleNamespace(rows=rows),
        "diagnosis": None, "answers": {}, "stage": "statistics of 4 frames",
    }  # fmt: skip
    return SimpleNamespace(**(known | more))


def test_before_a_diagnosis_the_worst_statistic_is_told_in_words():
    said = verdict(_session())
    assert "38 times the model's" in said.text
    assert (said.tone, said.action) == ("bad", "diagnose")


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ({"problem": None}, "Statistics of 4 frames."),
        ({"evaluation": None, "stage": "error of the first model"}, "Error of the first model."),
        (
            {"history": History.begun(NoiseModel(()), "fit")},
            "Computing the model error of the step “fit”.",
        ),
    ],
)
def test_what_is_still_computed_is_said(more, text):
    said = verdict(_session(**more))
    assert (said.text, said.tone, said.action) == (text, "wait", "")


@pytest.mark.parametrize(("before", "told"), [(13.3, True), (None, False), (11.0, False)])
def test_a_fit_whose_stated_error_is_larger_is_told_to_be_closer_only_where_it_is(before, told):
    history = History.begun(NoiseModel(()), "begun").measured(0, 10.2, {})
    history = history.grown("fit", NoiseModel(()), ("fit",)).measured(1, 11.8, {})
    history = history if before is None else history.beside(1, before)
    said = verdict(_session(history=history)).text
    assert ("the error falls from 13.3 to 11.8; 10.2 was by the larger σ" in said) == told


def test_the_missing_effect_is_named_with_its_evidence_and_the_button_adds_it():
    words = "columns carry 38 times the power; with column_fpn the difference falls"
    found = _diagnosis("missing", [_candidate("column_fpn", 0.95, 0.82, [words])])
    said = verdict(_session(diagnosis=found))
    assert said.text == "Columns carry 38 times the power. Missing: {column_fpn} (95 %)."
    assert (said.action, said.effect, said.before, said.after) == ("add", "column_fpn", 4.0, 0.82)


def test_an_unsure_effect_is_named_with_its_rivals():
    best = _candidate("rts", 0.5, 2.0, rivals=["noisy_pixels"])
    said = verdict(_session(diagnosis=_diagnosis("missing", [best])))
    assert said.text == "Missing: possibly {rts} (50 %), or {noisy_pixels}."


def test_baseline_effects_alone_are_added_together():
    named = [_candidate("read_noise", 0.99, 3.0), _candidate("quantization", 0.99, 1.1)]
    found = _diagnosis("missing", named, ordinary=["read_noise", "quantization"])
    said = verdict(_session(diagnosis=found))
    assert (said.action, said.after) == ("complete", 1.1)


def test_candidates_so_far_can_be_added_before_the_search_ends():
    found = _diagnosis("missing", [_candidate("rts", 0.4, 2.0)], finished=False)
    said = verdict(_session(diagnosis=found, worker=SimpleNamespace(runs=lambda kind: True)))
    assert said.text.startswith("Best so far: {rts}")
    assert said.text.endswith("are still being tested.")
    assert (said.action, said.effect) == ("add", "rts")


def test_candidates_of_a_search_that_was_ended_are_not_said_to_be_tested():
    found = _diagnosis("missing", [_candidate("rts", 0.4, 2.0)], finished=False)
    said = verdict(_session(diagnosis=found, worker=SimpleNamespace(runs=lambda kind: False)))
    assert said.text.endswith("Other candidates were not tested.")


def test_an_unexplained_residual_names_its_statistics():
    found = _diagnosis("unexplained", unexplained=["column_kurtosis"])
    said = verdict(_session(diagnosis=found))
    assert "excess kurtosis of the column means" in said.text
    assert said.action == ""


@pytest.mark.parametrize(
    ("answer", "tone", "action"),
    [
        ({"verdict": "adequate", "classifier": "A classifier cannot tell."}, "good", ""),
        ({"verdict": "adequate", "classifier": "It tells.", "tells": True}, "bad", "diagnose"),
        ({"verdict": "missing"}, "bad", "diagnose"),
    ],
)
def test_after_an_addition_the_command_s_sentence_and_the_classifier_s_are_told(
    answer, tone, action
):
    said = verdict(_session(answers={0: answer | {"headline": "With rts it falls."}}))
    assert said.text == f"With rts it falls. {answer.get('classifier', '')}".strip()
    assert (said.tone, said.action) == (tone, action)


def test_an_added_effect_is_told_by_its_plain_name():
    answer = {"verdict": "missing", "effect": "rts", "headline": "With rts the parts fall."}
    assert verdict(_session(answers={0: answer})).text == "With {rts} the parts fall."


def test_a_diagnosis_of_another_step_is_not_told():
    found = _diagnosis("adequate") | {"node": 3}
    assert verdict(_session(diagnosis=found)).action == "diagnose"
