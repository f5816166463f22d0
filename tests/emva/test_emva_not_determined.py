"""What captures cannot carry is not determined, with the reason."""

from __future__ import annotations

import numpy as np
import pytest
from known_sensor import sensor_frames
from scipy.ndimage import convolve

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.emva import Emva, evaluate
from dnanalyze.loaders.arrays import from_arrays
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting
from dnanalyze.report.emva_tables import undetermined

BAYER = (("R", "G"), ("G", "B"))


def of(captures, **options) -> Emva:
    return evaluate(analyze(captures, workers=1), **options)


def every(found: Emva):
    for group in found.groups:
        yield from group.quantities
        for current in group.dark_currents:
            yield from current.quantities
        for point in group.points:
            yield from point.quantities


def stated(found: Emva) -> None:
    """A finite value with its error, or a reason."""
    for quantity in every(found):
        if quantity.reason:
            assert quantity.value is None
            assert quantity.se is None
        else:
            assert np.isfinite(quantity.value), quantity.kind.key
            assert quantity.se >= 0, quantity.kind.key


def test_single_frame_has_a_mean_and_no_noise():
    found = of(sensor_frames(0, [(None, None, 1)]))
    stated(found)
    point = found.groups[0].points[0].quantities
    assert point["mean_dark_signal_dn"].determined
    for key in ("temporal_dark_noise_dn", "dsnu_dn", "dsnu_row_dn", "slope_temporal"):
        assert "one frame" in point[key].reason
    assert not found.groups[0].dark_currents[0].quantities["dark_current_mean_dn_s"].determined
    assert undetermined(found)


def test_one_exposure_without_a_black_level_has_no_dark_current():
    found = of(sensor_frames(0, [(25.0, 1.0, 4)]))
    stated(found)
    current = found.groups[0].dark_currents[0].quantities["dark_current_mean_dn_s"]
    assert "black level" in current.reason
    assert "two temperatures" in found.groups[0].quantities["doubling_temperature_c"].reason


def test_clustered_temperatures_do_not_carry_a_doubling_interval():
    points = [(t, e, 3) for t in (25.0, 27.0) for e in (0.0, 4.0, 8.0)]
    found = of(sensor_frames(0, points))
    assert len(found.groups[0].dark_currents) == 2
    assert "3 °C" in found.groups[0].quantities["doubling_temperature_c"].reason


def test_falling_dark_current_has_no_doubling_interval():
    points = [(t, e, 3) for t in (25.0, 45.0) for e in (0.0, 4.0, 8.0)]
    found = of(sensor_frames(0, points, energy_ev=-0.3))
    assert not found.groups[0].quantities["doubling_temperature_c"].determined


@pytest.mark.parametrize(("top", "black"), [(120, 100.0), (4095, 0.0)])
def test_clipped_operating_points_are_left_out(top, black):
    """Saturated above, or black-clipped below."""
    points = [(25.0, t, 4) for t in (0.0, 1.0, 2.0, 4.0)]
    found = of(sensor_frames(0, points, top=top, black=black, current_e_s=20.0))
    stated(found)
    bad = [p for p in found.groups[0].points if not p.quantities["mean_dark_signal_dn"].determined]
    assert bad
    for point in bad:
        assert "code" in point.quantities["mean_dark_signal_dn"].reason
        assert not point.quantities["temporal_dark_noise_dn"].determined
    left = 4 - len(bad)
    fits = [c.mean_line for c in found.groups[0].dark_currents if c.mean_line]
    assert all(len(line.x) == left for line in fits)


def test_noise_below_quantization_is_an_upper_limit():
    found = of(sensor_frames(0, [(25.0, 0.0, 8)], gain=0.05, black=100.5), system_gain_dn_e=0.05)
    stated(found)
    reason = found.groups[0].points[0].quantities["temporal_dark_noise_e"].reason
    assert "0.4 DN" in reason
    assert "8 e" in reason


def test_hits_that_grow_with_exposure_leave_photon_transfer_alone():
    points = [(25.0, t, 4) for t in (0.0, 2.0, 4.0, 8.0)]
    group = of(sensor_frames(0, points, hits=0.002)).groups[0]
    gain = group.quantities["photon_transfer_gain_dn_e"]
    assert gain.value == pytest.approx(0.8, abs=3 * gain.se)
    known = of(sensor_frames(0, points, hits=0.002), system_gain_dn_e=0.8).groups[0]
    variance = known.dark_currents[0].quantities["dark_current_var_e_s"]
    assert "not by shot noise alone" in variance.reason


@pytest.mark.parametrize("weights", [(1.0, 1.0, 1.0), (1.0, 2.0, 1.0)])
def test_filtered_frames_give_no_gain(weights):
    """Their variance, a tenth of that of the sensor, would give a gain with a small error."""
    kernel = np.outer(weights, weights) / np.sum(weights) ** 2
    points = [(25.0, t, 6) for t in (0.1, 1.0, 4.0, 8.0)]
    frames = {
        setting.point: [convolve(f.read().astype(float), kernel).round() for f in setting.frames]
        for setting in sensor_frames(0, points, (160, 160)).settings
    }
    gain = of(from_arrays(frames)).groups[0].quantities["photon_transfer_gain_dn_e"]
    assert not gain.determined
    assert "two apart" in gain.reason


@pytest.mark.parametrize(("jitter", "stated"), [(0.02, True), (0.3, False)])
def test_frames_that_move_give_the_gain_of_the_sensor_or_none(jitter, stated):
    """Dark charge of 20 to 350 e- that moves by 2 %, and by 30 %: up to five times its noise."""
    points = [(t, 1.0, 6) for t in (25.0, 35.0, 45.0, 55.0, 65.0)]
    for seed in range(4):
        frames = sensor_frames(seed, points, current_e_s=20.0, gain=1.0, jitter=jitter, top=65535)
        gain = of(frames).groups[0].quantities["photon_transfer_gain_dn_e"]
        assert gain.determined == stated
        if stated:
            assert abs(gain.value - 1.0) < 4 * gain.se
        else:
            assert "move" in gain.reason or "no clear slope" in gain.reason


def test_noise_that_grows_as_the_signal_is_no_photon_transfer():
    """A dark signal that wavers by 2 % from frame to frame in every pixel."""
    rng = np.random.default_rng(3)
    settings = []
    for t in (0.0, 1.0, 2.0, 4.0, 8.0, 16.0):
        point = OperatingPoint(25.0, t, 1.0)
        frames = []
        for n in range(6):
            y = 100.0 + 50.0 * t * (1.0 + 0.02 * rng.standard_normal((96, 96)))
            y = (y + 2.0 * rng.standard_normal(y.shape)).astype(np.float32)
            frames.append(Frame(f"{t}-{n}", point, lambda w, y=y: y if w is None else y[w.slices]))
        settings.append(Setting(point, tuple(frames)))
    found = of(CaptureSet("wavers", Sensor((96, 96)), tuple(settings)))
    gain = found.groups[0].quantities["photon_transfer_gain_dn_e"]
    assert not gain.determined
    assert "no clear slope" in gain.reason


def test_no_dark_current_has_no_gain():
    points = [(25.0, t, 4) for t in (0.0, 1.0, 2.0, 4.0)]
    found = of(sensor_frames(0, points, current_e_s=0.0))
    assert not found.groups[0].quantities["photon_transfer_gain_dn_e"].determined
    current = found.groups[0].dark_currents[0].quantities["dark_current_mean_dn_s"]
    assert abs(current.value) < 4 * current.se


def test_mosaic_has_its_quantities_plane_by_plane():
    points = [(25.0, t, 4) for t in (0.0, 2.0, 4.0, 8.0)]
    found = of(sensor_frames(0, points, cfa=BAYER))
    stated(found)
    assert [g.plane for g in found.groups] == ["R", "Gr", "Gb", "B"]
    for group in found.groups:
        gain = group.quantities["photon_transfer_gain_dn_e"]
        assert gain.value == pytest.approx(0.8, abs=4 * gain.se)


def test_eight_bit_and_constant_frames_state_or_say_why():
    stated(of(sensor_frames(0, [(25.0, 1.0, 3)], top=255)))
    stated(of(sensor_frames(0, [(25.0, 0.0, 3)], read_e=0.0, pixel_dn=0.0, black=64.0)))


def test_two_single_frames_have_no_uncertainty():
    found = of(sensor_frames(0, [(25.0, 1.0, 1), (25.0, 8.0, 1)]))
    stated(found)
    current = found.groups[0].dark_currents[0].quantities["dark_current_mean_dn_s"]
    assert "no uncertainty" in current.reason
