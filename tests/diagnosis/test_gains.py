"""Gains of a refit on either half."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.comparator.predictive_check import REPLICATES, FittedModel
from dnanalyze.diagnosis.gains import _in_time, _witnessed, trial_by_prediction, trial_of
from dnanalyze.diagnosis.selection import EVIDENCE_ODDS_10
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.fitting.state import deviance, start
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effects.defect_lines import DefectLines
from dnanalyze.model.effects.offset_drift import OffsetDrift
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINTS = [(OperatingPoint(t, 1.0, 1.0), 6) for t in (25.0, 45.0)]
BASE = (ReadNoise(4.0), PixelFpn(2.0), Quantization(12))
DRIFT = OffsetDrift(3.0)
UPPER, LOWER = Window(0, 50, 0, 80), Window(50, 100, 0, 80)


def of(*more: object, seed: int) -> NoiseModel:
    return NoiseModel((*BASE, *more), 64.0, POINTS[0][0], seed)


def captures_of(*more: object, seed: int) -> FitProblem:
    return fit_problem(design(simulate(of(*more, seed=seed), (128, 128), POINTS)))


def null_of(problem: FitProblem, model: NoiseModel) -> FittedModel:
    return FittedModel(problem, start(problem, model))


def halves(problem: FitProblem):
    return problem.train, problem.test


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_by_prediction_a_drift_of_another_walk_is_no_misfit(seed):
    """Every sensor walks in its own way: one simulated walk is as far off as none."""
    problem = captures_of(DRIFT, seed=seed)
    null = null_of(problem, of(seed=20))
    for walk in (30, 40, 50):
        after = null_of(problem, of(DRIFT, seed=walk)).state
        assert trial_by_prediction(null, trial_of(null, "offset_drift", after)).evidence > 60.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_by_prediction_what_varies_without_being_there_is_evidence_against_it(seed):
    problem = captures_of(seed=seed)
    null = null_of(problem, of(seed=20))
    after = null_of(problem, of(DRIFT, seed=30)).state
    assert trial_by_prediction(null, trial_of(null, "offset_drift", after)).evidence < 0.0


def test_the_gain_is_that_of_the_density_under_nine_sensors_of_either_make():
    problem = captures_of(DRIFT, seed=1)
    null = null_of(problem, of(seed=20))
    found = trial_of(null, "offset_drift", null_of(problem, of(DRIFT, seed=30)).state)
    made = trial_by_prediction(null, found)
    expected = [0.0, 0.0]
    for model, sign in ((null.state.model, 1.0), (found.state.model, -1.0)):
        sensors = [
            problem.coordinates(replace(model, seed=model.seed + n)) for n in range(REPLICATES + 1)
        ]
        z = [np.array([half.z(s[i]) for s in sensors]) for i, half in enumerate(halves(problem))]
        for i, half in enumerate(halves(problem)):
            for column, key in enumerate(half.keys):
                both = [
                    z[j][:, h.keys.index(key)]
                    for j, h in enumerate(halves(problem))
                    if key in h.keys
                ]
                variance = np.mean([np.var(one, ddof=1) for one in both])
                sd = np.sqrt(max(1.0, 10.0 / 9.0 * variance))
                mean = z[i][:, column].mean()
                expected[i] += sign * (deviance(mean / sd) + 2.0 * np.log(sd))
    assert (made.fitted_gain, made.gain) == pytest.approx(tuple(expected), rel=1e-6)
    assert (made.state, made.error) == (found.state, found.error)


def test_a_half_without_the_effect_is_evidence_against_it_only():
    problem = SimpleNamespace(plan=SimpleNamespace(windows=(UPPER, LOWER)))
    above, below, both = (
        DefectLines(axis="rows", lines=lines, offsets=(1.0,) * len(lines))
        for lines in ((10,), (60,), (10, 60))
    )
    for anywhere in (both, RowFpn(1.0), None):
        assert _witnessed(problem, anywhere, 30.0, 2.0) == (30.0, 2.0)
    assert _witnessed(problem, below, 30.0, 2.0) == (30.0, 30.0)
    assert _witnessed(problem, below, 30.0, -50.0) == (-20.0, -20.0)
    assert _witnessed(problem, above, 2.0, 30.0) == (30.0, 30.0)
    assert _witnessed(problem, above, -5.0, 30.0) == (25.0, 25.0)


@pytest.mark.parametrize(
    ("effect", "counts", "single", "expected"),
    [
        (RowNoise(), (1, 4), 7.0, 12.0),  # a fixed pattern has as much in a single frame
        (RowNoise(), (1, 4), -7.0, 5.0),
        (RowNoise(), (1, 1), 7.0, 19.0),  # nothing tells them apart
        (RowNoise(), (2, 4), 7.0, 19.0),
        (RowFpn(), (1, 4), 7.0, 19.0),
        (None, (1, 4), 7.0, 19.0),
    ],
)
def test_a_single_frame_is_no_evidence_for_what_is_new_in_every_frame(
    effect, counts, single, expected
):
    plan = SimpleNamespace(settings=[(OperatingPoint(25.0), n) for n in counts])
    setting, gains = np.array([0, 0, 1, 1]), np.array([single, 0.0, 9.0, 3.0])
    assert _in_time(SimpleNamespace(plan=plan), effect, setting, gains) == expected


def test_rows_of_single_frames_do_not_make_row_noise():
    """Fixed rows, in a single frame at most operating points, are none that each frame has anew."""
    counts = [(15.0, 1), (25.0, 1), (35.0, 1), (45.0, 2)]
    points = [(OperatingPoint(t, 1.0, 1.0), n) for t, n in counts]
    captures = simulate(of(RowFpn(4.0), seed=1), (128, 128), points)
    problem = fit_problem(design(captures, pool=False))
    null = null_of(problem, of(seed=20))
    for effect, found in ((RowNoise(2.0), False), (RowFpn(4.0), True)):
        after = null_of(problem, of(effect, seed=30)).state
        assert (trial_of(null, effect.name, after).evidence > EVIDENCE_ODDS_10) is found
