"""A simulation is a capture set whose frames are pure functions."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate, simulated_by
from dnanalyze.model.simulator import Simulator

SHAPE = (48, 64)
HOT, COLD = OperatingPoint(65.0, 0.1), OperatingPoint(25.0, 0.1)


def model(**changes) -> NoiseModel:
    known = built_in()
    names = ("convolved_lognormal", "dark_shot_noise", "crosstalk", "read_noise", "quantization")
    return NoiseModel(tuple(known[n](**changes.get(n, {})) for n in names), 64.0)


def frames(made):
    return [f.read() for f in made.frames()]


def test_same_model_same_pixels_in_any_order_and_with_any_memory():
    made = simulate(model(), SHAPE, [(COLD, 2), (HOT, 2)])
    first = frames(made)
    backwards = [f.read() for f in reversed(list(made.frames()))][::-1]
    forgetful = frames(simulated_by(Simulator(model(), SHAPE, Memo(0)), [(COLD, 2), (HOT, 2)]))
    for a, b, c in zip(first, backwards, forgetful, strict=True):
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(a, c)


@pytest.mark.parametrize(
    "window", [Window(0, 48, 0, 32), Window(5, 20, 7, 50), Window(47, 48, 63, 64)]
)
def test_a_window_holds_the_pixels_of_the_whole_frame(window):
    frame = simulate(model(), SHAPE, [(HOT, 1)]).settings[0].frames[0]
    np.testing.assert_array_equal(frame.read(window), frame.read()[window.slices])


def test_frames_differ_sensors_differ_and_the_silicon_stays():
    base = NoiseModel((built_in()["convolved_lognormal"](mu=3.0, sigma=1e-6),), 0.0)
    a, b = frames(simulate(base, SHAPE, [(COLD, 2)]))
    assert np.corrcoef(a.ravel(), b.ravel())[0, 1] > 0.999
    (other,) = frames(simulate(NoiseModel(base.effects, 0.0, seed=1), SHAPE, [(COLD, 1)]))
    # 3072 independent pixels: correlation 0 +- .018; 5 sigma
    assert abs(np.corrcoef(a.ravel(), other.ravel())[0, 1]) < 0.09
    c, d = frames(simulate(model(), SHAPE, [(COLD, 2)]))
    assert not np.array_equal(c, d)


def test_pedestal_is_added_once_whatever_the_chain():
    known = built_in()
    for names in ((), ("quantization",), ("read_noise",), ("read_noise", "quantization")):
        bare = NoiseModel(tuple(known[n]() for n in names), 100.0)
        (frame,) = frames(simulate(bare, SHAPE, [(COLD, 1)]))
        assert abs(frame.mean() - 100.0) < 5 * 1.1 / np.sqrt(frame.size)


def with_charge():
    return Memo(charge=Memo())


def test_what_is_read_out_differently_shares_its_charge():
    memo, made = with_charge(), []
    shot_noise = built_in()["dark_shot_noise"]

    @dataclass(frozen=True)
    class Counted(shot_noise):
        def apply(self, signal, site):
            made.append(site.frame)
            return shot_noise.apply(self, signal, site)

    def drawn(sigma, mu, memo):
        changes = {"read_noise": {"sigma": sigma}, "convolved_lognormal": {"mu": mu}}
        other = model(**changes).without("crosstalk").with_effect(Counted())
        first = built_in()["pixel_fpn"]()  # it writes into what it is given
        other = replace(other, effects=(first, *other.effects))
        frames = simulated_by(Simulator(other, SHAPE, memo), [(COLD, 2)]).frames()
        return np.array([f.read() for f in frames])

    for sigma, mu, counted in ((1.0, 2.0, 2), (2.0, 2.0, 0), (1.0, 2.0, 0), (1.0, 2.1, 2)):
        made.clear()
        with_room = drawn(sigma, mu, memo)
        assert len(made) == counted
        np.testing.assert_array_equal(with_room, drawn(sigma, mu, Memo()))


def test_charge_is_shared_by_like_sensors_settings_frames_and_windows_alone():
    memo = with_charge()
    for seed in (1, 2):
        other = replace(model(), seed=seed)
        made = [
            simulated_by(Simulator(other, SHAPE, kept), [(COLD, 2), (HOT, 2)])
            for kept in (memo, Memo())
        ]
        for one, plain in zip(*(m.frames() for m in made), strict=True):
            for window in (None, Window(8, 40, 0, 64), Window(8, 40, 8, 56)):
                np.testing.assert_array_equal(one.read(window), plain.read(window))
