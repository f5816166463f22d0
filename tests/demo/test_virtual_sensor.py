import ast
import math
from pathlib import Path

import numpy as np
import pytest
from demo_stacks import CALM, COLD, HOT, stack

import dnanalyze.demo
from dnanalyze.demo import CATALOGUED, EFFECTS, LEVELS, OUTSIDE, draw_sensor, generate, resolve
from dnanalyze.demo.sensor import WHITE_DN, arrhenius
from dnanalyze.errors import InputError

CONTRACT = """
hot_pixels, hot_clusters, dark_current_steps, rts, amp_glow, dark_gradient, cosmic_rays,
persistence, crosstalk, column_fpn, column_gain, row_fpn, row_noise, column_noise, flicker_fpn,
flicker_noise, heavy_tailed_read_noise, periodic_pattern, offset_drift, cfa_mismatch, column_taps,
stuck_pixels, defect_lines, missing_codes, digital_gain, black_clipping, dpc, denoise,
temporal_denoise, storage_dark_current, dark_current_fpn, serial_noise"""


def test_shares_no_code_with_the_model():
    for file in Path(dnanalyze.demo.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [a.name for a in node.names] if isinstance(node, ast.Import) else []
            allowed = ("dnanalyze.demo", "dnanalyze.errors", "dnanalyze.loaders.captures")
            for name in names:
                assert not name.startswith("dnanalyze") or name.startswith(allowed), (file, name)


def test_every_effect_of_the_catalogue_can_be_hidden():
    assert set(CATALOGUED) == set(CONTRACT.replace("\n", " ").strip().split(", "))
    assert len(OUTSIDE) >= 6


@pytest.mark.parametrize("celsius", [COLD, HOT])
def test_ordinary_mean_and_variances(celsius):
    x = stack(celsius=celsius)
    pixels, frames = x[0].size, len(x)
    k, mean_e = CALM.gain_dn_e, CALM.dark_e(celsius)
    temporal = k**2 * (mean_e + CALM.noise_e**2)
    pattern = (k * CALM.dsnu_e(celsius)) ** 2
    se = math.sqrt(pattern / pixels + temporal / pixels / frames)
    assert x.mean() == pytest.approx(CALM.pedestal_dn + k * mean_e, abs=5 * se)

    # Variance of a pixel over its frames: its scatter over pixels gives the sampling error.
    v = x.var(axis=0, ddof=1)
    assert v.mean() == pytest.approx(temporal, abs=5 * v.std() / math.sqrt(pixels))

    m = x.mean(axis=0)
    fixed = m.var() - v.mean() / frames
    se = np.std((m - m.mean()) ** 2) / math.sqrt(pixels)
    assert fixed == pytest.approx(pattern, abs=5 * se)


def test_dark_current_is_log_normal_and_arrhenius():
    x = stack(celsius=HOT, frames=40)
    dark = (x.mean(axis=0) - CALM.pedestal_dn) / CALM.gain_dn_e
    median = CALM.dark_e_s * CALM.exposure_s * arrhenius(HOT, CALM.activation_ev)
    # Median of log-normal pixels, error 1.25 sd / sqrt(n); noise shifts it by < .2 %.
    se = 1.25 * CALM.dark_spread * median / math.sqrt(dark.size)
    assert np.median(dark) == pytest.approx(median, abs=5 * se + 2e-3 * median)
    upper, lower = np.quantile(dark, [0.8413, 0.1587])
    assert math.log(upper / lower) / 2 == pytest.approx(CALM.dark_spread, rel=0.02)

    assert arrhenius(25.0, 0.6) == 1.0
    assert arrhenius(33.5, 0.634) == pytest.approx(2.0, rel=0.01)  # doubling step of n_i, 8.5 K


def test_photon_transfer_slope_is_the_gain():
    points = []
    for celsius in CALM.temperatures_c:
        x = stack(celsius=celsius)
        points.append((x.mean(), x.var(axis=0, ddof=1).mean()))
    mean, variance = np.transpose(points)
    # Variances are known to about 1 %, the slope from the hottest to .6 %.
    assert np.polyfit(mean, variance, 1, w=1 / variance)[0] == pytest.approx(4.0, rel=0.03)


def test_frames_are_white_and_independent():
    x = stack(frames=2)
    d = x[1] - x[0]
    d -= d.mean()
    se = 1 / math.sqrt(d.size)
    for dy, dx in [(0, 1), (1, 0), (1, 1), (0, 2)]:
        lagged = np.mean(d[: d.shape[0] - dy, : d.shape[1] - dx] * d[dy:, dx:]) / d.var()
        assert abs(lagged) < 5 * se


def test_same_seed_same_frames_and_other_seed_others():
    effects = {"rts": "strong", "flicker_noise": "weak", "dpc": "middling"}
    for name in effects:
        assert resolve(CALM, effects, 3)[name] == resolve(CALM, effects, 3)[name]
    one, two = (stack(effects, shape=(64, 64), seed=3) for _ in range(2))
    np.testing.assert_array_equal(one, two)
    assert np.mean(one != stack(effects, shape=(64, 64), seed=4)) > 0.5


def test_order_of_the_dictionary_is_of_no_account():
    a = {"column_fpn": "strong", "digital_gain": "middling", "hot_pixels": "strong"}
    b = dict(reversed(a.items()))
    np.testing.assert_array_equal(stack(a, shape=(64, 64)), stack(b, shape=(64, 64)))


def test_an_effect_leaves_the_random_numbers_of_the_rest_alone():
    with_rows = stack({"row_fpn": {"e": 1e-9}}, shape=(64, 64))
    np.testing.assert_array_equal(with_rows, stack(shape=(64, 64)))


def test_captures_have_their_settings_and_windows():
    captures = generate(CALM, shape=(48, 64), frames=3)
    assert [s.point.temperature_c for s in captures.settings] == list(CALM.temperatures_c)
    assert captures.frame_count == 15
    frame = captures.settings[0].frames[0]
    assert frame.name == "T+025C/dark_000.tif"
    assert frame.read().dtype == np.uint16
    frame.read()[:] = 0  # a copy: the frames of the set stay as they are
    assert frame.read().min() > 0


def test_drawn_sensors_go_from_negligible_to_clear_and_have_room():
    rng = np.random.default_rng(2)
    for _ in range(300):
        s = draw_sensor(rng)
        cold, hot = s.dark_e(s.temperatures_c[0]), s.dark_e(s.hottest_c)
        assert cold < 0.25 * hot
        assert hot > 2.0 * s.read_noise_e**2
        assert hot * s.gain_dn_e + s.pedestal_dn < 0.3 * WHITE_DN
        assert s.pedestal_dn >= 7.5 * s.gain_dn_e * math.hypot(s.read_noise_e, s.pixel_offset_e)
        assert s.read_noise_e * s.gain_dn_e >= 0.4


@pytest.mark.parametrize("name", EFFECTS)
@pytest.mark.parametrize("level", LEVELS)
def test_every_effect_runs_on_a_drawn_sensor(name, level):
    sensor = draw_sensor(np.random.default_rng(LEVELS.index(level)))
    shape, last = (48, 64), sensor.hottest_c
    with_it = stack({name: level}, last, 3, shape, sensor)
    if level == "strong" and name not in ("black_clipping", "cosmic_rays"):  # cold; rare in 9 kpx
        assert np.any(with_it != stack(None, last, 3, shape, sensor))


@pytest.mark.parametrize(
    ("effects", "says"),
    [
        ({"columns": "weak"}, "unknown effect 'columns'"),
        ({"row_fpn": "huge"}, "unknown level 'huge'"),
        ({"row_fpn": {"dn": 1.0}}, "unknown parameter 'dn'"),
    ],
)
def test_a_wrong_request_names_what_is_valid(effects, says):
    with pytest.raises(InputError, match=says + ".*valid"):
        generate(CALM, effects, (16, 16))
