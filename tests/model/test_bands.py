"""Frames drawn in bands and threads have the pixels of frames drawn whole."""

import numpy as np
import pytest

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate, simulate_frames

SHAPE = (70, 90)
POINT = OperatingPoint(55.0, 0.2)
BASE = ("convolved_lognormal", "dark_shot_noise", "read_noise")
CHOICES = {
    "dpc": [{"kind": "static", "fraction": 0.01}, {"threshold": 2.0}],
    "convolved_lognormal": [{"seed": "fixed"}, {"seed": "redrawn"}],
}


def whole(model, numbers):
    made = simulate(model, SHAPE, [(POINT, 8)]).settings[0].frames
    return [np.clip(np.rint(made[n].read()), 0, 65535).astype(np.uint16) for n in numbers]


@pytest.mark.parametrize("name", sorted(built_in()))
def test_no_effect_depends_on_threads_or_bands(name):
    known = built_in()
    for choice in CHOICES.get(name, [{}]):
        effect = known[name](**choice)
        others = tuple(known[n]() for n in BASE if n != name)
        model = NoiseModel((*others, effect), 200.0, seed=4)
        numbers = (0, 1, 5)
        expected = whole(model, numbers)
        for threads, rows in ((1, 70), (2, 23), (2, 1), (3, None)):
            made = simulate_frames(model, SHAPE, POINT, numbers, threads=threads, rows=rows)
            for frame, right in zip(made, expected, strict=True):
                np.testing.assert_array_equal(frame, right)


def test_a_simulated_capture_does_not_depend_on_threads():
    known = built_in()
    effects = tuple(known[n]() for n in (*BASE, "crosstalk", "flicker_noise", "quantization"))
    model = NoiseModel(effects, 200.0)
    one, two = (simulate(model, SHAPE, [(POINT, 2)], threads=n) for n in (1, 2))
    for a, b in zip(one.frames(), two.frames(), strict=True):
        np.testing.assert_array_equal(a.read(), b.read())
        part = Window(11, 50, 7, 80)
        np.testing.assert_array_equal(a.read(part), b.read(part))


def test_few_bits_are_bytes_within_their_range():
    model = NoiseModel((built_in()["read_noise"](sigma=200.0),), 128.0)
    (frame,) = simulate_frames(model, SHAPE, POINT, [0], bits=8)
    assert frame.dtype == np.uint8
    assert frame.min() == 0
    assert frame.max() == 255
