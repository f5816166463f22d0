"""The plain-formula generator of the truth suite, against its formulas."""

import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from scipy.constants import physical_constants

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from third_party.answers import ANSWERS
from third_party.case import FRAMES, SHAPE, Case
from third_party.cases import of_generator
from third_party.folders import read, truth, write
from third_party.generators import plain
from third_party.measures import STATISTICS
from third_party.verify import measure

BOLTZMANN = physical_constants["Boltzmann constant in eV/K"][0]

SENSOR = plain.Sensor(
    gain=0.8,
    read_e=3.0,
    offset_e=0.5,
    dark_e=200.0,
    spread=0.3,
    gap_ev=1.2,
    pedestal=100.0,
    exposure_s=0.5,
    temperatures_c=(20.0, 50.0),
)


@pytest.fixture(scope="module")
def ordinary():
    """Stacks of the coldest and the hottest point."""
    stacks = plain.expose(SENSOR, (), seed=3)
    return [stacks[p] for p in sorted(stacks)]


def test_mean_and_shot_noise_follow_the_dark_current(ordinary):
    cold, hot = ordinary
    assert hot.mean() == pytest.approx(100 + 0.8 * 200, rel=0.005)
    assert cold.mean() == pytest.approx(100 + 0.8 * 200 * SENSOR.growth(20.0), rel=0.005)
    variance = hot.astype(float).var(axis=0, ddof=1).mean()
    assert variance == pytest.approx(0.64 * (9 + 200) + 1 / 12, rel=0.02)


def test_dark_current_grows_by_half_the_gap():
    kelvin = np.array([293.15, 323.15])
    rate = kelvin**1.5 * np.exp(-1.2 / (2 * BOLTZMANN * kelvin))
    assert SENSOR.growth(20.0) == pytest.approx(rate[0] / rate[1])


def test_fixed_maps_stay_and_noise_does_not(ordinary):
    _, hot = ordinary
    first, second = hot[0].astype(float).ravel(), hot[1].astype(float).ravel()
    fixed = (0.8 * 200) ** 2 * np.expm1(0.3**2) + (0.8 * 0.5) ** 2
    correlation = fixed / (fixed + 0.64 * (9 + 200) + 1 / 12)
    assert np.corrcoef(first, second)[0, 1] == pytest.approx(correlation, abs=0.01)


def test_a_seed_gives_the_same_frames_and_another_does_not():
    recipe = plain.RECIPES["row_noise"]
    one, same, other = (recipe.draw(0.5, seed) for seed in (5, 5, 6))
    point = max(one.stacks)
    np.testing.assert_array_equal(one.stacks[point], same.stacks[point])
    assert not np.array_equal(one.stacks[point], next(reversed(other.stacks.values())))


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_noise_of_the_chain_has_its_power_law_and_deviation(power):
    rng = np.random.default_rng(1)
    noise = np.array([plain.chain(rng, 4096, power) for _ in range(200)])
    spectrum = np.mean(np.abs(np.fft.rfft(noise * np.hanning(4096))) ** 2, axis=0)
    low, high = spectrum[16:24].mean(), spectrum[256:384].mean()
    assert np.log(low / high) / np.log(16) == pytest.approx(power, abs=0.08)


@pytest.mark.parametrize("name", ["row_noise", "column_fpn", "narrow_hot", "offset_plane"])
def test_the_frames_show_what_an_effect_claims(name):
    recipe = plain.RECIPES[name]
    drawn = recipe.draw(recipe.amounts[1], 11)
    measured = measure(drawn.stacks, [asdict(c) for c in drawn.claims])
    assert measured
    assert all(m.holds for m in measured), [str(m) for m in measured]


def test_a_claim_fails_on_frames_that_do_not_show_it():
    claims = plain.RECIPES["row_noise"].draw(0.8, 11).claims
    without = plain.RECIPES["ordinary_1"].draw(0.0, 11).stacks
    assert not any(m.holds for m in measure(without, [asdict(c) for c in claims]))


def test_measured_row_noise_is_clear_of_the_white_noise():
    rng = np.random.default_rng(2)
    white = 3.0 * rng.standard_normal((FRAMES, *SHAPE))
    rows = 0.5 * rng.standard_normal((FRAMES, SHAPE[0], 1))
    assert STATISTICS["row_noise_sd"](white + rows) == pytest.approx(0.5, rel=0.08)
    assert STATISTICS["row_noise_sd"](white) < 0.1


def test_every_plain_case_has_a_name_of_its_own_and_an_answer():
    cases = of_generator("plain")
    assert len({c.key for c in cases}) == len({c.seed for c in cases}) == len(cases)
    assert {kind for c in cases for kind in c.recipe.hides} <= set(ANSWERS)


def test_a_new_series_has_new_seeds():
    assert not {c.seed for c in of_generator("plain")} & {c.seed for c in of_generator("plain", 1)}


def test_a_folder_is_read_as_it_was_written(tmp_path):
    case = Case("plain", "row_noise", 0, plain.RECIPES["row_noise"])
    drawn = case.drawn()
    folder = write(case, drawn, tmp_path)
    stacks = read(folder)
    assert set(stacks) == set(drawn.stacks)
    for point, stack in drawn.stacks.items():
        np.testing.assert_array_equal(stacks[point], stack)
    assert truth(folder)["hides"] == ["row_noise"]
    assert len(truth(folder)["claims"]) == len(drawn.claims)
