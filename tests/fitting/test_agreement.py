"""A model beside what the frames show without one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_ties import SENSOR, with_bias

from dnanalyze.demo.sensor import arrhenius
from dnanalyze.fitting import agreement
from dnanalyze.fitting.agreement import Agreement, agreements
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.from_part import converge
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.state import start


@pytest.fixture(scope="module")
def fitted():
    problem = fit_problem(design(with_bias()))
    model = baseline_model(problem)
    return problem, converge(problem, start(problem, model))


def test_of_a_right_model_every_quantity_agrees_with_the_frames_and_the_truth(fitted):
    found = agreements(*fitted)
    assert {a.quantity for a in found} == {
        "system gain, photon transfer", "dark signal", "activation energy of the dark signal",
    }  # fmt: skip
    assert all(a.kept for a in found)
    for a in found:
        if a.quantity == "dark signal":
            rate = SENSOR.dark_e_s * arrhenius(a.point.temperature_c, SENSOR.activation_ev)
            true = SENSOR.gain_dn_e * rate * SENSOR.exposure_s
            assert abs(a.direct - true) < 4 * a.error + 0.02 * true
    (energy,) = [a for a in found if a.unit == "eV"]
    assert energy.direct == pytest.approx(SENSOR.activation_ev, abs=4 * energy.error + 0.02)


def test_a_model_with_another_gain_and_black_level_is_told(fitted):
    problem, state = fitted
    shot = state.model.get("dark_shot_noise")
    wrong = state.model.with_effect(replace(shot, dn_per_e=2.0 * shot.dn_per_e))
    wrong = replace(wrong, pedestal=state.model.pedestal - 30.0)
    told = {a.quantity for a in agreements(problem, replace(state, model=wrong)) if not a.kept}
    assert told >= {"system gain, photon transfer", "dark signal"}


@pytest.mark.parametrize(
    ("model", "kept"), [(1.29, True), (1.31, False), (1.09, True), (0.71, True), (0.69, False)]
)
def test_a_difference_counts_beyond_three_standard_errors(model, kept):
    assert Agreement("x", None, "DN", 1.0, 0.1, model).kept == kept


def test_a_tenth_is_none():
    assert Agreement("x", None, "DN", 1.0, 0.001, 1.09).kept
    assert not Agreement("x", None, "DN", 1.0, 0.001, 1.11).kept
    assert Agreement("x", None, "DN", 1.0, 0.001, 1.11, tolerance=0.2).kept


def test_what_no_law_explains_is_an_error_of_a_dark_signal(fitted, monkeypatch):
    before = [a.error for a in agreements(*fitted) if a.quantity == "dark signal"]
    monkeypatch.setattr(agreement, "beyond_laws", lambda points, *_: np.full(len(points), -3.0))
    after = [a.error for a in agreements(*fitted) if a.quantity == "dark signal"]
    assert after == pytest.approx(np.hypot(before, 3.0))
