"""Errors where a wave runs through the frames, its phase new in each."""

from __future__ import annotations

import pytest
from dark_frames import capture_of, dark_frames
from test_honest_errors import scatter, too_small

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.analyzers.wave import widened

MOVED = (
    "temporal_noise", "temporal_noise_core", "temporal_r1", "temporal_kurtosis", "temporal_q0.01",
    "temporal_q0.99", "noise_at_50", "pattern_noise", "pattern_noise_core", "pattern_correlation",
    "pattern_corr_10", "pattern_corr_11", "pattern_q0.1", "pattern_q0.25", "pattern_pmin8",
)  # fmt: skip


@pytest.fixture(scope="module")
def found():
    return scatter(30, 6, (96, 128), hum=3.0)


def test_stated_errors_hold_the_scatter_of_the_phases(found):
    # 30 captures give a standard deviation to 13 %
    off = too_small({n: found[n] for n in MOVED}, 1.4 * 1.4)
    assert not off


def test_they_are_not_far_too_large(found):
    ratio = {n: found[n][1] / found[n][2] for n in MOVED}
    assert min(ratio.values()) > 0.3


def test_without_a_wave_they_are_as_they_were():
    (setting,) = analyze(capture_of(dark_frames(3, 6))).settings
    assert widened(setting.values, 6) == setting.values
    (single,) = analyze(capture_of(dark_frames(3, 1, hum=3.0))).settings
    assert widened(single.values, 1) == single.values


def test_errors_never_shrink():
    (setting,) = analyze(capture_of(dark_frames(3, 6, hum=3.0))).settings
    more = widened(setting.values, 6)
    assert more.keys() == setting.values.keys()
    assert all(more[n].se >= v.se and more[n].value == v.value for n, v in setting.values.items())
    assert more["temporal_r1"].se > setting.values["temporal_r1"].se
