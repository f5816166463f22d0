"""Charge that a register multiplies, and charge that moves from frame to frame, by NumPy."""

import numpy as np
import pytest

from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting

pytestmark = pytest.mark.long

SHAPE = (192, 192)
GAIN = 2.0  # DN/e-


def captures_of(seed: int, multiplied: bool = False, jitter: float = 0.0) -> CaptureSet:
    """Dark charge of 8, 40 and 200 e-; each electron leaves as an exponential number or as one.

    ``jitter``: relative standard deviation of the charge of a frame.
    """
    rng = np.random.default_rng(seed)
    shares = np.exp(0.3 * rng.standard_normal(SHAPE))
    offsets = 1.5 * rng.standard_normal(SHAPE)
    settings = []
    for celsius, electrons in ((0.0, 8.0), (15.0, 40.0), (30.0, 200.0)):
        point = OperatingPoint(celsius, 0.1, 1.0)
        frames = []
        for n in range(8):
            longer = 1.0 + jitter * rng.standard_normal()
            count = rng.poisson(longer * electrons * shares)
            charge = rng.gamma(np.maximum(count, 1e-9)) if multiplied else 1.0 * count
            dn = 400.0 + offsets + GAIN * charge + 5.0 * rng.standard_normal(SHAPE)
            codes = np.rint(dn).astype(np.uint16)
            frames.append(
                Frame(f"{celsius}/{n}", point, lambda w, y=codes: y if w is None else y[w.slices])
            )
        settings.append(Setting(point, tuple(frames)))
    return CaptureSet("made", Sensor(SHAPE), tuple(settings))


def test_the_conversion_gain_before_a_register_is_not_that_of_photon_transfer():
    """Photon transfer gives twice it: mean and variance are those of half of the charge."""
    found = refine_on(captures_of(1, multiplied=True), classifier=False)
    assert found.verdict == "adequate"
    assert found.model.get("electron_multiplication").excess == pytest.approx(2.0, abs=0.25)
    assert found.model.get("dark_shot_noise").dn_per_e == pytest.approx(GAIN, rel=0.15)


def test_charge_that_is_only_counted_has_no_register():
    found = refine_on(captures_of(2), classifier=False)
    assert "electron_multiplication" not in found.model.names
    assert found.model.get("dark_shot_noise").dn_per_e == pytest.approx(GAIN, rel=0.05)


def test_charge_that_moves_by_many_times_its_noise_is_named():
    """A quarter of 200 e-: four times their shot noise, and no noise of the pixels."""
    found = refine_on(captures_of(3, jitter=0.25), classifier=False)
    assert "offset_drift" in found.model.names
    assert found.steps[-1].error < 1.2
    assert found.model.get("dark_shot_noise").dn_per_e == pytest.approx(GAIN, rel=0.15)
