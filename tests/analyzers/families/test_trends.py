import math

import numpy as np
import pytest
from dark_frames import captures_of

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.analyzers.estimators.arrhenius import arrhenius_laws, doubts
from dnanalyze.analyzers.families.trends import Series, dark_signal, law_doubts
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.loaders.captures import OperatingPoint, Sensor
from dnanalyze.thermal import BOLTZMANN_EV, KELVIN

SHAPE = (64, 64)


def rate(celsius, energy, at_25=4.0):
    inverse = 1 / (np.asarray(celsius) + KELVIN) - 1 / (25 + KELVIN)
    return at_25 * np.exp(-energy / BOLTZMANN_EV * inverse)


def series(celsius, exposure, level, error=0.02):
    celsius, exposure = np.broadcast_arrays(np.asarray(celsius, float), np.asarray(exposure, float))
    level = np.asarray(level, float)
    return Series(celsius + KELVIN, exposure, level, np.full(level.size, error), True)


def pull(value, truth):
    return (value.value - truth) / value.se


def test_one_population_over_temperature():
    celsius = np.arange(0, 61, 10)
    kelvin = celsius + KELVIN
    pulls = []
    for seed in range(100):
        noise = 1 + 0.02 * np.random.default_rng(seed).normal(size=7)
        found = arrhenius_laws(kelvin, rate(celsius, 0.65) * noise, np.full(7, 0.02))
        pulls.append(pull(found["activation_energy_ev"], 0.65))
        assert "activation_share" not in found
    assert abs(np.mean(pulls)) < 0.5
    assert 0.6 < np.std(pulls) < 1.2  # the error grows with a bad fit, it never shrinks
    middle = 2 / (1 / kelvin[0] + 1 / kelvin[-1])
    step = found["doubling_step_c"].value
    energy = found["activation_energy_ev"].value
    assert step == pytest.approx(BOLTZMANN_EV * middle**2 * math.log(2) / energy)


def test_two_populations_over_temperature():
    celsius = np.arange(-20, 81, 10)
    rates = rate(celsius, 0.55) + rate(celsius, 1.2)
    noise = 1 + 0.01 * np.random.default_rng(1).normal(size=celsius.size)
    found = arrhenius_laws(celsius + KELVIN, rates * noise, np.full(celsius.size, 0.01))
    assert abs(pull(found["activation_energy_1_ev"], 0.55)) < 4
    assert abs(pull(found["activation_energy_2_ev"], 1.2)) < 4
    assert found["activation_energy_1_ev"].se < 0.05


def test_pedestal_of_a_temperature_series_alone():
    celsius = np.arange(-10, 61, 10)
    level = 64.0 + rate(celsius, 0.63)
    found, rates = dark_signal(series(celsius, 1.0, level))
    assert abs(found["pedestal"].value - 64.0) < 5 * found["pedestal"].se
    assert found["pedestal"].se < 0.2
    assert found["activation_energy_ev"].value == pytest.approx(0.63, abs=0.02)
    assert rates[-1].value == pytest.approx(rate(60, 0.63), rel=0.01)


def test_pedestal_of_exposures_at_one_temperature():
    exposure = np.array([1.0, 5.0, 20.0, 60.0])
    found, rates = dark_signal(series(25.0, exposure, 100.0 + 0.3 * exposure))
    assert found["pedestal"].value == pytest.approx(100.0, abs=0.01)
    assert rates[-1].value == pytest.approx(0.3, rel=1e-3)
    assert "activation_energy_ev" not in found


def test_bias_frames_carry_a_pedestal_that_moves_with_temperature():
    celsius = np.repeat(np.arange(-40, 21, 10), 2)
    exposure = np.tile([0.0, 30.0], 7)
    pedestal = 500 + 0.8 * celsius
    level = pedestal + exposure * rate(celsius, 0.7)
    found, rates = dark_signal(series(celsius, exposure, level))
    assert found["activation_energy_ev"].value == pytest.approx(0.7, abs=0.01)
    assert rates[1].value == pytest.approx(rate(-40, 0.7), abs=5 * rates[1].se)
    assert rates[-1].value == pytest.approx(rate(20, 0.7), rel=1e-3)


def test_a_black_level_pins_what_two_temperatures_cannot():
    level = 64.0 + rate([20.0, 50.0], 0.65)
    assert dark_signal(series([20.0, 50.0], 1.0, level)) == ({}, [])
    found, _ = dark_signal(series([20.0, 50.0], 1.0, level), black_level=64.0)
    assert abs(pull(found["activation_energy_ev"], 0.65)) < 4


def test_captures_over_temperature_have_laws_and_rates_and_lasting_hot_pixels():
    rng = np.random.default_rng(3)
    hot = np.where(rng.random(SHAPE) < 0.02, 25.0, 1.0) * np.exp(0.2 * rng.normal(size=SHAPE))
    made = []
    for celsius in (0, 15, 30, 45, 60):
        dark = rate(celsius, 0.65) * hot
        frames = [np.rint(64 + dark + rng.normal(size=SHAPE)).astype(np.uint16) for _ in range(4)]
        made.append((OperatingPoint(float(celsius), 1.0), frames))
    statistics = analyze(captures_of(made))
    trends = statistics.trends
    assert abs(pull(trends["pedestal"], 64.0)) < 4
    assert trends["activation_energy_ev"].value == pytest.approx(0.65, abs=0.05)
    assert trends["hot_repeat_settings"].value > 0.9
    warmest = statistics.settings[-1].values["dark_rate_dn_s"]
    assert warmest.value == pytest.approx(rate(60, 0.65), rel=0.05)


def test_one_setting_has_no_trend():
    frames = [np.random.default_rng(4).integers(90, 110, SHAPE).astype(np.uint16)] * 2
    assert analyze(captures_of([(OperatingPoint(), frames)])).trends == {}


def test_a_black_level_between_two_taps_is_uncertain_by_their_distance():
    rng = np.random.default_rng(6)
    taps = np.where(np.arange(SHAPE[1]) < 32, 1000, 1150)
    made = [
        (
            OperatingPoint(25.0, exposure),
            [(taps + 0.2 * exposure + rng.normal(0, 3, SHAPE)).round() for _ in range(4)],
        )
        for exposure in (0.0, 300.0)
    ]
    found = analyze(captures_of(made)).trends["pedestal"]
    assert found.se > 30
    one = [(point, [f[:, :32] for f in frames]) for point, frames in made]
    found = analyze(captures_of(one)).trends["pedestal"]
    assert found.value == pytest.approx(1000, abs=4 * found.se)
    assert found.se < 0.5


def test_no_energy_is_told_over_a_span_that_the_thermometer_blurs():
    # jitter of .4 C: a rise of 20 % over it would be 2.5 eV
    celsius = np.array([-17.26, -17.2, -17.03, -16.86])
    level = 100.0 + np.array([0.0, 200.0, 220.0, 240.0])
    found, rates = dark_signal(series(celsius, [0.0, 1.0, 1.0, 1.0], level))
    assert "activation_energy_ev" not in found
    assert "doubling_step_c" not in found
    assert rates[1].value == pytest.approx(200.0)


def test_no_pedestal_comes_of_a_law_over_such_a_span():
    celsius = np.array([20.0, 21.1, 22.2])
    found, _ = dark_signal(series(celsius, 1.0, [100.0, 110.0, 125.0]))
    assert found == {}


@pytest.mark.parametrize(
    ("energy", "se", "said"),
    [(0.65, 0.02, False), (0.15, 0.03, False), (0.05, 0.02, True), (1.6, 0.1, False),
     (1.7, 0.05, True), (-0.3, 0.05, True)],
)  # fmt: skip
def test_an_energy_outside_those_of_dark_current_is_doubted(energy, se, said):
    found = doubts({"activation_energy_ev": Value(energy, se), "doubling_step_c": Value(99.0, 9.0)})
    assert bool(found) == said
    assert not said or (f"{energy:g}" in found[0] and "doubling every 99 C" in found[0])


def test_doubts_are_told_channel_by_channel():
    def setting(channel, celsius, exposure, level):
        point = OperatingPoint(celsius, exposure, None, channel)
        values = {"median": Value(level, 0.0), "drift": Value(0.01, 0.5)}
        return SettingStatistics(point, "", 4, (64, 64), values)

    settings = []
    for channel, energy in (("hcg", 0.6), ("lcg", 0.02)):
        for t in (0.0, 20.0, 40.0, 60.0):
            settings.append(setting(channel, t, 0.0, 64.0))
            settings.append(setting(channel, t, 1.0, 64.0 + float(rate(t, energy, 40.0))))
    (text,) = law_doubts(Statistics("", Sensor((64, 64)), tuple(settings)))
    assert text.startswith("Channel lcg: The activation energy of 0.02")
