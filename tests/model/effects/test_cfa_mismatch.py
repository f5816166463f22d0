from dataclasses import replace

import numpy as np
import pytest
from readout_bench import POINT, Given, added, frames

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effects.cfa_mismatch import CfaMismatch

EFFECT = CfaMismatch(0.5, -1.0, 2.0)


def test_three_lines_at_the_corners_of_the_spectrum():
    d = added(EFFECT)
    np.testing.assert_allclose(d[0], d[1], atol=1e-4)
    modes = np.fft.fft2(d[0]).real / d[0].size
    found = {(0, 64): 0.5, (64, 0): -1.0, (64, 64): 2.0}
    for (v, u), size in found.items():
        assert modes[v, u] == pytest.approx(size, abs=1e-4)
    assert d[0].var() == pytest.approx(EFFECT.variance(POINT), rel=1e-4)
    assert d[0].mean() == pytest.approx(0.0, abs=1e-4)


def test_odd_windows_keep_the_phase_of_the_block():
    window = Window(3, 20, 7, 30)
    np.testing.assert_allclose(frames(EFFECT, window=window), frames(EFFECT)[:, 3:20, 7:30])


def test_follows_gain():
    loud = added(EFFECT, point=OperatingPoint(85.0, 1.0, 2.0))
    np.testing.assert_allclose(loud, 2 * added(EFFECT), atol=2e-4)


def test_guess_needs_the_diagonal_or_both_axes():
    n, floor = 256 * 256, 4.0
    ratios = {f"pattern_nyquist_{k}": b**2 * n / floor for k, b in (("10", 0.3), ("11", 0.2))}
    seen = {**ratios, "pattern_psd_0.35_0.5": floor}
    columns = 0.3 * (1.0 - 2.0 * (np.arange(256) % 2))
    columns[7] += 40.0  # a defect column
    clues = Given(seen=seen, off=dict.fromkeys(ratios, 9.0), profiles={"columns": [columns]})
    for effect, uv in zip(CfaMismatch.guess(clues), (0.2, -0.2), strict=True):
        assert (effect.u, effect.v, effect.uv) == pytest.approx((0.3, 0.0, uv))
    assert CfaMismatch.guess(Given(seen=seen, off={"pattern_nyquist_10": 9.0})) == []


@pytest.mark.parametrize(("share", "mosaic"), [(0.02, False), (0.2, True)])
def test_a_line_far_below_the_columns_is_no_mosaics(share, mosaic):
    seen = {"pattern_nyquist_10": 900.0, "pattern_nyquist_01": 900.0 * share**2}
    clues = Given(
        seen={**seen, "pattern_psd_0.35_0.5": 1.0, "pattern_nyquist_11": 0.1},
        off=dict.fromkeys(seen, 9.0),
    )
    assert bool(CfaMismatch.guess(clues)) == mosaic


def test_guess_takes_u_and_v_from_the_lines_and_tries_either_sign_of_uv():
    line = 1.0 - 2.0 * (np.arange(256) % 2)
    seen = dict.fromkeys([f"pattern_nyquist_{k}" for k in ("10", "01", "11")], 100.0)
    clues = Given(
        seen=seen | {"pattern_psd_0.35_0.5": 1.0},
        off=dict.fromkeys(seen, 9.0),
        profiles={"columns": [-line], "rows": [line]},
    )
    effect, other = CfaMismatch.guess(clues)
    assert (effect.u, effect.v) == pytest.approx((-1.0, 1.0))
    assert (other.u, other.v, other.uv) == (effect.u, effect.v, -effect.uv)
    assert effect.relatives() == [other]


def test_colours_that_are_analysed_apart_tell_it_by_their_levels():
    """Of two exposures and gains; offsets within their errors are none."""
    offsets = np.array([0.2, 0.9, -0.6, 0.1])
    points = (POINT, replace(POINT, gain=2.0 * POINT.gain))
    levels = np.array([[(100.0 + g * o, 0.01) for o in offsets] for g in (1.0, 2.0)])
    (effect,) = CfaMismatch.guess(Given(points=points, seen={"colours median": levels}))
    u, v, uv = effect.u, effect.v, effect.uv
    made = [u + v + uv, -u + v - uv, u - v - uv, -u - v + uv]
    assert made == pytest.approx(list(offsets - offsets.mean()), abs=1e-6)
    levels[..., 1] = 1.0
    assert CfaMismatch.guess(Given(points=points, seen={"colours median": levels})) == []
