"""A description as a run would return it, for what shows and writes it."""

from dataclasses import replace

import numpy as np

from dnanalyze.demo import tiny
from dnanalyze.description.describe import Description, Number
from dnanalyze.description.look import Look
from dnanalyze.description.nearest import Nearest
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel

EFFECT = CompositeEffect(where="rings", centre_y=30.0, centre_x=-5.0, period=9.0, amplitude=0.8)
POINTS = [OperatingPoint(t, 1.0, 1.0) for t in (25.0, 45.0)]


def description(captures=None, verdict="described"):
    captures = captures or replace(tiny(), name="folder")
    model = NoiseModel((ReadNoise(2.0), EFFECT), 64.0)
    numbers = [Number("period", 9.0, 0.02, "pixel", 9.0)]
    shown = Look(
        np.outer(np.arange(8.0), np.ones(9)), "mean frame − median [DN]", np.arange(5.0),
        np.arange(5.0), "distance from the centre [pixel]", POINTS, np.array([0.8, 0.81]),
        np.array([0.02, 0.02]), np.array([0.8, 0.8]),
    )  # fmt: skip
    near = [Nearest("periodic_pattern", 1.9, "not indicated by the statistics")]
    return Description(
        captures, verdict, "Fixed rings, period 9.000 ± 0.020 px: known.", 2.1, 0.9, 0.99,
        "adequate", EFFECT, numbers, ["something is right"], near, ["flicker_fpn"],
        ["More frames."], ["Another."], model, shown,
    )  # fmt: skip
