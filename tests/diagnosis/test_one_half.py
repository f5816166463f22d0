"""Defects that lie in one half of the field, of which the other can say nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drawn_sensor import SENSOR

from dnanalyze.demo import generate
from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.loaders.captures import CaptureSet, Frame, Window
from dnanalyze.model.effects.defect_lines import DefectLines
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.registry import BASE, BASELINE, built_in

UPPER, LOWER = Window(0, 50, 0, 80), Window(50, 100, 0, 80)
KNOWN = {n: e for n, e in built_in().items() if n in (BASE, *BASELINE, "row_fpn", "defect_lines")}


@pytest.mark.parametrize(
    ("lines", "more", "upper", "lower"),
    [
        ((), {}, True, True),
        ((49,), {}, True, False),
        ((50,), {}, False, True),
        ((10, 60), {}, True, True),
        ((10,), {"axis": "columns"}, True, True),
        ((90,), {"axis": "columns"}, False, False),  # beyond the field
        ((10,), {"axis": "columns", "begins": (50.0,), "ends": (100.0,)}, False, True),
        ((10,), {"axis": "columns", "begins": (0.0,), "ends": (50.0,)}, True, False),
        ((10,), {"axis": "columns", "begins": (49.0,), "ends": (51.0,)}, True, True),
        ((60,), {"axis": "rows", "begins": (80.0,), "ends": (90.0,)}, False, False),
    ],
)
def test_where_named_lines_lie(lines, more, upper, lower):
    kind = {"axis": "rows", **more}
    made = DefectLines(lines=lines, offsets=(1.0,) * len(lines), **kind)
    assert (made.lies_in(UPPER), made.lies_in(LOWER)) == (upper, lower)


def test_what_has_no_places_lies_everywhere():
    assert RowFpn(1.0).lies_in(UPPER)


def with_a_bad_row(captures: CaptureSet, row: int, offset: float) -> CaptureSet:
    """The captures with one row off in every frame."""

    def spoiled(frame: Frame) -> Frame:
        def load(window: Window | None) -> np.ndarray:
            made = np.array(frame.read())
            made[row] = np.rint(made[row] + offset)
            return made if window is None else np.ascontiguousarray(made[window.slices])

        return replace(frame, load=load)

    settings = (replace(s, frames=tuple(map(spoiled, s.frames))) for s in captures.settings)
    return replace(captures, settings=tuple(settings))


@pytest.mark.parametrize("row", [pytest.param(40, marks=pytest.mark.slow), 150])
def test_one_bad_row_is_named_whichever_half_it_lies_in(row):
    plain = generate(SENSOR, {}, (192, 192), SENSOR.temperatures_c[::2], frames=4, seed=3)
    offset = float(np.rint(2.0 * SENSOR.noise_dn))
    found = refine_on(with_a_bad_row(plain, row, offset), known=KNOWN, classifier=False)
    assert found.verdict == "adequate"
    assert [n for n in found.effects if n not in (BASE, *BASELINE)] == ["defect_lines"]
    named = found.model.get("defect_lines")
    assert named.axis == "rows"
    assert named.lines == (row,)
    # of 12 frames of 192 pixels, beside pixel offsets and dark current
    assert named.sigma == pytest.approx(offset, rel=0.15)
    assert found.steps[-1].confidence > 0.9
    own = [k.effect == "defect_lines" for k in found.state.free]
    assert np.any(found.state.jacobian[:, own]) == (row == 40)  # the fitted half is the upper
