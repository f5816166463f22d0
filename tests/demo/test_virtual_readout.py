"""Each hidden effect of the readout against its own formula."""

import math

import numpy as np
import pytest
from demo_stacks import CALM, COLD, HOT, ROUNDING_E2, added, stack

ROWS, COLUMNS = 192, 256


@pytest.mark.parametrize(
    ("name", "axis", "fixed"),
    [
        ("column_fpn", 1, True),
        ("row_fpn", 2, True),
        ("column_noise", 1, False),
        ("row_noise", 2, False),
    ],
)
def test_lines_have_their_deviation_direction_and_life(name, axis, fixed):
    d = added({name: {"e": 1.5}})
    lines = d.mean(axis=axis)  # (frames, lines)
    count = lines[0].size if fixed else lines.size
    assert lines.var() == pytest.approx(1.5**2, rel=5 * math.sqrt(2 / count))
    within = d - np.expand_dims(lines, axis)
    assert within.var() < 1.5 * ROUNDING_E2
    correlation = np.corrcoef(lines[0], lines[1])[0, 1]
    if fixed:
        assert correlation > 0.99
    else:
        assert abs(correlation) < 5 / math.sqrt(lines[0].size)


def test_line_offsets_do_not_grow_with_temperature():
    cold, hot = (added({"column_fpn": {"e": 1.0}}, t).mean(axis=(0, 1)) for t in (COLD, HOT))
    np.testing.assert_allclose(cold, hot, atol=0.05)


def test_column_gain_multiplies_the_signal():
    hot = added({"column_gain": {"relative": 0.05}}, HOT).mean(axis=(0, 1))
    signal = (stack(None, HOT).mean(axis=(0, 1)) - CALM.pedestal_dn) / CALM.gain_dn_e
    assert np.std(hot / signal) == pytest.approx(0.05, rel=5 / math.sqrt(2 * COLUMNS))
    cold = added({"column_gain": {"relative": 0.05}}, COLD).mean(axis=(0, 1))
    ratio = np.polyfit(hot, cold, 1)[0]
    assert ratio == pytest.approx(CALM.dark_e(COLD) / CALM.dark_e(HOT), abs=0.01)


def test_flicker_fpn_is_fixed_isotropic_and_falls_as_its_power_law():
    d = added({"flicker_fpn": {"e": 3.0, "alpha": 1.0}})
    assert np.corrcoef(d[0].ravel(), d[1].ravel())[0, 1] > 0.99
    spectrum = np.abs(np.fft.fft2(d.mean(axis=0))) ** 2
    v, u = np.fft.fftfreq(ROWS)[:, None], np.fft.fftfreq(COLUMNS)[None, :]
    rho = np.hypot(v, u)

    def power(low, high, keep):
        return spectrum[(rho > low) & (rho < high) & keep].mean()

    near, far = np.abs(u) < np.abs(v), np.abs(u) >= np.abs(v)
    # 4 % sampling error in the lower band of half a plane; bands centred on .05 and .2.
    assert power(0.04, 0.06, True) / power(0.18, 0.22, True) == pytest.approx(4.0, rel=0.2)
    assert power(0.04, 0.3, near) == pytest.approx(power(0.04, 0.3, far), rel=0.15)


def test_flicker_fields_have_their_deviation():
    # The lowest frequencies, beyond the frame's size, scatter its variance: average over seeds.
    fixed = [added({"flicker_fpn": {"e": 2.0, "alpha": 1.0}}, frames=1, seed=s) for s in range(12)]
    noise = added({"flicker_noise": {"e": 2.0, "alpha": 1.0}}, frames=24)
    assert np.mean(np.square(fixed)) == pytest.approx(4.0, rel=0.2)
    assert np.mean(noise**2) == pytest.approx(4.0, rel=0.2)


def test_flicker_noise_runs_along_the_scan():
    d = added({"flicker_noise": {"e": 3.0, "alpha": 1.0}}, frames=12)
    assert (
        abs(np.corrcoef(d[0].ravel(), d[1].ravel())[0, 1]) < 0.5
    )  # smooth: few degrees of freedom
    scan = d.reshape(12, -1)
    spectrum = np.mean(np.abs(np.fft.rfft(scan - scan.mean(axis=1, keepdims=True))) ** 2, axis=0)
    f = np.fft.rfftfreq(scan.shape[1])
    low = spectrum[(f > 0.002) & (f < 0.004)].mean()
    high = spectrum[(f > 0.02) & (f < 0.04)].mean()
    assert low / high == pytest.approx(10.0, rel=0.2)


def test_rows_of_serial_noise_are_autoregressive_and_independent():
    d = added({"serial_noise": {"e": 3.0, "radius": 0.8, "turn": 0.3}}, frames=8)
    first, second = 2 * 0.8 * np.cos(0.3 * np.pi), -(0.8**2)
    wanted = [1.0, first / (1 - second)]
    for _ in range(3):
        wanted.append(first * wanted[-1] + second * wanted[-2])
    # of this process a lag is known to about sqrt(sum of r^2 / n), 1.7 / sqrt(n)
    tolerance = 5 * 1.7 / np.sqrt(d.size)
    assert d.var() == pytest.approx(9.0 + ROUNDING_E2, rel=2 * tolerance)
    found = [np.mean(d[:, :, k:] * d[:, :, : d.shape[2] - k]) / 9.0 for k in range(1, 5)]
    assert found == pytest.approx(wanted[1:], abs=tolerance)
    assert np.mean(d[:, 1:] * d[:, :-1]) / 9.0 == pytest.approx(0.0, abs=tolerance)


def test_heavy_tails_keep_the_variance():
    x = stack({"heavy_tailed_read_noise": {"excess_kurtosis": 1.0}}, frames=2)
    bare = stack(None, frames=2)
    d, b = x[1] - x[0], bare[1] - bare[0]
    assert d.var() == pytest.approx(b.var(), rel=0.05)
    # The difference of two frames halves the excess; shot noise and rounding dilute it.
    share = CALM.read_noise_e**2 / (CALM.read_noise_e**2 + CALM.dark_e(COLD) + 1 / 192)
    excess = np.mean(d**4) / d.var() ** 2 - 3
    assert excess == pytest.approx(share**2 / 2, abs=0.25)
    assert abs(np.mean(b**4) / b.var() ** 2 - 3) < 0.15


def test_periodic_pattern_is_one_line_of_random_phase():
    fy, fx, e = 12 / ROWS, 40 / COLUMNS, 0.8
    d = added({"periodic_pattern": {"e": e, "fy": fy, "fx": fx}}, frames=8)
    spectrum = np.fft.fft2(d) / d[0].size
    line = spectrum[:, 12, 40]
    np.testing.assert_allclose(np.abs(line), e / 2, rtol=0.02)
    assert d.var() == pytest.approx(e**2 / 2 + ROUNDING_E2, rel=0.02)
    assert np.ptp(np.angle(line)) > 1.0


def test_rows_of_two_converters_and_rows_that_slope():
    d = added({"row_noise": {"e": 2.0, "apart": 1.0, "slope": 0.0}}, frames=8)
    even, odd = d[:, :, ::2].mean(axis=2).ravel(), d[:, :, 1::2].mean(axis=2).ravel()
    five = 5 / np.sqrt(even.size)
    assert even.std() == pytest.approx(odd.std(), rel=2 * five)
    assert np.corrcoef(even, odd)[0, 1] == pytest.approx(0.0, abs=five)
    d = added({"row_noise": {"e": 2.0, "slope": 1.0}}, frames=8)
    ends = d[:, :, -1] - d[:, :, 0]
    reach = 1.0 - 1.0 / d.shape[2]
    assert ends.std() / d.mean(axis=2).std() == pytest.approx(reach, rel=3 * five)


@pytest.mark.parametrize(("at_once", "banks"), [(4, 1), (4, 2), (2, 2)])
def test_rows_that_are_read_at_once(at_once, banks):
    given = {"e": 2.0, "at_once": at_once, "banks": banks}
    rows = added({"row_noise": given}, frames=8).mean(axis=2)
    whole = rows.shape[1] // (at_once * banks)
    r = rows[:, : whole * at_once * banks].reshape(8, whole, at_once, banks)
    within = r.std(axis=2).mean()
    assert within < 0.1 * r[:, :, 0].std()  # rounding alone
    other = np.corrcoef(r[:, 1:, 0, 0].ravel(), r[:, :-1, 0, 0].ravel())[0, 1]
    assert other == pytest.approx(0.0, abs=5 / np.sqrt(r[:, 1:, 0, 0].size))


def test_a_periodic_pattern_may_have_a_harmonic():
    fy, fx, e = 12 / ROWS, 40 / COLUMNS, 0.8
    given = {"e": e, "fy": fy, "fx": fx}
    d = added({"periodic_pattern": given | {"harmonic": 0.5}}, frames=8)
    spectrum = np.fft.fft2(d) / d[0].size
    for n, amplitude in ((1, e), (2, 0.5 * e)):
        line = spectrum[:, n * 12 % ROWS, n * 40 % COLUMNS]
        np.testing.assert_allclose(np.abs(line), amplitude / 2, rtol=0.04)
        assert np.ptp(np.angle(line)) > 1.0


def test_offset_drift_walks():
    d = added({"offset_drift": {"e": 0.5}}, frames=120)
    level = d.mean(axis=(1, 2))
    steps = np.diff(level)
    assert steps.std() == pytest.approx(0.5, rel=5 / math.sqrt(2 * steps.size))
    assert abs(np.corrcoef(steps[1:], steps[:-1])[0, 1]) < 5 / math.sqrt(steps.size)
    assert d.var(axis=(1, 2)).max() < 1.5 * ROUNDING_E2


def test_cfa_mismatch_has_all_three_lines():
    d = added({"cfa_mismatch": {"e": 1.0, "gain": 0.0}}).mean(axis=0)
    cell = [d[r::2, c::2].mean() for r in (0, 1) for c in (0, 1)]
    assert np.std(cell) == pytest.approx(1.0, abs=0.01)
    spectrum = np.abs(np.fft.fft2(d) / d.size) ** 2
    lines = [spectrum[0, COLUMNS // 2], spectrum[ROWS // 2, 0], spectrum[ROWS // 2, COLUMNS // 2]]
    assert sum(lines) == pytest.approx(1.0, abs=0.02)
    assert min(lines) > 0.1


@pytest.mark.parametrize("interleaved", [True, False])
def test_column_taps_have_their_places(interleaved):
    hidden = {"column_taps": {"e": 1.0, "taps": 4, "interleaved": interleaved}}
    profile = added(hidden).mean(axis=(0, 1))
    taps = profile.reshape(-1, 4).T if interleaved else profile.reshape(4, -1)
    assert taps.mean(axis=1).std() == pytest.approx(1.0, abs=0.01)
    assert taps.std(axis=1).max() < 0.02


def test_stuck_pixels_never_move():
    x = stack({"stuck_pixels": {"fraction": 0.01}})
    still = np.ptp(x, axis=0) == 0
    assert still.mean() == pytest.approx(0.01, abs=5 * math.sqrt(0.01 / still.size))
    values = x[0][still]
    assert np.mean(values == 0) == pytest.approx(1 / 3, abs=5 * math.sqrt(2 / 9 / values.size))
    assert np.mean(values == 4095) == pytest.approx(1 / 3, abs=5 * math.sqrt(2 / 9 / values.size))


@pytest.mark.parametrize("columns", [True, False])
def test_defect_lines_are_few_and_far(columns):
    hidden = {"defect_lines": {"e": 2.0, "lines": 3, "columns": columns}}
    profile = added(hidden).mean(axis=(0, 1) if columns else (0, 2))
    off = np.abs(profile) > 1.0
    assert off.sum() == 3
    assert np.all((np.abs(profile[off]) > 1.3) & (np.abs(profile[off]) < 2.7))
    assert np.abs(profile[~off]).max() < 0.05
