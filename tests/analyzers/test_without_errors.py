"""Without standard errors every compared value is the same, to the last bit."""

import numpy as np
import pytest
from dark_frames import capture_of, dark_frames

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.loaders.captures import Window

SHAPE = (96, 151)
HALVES = (Window(0, 96, 0, 75), Window(0, 96, 75, 151), None)
MOSAIC = (("R", "G"), ("G", "B"))


@pytest.mark.parametrize("codes", [True, False])
@pytest.mark.parametrize("count", [1, 2, 3, 6])
@pytest.mark.parametrize("cfa", [None, MOSAIC])
def test_compared_values_do_not_depend_on_errors(codes, count, cfa):
    frames = dark_frames(8, count, SHAPE, columns=0.3, drift=0.2, hot=0.01, codes=codes)
    captures = capture_of(frames, cfa=cfa)
    compared = {name for name, info in catalogue().items() if info.compared}
    full, quick = (analyze_windows(captures, HALVES, workers=1, errors=e) for e in (True, False))
    for one, other in zip(full, quick, strict=True):
        for a, b in zip(one.settings, other.settings, strict=True):
            assert compared & set(a.values) == compared & set(b.values)
            assert {n: a.values[n].value for n in compared & set(a.values)} == {
                n: b.values[n].value for n in compared & set(b.values)
            }
            np.testing.assert_array_equal(a.curves["block_means"], b.curves["block_means"])


def test_a_width_whose_half_is_prime_keeps_one_crop():
    """74 = 2 x 37 stands for 75, but would itself be cropped to 72."""
    (found,) = analyze_windows(capture_of(dark_frames(1, 3, (40, 75))), (None,), workers=1)
    assert found.settings[0].values["temporal_psd_0.35_0.5"].value > 0
