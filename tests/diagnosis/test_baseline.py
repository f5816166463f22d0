"""The baseline effects."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.baseline import (
    baseline_fitted,
    baseline_start,
    lacks_baseline,
    reasons,
)
from dnanalyze.diagnosis.search_path import Path
from dnanalyze.diagnosis.stepwise import Search
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.state import start
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, BASELINE, WANG, built_in


@pytest.fixture(scope="module")
def problem():
    sensor = replace(
        draw_sensor(np.random.default_rng(7)), gain_dn_e=1.5, read_noise_e=4.0, dark_e_s=60.0,
        exposure_s=1.0, dark_spread=0.3,
    )  # fmt: skip
    made = generate(sensor, {}, (128, 128), sensor.temperatures_c[::2], frames=4, seed=3)
    return fit_problem(design(made))


@pytest.fixture(scope="module")
def model(problem):
    return baseline_fitted(problem, baseline_start(problem)).model


def test_all_four_are_in_the_model(model):
    assert set(model.names) == {BASE, *BASELINE}


def test_the_conversion_gain_and_the_noise_are_the_sensors(model):
    # 8,192 pixels of 4 frames at 3 temperatures: the slope of the variance is good to 3 %
    assert model.get("dark_shot_noise").dn_per_e == pytest.approx(1.5, rel=0.1)
    assert model.get("read_noise").sigma == pytest.approx(6.0, rel=0.1)


def test_an_excluded_effect_is_left_out(problem):
    begun = baseline_start(problem, ["dark_shot_noise"])
    assert set(begun.names) == {BASE, *BASELINE} - {"dark_shot_noise"}


def test_the_simulated_sensor_is_that_of_the_seed(problem):
    assert baseline_start(problem, seed=5).seed == 5


def test_a_search_states_them_one_by_one_with_the_error_of_all(problem):
    search = Search(problem, {})
    path = search._with_baseline(Path(start(problem, paper_start(problem), [])), ())
    assert [s.added for s in path.steps] == [n for n in BASELINE if n not in WANG]
    assert len({s.error for s in path.steps}) == 1


def test_a_model_with_any_of_them_lacks_none():
    model = NoiseModel((built_in()["convolved_lognormal"](),))
    assert lacks_baseline(model)
    assert lacks_baseline(model, exclude=BASELINE[:3])
    assert not lacks_baseline(model, exclude=BASELINE)
    rounded = model.with_effect(built_in()["quantization"]())
    assert lacks_baseline(rounded)
    assert not lacks_baseline(rounded, exclude=BASELINE[:3])
    assert not lacks_baseline(model.with_effect(built_in()["read_noise"]()))


def test_shared_amplifiers_are_told():
    assert len(reasons(ReadNoise(1.0))) == 1
    assert "2x1 (rows x columns) share an amplifier" in reasons(ReadNoise(1.0, shared="2x1"))[1]
