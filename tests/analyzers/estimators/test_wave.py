"""Errors where a wave runs through the frames, its phase new in each."""

from __future__ import annotations

import numpy as np
import pytest
from dark_frames import capture_of, dark_frames
from test_honest_errors import scatter, too_small

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.estimators.wave_errors import widened

MOVED = (
    "temporal_noise", "temporal_noise_core", "temporal_r1", "temporal_kurtosis", "temporal_q0.01",
    "temporal_q0.99", "noise_at_50", "pattern_noise", "pattern_noise_core", "pattern_correlation",
    "pattern_corr_10", "pattern_corr_11", "pattern_q0.1", "pattern_q0.25", "pattern_pmin8",
    "pattern_psd_0.08_0.16", "pattern_u_0.03_0.1", "pattern_v_0.1_0.3", "pattern_line",
    "pattern_line_in_step", "temporal_line", "temporal_psd_0.08_0.16",
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


def test_what_is_left_of_a_wave_is_no_more_certain_where_it_happens_to_be_little():
    """Each capture's misfit from the mean, in its own error: an exponential's, not a fluke's."""
    infos = catalogue()
    for name in ("pattern_psd_0.08_0.16", "pattern_u_0.03_0.1", "pattern_line"):
        seen = [
            analyze(capture_of(dark_frames(seed, 6, (96, 128), hum=3.0))).settings[0].values[name]
            for seed in range(30)
        ]
        at = np.array([infos[name].scale.coordinate(v.value) for v in seen])
        mean = infos[name].scale.coordinate(float(np.mean([v.value for v in seen])))
        assert np.max(np.abs(at - mean) / [v.se for v in seen]) < 5.0


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
