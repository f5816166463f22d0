"""A model of a window against the rest of the field."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze import NoiseModel, OperatingPoint, catalogue, simulate
from dnanalyze.fitting.design import design
from dnanalyze.fitting.whole_field import coverage, departures
from dnanalyze.loaders.captures import Frame, Setting, Window

SHAPE = (384, 512)
MODEL = NoiseModel(
    (catalogue()["read_noise"](sigma=3.0), catalogue()["quantization"](bits=12)), pedestal=100.0
)


def captures(structure=0.0):
    """Simulated frames with something more on them."""
    made = simulate(replace(MODEL, seed=5), SHAPE, [(OperatingPoint(t), 2) for t in (20.0, 40.0)])
    added = np.broadcast_to(np.asarray(structure, np.float32), SHAPE)

    def with_more(frame: Frame) -> Frame:
        def load(window):
            part = (window or Window.whole(SHAPE)).slices
            return frame.read(window) + added[part]

        return replace(frame, load=load)

    settings = tuple(Setting(s.point, tuple(map(with_more, s.frames))) for s in made.settings)
    return replace(made, settings=settings)


def middle(found):
    """A design with a quarter of the field in its middle."""
    rows, columns = SHAPE
    upper = Window(rows // 4, rows // 2, columns // 4, 3 * columns // 4)
    lower = Window(rows // 2, 3 * rows // 4, columns // 4, 3 * columns // 4)
    return replace(design(found), train=upper, test=lower)


def test_a_right_model_holds_everywhere():
    seen = coverage(middle(captures()), MODEL)
    assert seen.departures == ()
    assert seen.share == 0.25
    assert not seen.departs


def test_of_a_window_that_is_the_whole_field_nothing_is_left():
    assert departures(design(captures()), MODEL) == []


@pytest.mark.parametrize(
    ("place", "kind", "where"),
    [
        ((slice(0, 64), slice(448, 512)), "blocks", "top right"),
        ((slice(None), slice(500, 501)), "columns", "column 500"),
        ((slice(7, 8), slice(None)), "rows", "row 7"),
    ],
)
def test_what_the_window_does_not_see_is_told(place, kind, where):
    structure = np.zeros(SHAPE)
    structure[place] = -2.0
    found = {d.kind: d for d in departures(middle(captures(structure)), MODEL)}[kind]
    assert found.place == where
    assert found.difference_dn == pytest.approx(-2.0, abs=0.6)
    assert found.sigma > 5.0
    assert 0.0 < found.share < 0.1


def test_shading_that_the_model_has_is_none():
    model = MODEL.with_effect(catalogue()["offset_gradient"](x=8.0))
    made = simulate(replace(model, seed=5), SHAPE, [(OperatingPoint(t), 2) for t in (20.0, 40.0)])
    assert departures(middle(made), model) == []
