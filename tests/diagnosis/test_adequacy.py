"""What is left beyond what a second sensor of the model's make would show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.diagnosis.adequacy import (
    FEW,
    HASTY,
    Adequacy,
    adequacy,
    farthest,
    leaves,
    mends,
    on_average,
    sobered,
)
from dnanalyze.diagnosis.trial import judged
from dnanalyze.fitting.design import design
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import State, given, start
from dnanalyze.fitting.predictor import Bench, bench
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.flicker_fpn import FlickerFpn
from dnanalyze.model.effects.offset_drift import OffsetDrift
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

COLD, WARM = (OperatingPoint(t, 1.0, 1.0) for t in (25.0, 45.0))
BASE = (ReadNoise(4.0), PixelFpn(2.0), Quantization(12))


def _model(*more: object, seed: int) -> NoiseModel:
    return NoiseModel((*BASE, *more), 64.0, COLD, seed)


@pytest.fixture(scope="module")
def held() -> Bench:
    drifts = _model(OffsetDrift(1.0), seed=1)
    return bench(design(simulate(drifts, (128, 128), [(COLD, 8), (WARM, 8)])))


def _at(held: Bench, model: NoiseModel) -> State:
    return start(held, model, knobs_of(model))


def test_what_no_second_sensor_shows_is_left(held):
    found = adequacy(held, _at(held, _model(seed=2)))
    assert not found.adequate
    assert "drift" in found.left


@pytest.mark.parametrize("tolerable", [1.3, 0.0])
def test_nothing_is_left_of_a_sensor_of_the_same_make(held, monkeypatch, tolerable):
    """Nor where its error alone would not do: then its like stand as far off."""
    monkeypatch.setattr("dnanalyze.diagnosis.adequacy.TOLERABLE", tolerable)
    assert adequacy(held, _at(held, _model(OffsetDrift(1.0), seed=2))) == Adequacy(True, [])


def test_sensors_are_drawn_for_as_long_as_they_may_tell(held, monkeypatch):
    drawn = []
    replicate = Bench.replicate
    monkeypatch.setattr(
        Bench, "replicate", lambda self, *what: drawn.append(what) or replicate(self, *what)
    )
    begun = _at(held, _model(seed=2))
    for misfit, most in ((0.0, 0), (1.6, 11)):
        train, test = (misfit * (h.names == "temporal_noise") for h in (held.train, held.test))
        drawn.clear()
        assert adequacy(held, replace(begun, train=train, unseen=given(test))) == Adequacy(True, [])
        assert min(1, most) <= len(drawn) <= most
    drawn.clear()
    assert adequacy(held, begun, 3).left
    assert len(drawn) == 3


def test_two_sensors_are_drawn_to_say_that_something_is_left(held, monkeypatch):
    """And more where these do not say so."""
    counts = []
    of: dict[int, list[str]] = {}
    monkeypatch.setattr(
        "dnanalyze.diagnosis.adequacy.adequacy",
        lambda _, __, n: counts.append(n) or Adequacy(False, of[n]),
    )
    for hasty, few, asked in (
        (True, True, [HASTY]),
        (False, True, [HASTY, FEW]),
        (False, False, [HASTY, FEW]),
    ):
        counts.clear()
        of = {HASTY: ["drift"] * hasty, FEW: ["drift"] * few}
        assert leaves(held, None) == (hasty or few)
        assert counts == asked
    monkeypatch.undo()
    assert leaves(held, _at(held, _model(seed=2)))
    assert not leaves(held, _at(held, _model(OffsetDrift(1.0), seed=2)))


@pytest.mark.parametrize(
    ("expected", "scatter", "error", "adequate"),
    [
        (1.4, 0.1, 1.7, True),
        (1.4, 0.1, 1.9, False),
        (1.4, 1.0, 1.9, True),
        (3.0, 1.0, 2.1, False),  # its phases drawn anew, nothing of this make would be too far off
        (1.0, 0.01, 1.2, True),
    ],
)
def test_luck_excuses_a_misfit_up_to_an_error_of_two(
    held, monkeypatch, expected, scatter, error, adequate
):
    errors = iter([expected - scatter, expected + scatter] * 6)
    monkeypatch.setattr("dnanalyze.diagnosis.adequacy.error_of", lambda *_: error)
    monkeypatch.setattr("dnanalyze.diagnosis.adequacy.pooled", lambda *_: next(errors))
    at = _at(held, _model(OffsetDrift(1.0), seed=2))
    assert adequacy(held, at) == Adequacy(adequate, [])


def test_the_farthest_are_told_worst_first(held):
    begun = _at(held, _model(seed=2))
    sizes = {"temporal_noise": (3.0, 9.0), "mean": (5.0, 4.0), "median": (50.0, 0.0)}
    train, test = (
        np.array([sizes.get(str(n), (0.0, 0.0))[i] for n in half.names])
        for i, half in enumerate((held.train, held.test))
    )
    state = replace(begun, train=train, unseen=given(test))
    assert farthest(held, state, 2) == ["mean", "temporal_noise"]


def test_an_average_sensor_is_the_mean_of_some_and_scatters_less(held):
    model = _model(OffsetDrift(1.0), seed=2)
    own, calm = _at(held, model), on_average(held, _at(held, model), 3)[1]
    drawn = [held.replicate(model, r) for r in range(3)]
    for side, half, single, mean in (
        (0, held.train, own.train, calm.train),
        (1, held.test, own.test, calm.test),
    ):
        every = np.array([single, *(half.z(d[side]) for d in drawn)])
        told = np.isfinite([d[side] for d in drawn]).all(axis=0)
        np.testing.assert_allclose(mean[told], every.mean(axis=0)[told], atol=1e-6)
        assert np.mean(mean**2) < np.mean(every**2)


def test_where_the_luck_of_one_sensor_is_the_measured_ones_too_it_lies_at_the_average(held):
    own = _at(held, _model(OffsetDrift(1.0), seed=2))
    bench, calm = on_average(replace(held, part=held), own, 3)
    again = _at(bench, own.model)
    np.testing.assert_allclose(again.train, calm.train, atol=1e-6)
    np.testing.assert_allclose(again.test, calm.test, atol=1e-6)
    assert bench.part is None  # of which nothing is known


def test_the_effect_mends_it_and_another_does_not(held):
    before = _at(held, _model(seed=2))
    left = adequacy(held, before).left
    right = _at(held, _model(OffsetDrift(1.0), seed=2))
    assert mends(held, left, before, right)
    assert not mends(held, left, before, before)
    assert not mends(held, [], before, right)


def test_one_thing_is_mended_where_it_is_put_right_on_both_halves(held):
    before = _at(held, _model(seed=2))
    train, test = (
        np.where(half.names == "drift", 0.0, z)
        for half, z in ((held.train, before.train), (held.test, before.test))
    )
    left = ["drift", "temporal_noise"]
    assert mends(held, left, before, replace(before, train=train, unseen=given(test)))
    assert not mends(held, left, before, replace(before, unseen=given(test)))
    assert not mends(held, left[1:], before, replace(before, train=train, unseen=given(test)))


def test_what_is_put_right_of_one_sensors_clouds_is_luck():
    clouds = FlickerFpn(3.0, 2.0)
    points = [(OperatingPoint(t, 1.0, 1.0), 6) for t in (15.0, 25.0, 35.0, 45.0)]
    seen = bench(design(simulate(_model(clouds, seed=1), (128, 128), points)))
    before = _at(seen, _model(clouds, seed=2))
    shaded = [
        np.char.startswith(half.names.astype(str), "shading") for half in (seen.train, seen.test)
    ]
    train, test = (
        np.where(s, 0.0, z) for s, z in zip(shaded, (before.train, before.test), strict=True)
    )
    found = judged(seen, before, "glow", replace(before, train=train, unseen=given(test)))
    sober = sobered(seen, before, found)
    assert found.evidence > 60
    assert sober.evidence < 0.7 * found.evidence


def test_what_no_luck_makes_keeps_its_evidence():
    noisy = NoiseModel((ReadNoise(5.0), *BASE[1:]), 64.0, COLD, 1)
    seen = bench(design(simulate(noisy, (128, 128), [(COLD, 8), (WARM, 8)])))
    before = _at(seen, _model(seed=2))
    louder = replace(noisy, seed=2)
    found = judged(seen, before, "more_noise", _at(seen, louder))
    assert found.falls.sum() / 2.0 == pytest.approx(found.evidence)
    assert sobered(seen, before, found).evidence > 0.7 * found.evidence > 60
