"""The best form of an effect."""

from dataclasses import replace

import pytest
from drawn_sensor import problem_with

from dnanalyze.comparator.predictive_check import FittedModel, error_of
from dnanalyze.diagnosis.forms import _promising, completed, in_best_form, preferred
from dnanalyze.diagnosis.gains import trial_of
from dnanalyze.fitting import design as designs
from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.from_part import converge
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.fitting.state import start
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.amp_glow import AmpGlow
from dnanalyze.model.effects.denoise import Denoise
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.effects.temporal_denoise import TemporalDenoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate


@pytest.mark.parametrize("seed", [2, 3])
def test_a_completed_filter_has_its_strength_and_the_noise_that_goes_with_it(seed):
    point, sigma, share = OperatingPoint(25.0, 1.0, 1.0), 1.2, 0.45

    def model(noise, memory, seed):
        effects = ReadNoise(noise), PixelFpn(1.0), Quantization(12), TemporalDenoise(memory)
        return NoiseModel(effects, 64.0, point, seed)

    problem = fit_problem(design(simulate(model(sigma, share, 1), (128, 128), [(point, 8)])))
    begun = model(0.8 * sigma, 0.25, seed)
    null = FittedModel(problem, start(problem, begun.without("temporal_denoise"), []))
    found = trial_of(null, "temporal_denoise", start(problem, begun))
    ended = completed(problem, found)
    # 16,384 pixels of 8 frames tell a memory to about .01
    assert ended.model.get("temporal_denoise").share == pytest.approx(share, abs=0.05)
    assert ended.model.get("read_noise").sigma == pytest.approx(sigma, rel=0.1)


def test_forms_are_tried_while_replicates_reject_a_model_whose_error_is_below_1():
    point = OperatingPoint(25.0, 1.0, 1.0)

    def model(seed, rows):
        return NoiseModel(
            (ReadNoise(4.0), PixelFpn(2.0), Quantization(12), rows), 64.0, point, seed
        )

    measured = model(1, RowNoise(1.0, alternating=0.5))
    problem = fit_problem(design(simulate(measured, (256, 256), [(point, 6)])))
    begun = model(2, RowNoise(0.8))
    null = FittedModel(problem, start(problem, begun.without("row_noise"), []))
    plain = minimise(problem, start(problem, begun))
    found = trial_of(null, "row_noise", plain)
    assert error_of(problem, plain) < 1.0
    assert not FittedModel.of(problem, plain).adequate
    ended = completed(problem, found)
    assert ended.model.get("row_noise").alternating == pytest.approx(0.5, abs=0.15)
    assert FittedModel.of(problem, ended).adequate


def filtered(kind, seed, *more):
    """A sensor with a spatial filter."""
    effects = ReadNoise(4.0), PixelFpn(2.0), Quantization(12), Denoise(kind=kind), *more
    return NoiseModel(effects, 64.0, OperatingPoint(25.0, 1.0, 1.0), seed)


def of_median(shape):
    """Eight frames of a sensor with a median filter; the model with it is right."""
    model = filtered("median", 1)
    captures = simulate(model, shape, [(model.reference, 8)])
    return fit_problem(design(captures)).weighted(0.0)


def test_the_kind_of_a_filter_is_that_of_the_lowest_loss():
    problem = of_median((128, 128))
    begun = filtered("gaussian", 2)
    null = FittedModel(problem, start(problem, begun.without("denoise"), []))
    found = trial_of(null, "denoise", start(problem, begun))
    ended = in_best_form(problem, found)
    assert ended.model.get("denoise").kind == "median"
    assert ended.loss < found.state.loss
    assert in_best_form(problem, trial_of(null, "denoise", ended)) is ended


def test_forms_of_what_has_no_place_are_compared_on_a_part_of_the_field(monkeypatch):
    windows = []

    def several(self, models):
        windows.extend([self.plan.windows] * len(models))
        return simulated(self, models)

    simulated = FitProblem.several
    monkeypatch.setattr(designs, "PART_FROM_PIXELS", 0)
    problem = of_median((256, 128))
    monkeypatch.setattr(FitProblem, "several", several)

    def best(begun):
        null = FittedModel(problem, start(problem, begun.without("denoise"), []))
        found = trial_of(null, "denoise", start(problem, begun))
        windows.clear()
        return in_best_form(problem, found), found.state

    ended, begun = best(filtered("gaussian", 2))
    assert ended.model.get("denoise").kind == "median"
    assert ended.loss < begun.loss
    assert len(ended.train) == len(problem.train.keys)
    whole = windows.count(problem.plan.windows)
    assert windows.count(problem.part.plan.windows) == len(windows) - whole > whole > 0
    few, _ = best(filtered("gaussian", 2, HotPixels(0.001)))  # the part rules other kinds out
    assert few.model.get("denoise").kind == "median"
    assert windows[0] == problem.part.plan.windows
    best(filtered("gaussian", 2, AmpGlow(1.0)))  # the part does not show a glow as the whole does
    assert windows[0] == problem.plan.windows


def test_another_form_is_refitted_though_the_derivatives_of_this_one_promise_nothing_of_it():
    """Fitted to a median filter, a Gaussian one takes other strengths and noise with it."""
    problem = of_median((256, 128))
    begun = filtered("gaussian", 2)
    null = FittedModel(problem, start(problem, begun.without("denoise"), []))
    found = trial_of(null, "denoise", minimise(problem, start(problem, begun)))
    assert found.state.model.get("denoise").strength < 0.9
    ended = in_best_form(problem, found)
    assert ended.model.get("denoise").kind == "median"
    assert ended.loss < 0.5 * found.state.loss


@pytest.mark.long
def test_the_better_by_both_halves_is_preferred():
    problem = problem_with({"row_fpn": "strong"})
    without, right = (
        converge(problem, start(problem, m))
        for m in (baseline_model(problem), baseline_model(problem).with_effect(RowFpn(1.0)))
    )
    assert preferred(without, right) is right
    assert preferred(right, without) is right
    assert preferred(right, right) is right


def test_forms_that_the_captures_do_not_tell_apart_are_none():
    """A glow of a thousandth of the noise is the same in any corner, one of 30 DN is not."""
    point = OperatingPoint(25.0, 1.0, 1.0)

    def promising(amplitude):
        glow = AmpGlow(amplitude, location="nw")
        model = NoiseModel((ReadNoise(4.0), PixelFpn(2.0), glow), 64.0, point, 1)
        problem = fit_problem(design(simulate(model, (128, 128), [(point, 4)])))
        begun = replace(model, seed=2).with_effect(replace(glow, location="se"))
        state = derive(problem, start(problem, begun))
        return _promising(problem, state, [replace(model, seed=2)])

    assert promising(0.004) == []
    assert promising(30.0) != []
