"""Memory from frame to frame, and what is none: things that all pixels of a frame share."""

from __future__ import annotations

import hidden_filters as hidden
import numpy as np
import pytest
from virtual_sensor import Traits, VirtualSensor, captures

from dnanalyze.detection import detect
from dnanalyze.detection.memory import autocorrelation


def _noise(frames: int, seed: int = 0, sd: float = 3.0) -> np.ndarray:
    return np.random.default_rng(seed).normal(100, sd, (frames, 128, 128)).round()


@pytest.mark.parametrize("frames", [6, 8, 16])
def test_a_recursive_filter_is_significant_against_both_nulls(frames):
    run = hidden.recursive(0.2)(_noise(frames).astype(np.uint16)).astype(np.float32)
    found = autocorrelation(run)
    assert found is not None
    assert found.p < 1e-5
    assert found.everywhere > 0.03
    assert found.without_trend > 0.6 * found.excess
    assert found.memory == pytest.approx(0.2, abs=0.06)  # rounding hides some of it


def test_residuals_that_do_not_sum_to_zero_are_no_memory():
    # noise of a quarter of a step, colours between two codes, 1/f noise: what is taken off a frame
    # as its lines does not sum to zero over the frames, which moves the correlation of all pairs
    traits = Traits(
        gain=0.056, read=4.85, flicker=3.3, heavy=0.04, plane_offset=2.6, rts=0.008, pedestal=240.0
    )
    stack = VirtualSensor(traits, (128, 128), 7).stack(25.0, 8).astype(np.float32)
    found = autocorrelation(stack)
    assert found is not None
    assert abs(found.excess) < 5 * np.hypot(found.se, found.shared_se)
    assert found.p > 1e-5


def test_a_trend_of_every_pixel_is_no_memory():
    # an eighth of the noise a frame, up or down: significant, and little without the trend
    slopes = np.random.default_rng(8).normal(0, 0.4, (128, 128))
    stack = _noise(16) + slopes * (np.arange(16) - 7.5)[:, None, None]
    found = autocorrelation(stack.astype(np.float32))
    assert found is not None
    assert found.excess > 0.05
    assert found.everywhere > 0.05
    assert found.without_trend < 0.03


@pytest.mark.parametrize("frames", [8, 16])
def test_a_glow_that_warms_up_is_no_memory(frames):
    traits = Traits(gain=1.2, glow=283.0, drift=0.019, dark=0.35)
    seen = captures(VirtualSensor(traits, (192, 192), 1), (65.0, 105.0), frames)
    assert detect(seen).kind == "none"
