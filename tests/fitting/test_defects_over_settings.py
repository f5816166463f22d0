"""Single lines over both halves of the field and all settings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.line_defects import line_defects
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.residual import Residual
from dnanalyze.fitting.state import start
from dnanalyze.loaders.captures import CaptureSet, Frame, Setting, Window

PROFILE = np.random.default_rng(0).standard_normal(100) * 0.1


def _told(*seen, gains=(1.0,), frame=(80, 100)):
    profile = PROFILE.copy()
    profile[[30, 60]] += (5.0, -3.0)
    rows = [np.array(s, float).reshape(-1, 4) for s in seen]
    return line_defects((np.arange(100), profile), rows, np.array(gains), "columns", frame)


def test_a_line_in_both_halves_is_one_from_the_first_begin_to_the_last_end():
    seen = [(30, 9.0, 35, 40), (30, 8.0, 40, 80), (60, -3.0, 0, 40), (60, -3.1, 40, 80)]
    partial, whole = _told(seen)
    assert tuple(partial) == (30, 8.0, 35, 80)
    assert tuple(whole[[0, 2, 3]]) == (60, 0, 80)
    assert whole[1] == pytest.approx(-3.0, abs=0.5)  # of the profile, over all settings


def test_settings_vote_and_their_gain_is_taken_off():
    seen = [[(30, 8.0, 40, 80)], [(30, 16.0, 42, 80)], [(30, 8.2, 41, 80)], []]
    partial, unseen = _told(*seen, gains=(1.0, 2.0, 1.0, 1.0))
    assert tuple(partial) == (30, 8.0, 41, 80)
    assert tuple(unseen[2:]) == (0, 80)  # nothing told of how far along: the whole line


def _with_defects(cfa: tuple[tuple[str, ...], ...] | None) -> CaptureSet:
    """Column 51 is off from row 100 down, row 20 as a whole."""
    rng = np.random.default_rng(4)
    made = generate(draw_sensor(rng), {}, (192, 160), frames=4, seed=4)

    def off(frame: Frame) -> Frame:
        def read(window=None):
            image = np.asarray(frame.read(), float)
            image[100:, 51] += 400.0
            image[20] += 300.0
            image = np.clip(image, 0, 65535).astype(np.uint16)
            w = window or Window(0, image.shape[0], 0, image.shape[1])
            return image[w.top : w.bottom, w.left : w.right]

        return replace(frame, load=read)

    settings = tuple(Setting(s.point, tuple(off(f) for f in s.frames)) for s in made.settings)
    return replace(made, settings=settings, sensor=replace(made.sensor, cfa=cfa))


@pytest.mark.parametrize("cfa", [None, (("R", "G"), ("G", "B"))], ids=["mono", "mosaic"])
def test_lines_are_found_where_they_are(cfa):
    problem = fit_problem(design(_with_defects(cfa)))
    model = paper_start(problem)
    clues = Residual(problem, start(problem, model, []))
    ((column, offset, begin, end),) = clues.defects("columns")
    assert column == 51
    assert offset == pytest.approx(400, rel=0.1)
    assert begin == pytest.approx(100, abs=4)
    assert end == 192
    ((row, offset, begin, end),) = clues.defects("rows")
    assert (row, begin, end) == (20, 0, 160)
    assert offset > 0
    for axis, length in (("columns", 160), ("rows", 192)):
        places, means = clues.lines(axis, 0)
        assert places.size == means.size == length
