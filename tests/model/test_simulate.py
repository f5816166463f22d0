"""A simulation is a capture set whose frames are pure functions."""

import numpy as np
import pytest

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import Memo, simulate

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
    forgetful = frames(simulate(model(), SHAPE, [(COLD, 2), (HOT, 2)], memo=Memo(0)))
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
