"""Candidates that explain alike are held against a classifier."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.diagnosis.classifier_tests import TOLD, told_apart
from dnanalyze.diagnosis.selection import Trial, significant
from dnanalyze.fitting.design import design
from dnanalyze.fitting.predictor import bench
from dnanalyze.fitting.state import start
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINTS = [(OperatingPoint(t, 1.0, 1.0), 3) for t in (25.0, 45.0)]
PLAIN = NoiseModel((ReadNoise(4.0), PixelFpn(2.0), Quantization(12)), 64.0, POINTS[0][0], 1)
STRIPED = PLAIN.with_effect(RowNoise(1.2))


@pytest.fixture(scope="module")
def held():
    return bench(design(simulate(PLAIN, (128, 128), POINTS)))


def trial(held, effect, model, evidence):
    falls = np.array([evidence, evidence])
    state = start(held, model, [])
    return Trial(effect, state, evidence, evidence, 1.0, 1.0, falls=falls)


def test_of_two_alike_the_one_whose_frames_are_told_is_excluded(held):
    wrong, right = trial(held, "wrong", STRIPED, 900.0), trial(held, "right", PLAIN, 850.0)
    first, second = told_apart(held, [wrong, right])
    assert (first.effect, first.denied) == ("wrong", TOLD)
    assert not significant(first)
    assert second is right


def test_two_whose_frames_are_told_stay_as_they_are(held):
    both = [trial(held, "one", STRIPED, 900.0), trial(held, "other", STRIPED, 850.0)]
    assert told_apart(held, both) == both


def test_a_candidate_without_a_competitor_is_not_asked(held):
    alone = [trial(held, "wrong", STRIPED, 900.0), trial(held, "right", PLAIN, 100.0)]
    assert told_apart(held, alone) == alone
    assert told_apart(held, []) == []
