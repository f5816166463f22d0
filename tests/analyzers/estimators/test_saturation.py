"""Saturation against frames whose full well, or clip, is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.analyzers.estimators.saturation import of_maps, saturation
from dnanalyze.analyzers.saturated_settings import notes, saturated_settings, unsaturated
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting

SHAPE = (192, 192)
PEDESTAL, READ = 100.0, 3.0


def _charge(rng: np.random.Generator, mean: float) -> np.ndarray:
    return mean * np.exp(0.3 * rng.standard_normal(SHAPE))


def _frames(charge: np.ndarray, well: np.ndarray | float, count: int, seed: int = 1) -> np.ndarray:
    """Shot noise, a full well, read noise, whole codes."""
    rng = np.random.default_rng(seed)
    held = np.minimum(rng.poisson(charge, (count, *SHAPE)), well)
    return np.round(PEDESTAL + held + READ * rng.standard_normal(held.shape)).astype(np.uint16)


@pytest.mark.parametrize("count", [2, 6])
@pytest.mark.parametrize("spread", [0.0, 0.01])
@pytest.mark.parametrize("share", [0.05, 0.3, 0.6])
def test_a_full_well_shows_from_where_the_noise_collapses(count, spread, share):
    rng = np.random.default_rng([count, int(100 * share)])
    charge = _charge(rng, 800.0)
    well = float(np.quantile(charge, 1 - share))
    field = well * (1 + spread * rng.standard_normal(SHAPE))
    found = saturation(_frames(charge, field, count))
    assert found.plateau
    assert found.low_share == 0
    # begins within shot noise and the spread of the wells below their mean
    reach = 3 * (math.sqrt(well) + spread * well) + 3 * READ
    assert PEDESTAL + well - reach < found.high < PEDESTAL + well + reach
    assert found.high_share == pytest.approx(share, abs=0.08)


def test_frames_at_neighbouring_temperatures_show_a_full_well_in_pairs():
    """The well moves with temperature, by more than the noise; least between the nearest two."""
    charge = _charge(np.random.default_rng(6), 800.0)
    wells = (700.0, 790.0, 792.0)
    stack = np.concatenate([_frames(charge, w, 1, seed) for seed, w in enumerate(wells)])
    assert not saturation(stack).plateau
    found = saturation(stack, repeats=False)
    assert found.plateau
    assert 600.0 < found.high - PEDESTAL < 800.0
    free = np.concatenate(
        [_frames(charge * f, math.inf, 1, n) for n, f in enumerate((1, 1.1, 1.2))]
    )
    assert not saturation(free, repeats=False).plateau


@pytest.mark.parametrize("count", [2, 6])
def test_shot_noise_hot_pixels_hits_and_amplifiers_are_no_plateau(count):
    rng = np.random.default_rng(2)
    charge = _charge(rng, 800.0) + np.where(rng.random(SHAPE) < 2e-3, 20000.0, 0.0)
    clean = _frames(charge, math.inf, count)
    hits = clean.astype(float)
    hits[rng.random(hits.shape) < 3e-3] += 300.0
    two = PEDESTAL + np.where(np.arange(SHAPE[1]) < 96, 0.0, 20.0)
    noise = np.where(np.arange(SHAPE[1]) < 96, 6.0, 2.5)
    amplifiers = np.round(two + noise * rng.standard_normal((count, *SHAPE)))
    # a filter that leaves outliers as they are: most pixels are quiet, and lie between the others
    left = rng.random((count, *SHAPE)) < 0.1
    denoised = np.round(
        PEDESTAL + 10 * rng.standard_normal((count, *SHAPE)) * np.where(left, 1, 0.1)
    )
    for stack in (clean, np.round(hits), amplifiers, denoised):
        found = saturation(stack)
        assert not found.plateau
        assert found.share < 0.01


@pytest.mark.parametrize("share", [0.02, 0.4, 0.95])
def test_values_cut_at_a_code_pile_up_there(share):
    stack = _frames(_charge(np.random.default_rng(3), 800.0), math.inf, 4).astype(float)
    low, high = np.quantile(stack, [share, 1 - share], method="nearest")
    bottom, top = saturation(np.maximum(stack, low)), saturation(np.minimum(stack, high))
    assert bottom.low == low
    assert high - 3 * math.sqrt(800.0) < top.high <= high  # below, the cut truncates shot noise
    assert bottom.low_share == pytest.approx(share, abs=0.01)
    assert share - 0.01 < top.high_share < share + 0.2
    assert saturation(stack) == type(bottom)()


def test_what_one_pass_keeps_tells_the_same():
    charge = _charge(np.random.default_rng(4), 800.0)
    stack = _frames(charge, float(np.quantile(charge, 0.4)), 5)
    values, counts = np.unique(stack, return_counts=True)
    variance = stack.var(axis=0, ddof=1, dtype=float)
    found = of_maps(stack.min(axis=0), variance, 5, values, counts)
    assert found == saturation(stack)


def _captures(wells: dict[float, float], frames: int = 3) -> CaptureSet:
    """A series whose charge doubles every 8 C, and where each setting is cut."""
    settings = []
    for seed, (celsius, well) in enumerate(wells.items()):
        charge = _charge(np.random.default_rng(5), 30.0 * 2 ** ((celsius - 20) / 8))
        stack = _frames(charge, well, frames, seed)
        point = OperatingPoint(celsius, 0.1)
        loads = [lambda w, f=f: f if w is None else f[w.slices] for f in stack]
        settings.append(
            Setting(point, tuple(Frame(f"{celsius}-{n}", point, g) for n, g in enumerate(loads)))
        )
    return CaptureSet("made", Sensor(SHAPE), tuple(settings))


def test_a_full_well_found_at_one_setting_holds_at_the_others():
    captures = _captures({20.0: 700.0, 56.0: 700.0, 68.0: 700.0, 90.0: 700.0})
    cold, warm, warmer, full = saturated_settings(captures)
    assert cold.share == 0
    assert warm.plateau
    assert 0.5 < warmer.share < 1
    assert full.share > 0.99  # all pixels full: alone it would look as any quiet sensor
    kept, said = unsaturated(captures)
    assert [s.point.temperature_c for s in kept.settings] == [20.0, 56.0]
    assert any(text.startswith("90 °C") and "plateau" in text for text in said)
    assert notes(captures, [type(cold)()] * 4) == []


def test_saturated_settings_are_said_and_stay_out_of_the_trends():
    open_ended = _captures(dict.fromkeys((20.0, 44.0, 60.0), math.inf))
    free = analyze(open_ended)
    cut = analyze(_captures({20.0: math.inf, 44.0: math.inf, 60.0: math.inf, 76.0: 3300.0}))
    assert "saturation" in cut.settings[3].missing
    assert not any("saturation" in s.missing for s in (*free.settings, *cut.settings[:3]))
    for ours, theirs in zip(free.settings, cut.settings[:3], strict=True):
        assert ours.values == theirs.values
    assert cut.trends["activation_energy_ev"] == free.trends["activation_energy_ev"]


def test_pixels_at_the_lowest_code_are_no_peaks_that_equal_their_neighbours():
    """Nearly all of them lie there, and so does the 99 % quantile."""
    rng = np.random.default_rng(6)
    point = OperatingPoint(20.0, 0.1)
    stack = np.where(rng.random((4, *SHAPE)) < 0.004, rng.integers(1, 60, (4, *SHAPE)), 0)
    loads = [lambda w, f=f: f if w is None else f[w.slices] for f in stack.astype(np.uint16)]
    frames = tuple(Frame(str(n), point, load) for n, load in enumerate(loads))
    found = analyze(CaptureSet("dark", Sensor(SHAPE), (Setting(point, frames),))).settings[0]
    ties = found.values["ties_max8"]
    assert ties.value < 5 * 8 * 0.004 / 59  # a neighbour above 0, and of the same code
