"""EMVA quantities against closed forms, on frames whose sensor is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from known_sensor import doubling_step, sensor_frames

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.emva import Emva, Quantity, evaluate
from dnanalyze.errors import InputError

# Of the mean square of pulls of a gain: its error holds that of charge shared between neighbours,
# of which these sensors have none.
COUPLED = 0.03
EXPOSURES = [(25.0, t, 6) for t in (0.0, 1.0, 2.0, 4.0, 6.0, 8.0)]


def of(captures, **options) -> Emva:
    return evaluate(analyze(captures, workers=1), **options)


def pull(quantity: Quantity, truth: float) -> float:
    assert quantity.determined, quantity.reason
    return (quantity.value - truth) / quantity.se


def within(pulls: list[float], least: float = 0.25) -> None:
    """Standard normal by their mean square and their mean; ``least`` of the mean square."""
    n, values = len(pulls), np.array(pulls)
    assert abs(values.mean()) < 4 / math.sqrt(n)
    assert least < float(np.mean(values**2)) < 1 + 4 * math.sqrt(2 / n)


def test_gain_and_dark_current_from_exposures_are_those_of_the_sensor():
    """K by photon transfer; mu_c of the realised pixels in DN/s and e-/s."""
    gains, currents, electrons, offsets = [], [], [], []
    for seed in range(8):
        group = of(sensor_frames(seed, EXPOSURES)).groups[0]
        gains.append(pull(group.quantities["photon_transfer_gain_dn_e"], 0.8))
        rng = np.random.default_rng([seed, 1288])
        rate = 40.0 * np.exp(0.3 * rng.normal(size=(96, 128)) - 0.045)
        found = group.dark_currents[0].quantities
        currents.append(pull(found["dark_current_mean_dn_s"], 0.8 * rate.mean()))
        electrons.append(pull(found["dark_current_mean_e_s"], rate.mean()))
        offsets.append(
            pull(found["mean_dark_signal_0_dn"], 100 + rng.normal(size=(96, 128)).mean())
        )
        assert found["dark_current_var_e_s"].reason == "K itself comes from the variance"
    within(gains, COUPLED)
    within(currents)
    within(electrons, COUPLED)
    # its error is that of a frame of any exposure, and at exposure 0 frames scatter less
    assert np.mean(np.square(offsets)) < 1.5


@pytest.mark.parametrize(
    ("sensor", "tolerance"),
    [
        ({"spread": 0.3}, 0.01),
        ({"spread": 1.0}, 0.015),
        ({"spread": 0.6, "read_spread": 0.5, "read_e": 5.0}, 0.03),
        ({"spread": 0.3, "coupling": 0.005}, 0.02),
        ({"spread": 0.3, "coupling": 0.02}, 0.02),
        ({"spread": 0.6, "coupling": 0.05}, 0.04),
    ],
)
def test_gain_of_unlike_and_of_coupled_pixels(sensor, tolerance):
    """Mean over eight sensors: charge and read noise that differ, charge shared with neighbours."""
    points = [(25.0, t, 6) for t in (0.1, 0.5, 1.5, 4.0)]
    found = []
    for seed in range(8):
        group = of(sensor_frames(seed, points, (160, 160), gain=1.3, **sensor)).groups[0]
        gain = group.quantities["photon_transfer_gain_dn_e"]
        assert abs(pull(gain, 1.3)) < 4.5
        found.append(gain.value)
    assert np.mean(found) == pytest.approx(1.3, rel=tolerance)


def test_dark_current_from_the_variance_with_a_known_gain():
    pulls = []
    for seed in range(8):
        found = of(sensor_frames(seed, EXPOSURES), system_gain_dn_e=0.8).groups[0]
        assert found.quantities["system_gain_dn_e"].note == "given"
        rate = 40 * np.exp(0.3 * np.random.default_rng([seed, 1288]).normal(size=(96, 128)) - 0.045)
        quantity = found.dark_currents[0].quantities["dark_current_var_e_s"]
        pulls.append(pull(quantity, rate.mean()))
    within(pulls)


def test_temporal_dark_noise_in_electrons_is_read_and_shot_noise_without_quantization():
    pulls = []
    for seed in range(10):
        found = of(sensor_frames(seed, [(25.0, 1.0, 8)], gain=0.4), system_gain_dn_e=0.4)
        quantity = found.groups[0].points[0].quantities["temporal_dark_noise_e"]
        pulls.append(pull(quantity, math.sqrt(3.0**2 + 40.0)))
    within(pulls)


def test_dsnu_split_recovers_rows_columns_and_pixels():
    """Against the standard deviations that were drawn, rows that move in time not among them."""
    pulls = {"row": [], "col": [], "pixel": [], "": []}
    for seed in range(10):
        captures = sensor_frames(
            seed, [(25.0, 0.5, 6)], row_dn=0.6, col_dn=0.9, pixel_dn=2.0, row_noise_dn=1.0
        )
        found = of(captures).groups[0].points[0].quantities
        current = 0.8 * 20 * math.sqrt(math.expm1(0.09))  # spread of the dark signal, DN
        pixel = math.hypot(2.0, current)
        truth = {"row": 0.6, "col": 0.9, "pixel": pixel, "": math.hypot(0.6, 0.9, pixel)}
        for name, value in truth.items():
            key = f"dsnu_{name}_dn" if name else "dsnu_dn"
            pulls[name].append(pull(found[key], value))
    for own in pulls.values():
        within(own)


def test_dsnu_split_equals_the_standards_formula_on_the_mean_image():
    """EMVA 1288 Release 4.0 written out in NumPy, for white temporal noise."""
    captures = sensor_frames(3, [(25.0, 0.5, 40)], row_dn=0.6, col_dn=0.9)
    stack = np.array([f.read() for f in captures.frames()], float)
    k, m, n = stack.shape
    mean, left = stack.mean(axis=0), stack.var(axis=0, ddof=1).mean() / k
    s2, cav, rav = (
        mean.var() - left,
        mean.mean(axis=0).var() - left / m,
        mean.mean(axis=1).var() - left / n,
    )
    rest = m * n - m - n
    formula = {
        "dsnu_dn": s2,
        "dsnu_row_dn": ((m * n - n) * rav - m * (s2 - cav)) / rest,
        "dsnu_col_dn": ((m * n - m) * cav - n * (s2 - rav)) / rest,
        "dsnu_pixel_dn": m * n * (s2 - cav - rav) / rest,
    }
    found = of(captures).groups[0].points[0].quantities
    for key, value in formula.items():
        assert found[key].value == pytest.approx(math.sqrt(value), rel=3e-3)


def test_doubling_temperature_and_gain_over_temperature():
    steps, gains = [], []
    points = [(t, 0.2, 6) for t in (25.0, 35.0, 45.0, 55.0, 65.0)]
    truth = doubling_step(0.62, 25.0, 65.0)
    for seed in range(8):
        group = of(sensor_frames(seed, points)).groups[0]
        steps.append(pull(group.quantities["doubling_temperature_c"], truth))
        gain = group.quantities["photon_transfer_gain_dn_e"]
        over = gain.note.removeprefix("photon transfer over ")
        assert over in ("operating points", "operating points and hot pixels")
        gains.append(pull(gain, 0.8))
    # its error holds that of the thermometer, 2 % of a rate, which these do not have
    assert np.mean(np.square(steps)) < 1.5
    assert abs(np.mean(steps)) < 1
    within(gains, COUPLED)


def test_hot_pixels_above_ten_times_the_median_are_counted():
    captures = sensor_frames(5, [(25.0, t, 4) for t in (0.0, 4.0, 8.0)], spread=1.0)
    rate = 40 * np.exp(np.random.default_rng([5, 1288]).normal(size=(96, 128)) - 0.5)
    expected = 100 * np.mean(rate > 10 * np.median(rate))
    quantity = of(captures).groups[0].points[-1].quantities["hot_10_times_percent"]
    assert quantity.value == pytest.approx(expected, abs=3 * quantity.se)


def test_recorded_gain_is_used_and_said():
    group = of(sensor_frames(1, [(25.0, 1.0, 4)], system_gain=0.8)).groups[0]
    assert group.quantities["system_gain_dn_e"].value == 0.8
    assert group.quantities["system_gain_dn_e"].note == "recorded in files"


def test_a_gain_must_be_above_zero():
    measured = analyze(sensor_frames(1, [(25.0, 1.0, 2)], (32, 32)), workers=1)
    for bad in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InputError, match="above 0"):
            evaluate(measured, bad)
