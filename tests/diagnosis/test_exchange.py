"""An effect in the place of its relative."""

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.exchange import exchange
from dnanalyze.diagnosis.trial import error_of
from dnanalyze.fitting.design import design
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import converge, start
from dnanalyze.fitting.moments import moments
from dnanalyze.fitting.predictor import bench
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.start import ordinary_model
from dnanalyze.model.effects.amp_glow import AmpGlow
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.effects.row_noise import RowNoise

KNOWN = {"row_fpn": RowFpn, "row_noise": RowNoise}


@pytest.fixture(scope="module")
def held():
    return made({"row_fpn": {"level": "strong"}})


def made(hidden):
    sensor = draw_sensor(np.random.default_rng(11))
    return bench(design(generate(sensor, hidden, (128, 128), frames=4, seed=3)))


def fitted(held, effect):
    found = moments(Readings(held.measured[0]), held.plan.captures.sensor.black_level)
    model = ordinary_model(found).with_effect(effect)
    return converge(held, start(held, model, knobs_of(model)))


def test_noise_that_is_new_in_every_frame_gives_way_to_the_fixed_pattern_it_is_taken_for(held):
    state = fitted(held, RowNoise(0.5))
    others = {"row_fpn": RowFpn}
    found = exchange(held, state, ["row_noise"], others)
    assert found is not None
    assert (found.gone, found.found.effect) == ("row_noise", "row_fpn")
    assert found.without.model.get("row_noise") is None
    assert found.found.state.model.get("row_fpn") is not None
    assert found.found.evidence > 0
    assert exchange(held, state, ["row_noise"], {}) is None  # no relative may come
    assert exchange(held, state, [], others) is None  # nothing may go


def test_what_is_right_stays(held):
    state = fitted(held, RowFpn(1.0))
    assert exchange(held, state, ["row_fpn"], {"row_noise": RowNoise}) is None


def test_an_effect_begun_at_a_wrong_place_is_guessed_anew():
    held = made({"amp_glow": {"level": "strong", "corner": [1, 1]}})
    state = fitted(held, AmpGlow(1.0, 0.1, location="n"))
    found = exchange(held, state, ["amp_glow"], {})
    assert found is not None
    assert (found.gone, found.found.effect) == ("amp_glow", "amp_glow")
    assert found.found.state.model.get("amp_glow").location == "se"
    assert found.found.error < 0.5 * error_of(held, state)
