"""A small virtual sensor with column FPN, as a folder of frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dnanalyze.demo import draw_sensor, generate, write_folder


def write_sensor(folder: Path, every: int = 4) -> Path:
    """At each ``every``-th of its five temperatures: by default the first and the last."""
    sensor = draw_sensor(np.random.default_rng(3))
    at = sensor.temperatures_c[::every]
    return write_folder(generate(sensor, {"column_fpn": "strong"}, (96, 144), at, 3, 3), folder)
