"""The baseline effects."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.baseline import lacks_baseline, with_baseline
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.least_squares import start
from dnanalyze.fitting.predictor import bench
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import EVERYDAY, built_in


@pytest.fixture(scope="module")
def held():
    sensor = replace(
        draw_sensor(np.random.default_rng(7)), gain_dn_e=1.5, read_noise_e=4.0, dark_e_s=60.0,
        exposure_s=1.0, dark_spread=0.3,
    )  # fmt: skip
    return bench(design(generate(sensor, {}, (128, 128), frames=4, seed=3)))


@pytest.fixture(scope="module")
def stages(held):
    told = []
    full = with_baseline(held, start(held, paper_start(held), []), (), lambda *s: told.append(s))
    assert told[-1][1] is full
    return told


def test_each_of_the_four_is_stated_with_its_state(stages):
    assert [name for name, _ in stages] == list(EVERYDAY)
    for count, (_, state) in enumerate(stages, 1):
        assert set(EVERYDAY[:count]) <= set(state.model.names)
        assert not set(EVERYDAY[count:]) & set(state.model.names)
    assert stages[-1][1].loss < stages[0][1].loss


def test_the_conversion_gain_and_the_noise_are_the_sensors(stages):
    model = stages[-1][1].model
    # 8,192 pixels of 4 frames at 5 temperatures: the slope of the variance is good to 2 %
    assert model.get("dark_shot_noise").dn_per_e == pytest.approx(1.5, rel=0.1)
    assert model.get("read_noise").sigma == pytest.approx(6.0, rel=0.1)


def test_an_excluded_effect_is_left_out(held):
    told = []
    paper = start(held, paper_start(held), [])
    full = with_baseline(held, paper, ("dark_shot_noise",), lambda name, _: told.append(name))
    assert told == [n for n in EVERYDAY if n != "dark_shot_noise"]
    assert full.model.get("dark_shot_noise") is None


def test_the_simulated_sensor_stays_that_of_the_seed(held):
    paper = replace(paper_start(held), seed=5)
    full = with_baseline(held, start(held, paper, []), (), lambda *_: None)
    assert full.model.seed == 5


def test_a_model_with_any_of_them_lacks_none():
    model = NoiseModel((built_in()["convolved_lognormal"](),))
    assert lacks_baseline(model)
    assert lacks_baseline(model, exclude=EVERYDAY[:3])
    assert not lacks_baseline(model, exclude=EVERYDAY)
    assert not lacks_baseline(model.with_effect(built_in()["read_noise"]()))
