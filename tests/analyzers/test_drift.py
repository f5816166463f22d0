"""Whole frames that move by many times the noise change neither noise nor DSNU nor spectra."""

import numpy as np
import pytest

from dnanalyze import OperatingPoint
from dnanalyze.analyzers.analyze import finish
from dnanalyze.analyzers.streaming.accumulation import accumulate
from dnanalyze.emva import kinds
from dnanalyze.emva.operating_point import quantities
from dnanalyze.emva.quantity import unknown
from dnanalyze.emva.system_gain import system_gain

SHAPE, NOISE, DSNU = (96, 128), 3.0, 1.0
MOVES = {
    "ramp": 8.0 * np.arange(8),
    "jump": np.where(np.arange(8) < 3, 0.0, 90.0),
    "walk": np.cumsum(np.random.default_rng(2).normal(0, 20, 8)),
    "down": -40.0 * np.arange(8),
}


def stack():
    rng = np.random.default_rng(1)
    pattern = rng.normal(0, DSNU, SHAPE) + 40 * (rng.random(SHAPE) < 0.005)
    return np.rint(1000 + pattern + rng.normal(0, NOISE, (8, *SHAPE)))


def measured(frames):
    return finish(accumulate(list(frames.astype(np.float32))).finish(), OperatingPoint(20.0, 1.0))


@pytest.fixture(scope="module")
def still():
    return measured(stack())


@pytest.mark.parametrize("move", MOVES)
def test_noise_and_dsnu_are_those_of_the_differences_less_their_means(move):
    frames = stack() + np.rint(MOVES[move])[:, None, None]
    level = frames.mean(axis=(1, 2), keepdims=True)
    noise = np.sqrt((frames - level).var(axis=0, ddof=1).mean())
    dsnu = np.sqrt(frames.mean(axis=0).var() - noise**2 / 8)
    found = measured(frames)
    gain = system_gain(None, None, True, unknown(kinds.TRANSFER, "no light"))
    quantity = quantities(found, gain).quantities["temporal_dark_noise_dn"]
    assert quantity.value == pytest.approx(noise, rel=1e-3)
    assert found.values["dsnu_1288"].value == pytest.approx(dsnu, rel=1e-3)
    assert found.values["mean"].value == pytest.approx(frames.mean(), abs=0.01)
    assert found.values["drift"].value == pytest.approx(level.std(ddof=1), rel=1e-3)


@pytest.mark.parametrize("move", MOVES)
def test_spectra_lines_and_hot_pixels_are_those_of_still_frames(still, move):
    found = measured(stack() + np.rint(MOVES[move])[:, None, None])
    names = [
        n
        for n in still.values
        if n.startswith(("frame_psd", "temporal_psd", "temporal_row", "temporal_col"))
    ]
    assert len(names) > 12
    for name in [*names, "pattern_correlation", "hot_repeat"]:
        value, se = still.values[name].value, still.values[name].se
        assert found.values[name].value == pytest.approx(value, rel=0.02, abs=0.2 * se), name
