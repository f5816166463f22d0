"""Memory that an analysis takes: some frames, however many are read, and none is kept."""

import tracemalloc

import numpy as np
import pytest
from dark_frames import dark_frames

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting

SHAPE = (512, 512)
FRAME = 4 * SHAPE[0] * SHAPE[1]  # bytes, in single precision
POINT = OperatingPoint(25.0, 0.1)


@pytest.fixture(scope="module")
def captured():
    """Captures of so many frames, from four in memory."""
    held = dark_frames(1, 4, SHAPE)

    def of(count):
        frames = tuple(
            Frame(str(n), POINT, lambda window, n=n: held[n % 4].copy()) for n in range(count)
        )
        return CaptureSet("stack", Sensor(SHAPE), (Setting(POINT, frames),))

    analyze(of(5))  # compiled
    return of


def test_memory_does_not_grow_with_the_frames(captured):
    peaks = []
    for count in (8, 40):
        tracemalloc.start()
        analyze(captured(count), workers=1)
        peaks.append(tracemalloc.get_traced_memory()[1] / FRAME)
        tracemalloc.stop()
    # sums of a pixel are 64 bytes or 16 frames, ten frames are held; and the histograms
    assert max(peaks) < 36
    assert peaks[1] == pytest.approx(peaks[0], rel=0.02)


def test_statistics_keep_no_map(captured):
    (setting,) = analyze(captured(5)).settings
    for name, curve in setting.curves.items():
        owner = curve if curve.base is None else np.asarray(curve.base)
        assert owner.nbytes <= 2 * curve.nbytes, name
