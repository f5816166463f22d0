"""A pattern learned from frames: its map and law, and that chance is no pattern."""

import numpy as np
import pytest

import dnanalyze
from dnanalyze.description.pattern import LearnedPattern, learn_pattern
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.model.learned.field_map import FieldMap
from dnanalyze.model.learned.pattern_map import PatternMap
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate
from dnanalyze.thermal import arrhenius

SHAPE = 64, 96
AT = OperatingPoint(25.0, 0.1, 1.0)
POINTS = [(OperatingPoint(t, 0.1, 1.0), 6) for t in (25.0, 45.0, 65.0)]
NOISE = dnanalyze.catalogue()["read_noise"](sigma=2.0)
RISE = np.linspace(-3.0, 3.0, SHAPE[1], dtype=np.float32)
PATTERN = np.tile(RISE, (SHAPE[0], 1))


def captures(*effects, seed=3):
    return simulate(NoiseModel((NOISE, *effects), 64.0, AT, seed), SHAPE, POINTS)


MODEL = NoiseModel((NOISE,), 64.0, AT, seed=9)


@pytest.mark.parametrize(("law", "energy"), [("constant", 0.0), ("thermal", 0.3)])
def test_map_and_law_are_those_of_the_sensor(law, energy):
    hidden = PatternMap(law=law, ea_ev=energy, map=FieldMap(PATTERN))
    found = learn_pattern(captures(hidden), MODEL)
    assert found.effect.law == law
    if law == "thermal":
        assert found.effect.ea_ev == pytest.approx(energy, abs=0.03)
        growth = [arrhenius(p.temperature_c, 25.0, energy) for p, _ in POINTS]
        assert found.sizes == pytest.approx(growth, rel=0.1)
    # six frames of 2 DN at three points: chance of 2 / sqrt(18) DN in a pixel, less in few modes
    assert np.std(found.effect.map.array - PATTERN) < 0.25
    assert found.supported
    assert found.frames_share > 0.9
    assert found.points_share > 0.8
    assert found.error_after < found.error_before
    assert "Pattern of this sensor" in found.summary()
    assert found.to_dict()["law"] == law
    assert len(found.to_dataframe()) == len(POINTS)
    assert len(found.plot()) == 2


def test_chance_is_no_pattern():
    found = learn_pattern(captures(), MODEL)
    assert not found.supported
    assert found.rms == 0
    assert found.sentence().startswith("No fixed pattern")


def test_single_frames_and_a_second_pattern_are_refused():
    single = simulate(MODEL, SHAPE, [(AT, 1)])
    with pytest.raises(InputError, match="one frame at each operating point"):
        learn_pattern(single, MODEL)
    with pytest.raises(InputError, match="already has the effect 'pattern_map'"):
        learn_pattern(captures(), MODEL.with_effect(PatternMap(map=FieldMap(PATTERN))))


def test_a_pattern_that_raises_the_error_is_not_added():
    effect = PatternMap(map=FieldMap(PATTERN))
    one, measured = np.ones(1), captures()
    found = LearnedPattern(measured, effect, MODEL, 1.7, one, one, [], 0.1, 0.1, 1.45, 1.76)
    assert not found.supported
    assert "rises from 1.45 to 1.76" in found.sentence()
    assert LearnedPattern(measured, effect, MODEL, 1.7, one, one, [], 0.1, 0.1, 1.45, 1.5).supported


def test_the_map_takes_the_place_of_a_fixed_structure():
    wave = CompositeEffect(where="wave", u=0.05, amplitude=2.0)
    blink = CompositeEffect(where="blob", when="switching", distribution="on_off")
    hidden = PatternMap(map=FieldMap(PATTERN))
    names = [
        learn_pattern(captures(hidden), MODEL.with_effect(e)).model.names for e in (wave, blink)
    ]
    assert names == [["read_noise", "pattern_map"], ["read_noise", "composite", "pattern_map"]]
