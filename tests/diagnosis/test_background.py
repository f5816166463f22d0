"""Charge under all of the field, told from the pedestal."""

import math
from dataclasses import replace

import pytest

from dnanalyze.diagnosis import background, completion
from dnanalyze.diagnosis.background import SHARES, along_background, other_backgrounds
from dnanalyze.diagnosis.trial import error_of
from dnanalyze.fitting.design import design
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import converge, given, start
from dnanalyze.fitting.predictor import bench
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.dark_gradient import DarkGradient
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINT = OperatingPoint(25.0, 1.0, 1.0)
LEVEL, NOISE, SPREAD = 400.0, 900.0, 2.0  # DN, DN^2, DN
SURFACE = DarkGradient(x=6.0, y=6.0)


def model(share, k, seed, level=LEVEL):
    """A level and noise of which charge has a share of the noise."""
    charge = share * NOISE / k
    effects = (
        ConvolvedLognormal(mu=math.log(charge), delta=SPREAD / charge, sigma=1e-6),
        DarkShotNoise(k),
        ReadNoise(math.sqrt((1.0 - share) * NOISE), serial=-0.1),
        SURFACE,
    )
    return NoiseModel(effects, level - charge, POINT, seed)


@pytest.mark.parametrize("k", [5.0, 2.0])
def test_other_backgrounds_keep_level_noise_pattern_and_serial_correlation(k):
    found = other_backgrounds(model(0.05, 5.0, 0), k)
    assert len(found) == len(SHARES)
    for other, share in zip(found, SHARES, strict=True):
        light, shot, read, _ = other.effects
        charge = math.exp(light.mu)
        assert shot.dn_per_e == pytest.approx(k)
        assert shot.dn_per_e * charge == pytest.approx(share * NOISE)
        assert other.pedestal + charge == pytest.approx(LEVEL)
        assert shot.dn_per_e * charge + read.sigma**2 == pytest.approx(NOISE)
        assert light.delta * charge == pytest.approx(SPREAD)
        assert read.serial * read.sigma**2 == pytest.approx(
            max(-0.1 * 0.95 * NOISE, -0.45 * read.sigma**2)
        )


def test_warmer_settings_keep_what_they_have_more():
    warm = TableLaw((POINT, OperatingPoint(65.0)), (math.log(10.0), math.log(300.0)))
    base = model(0.05, 5.0, 0)
    for other in other_backgrounds(base.with_effect(ConvolvedLognormal(mu=warm)), 5.0):
        cold, hot = (math.exp(mu) for mu in other.get("convolved_lognormal").mu.values)
        assert hot - cold == pytest.approx(290.0)
        assert other.pedestal + cold == pytest.approx(base.pedestal + 10.0)


@pytest.mark.parametrize("name", ["dark_shot_noise", "read_noise"])
def test_a_model_that_counts_nothing_has_no_other_background(name):
    assert other_backgrounds(model(0.05, 5.0, 0).without(name), 5.0) == []


@pytest.fixture(scope="module")
def held():
    return bench(design(simulate(model(0.7, 8.0, 1), (384, 384), [(POINT, 6)])))


def fitted(held, begun):
    return converge(held, start(held, begun, knobs_of(begun)))


def test_a_background_of_charge_is_told_from_the_pedestal(held):
    begun = fitted(held, model(0.03, 20.0, 2))
    found = along_background(held, begun)
    assert found.loss < begun.loss
    assert error_of(held, found) < error_of(held, begun)
    k, charge = (
        found.model.get("dark_shot_noise").dn_per_e,
        math.exp(found.model.get("convolved_lognormal").mu),
    )
    assert k == pytest.approx(8.0, rel=0.2)
    assert 0.35 < k * charge / NOISE < 1.0


def test_a_background_that_agrees_with_the_shading_of_the_noise_stays(held):
    state = fitted(held, model(0.7, 8.0, 2))
    assert along_background(held, state) is state
    plain = start(held, state.model.without("dark_shot_noise"), [])
    assert along_background(held, plain) is plain


@pytest.mark.parametrize(
    ("error", "tried"), [(completion.POOR + 0.1, True), (completion.POOR, False)]
)
def test_a_completed_effect_is_given_another_background_where_the_model_is_poor(
    held, error, tried, monkeypatch
):
    state, other = (start(held, model(0.7, k, 2), []) for k in (8.0, 6.0))
    monkeypatch.setattr(completion, "converge", lambda _, there: there)
    monkeypatch.setattr(completion, "settled", lambda _, there, name, **more: there)
    monkeypatch.setattr(completion, "error_of", lambda *_: error)
    monkeypatch.setattr(completion, "along_background", lambda *_: other)
    ended = completion.completed(held, state, "dark_gradient")
    assert (ended is other) == tried


@pytest.mark.parametrize(("worse", "taken"), [(0.4, True), (2.0, False)])
def test_both_halves_choose_the_background(held, worse, taken, monkeypatch):
    state = start(held, model(0.7, 20.0, 2), [])
    even = replace(
        state, model=model(0.7, 8.0, 2), train=worse * state.train, unseen=given(worse * state.test)
    )
    one_sided = replace(state, train=0.0 * state.train, unseen=given(9.0 * state.test))
    begun = iter((one_sided, even))
    monkeypatch.setattr(background, "other_backgrounds", lambda *_: [state.model] * 2)
    monkeypatch.setattr(background, "_level_and_noise", lambda *_: next(begun))
    monkeypatch.setattr(background, "start", lambda _, chosen, knobs: chosen)
    monkeypatch.setattr(background, "converge", lambda _, chosen: chosen)
    monkeypatch.setattr(background, "preferred", lambda _, chosen: chosen)
    assert along_background(held, state) is (even.model if taken else state)
