"""The conversion gain of a sensor without charge, and of one with it."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.everyday import FAR_OFF, everyday, spread_out, told_gain
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import converge, start
from dnanalyze.fitting.predictor import Bench, bench
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate


def of_dark(dark_e_s):
    sensor = replace(
        draw_sensor(np.random.default_rng(7)), gain_dn_e=1.5, read_noise_e=4.0, dark_e_s=dark_e_s,
        exposure_s=1.0, dark_spread=0.3,
    )  # fmt: skip
    return bench(design(generate(sensor, {}, (128, 128), frames=4, seed=3)))


def of_paper(on):
    return start(on, paper_start(on), [])


def at_gain(model, k):
    return model.with_effect(replace(model.get("dark_shot_noise"), dn_per_e=k))


@pytest.mark.parametrize(("charge", "held"), [(False, True), (True, False)])
def test_the_gain_goes_back_to_the_beginnings_only_where_no_charge_tells_it(charge, held):
    on = of_dark(60.0)
    model = everyday(on, of_paper(on), (), lambda *_: None).model
    if not charge:
        model = model.with_effect(replace(model.get("convolved_lognormal"), mu=-12.0))
    k = model.get("dark_shot_noise").dn_per_e
    state = start(on, model, knobs_of(model))
    kept = told_gain(on, state, at_gain(model, 6.0 * k))
    assert kept.model.get("dark_shot_noise").dn_per_e == pytest.approx(6.0 * k if held else k)
    for near in (0.5, 2.0):
        assert told_gain(on, state, at_gain(model, near * k)) is state


def test_without_shot_noise_in_the_model_there_is_no_gain_to_tell():
    on = of_dark(60.0)
    model = everyday(on, of_paper(on), ("dark_shot_noise",), lambda *_: None).model
    assert model.get("dark_shot_noise") is None
    state = start(on, model, [])
    assert told_gain(on, state, model) is state


def test_each_of_the_four_is_told_with_its_error():
    on, told = of_dark(60.0), []
    full = everyday(on, of_paper(on), (), lambda *step: told.append(step))
    assert [name for name, _ in told] == [
        "read_noise", "pixel_fpn", "dark_shot_noise", "quantization",
    ]  # fmt: skip
    assert told[-1][1] is full
    assert full.loss < told[0][1].loss
    assert {name for name, _ in told} <= set(full.model.names)


def test_a_stage_is_tried_at_the_papers_pedestal_only_where_it_would_be_worse(monkeypatch):
    on = of_dark(60.0)
    paper, tried, told = of_paper(on), [], []
    sizes = {(1, True): 1.2, (1, False): 1.1, (2, True): 0.5, (3, True): 0.6, (3, False): 0.7}

    def named(_found, _paper, full, names, pedestal):
        tried.append((len(names), pedestal == full.pedestal))
        return tried[-1]

    def off(self, size):
        return [
            held.coordinates - size * z * held.floor
            for held, z in ((self.train, paper.train), (self.test, paper.test))
        ]

    monkeypatch.setattr("dnanalyze.diagnosis.everyday.partly_named", named)
    monkeypatch.setattr(Bench, "coordinates", lambda self, model: off(self, sizes[model]))
    everyday(on, paper, (), lambda _, state: told.append(state))
    assert tried == list(sizes)
    for size, state in zip((1.1, 0.5, 0.6), told, strict=False):
        np.testing.assert_allclose(state.train, size * paper.train, atol=1e-6)
        np.testing.assert_allclose(state.test, size * paper.test, atol=1e-6)


def test_at_rest_the_derivatives_of_the_part_will_do(monkeypatch):
    on, trusted = of_dark(60.0), []

    def settled(bench, begun, own=False, hopeless=np.inf):
        trusted.append(own)
        assert hopeless == FAR_OFF
        return converge(bench, begun)

    monkeypatch.setattr("dnanalyze.diagnosis.everyday.converge", settled)
    everyday(on, of_paper(on), (), lambda *_: None)
    assert trusted == [True]


@pytest.mark.parametrize("spread", [0.0, 0.4])
def test_a_spread_of_read_noise_is_tried_where_none_was_fitted(spread):
    """At none at all no derivative tells of any; where there is none the fit stays as it is."""
    points = [OperatingPoint(t, 0.1) for t in (25.0, 45.0)]
    names = ("convolved_lognormal", "dark_shot_noise", "read_noise", "pixel_fpn", "quantization")
    plain = NoiseModel(tuple(built_in()[n]() for n in names), 64.0, points[0], seed=4)
    sensor = plain.with_effect(ReadNoise(4.0, spread))
    on = bench(design(simulate(sensor, (128, 128), [(p, 8) for p in points])))
    without = plain.with_effect(ReadNoise(4.0 * np.exp(spread**2), 0.0))  # as noisy on average
    state = start(on, without, knobs_of(without))
    found = spread_out(on, state)
    if not spread:
        assert found is state
    else:
        assert found.loss < state.loss
        # 8 frames of 8,192 pixels: the log of a variance is told to .5 a pixel
        assert found.model.get("read_noise").spread == pytest.approx(spread, abs=0.04)
