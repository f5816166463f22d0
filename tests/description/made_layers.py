"""Residual layers of white noise with a known structure."""

import numpy as np

from dnanalyze.description.layers import Layers, Taken
from dnanalyze.loaders.captures import OperatingPoint, Window

SHAPE = (128, 128)
CELSIUS = (25.0, 45.0, 65.0)
POINTS = tuple(OperatingPoint(t, 1.0, 1.0) for t in CELSIUS)
DARK = np.array([1.0, 5.0, 25.0])
READ, PIXEL = 2.0, 0.8
ROW, COLUMN = np.arange(SHAPE[0])[:, None], np.arange(SHAPE[1])[None, :]


def made(
    add=None, frames=6, seed=1, points=POINTS, dark=DARK, noise=None, pixel=PIXEL, codes=False
):
    """Layers of frames; ``add(point number, frame, rng)`` is added to each, DN.

    ``codes``: whether the frames are rounded.
    """
    rng = np.random.default_rng(seed)
    fixed = pixel * rng.standard_normal(SHAPE)
    scale = READ if noise is None else noise
    taken = []
    for n, point in enumerate(points):
        stack = [
            100.0 + dark[n] + fixed + scale * rng.standard_normal(SHAPE)
            + (0.0 if add is None else add(n, f, rng))
            for f in range(frames)
        ]  # fmt: skip
        stack = np.array(stack, np.float32)
        taken.append(Taken(point, np.round(stack) if codes else stack))
    return Layers(tuple(taken), Window.whole(SHAPE), SHAPE, np.asarray(dark, float))
