"""Candidates that explain alike are held against a classifier."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.diagnosis.classifier_tests import DISTINGUISHED, without_distinguished
from dnanalyze.diagnosis.selection import Trial, significant
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.state import start
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

pytestmark = pytest.mark.long

POINTS = [(OperatingPoint(t, 1.0, 1.0), 3) for t in (25.0, 45.0)]
EVIDENCE_DECISIVE = NoiseModel(
    (ReadNoise(4.0), PixelFpn(2.0), Quantization(12)), 64.0, POINTS[0][0], 1
)
STRIPED = EVIDENCE_DECISIVE.with_effect(RowNoise(1.2))


@pytest.fixture(scope="module")
def problem():
    return fit_problem(design(simulate(EVIDENCE_DECISIVE, (128, 128), POINTS)))


def trial(problem, effect, model, evidence):
    falls = np.array([evidence, evidence])
    state = start(problem, model, [])
    return Trial(effect, state, evidence, evidence, 1.0, 1.0, falls=falls)


def test_of_two_alike_the_one_whose_frames_are_told_is_excluded(problem):
    wrong, right = (
        trial(problem, "wrong", STRIPED, 900.0),
        trial(problem, "right", EVIDENCE_DECISIVE, 850.0),
    )
    first, second = without_distinguished(problem, [wrong, right])
    assert (first.effect, first.denied) == ("wrong", DISTINGUISHED)
    assert not significant(first)
    assert second is right


def test_two_whose_frames_are_told_stay_as_they_are(problem):
    both = [trial(problem, "one", STRIPED, 900.0), trial(problem, "other", STRIPED, 850.0)]
    assert without_distinguished(problem, both) == both


def test_a_candidate_without_a_competitor_is_not_asked(problem):
    alone = [
        trial(problem, "wrong", STRIPED, 900.0),
        trial(problem, "right", EVIDENCE_DECISIVE, 100.0),
    ]
    assert without_distinguished(problem, alone) == alone
    assert without_distinguished(problem, []) == []
