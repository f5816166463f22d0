"""A few small dark frames of a virtual sensor, to try the library on."""

from __future__ import annotations

import numpy as np

from dnanalyze.demo.sensor import draw_sensor
from dnanalyze.demo.virtual_sensor import generate
from dnanalyze.loaders.captures import CaptureSet


def tiny(hide: str | None = "column_fpn", frames: int = 3, seed: int = 1) -> CaptureSet:
    """Return 64 x 64 dark frames of a virtual sensor at 25, 45 and 65 C.

    Parameters
    ----------
    hide : str, optional
        Effect that is hidden in the sensor.
    frames : int
        Frames at each temperature.
    seed : int
        Another seed is another sensor.

    Returns
    -------
    CaptureSet
        Held in memory.

    Examples
    --------
    >>> from dnanalyze.demo import tiny
    >>> tiny().frame_count
    9
    """
    sensor = draw_sensor(np.random.default_rng(seed))
    hidden = {hide: "strong"} if hide else None
    return generate(sensor, hidden, (64, 64), (25.0, 45.0, 65.0), frames, seed)
