"""A composite effect is drawn on a device as on the CPU."""

import numpy as np
import pytest
from test_gpu_frames import POINT, SHAPE, on_cpu

from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.gpu.render import Renderer
from dnanalyze.model.noise_model import NoiseModel


@pytest.mark.parametrize(
    "words",
    [
        {"where": "rings", "amplitude": 20.0},
        {"where": "block", "when": "frame", "amplitude": 20.0},
        {"where": "wave", "what": "noise", "amplitude": 20.0},
    ],
)
def test_frames_are_those_of_the_cpu(device, words):
    model = NoiseModel((ReadNoise(3.0), CompositeEffect(**words)), 64.0, seed=7)
    frames = device.host(Renderer(model, SHAPE, device, 16).frames(POINT, [0, 1, 5]))
    difference = np.abs(frames.astype(np.int64) - on_cpu(model, [0, 1, 5]))
    assert difference.max() <= 1
    assert np.mean(difference > 0) < 1e-3  # rounding of a float32 sum
