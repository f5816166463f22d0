"""The composite effect against closed forms: variance, spectral line, geometry, laws, time."""

import math
from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.diagnosis.candidates import candidates_of
from dnanalyze.errors import InputError
from dnanalyze.fitting.free_parameters import free_parameters
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.composite.effect import FORMS, CompositeEffect
from dnanalyze.model.composite.source import own_effect
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel, dump_model, load_model, model_from_plain
from dnanalyze.model.registry import built_in, catalogue
from dnanalyze.model.simulator import Simulator
from dnanalyze.thermal import arrhenius

POINT = OperatingPoint(25.0, 1.0, 1.0)
WHENS = ("fixed", "frame", "persisting", "drifting", "switching")
SURFACE = (1.0, 0.0, 0.5, 1.0, 0.0)


def effect(**words):
    given = {"centre_y": 30.0, "centre_x": 20.0, "radius": 8.0} | words
    if given["where"] == "surface":
        given.setdefault("coefficients", SURFACE)
    return CompositeEffect(**given)


def frames(made, count=2, shape=(96, 120), point=POINT):
    """What the effect adds to a level of 0, (count, rows, columns)."""
    simulator = Simulator(NoiseModel((made,), 0.0, POINT, 3), shape)
    return np.stack([simulator.frame(point, n) for n in range(count)]).astype(float)


def share_of(values, expected, sigmas=5.0):
    """Within so many standard errors of a sum of squares of independent normal values."""
    error = expected * math.sqrt(2.0 / values.size)
    assert np.mean(values**2) == pytest.approx(expected, abs=sigmas * error)


@pytest.mark.parametrize("where", FORMS)
@pytest.mark.parametrize("when", WHENS)
def test_a_window_has_the_pixels_of_the_frame_and_a_file_draws_the_same(tmp_path, where, when):
    model = NoiseModel((ReadNoise(1.0), effect(where=where, when=when)), 64.0, POINT, 3)
    whole = Simulator(model, (64, 60)).frame(POINT, 2)
    window = Window(7, 30, 3, 41)
    own = Simulator(model, (64, 60)).frame(POINT, 2, window)
    np.testing.assert_array_equal(own, whole[window.slices])
    assert np.isfinite(whole).all()
    (tmp_path / "own.py").write_text(own_effect(model.effects[1], "A structure."))
    (tmp_path / "m.yaml").write_text(dump_model(model))
    read = load_model(tmp_path / "m.yaml", catalogue((tmp_path / "own.py",)))
    np.testing.assert_array_equal(Simulator(read, (64, 60)).frame(POINT, 2), whole)
    assert load_model(tmp_path / "m.yaml").to_plain() == model.to_plain()


@pytest.mark.parametrize("what", ["noise", "gain"])
def test_a_file_draws_the_same_noise_and_gain(tmp_path, what):
    model = NoiseModel((ReadNoise(1.0), effect(where="rings", what=what)), 64.0, POINT, 3)
    (tmp_path / "own.py").write_text(own_effect(model.effects[1], "Rings."))
    (tmp_path / "m.yaml").write_text(dump_model(model))
    read = load_model(tmp_path / "m.yaml", catalogue((tmp_path / "own.py",)))
    drawn = [Simulator(m, (64, 60)).frame(POINT, 1) for m in (model, read)]
    np.testing.assert_array_equal(*drawn)


@pytest.mark.parametrize("distribution", ["normal", "two_level"])
@pytest.mark.parametrize("when", ["fixed", "frame", "persisting", "switching"])
def test_variance_of_pixels_is_the_square_of_the_amplitude_times_the_share(when, distribution):
    if (when, distribution) == ("persisting", "two_level"):
        pytest.skip("not a valid pair")
    made = effect(where="pixel", when=when, distribution=distribution, amplitude=2.0)
    share_of(frames(made)[1], 4.0)
    assert made.variance(POINT) == 4.0
    few = replace(made, share=0.05)
    count = 96 * 120 * 0.05
    found = np.mean(frames(few)[1] ** 2)
    assert found == pytest.approx(0.2, abs=5 * 0.2 * math.sqrt(3.0 / count))
    assert few.variance(POINT) == pytest.approx(0.2)


def test_heavy_values_have_the_kurtosis_of_laplace():
    drawn = frames(effect(where="pixel", distribution="heavy", amplitude=1.0), 1, (512, 512))[0]
    assert np.var(drawn) == pytest.approx(1.0, abs=5 * math.sqrt(5.0 / drawn.size))
    # 4th moment 6, 8th 8!/16 = 2520: its error is sqrt(2520 - 36) / sqrt(n)
    assert np.mean(drawn**4) == pytest.approx(6.0, abs=5 * math.sqrt(2484.0 / drawn.size))


def test_a_wave_is_one_spectral_line_of_its_amplitude():
    made = effect(where="wave", u=10 / 120, v=-8 / 96, amplitude=1.5, phase=0.4)
    power = np.abs(np.fft.fft2(frames(made)[0])) ** 2 / (96 * 120) ** 2
    assert power[-8, 10] == pytest.approx(1.5**2 / 2, rel=1e-4)
    assert power[8, -10] == pytest.approx(1.5**2 / 2, rel=1e-4)
    assert power.sum() == pytest.approx(made.variance(POINT), rel=1e-4)


def test_rings_follow_the_distance_from_their_centre():
    made = effect(where="rings", centre_y=-20.0, centre_x=40.0, period=9.0, amplitude=1.0)
    i, j = np.mgrid[:96, :120]
    expected = math.sqrt(2) * np.cos(2 * math.pi * np.hypot(i + 20, j - 40) / 9.0)
    np.testing.assert_allclose(frames(made)[0], expected, atol=1e-5)


def test_a_checkerboard_grows_to_its_side():
    made = effect(where="wave", u=0.5, v=0.5, envelope="down", amplitude=1.0, phase=math.pi / 4)
    drawn = frames(made)[0]
    assert np.abs(drawn[0]).max() == 0.0
    np.testing.assert_allclose(np.abs(drawn[-1]), math.sqrt(3.0), rtol=1e-5)
    i, j = np.indices(drawn[1:].shape)
    np.testing.assert_array_equal(np.sign(drawn[1:]), -((-1.0) ** (i + j)))


def test_blocks_share_a_value_and_their_diagonal_alone():
    made = effect(where="block", height=3, width=2, top=1, left=1)
    drawn = frames(made)[0]
    np.testing.assert_array_equal(drawn[2], drawn[4])
    np.testing.assert_array_equal(drawn[:, 1], drawn[:, 2])
    assert len(np.unique(drawn)) == (96 + 1 + 2) // 3 * ((120 + 1 + 1) // 2)
    pairs = frames(effect(where="block", when="frame", mask="diagonal", amplitude=2.0), 1)[0]
    np.testing.assert_array_equal(pairs[::2, ::2], pairs[1::2, 1::2])
    assert not pairs[::2, 1::2].any()
    share_of(pairs[::2, ::2], 4.0)


def test_lines_diagonals_and_parts_have_one_value_each():
    by = {name: frames(effect(where=name))[0] for name in ("row", "column", "quadrants")}
    assert np.ptp(by["row"], axis=1).max() == 0.0
    assert np.ptp(by["column"], axis=0).max() == 0.0
    assert len(np.unique(by["quadrants"])) == 4
    down = frames(effect(where="diagonal", slant="down"))[0]
    np.testing.assert_array_equal(down[1:, 1:], down[:-1, :-1])
    up = frames(effect(where="diagonal", slant="up"))[0]
    np.testing.assert_array_equal(up[1:, :-1], up[:-1, 1:])
    halves = frames(effect(where="halves", axis="columns"))[0]
    assert len(np.unique(halves[:, :60])) == len(np.unique(halves[:, 60:])) == 1


def test_columns_jump_once_to_the_opposite():
    made = effect(where="column_segments", when="frame", share=0.2, distribution="two_level")
    drawn = frames(made)
    jumping = np.abs(drawn[0]).max(axis=0) > 0
    assert jumping.mean() == pytest.approx(0.2, abs=5 * math.sqrt(0.16 / 120))
    assert (np.abs(np.diff(drawn[0], axis=0)) > 0).sum(axis=0).max() == 1
    np.testing.assert_array_equal(jumping, np.abs(drawn[1]).max(axis=0) > 0)


def test_a_surface_has_its_shape_and_a_spread_of_one():
    drawn = frames(effect(where="surface", coefficients=(0.0, 0.0, 0.0, 2.0, 0.0), amplitude=3.0))
    assert drawn[0].std() == pytest.approx(3.0, rel=1e-5)
    x, y = np.arange(120) / 120 - 0.5, np.arange(96) / 96 - 0.5
    assert np.corrcoef(drawn[0].ravel(), np.outer(y, x).ravel())[0, 1] > 1 - 1e-6


def test_a_spot_stands_or_moves():
    still = frames(effect(where="blob", amplitude=5.0))
    assert np.unravel_index(still[0].argmax(), still[0].shape) == (30, 20)
    assert still[0].max() == pytest.approx(5.0)
    np.testing.assert_array_equal(still[0], still[1])
    moving = frames(effect(where="blob", when="frame", amplitude=5.0), 3)
    assert len({int(f.argmax()) for f in moving}) == 3


def test_noise_of_a_wave_is_modulated_and_keeps_its_mean_variance():
    made = effect(what="noise", where="wave", u=6 / 120, amplitude=2.0)
    drawn = frames(made, 24)
    by_column = drawn.var(axis=0).mean(axis=0)
    expected = 4.0 * (1.0 + np.cos(2 * math.pi * 6 * np.arange(120) / 120))
    # a variance of 24 values, 1 / 24 too small, over 96 rows
    error = expected * math.sqrt(2.0 / 24 / 96)
    assert np.all(np.abs(by_column - expected * 23 / 24) <= 5 * error + 1e-4)


def test_persisting_and_switching_values_forget_by_their_time_constant():
    for when in ("persisting", "switching"):
        drawn = frames(effect(where="pixel", when=when, tau=2.0, amplitude=1.0), 4)
        for lag in (1, 3):
            found = np.mean(drawn[0] * drawn[lag])
            expected = math.exp(-lag / 2.0)
            assert found == pytest.approx(expected, abs=5 * math.sqrt(2.0 / drawn[0].size))


def test_known_steps_have_their_sign_and_size_in_every_sensor():
    drawn = frames(effect(where="halves", axis="columns", coefficients=(-1.0,), amplitude=2.0))[0]
    assert np.all(drawn[:, :60] == 2.0)
    assert np.all(drawn[:, 60:] == -2.0)
    made = effect(where="quadrants", coefficients=(0.6, 0.0, 0.8), amplitude=1.0)
    drawn = frames(made)[0]
    corners = [drawn[0, 0], drawn[0, -1], drawn[-1, 0], drawn[-1, -1]]
    np.testing.assert_allclose(corners, [0.2, -1.4, -0.2, 1.4], atol=1e-6)
    assert "share" not in made.to_plain()


def test_named_lines_alone_have_a_value():
    drawn = frames(effect(where="row", when="frame", lines=(2.0, 4.0, 90.0, 90.0)))
    assert list(np.flatnonzero(np.abs(drawn[0]).max(axis=1))) == [2, 3, 4, 90]
    noisy = frames(effect(what="noise", where="column", lines=(7.0, 8.0), distribution="two_level"))
    assert list(np.flatnonzero(np.abs(noisy[0]).max(axis=0))) == [7, 8]
    jumping = frames(effect(where="column_segments", when="frame", lines=(5.0, 5.0)))
    assert list(np.flatnonzero(np.abs(jumping[1]).max(axis=0))) == [5]


def test_a_spot_that_blinks_is_there_or_not():
    made = effect(where="blob", when="switching", distribution="on_off", tau=0.05, amplitude=5.0)
    heights = frames(made, 24)[:, 30, 20]
    assert set(np.round(heights, 4)) == {0.0, 5.0}
    assert 3 <= np.sum(heights > 0) <= 21  # 24 draws of 1/2: 3.7 standard deviations


def test_a_row_keeps_a_share_of_the_row_before(tmp_path):
    noise, lag = ReadNoise(2.0), effect(what="gain", where="row_before", gain=0.1)
    model = NoiseModel((noise, lag), 64.0, POINT, 3)
    drawn = Simulator(model, (64, 60)).frame(POINT, 1).astype(float) - 64.0
    plain = Simulator(NoiseModel((noise,), 64.0, POINT, 3), (64, 60)).frame(POINT, 1) - 64.0
    np.testing.assert_allclose(drawn[1:], plain[1:] + 0.1 * plain[:-1], atol=1e-4)
    np.testing.assert_allclose(drawn[0], plain[0], atol=1e-4)
    window = Window(7, 30, 3, 41)
    own = Simulator(model, (64, 60)).frame(POINT, 1, window)
    np.testing.assert_array_equal(own - 64.0, drawn[window.slices])
    (tmp_path / "own.py").write_text(own_effect(lag, "A lag."))
    (tmp_path / "m.yaml").write_text(dump_model(model))
    read = load_model(tmp_path / "m.yaml", catalogue((tmp_path / "own.py",)))
    np.testing.assert_array_equal(Simulator(read, (64, 60)).frame(POINT, 1, window), own)


@pytest.mark.parametrize(
    "words",
    [
        {"where": "halves", "coefficients": (-1.0,)},
        {"where": "quadrants", "coefficients": (1.0, 0.5, 0.0), "when": "frame"},
        {"where": "row", "lines": (3.0, 9.0), "what": "noise"},
        {"where": "blob", "when": "switching", "distribution": "on_off"},
    ],
)
def test_a_file_draws_the_same_of_known_steps_lines_and_spots(tmp_path, words):
    model = NoiseModel((ReadNoise(1.0), effect(**words)), 64.0, POINT, 3)
    (tmp_path / "own.py").write_text(own_effect(model.effects[1], "A structure."))
    (tmp_path / "m.yaml").write_text(dump_model(model))
    read = load_model(tmp_path / "m.yaml", catalogue((tmp_path / "own.py",)))
    drawn = [Simulator(m, (64, 60)).frame(POINT, 1) for m in (model, read)]
    np.testing.assert_array_equal(*drawn)
    assert load_model(tmp_path / "m.yaml").to_plain() == model.to_plain()


@pytest.mark.parametrize(
    ("law", "factor"),
    [
        ("constant", 1.0),
        ("gain", 4.0),
        ("exposure", 0.5),
        ("thermal", 0.5 * arrhenius(65.0, 25.0, 0.7)),
    ],
)
def test_laws(law, factor):
    made = effect(where="row", law=law, ea_ev=0.7, amplitude=1.0)
    here, there = frames(made)[0], frames(made, point=OperatingPoint(65.0, 0.5, 4.0))[0]
    np.testing.assert_allclose(there, here * factor, rtol=1e-5)


def test_gain_scales_the_signal():
    level = NoiseModel((effect(what="gain", where="column", gain=0.1),), 0.0, POINT, 3)

    class Flat(Simulator):
        def _level(self, window, level):
            return np.full(window.shape, 100.0, np.float32)

    drawn = Flat(level, (96, 120)).frame(POINT, 0)[0].astype(float) / 100.0 - 1.0
    share_of(drawn, 0.01)


def test_only_what_the_words_use_is_written_and_fitted():
    made = effect(where="rings", law="thermal")
    assert set(made.to_plain()) == {
        "what", "when", "where", "law", "amplitude", "ea_ev", "centre_y", "centre_x", "period",
        "phase", "envelope",
    }  # fmt: skip
    model = NoiseModel((made,), 0.0)
    assert [k.name for k in free_parameters(model)] == [
        "pedestal", "composite.amplitude", "composite.ea_ev",
    ]  # fmt: skip


def test_no_diagnosis_tries_it_by_itself():
    assert CompositeEffect.name not in built_in()
    state = type("State", (), {"model": NoiseModel(())})()
    assert CompositeEffect.name not in candidates_of(state, built_in(), [])


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"where": "spiral"}, "where: 'spiral' is not one of"),
        ({"period": -3.0}, "period: -3 pixel is outside"),
        ({"height": 0}, "height, width: valid: 1 pixel or more"),
        ({"where": "surface"}, "coefficients: valid: five numbers"),
        ({"where": "wave", "u": 0.0}, "u, v: valid: not both 0"),
        ({"when": "persisting", "distribution": "heavy"}, "valid with when: persisting: normal"),
        ({"what": "noise", "when": "frame"}, "valid with what: noise: fixed"),
        ({"amplitude": 1e9}, "amplitude: 1e.09 DN is outside"),
        ({"radius": "wide"}, "radius: 'wide' is no law"),
        ({"amplitude": 1e300}, r"amplitude: 1e\+300 DN is outside"),
        ({"amplitude": math.nan}, "amplitude: 'nan' is no law"),
        ({"period": 0.0}, "period: 0 pixel is outside"),
        ({"lines": [3]}, "lines: valid: pairs of a first and a last line"),
        ({"lines": [5, 2]}, "lines: valid: pairs of a first and a last line"),
        ({"lines": [math.nan, 4]}, "lines: .* is no list of finite numbers"),
        ({"coefficients": [1e300, 1, 1, 1, 1]}, "coefficients: valid: up to"),
        ({"where": "halves", "coefficients": [1, 2]}, "coefficients: valid: none or 1"),
        ({"where": "quadrants", "coefficients": [0, 0, 0]}, "coefficients: valid: none or 3"),
        ({"where": "row_before"}, "valid with where: row_before: gain, fixed"),
    ],
)
def test_absurd_parameters_are_told_in_one_line(given, told):
    with pytest.raises(InputError, match=told) as refused:
        model_from_plain({"effects": [{"composite": given}]}, "M.yaml")
    assert "\n" not in str(refused.value)
