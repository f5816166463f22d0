from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze import NoiseModel, OperatingPoint, catalogue, classify, simulate
from dnanalyze.classifier.classify import classify_on
from dnanalyze.fitting.processes import Processes
from dnanalyze.fitting.time_limit import TimeLimit
from dnanalyze.loaders.captures import CaptureSet, Frame, Sensor

KNOWN = catalogue()
POINT, WARM = OperatingPoint(25.0, 0.1), OperatingPoint(60.0, 0.1)
PLAIN = NoiseModel(
    (
        KNOWN["read_noise"](sigma=2.0),
        KNOWN["pixel_fpn"](sigma=1.0),
        KNOWN["column_fpn"](sigma=0.3),
        KNOWN["quantization"](bits=12),
    ),
    64.0,
)


def _captures(model: NoiseModel, frames: int = 4, sensor: Sensor | None = None) -> CaptureSet:
    sensor = sensor or Sensor((128, 128))
    return simulate(replace(model, seed=99), sensor.shape, [(POINT, frames)], sensor=sensor)


def _shifted(captures: CaptureSet, shifts: np.ndarray) -> CaptureSet:
    """Each frame with an offset of its own."""

    def moved(frame: Frame, shift: float) -> Frame:
        return replace(frame, load=lambda w: frame.load(w) + shift)

    (setting,) = captures.settings
    frames = tuple(moved(f, s) for f, s in zip(setting.frames, shifts, strict=True))
    return replace(captures, settings=(replace(setting, frames=frames),))


def test_another_sensor_of_the_model_with_offsets_of_whole_frames_is_not_told():
    shifts = np.array([0.0, 5.0, -3.0, 11.0])
    found = classify(_shifted(_captures(PLAIN), shifts), PLAIN)
    assert not found.tells
    assert {c.view for c in found.cells} == {"frame", "pair", "mean", "tall", "wide"}
    assert "cannot tell" in found.sentence()


def test_a_wider_tail_is_told_and_named():
    hot = PLAIN.without("read_noise").with_effect(
        KNOWN["heavy_tailed_read_noise"](sigma=2.0, tail=0.0)
    )
    found = classify(_captures(hot), PLAIN)
    assert found.tells
    assert found.auc - found.control > 0.05
    assert 0.5 < found.low < found.auc <= found.high
    assert found.telling
    assert found.telling[0] in found.sentence()
    assert found.patches.measured.shape == found.patches.simulated.shape


def test_the_same_seed_gives_the_same_numbers():
    captures = _captures(PLAIN, frames=1)
    one, two = (classify(captures, PLAIN, seed=3) for _ in range(2))
    assert one.cells == two.cells


def test_one_frame_has_the_pictures_that_exist():
    found = classify(_captures(PLAIN, frames=1), PLAIN)
    assert {c.view for c in found.cells} == {"mean", "tall", "wide"}


def test_a_small_field_gives_the_reason():
    small = _captures(PLAIN, sensor=Sensor((64, 32)))
    found = classify(small, PLAIN)
    assert not found.cells
    assert found.auc is None
    assert not found.tells
    assert "fewer than 64" in found.sentence()


def test_a_time_limit_ends_it_early():
    captures = simulate(replace(PLAIN, seed=99), (128, 128), [(POINT, 3), (WARM, 3)])
    found = classify_on(captures, PLAIN, limit=TimeLimit(0.0))
    assert {c.point for c in found.cells} == {POINT}
    assert not found.finished


@pytest.mark.long
def test_a_helper_takes_operating_points_and_views_of_its_own_and_finds_the_same():
    points = [(POINT, 2), (replace(POINT, temperature_c=40.0), 2), (WARM, 2)]
    captures = simulate(replace(PLAIN, seed=99), (128, 128), points)
    helpers = Processes(1)
    try:
        shared = classify_on(captures, PLAIN, helpers=helpers)
        assert shared.cells == classify(captures, PLAIN).cells
        assert helpers.shares == 2
    finally:
        helpers.close()


def test_codes_with_a_step_and_a_mosaic():
    scale = 16
    effects = (*PLAIN.effects[:3], KNOWN["quantization"](bits=16, step=scale))
    wide = [replace(e, sigma=scale * e.sigma) for e in effects[:3]]
    model = NoiseModel((*wide, effects[3]), 1024.0)
    sensor = Sensor((160, 160), cfa=(("R", "G"), ("G", "B")))
    assert not classify(_captures(model, frames=2, sensor=sensor), model).tells


def test_all_operating_points_together_are_a_cell_of_each_view():
    captures = simulate(replace(PLAIN, seed=99), (128, 128), [(POINT, 2), (WARM, 2)])
    found = classify(captures, PLAIN)
    assert {c.view for c in found.together} == {c.view for c in found.cells}
    for together in found.together:
        areas = [c.auc for c in found.cells if c.view == together.view]
        assert together.auc == pytest.approx(np.mean(areas))
        assert together.point is None
    assert classify(_captures(PLAIN, frames=1), PLAIN).together == []


def test_fewer_operating_points_may_be_asked_for():
    points = [(POINT, 2), (replace(POINT, temperature_c=40.0), 2), (WARM, 2)]
    captures = simulate(replace(PLAIN, seed=99), (128, 128), points)
    assert {c.point for c in classify(captures, PLAIN, points=2).cells} == {POINT, WARM}
