"""Strength and noise moved together."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.diagnosis import bend, completion
from dnanalyze.diagnosis.bend import (
    _other_strengths,
    along_bend,
    begun_again,
    begun_elsewhere,
    least_noise,
    relevelled,
    unbent,
)
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import ordinary_start
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import start
from dnanalyze.fitting.predictor import Bench, bench
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.denoise import Denoise
from dnanalyze.model.effects.digital_gain import DigitalGain
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.temporal_denoise import TemporalDenoise
from dnanalyze.model.laws import ArrheniusLaw, TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINT = OperatingPoint(25.0, 1.0, 1.0)
SIGMA, SHARE = 1.2, 0.45


def _model(sigma: float, share: float | None, seed: int) -> NoiseModel:
    filtered = [] if share is None else [TemporalDenoise(share)]
    effects = (ReadNoise(sigma), PixelFpn(1.0), Quantization(12), *filtered)
    return NoiseModel(effects, 64.0, POINT, seed)


@pytest.fixture(scope="module")
def held() -> Bench:
    return bench(design(simulate(_model(SIGMA, SHARE, 1), (128, 128), [(POINT, 8)])))


def test_the_least_noise_is_that_of_the_frames(held):
    after = np.sqrt((SIGMA**2 + 1 / 12) * (1 - SHARE) / (1 + SHARE) + 1 / 12)
    assert least_noise(held) == pytest.approx(after, rel=0.1)  # eight frames, the first unfiltered


def test_another_strength_brings_the_noise_it_bends(held):
    kept = np.sqrt((1 - SHARE) / (1 + SHARE) * (1 + 0.25) / (1 - 0.25))
    begun = _model(SIGMA * kept, 0.25, 2)  # as much noise as measured, with too little memory
    state = start(held, begun, knobs_of(begun))
    found = along_bend(held, state, "temporal_denoise")
    assert found is not None
    assert found.loss < 0.5 * state.loss
    # 16,384 pixels of 8 frames tell a memory to about .01
    assert found.model.get("temporal_denoise").share == pytest.approx(SHARE, abs=0.05)
    assert found.model.get("read_noise").sigma == pytest.approx(SIGMA, rel=0.1)


@pytest.mark.parametrize(
    ("pedestal", "mu", "moved"),
    [
        (64.4, TableLaw((POINT,), (0.5,)), True),
        (64.4, ArrheniusLaw(1.5, 25.0, 0.6), False),  # its numbers are others
        (TableLaw((POINT,), (64.4,)), TableLaw((POINT,), (0.5,)), False),
    ],
)
def test_the_level_of_another_model_is_taken_where_the_same_numbers_are_free(pedestal, mu, moved):
    seed = ConvolvedLognormal(mu=TableLaw((POINT,), (1.0,)), delta=0.3, sigma=1e-6)
    begun = NoiseModel((seed, ReadNoise(9.0)), 64.0, POINT)
    model = NoiseModel((replace(seed, mu=mu, delta=0.9), ReadNoise(SIGMA)), pedestal, POINT)
    found = relevelled(model, begun)
    if moved:
        assert found == NoiseModel((seed, ReadNoise(SIGMA)), 64.0, POINT)
    else:
        assert found is None
    assert relevelled(_model(SIGMA, None, 1), begun) is None  # it has no seed


def test_an_effect_that_bends_nothing_stays(held):
    model = _model(SIGMA, None, 2)
    assert along_bend(held, start(held, model, knobs_of(model)), "pixel_fpn") is None


@pytest.mark.parametrize("seed", [2, 3])
def test_a_completed_effect_has_its_strength_and_the_noise_that_goes_with_it(held, seed):
    begun = _model(SIGMA * 0.8, 0.25, seed)
    ended = completion.completed(held, start(held, begun, knobs_of(begun)), "temporal_denoise")
    assert completion.error_of(held, ended) < completion.POOR
    assert ended.model.get("temporal_denoise").share == pytest.approx(SHARE, abs=0.05)
    assert ended.model.get("read_noise").sigma == pytest.approx(SIGMA, rel=0.1)


@pytest.mark.parametrize("filtered", [Denoise(range=1.2, kind="bilateral"), DigitalGain(2.0)])
def test_begun_again_it_has_its_level_from_the_means_and_its_noise_from_what_is_left(
    filtered, held, monkeypatch
):
    """Only numbers of which it leaves no trace are guessed: the others were found with it."""
    monkeypatch.setattr(bend, "converge", lambda _, there: there)
    moments = ordinary_start(held)
    numbers = ReadNoise(SIGMA, spread=0.3), PixelFpn(0.7)
    model = replace(moments, pedestal=70.0, seed=3).with_effect(numbers[0]).with_effect(numbers[1])
    model = model.with_effect(replace(model.get("convolved_lognormal"), delta=0.9))
    found = begun_again(held, start(held, model.with_effect(filtered), []), filtered.name)
    assert found is not None
    right = unbent(moments, filtered, least_noise(held))
    assert found.model.pedestal == pytest.approx(right.pedestal)
    assert found.model.get("convolved_lognormal") == right.get("convolved_lognormal")
    assert found.model.get(filtered.name) == filtered
    assert found.model.seed == 3
    noise, fixed = (found.model.get(name) for name in ("read_noise", "pixel_fpn"))
    if filtered.name == "denoise":
        assert noise.spread == 0.0
        assert noise.sigma == pytest.approx(right.get("read_noise").sigma)
        assert fixed == right.get("pixel_fpn")
    else:
        assert (noise, fixed) == numbers


def test_what_bends_nothing_is_not_begun_again(held):
    model = _model(SIGMA, None, 2)
    assert begun_again(held, start(held, model, []), "pixel_fpn") is None


def test_where_no_bend_leads_to_other_strengths_it_is_begun_again_at_the_best(held, monkeypatch):
    """Of a filter that looks at the noise: its noise is guessed at each strength."""
    monkeypatch.setattr(bend, "converge", lambda _, there: there)
    tried = []

    def begin(bench, model, knobs):
        effect = model.get("denoise")
        tried.append(effect)
        far = abs(effect.range - 1.2 * 0.65) + abs(effect.strength - 1.0)
        return SimpleNamespace(model=model, loss=far)

    monkeypatch.setattr(bend, "start", begin)
    filtered = Denoise(range=1.2, kind="nlm")
    model = _model(SIGMA, None, 2).with_effect(ReadNoise(SIGMA, spread=0.3)).with_effect(filtered)
    found = begun_elsewhere(held, SimpleNamespace(model=model), "denoise")
    assert found.model.get("denoise") == replace(filtered, range=1.2 * 0.65)
    assert found.model.get("read_noise").spread == 0.0
    assert {e.space for e in tried} == {filtered.space}  # idle in this kind
    assert filtered not in tried
    assert begun_elsewhere(held, SimpleNamespace(model=model), "pixel_fpn") is None
    linear = model.with_effect(Denoise(kind="gaussian"))  # a bend leads to all of its strengths
    assert begun_elsewhere(held, SimpleNamespace(model=linear), "denoise") is None


@pytest.mark.parametrize("way", ["begun_again", "begun_elsewhere"])
def test_a_poor_refit_is_begun_again_before_its_other_kinds_are_asked(held, monkeypatch, way):
    poor = start(held, _model(SIGMA, 0.25, 2), [])
    right = start(held, _model(SIGMA, SHARE, 2), [])
    asked, seen = [], []
    monkeypatch.setattr(completion, "converge", lambda _, there: there)
    for other in ("begun_again", "along_bend", "begun_elsewhere"):
        monkeypatch.setattr(completion, other, lambda *_: None)
    monkeypatch.setattr(completion, way, lambda _, there, __: asked.append(there) or right)
    monkeypatch.setattr(
        completion, "settled", lambda _, there, *__, **___: seen.append(there) or there
    )
    for begun in (poor, right):
        assert completion.completed(held, begun, "temporal_denoise") is right
    assert asked == [poor]
    assert seen == [right] * 4


def test_a_poor_refit_goes_to_its_end_before_another_strength_is_held_against_it(held, monkeypatch):
    """A strength that ends in a valley beside it may lie lower than where it has come so far."""
    begun = start(held, _model(SIGMA, 0.25, 2), [])
    ended = start(held, _model(SIGMA, SHARE, 2), [])
    asked = []
    monkeypatch.setattr(completion, "converge", lambda _, there: asked.append(there) or ended)
    monkeypatch.setattr(completion, "along_bend", lambda _, there, __: asked.append(there))
    monkeypatch.setattr(completion, "settled", lambda _, there, *__, **___: there)
    assert completion.error_of(held, begun) > completion.POOR > completion.error_of(held, ended)
    completion.completed(held, begun, "temporal_denoise")
    assert asked[0] is begun
    assert begun not in asked[1:]


def test_numbers_that_were_bent_come_right_by_factor_and_shift():
    gain, other = (DigitalGain(g, 20.0) for g in (1.6, 1.25))
    model = NoiseModel((ReadNoise(2.0),), 100.0, POINT)
    right = unbent(model, gain)
    assert right.get("read_noise").sigma == pytest.approx(2.0 / 1.6)
    assert right.pedestal == pytest.approx(20.0 + 80.0 / 1.6)
    changed = unbent(model, gain, other=other)  # numbers that were right with the other
    assert changed.get("read_noise").sigma == pytest.approx(2.0 * 1.25 / 1.6)
    assert changed.pedestal == pytest.approx(20.0 + 80.0 * 1.25 / 1.6)
    assert unbent(model, gain, other=gain) is None


def test_other_strengths_of_a_filter_go_by_the_noise():
    """One far wider than the noise takes it as a Gaussian, and bends it; a narrower one not."""
    wide = Denoise(kind="bilateral", range=10.0, space=0.8)
    model = NoiseModel((ReadNoise(0.5), wide), 64.0, POINT)
    assert any(m.get("read_noise").sigma != 0.5 for m in _other_strengths(model, "denoise", 0.2))
    assert not list(_other_strengths(model, "denoise", np.inf))


def test_other_strengths_are_asked_for_with_the_noise_of_the_frames(held, monkeypatch):
    asked = []
    monkeypatch.setattr(bend, "_other_strengths", lambda _m, _n, noise: asked.append(noise) or [])
    begun = _model(SIGMA, 0.25, 2)
    assert along_bend(held, start(held, begun, knobs_of(begun)), "temporal_denoise") is None
    assert asked == [least_noise(held)]


def test_a_bilateral_bends_noise_far_below_its_range_as_a_gaussian_does():
    noise = NoiseModel((ReadNoise(0.01),), 64.0, POINT)
    filtered, other = (
        unbent(noise, Denoise(kind=k, space=1.0), 0.01) for k in ("bilateral", "gaussian")
    )
    assert filtered == other
    assert filtered.get("read_noise").sigma > 0.02


@pytest.mark.parametrize("kind", ["bilateral", "nlm"])
def test_noise_far_beyond_its_range_is_left_as_it_is(kind):
    noise = NoiseModel((ReadNoise(100.0, 0.3),), 64.0, POINT)
    there = unbent(noise, Denoise(kind=kind, space=1.0), 100.0).get("read_noise")
    assert there.sigma == pytest.approx(100.0, rel=0.05)
    assert there.spread == 0.0
    assert unbent(noise, Denoise(kind=kind, space=1.0)) is None  # nothing known of the noise
