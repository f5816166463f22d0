"""Defects that lie in one half of the field, of which the other can say nothing."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis import adequacy
from dnanalyze.diagnosis.refine import refine
from dnanalyze.diagnosis.trial import Trial, witnessed
from dnanalyze.fitting.least_squares import State, given
from dnanalyze.loaders.captures import CaptureSet, Frame, Window
from dnanalyze.model.effects.defect_lines import DefectLines
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, EVERYDAY, built_in

UPPER, LOWER = Window(0, 50, 0, 80), Window(50, 100, 0, 80)
KNOWN = {n: e for n, e in built_in().items() if n in (BASE, *EVERYDAY, "row_fpn", "defect_lines")}


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


def test_a_half_with_none_of_it_speaks_only_against_it():
    bench = SimpleNamespace(plan=SimpleNamespace(windows=(UPPER, LOWER)))
    above, below, both = (
        DefectLines(axis="rows", lines=lines, offsets=(1.0,) * len(lines))
        for lines in ((10,), (60,), (10, 60))
    )
    assert witnessed(bench, both, 30.0, 2.0) == (30.0, 2.0)
    assert witnessed(bench, None, 30.0, 2.0) == (30.0, 2.0)
    assert witnessed(bench, below, 30.0, 2.0) == (30.0, 30.0)
    assert witnessed(bench, below, 30.0, -50.0) == (-20.0, -20.0)
    assert witnessed(bench, above, 2.0, 30.0) == (30.0, 30.0)
    assert witnessed(bench, above, -5.0, 30.0) == (25.0, 25.0)


def test_so_it_is_where_gains_are_told_in_units_of_the_scatter_of_sensors(monkeypatch):
    half = SimpleNamespace(names=np.array(["row_extreme"] * 10))
    plan = SimpleNamespace(windows=(UPPER, LOWER))
    bench = SimpleNamespace(plan=plan, train=half, test=half)
    monkeypatch.setattr(adequacy, "_others", lambda *_: (np.zeros((2, 10)), np.zeros((2, 10))))
    named = NoiseModel((DefectLines(axis="rows", lines=(60,), offsets=(1.0,)),))
    before, after = (
        State(named, [], np.zeros(10), given(np.full(10, level)), np.zeros((10, 0)))
        for level in (10.0, 0.0)
    )
    found = adequacy.sobered(bench, before, Trial("defect_lines", after, 0.0, 0.0, 1.0))
    assert found.gain == found.fitted_gain > 0.0


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
    sensor = draw_sensor(np.random.default_rng(11))
    plain = generate(sensor, {}, (192, 192), frames=4, seed=3)
    offset = float(np.rint(2.0 * sensor.noise_dn))
    found = refine(with_a_bad_row(plain, row, offset), known=KNOWN)
    assert found.verdict == "adequate"
    assert [n for n in found.effects if n not in (BASE, *EVERYDAY)] == ["defect_lines"]
    named = found.model.get("defect_lines")
    assert named.axis == "rows"
    assert named.lines == (row,)
    # of 20 frames of 192 pixels, beside pixel offsets and dark current
    assert named.sigma == pytest.approx(offset, rel=0.15)
    assert found.steps[-1].confidence > 0.9
    own = [k.effect == "defect_lines" for k in found.state.knobs]
    assert np.any(found.state.jacobian[:, own]) == (row == 40)  # the fitted half is the upper
