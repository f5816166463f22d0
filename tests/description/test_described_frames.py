"""What a classifier says of the frames decides whether a described model is adequate."""

from __future__ import annotations

import importlib

import pytest

import dnanalyze
from dnanalyze.classifier.result import Cell, Classification
from dnanalyze.demo import tiny
from dnanalyze.loaders.captures import OperatingPoint

describing = importlib.import_module("dnanalyze.description.describe")


@pytest.mark.parametrize(("tells", "verdict"), [(False, "adequate"), (True, "nothing")])
def test_a_model_whose_frames_are_told_is_not_adequate(monkeypatch, tells, verdict):
    def classify(captures, model, **_):
        auc = 0.9 if tells else 0.5
        cell = Cell(OperatingPoint(25.0), "mean", "mean frame", auc, 0.8 * auc, 1.0, 0.5, True)
        return Classification(captures, model, [cell])

    def nothing(captures, problem, state, *_, **__):
        return describing._without(captures, problem, state, "nothing", "No structure.")

    monkeypatch.setattr(describing, "classify_on", classify)
    monkeypatch.setattr(describing, "described", nothing)
    monkeypatch.setattr(describing.FittedModel, "adequate", True)
    found = dnanalyze.describe(tiny())
    assert found.verdict == verdict
    assert found.classification.tells is tells
