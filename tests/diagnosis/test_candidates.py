"""Refits of candidates."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.baseline import with_baseline
from dnanalyze.diagnosis.candidates import SoFar, _witnessed, candidates_of, judged, trials
from dnanalyze.diagnosis.predictive_check import REPLICATES, Null
from dnanalyze.diagnosis.selection import significant
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.from_part import fitted
from dnanalyze.fitting.least_squares import deviance
from dnanalyze.fitting.predictor import bench
from dnanalyze.loaders.captures import Window
from dnanalyze.model.effects.column_fpn import ColumnFpn
from dnanalyze.model.effects.defect_lines import DefectLines
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.registry import BASE, built_in

UPPER, LOWER = Window(0, 50, 0, 80), Window(50, 100, 0, 80)
ROWS = ("row_fpn", "row_noise", "column_fpn")


@pytest.fixture(scope="module")
def null() -> Null:
    """A sensor with row noise and column offsets, and its baseline model."""
    hidden = {"row_noise": {"level": "strong"}, "column_fpn": {"level": "strong"}}
    drawn = draw_sensor(np.random.default_rng(11))
    held = bench(design(generate(drawn, hidden, (128, 128), frames=4, seed=3)))
    paper = fitted(held, paper_start(held))
    return Null(held, with_baseline(held, paper, (), lambda *_: None))


def of(*names):
    return {name: effect for name, effect in built_in().items() if name in names}


def test_both_hidden_effects_are_refitted_and_significant(null):
    so_far, told = SoFar(), []
    found = trials(null, of(*ROWS), told.append, so_far)
    named = {t.effect: t for t in found}
    assert {found[0].effect, found[1].effect} == {"row_noise", "column_fpn"}
    for name in ("row_noise", "column_fpn"):
        assert significant(named[name], null.error)
        assert named[name].state.loss < null.state.loss
        assert named[name].error < null.error
    assert set(so_far.screened) <= set(ROWS)
    assert {t.effect for t in so_far.trials} == set(named)
    assert set(named) <= set(told)


def test_the_gain_is_that_of_both_halves_in_units_of_the_scatter(null):
    (found,) = trials(null, of("column_fpn"))
    again = judged(null, "column_fpn", found.state)
    assert (again.gain, again.fitted_gain) == (found.gain, found.fitted_gain)
    assert found.falls.sum() == pytest.approx(found.gain + found.fitted_gain)
    assert judged(null, "column_fpn", null.state).evidence == 0.0


def test_candidates_are_not_in_the_model_nor_excluded(null):
    known = of("read_noise", *ROWS)
    assert set(candidates_of(null.state, known, [BASE, "row_fpn"])) == {"row_noise", "column_fpn"}


def test_no_candidates_no_trials(null):
    assert trials(null, {}) == []


@pytest.fixture(scope="module")
def alike() -> Null:
    """A sensor with few atoms of one metal: its hot pixels are nearly alike."""
    drawn = draw_sensor(np.random.default_rng(11))
    hidden = {"dark_current_steps": {"level": "middling"}}
    held = bench(design(generate(drawn, hidden, (128, 128), frames=4, seed=3)))
    paper = fitted(held, paper_start(held))
    return Null(held, with_baseline(held, paper, (), lambda *_: None))


def test_competitors_are_judged_by_nine_sensors_of_their_make(alike):
    found = trials(alike, of("dark_current_steps", "hot_pixels"))
    assert len(found) == 2
    for t in found:
        fall = 0.0
        for model, sign in ((alike.state.model, 1.0), (t.state.model, -1.0)):
            seeds = (replace(model, seed=model.seed + n) for n in range(REPLICATES + 1))
            made = np.array([alike.held.fitted_coordinates(m) for m in seeds])
            made = np.where(np.isfinite(made), made, made[0])  # a sensor may lack a statistic
            z = alike.held.train.z(made.mean(axis=0))
            fall += sign * np.sum(deviance(z / alike.scatter[0]))
        assert t.fitted_gain == pytest.approx(fall, rel=1e-6)


def test_an_effect_that_the_captures_do_not_show_as_such_is_no_candidate(null):
    @dataclass(frozen=True)
    class Unseen(ColumnFpn):
        def shows_in(self, frames):
            return frames > 4

    assert [t.effect for t in trials(null, of("column_fpn"))] == ["column_fpn"]
    assert trials(null, {"column_fpn": Unseen}) == []


def test_a_half_without_the_effect_is_evidence_against_it_only():
    held = SimpleNamespace(plan=SimpleNamespace(windows=(UPPER, LOWER)))
    above, below, both = (
        DefectLines(axis="rows", lines=lines, offsets=(1.0,) * len(lines))
        for lines in ((10,), (60,), (10, 60))
    )
    for anywhere in (both, RowFpn(1.0), None):
        assert _witnessed(held, anywhere, 30.0, 2.0) == (30.0, 2.0)
    assert _witnessed(held, below, 30.0, 2.0) == (30.0, 30.0)
    assert _witnessed(held, below, 30.0, -50.0) == (-20.0, -20.0)
    assert _witnessed(held, above, 2.0, 30.0) == (30.0, 30.0)
    assert _witnessed(held, above, -5.0, 30.0) == (25.0, 25.0)
