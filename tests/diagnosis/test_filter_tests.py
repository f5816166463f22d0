"""A filter that is a candidate against the tests for filters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.diagnosis.filter_tests import denied, without_denied
from dnanalyze.diagnosis.selection import Trial, confidence_of, significant
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.state import start
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.denoise import Denoise
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINTS = [(OperatingPoint(t, 1.0, 1.0), 4) for t in (25.0, 45.0)]
EVIDENCE_DECISIVE = NoiseModel(
    (ReadNoise(4.0), PixelFpn(2.0), HotPixels(), Quantization(12)), 64.0, POINTS[0][0], 1
)
STRONG = EVIDENCE_DECISIVE.with_effect(Denoise(kind="median", strength=1.0))
WEAK = EVIDENCE_DECISIVE.with_effect(Denoise(kind="gaussian", space=0.2, strength=0.02))


def fit_problem_of(model):
    return fit_problem(design(simulate(model, (128, 128), POINTS)))


@pytest.fixture(scope="module")
def plain():
    return fit_problem_of(EVIDENCE_DECISIVE)


def test_a_filter_that_the_tests_would_find_is_denied(plain):
    assert denied(plain, STRONG, needed=False)


def test_one_that_they_could_not_find_is_denied_only_where_they_must_find_it(plain):
    assert not denied(plain, WEAK, needed=False)
    assert denied(plain, WEAK, needed=True)


def test_a_filter_that_is_found_is_not_denied():
    assert not denied(fit_problem_of(STRONG), STRONG, needed=True)


def test_a_denied_candidate_is_never_named(plain):
    state = start(plain, EVIDENCE_DECISIVE, [])
    found = Trial("denoise", state, 900.0, 900.0, 1.0, 1.0, falls=np.array([900.0, 900.0]))
    other = Trial("crosstalk", state, 800.0, 800.0, 1.0, 1.0, falls=np.array([800.0, 800.0]))
    assert significant(found)
    gone = replace(found, denied="a test")
    assert not significant(gone)
    assert confidence_of(gone, [gone, other]) == 0.0
    assert confidence_of(other, [gone, other]) > 0.9


@pytest.mark.parametrize(
    ("model", "kept"), [(EVIDENCE_DECISIVE, {"crosstalk"}), (STRONG, {"crosstalk", "dpc"})]
)
def test_forms_of_a_filter_are_not_tried_where_the_tests_deny_it_beside_another_kind(model, kept):
    problem = fit_problem_of(model)
    state = start(problem, STRONG, [])
    filters = Trial("dpc", state, 700.0, 700.0, 1.0, 1.0)
    other = Trial("crosstalk", state, 800.0, 800.0, 1.0, 1.0)
    assert without_denied(problem, other, [filters, other], {"crosstalk", "dpc"}) == kept
    assert without_denied(problem, filters, [filters, other], {"dpc"}) == {"dpc"}
