"""Direct measurements as constraints of a fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.demo import VirtualSensor, generate
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model, fit_on
from dnanalyze.fitting.free_parameters import free_parameters, positions
from dnanalyze.fitting.from_part import converge
from dnanalyze.fitting.moments import BlackLevel
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.state import start
from dnanalyze.fitting.ties import Direct, Known, Tie, direct, misfits
from dnanalyze.loaders.arrays import from_arrays
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.registry import catalogue

SHAPE = 96, 96
SENSOR = VirtualSensor(gain_dn_e=0.5, temperatures_c=(40.0, 60.0, 80.0))


def with_bias(sensor: VirtualSensor = SENSOR) -> CaptureSet:
    """Dark frames over temperature, each beside bias frames."""
    dark = generate(sensor, {}, (96, 96), frames=4, seed=2)
    bias = generate(replace(sensor, exposure_s=0.0), {}, (96, 96), frames=4, seed=2, first=50)
    settings = sorted((*dark.settings, *bias.settings), key=lambda s: s.point.sort_key())
    return replace(dark, settings=tuple(settings))


def test_frames_tell_the_gain_and_the_black_level():
    found = direct(analyze(with_bias(), workers=1))
    ((setting, gain),) = found.gains
    assert setting == 1.0
    assert gain.source == "photon transfer"
    assert abs(gain.value - 0.5) < 3 * gain.error
    assert found.black is None  # it does not move
    assert found.level is not None
    assert abs(found.level.mean - SENSOR.pedestal_dn) < 0.5


def test_a_recorded_gain_is_good_to_a_tenth():
    made = with_bias()
    made = replace(made, sensor=replace(made.sensor, system_gain_dn_e=0.6))
    known = {g.source: g for _, g in direct(analyze(made, workers=1)).gains}
    assert known["recorded"] == Known(0.6, pytest.approx(0.06), "recorded")


def knobs_and_model():
    problem = fit_problem(design(with_bias()))
    model = baseline_model(problem)
    return problem, model, free_parameters(model)


def test_a_gain_binds_the_parameter_less_a_digital_gain():
    _, model, free = knobs_and_model()
    known = Direct(((1.0, Known(0.9, 0.09, "photon transfer")), (4.0, Known(9.0, 1.0, "recorded"))))
    (tie,) = known.ties(model, free, SHAPE)
    assert free[tie.at].name == "dark_shot_noise.dn_per_e"
    assert (tie.position, tie.error) == (pytest.approx(np.log(0.9)), pytest.approx(0.1))
    times = model.with_effect(catalogue()["digital_gain"](gain=1.5))
    (tie,) = known.ties(times, free_parameters(times), SHAPE)
    assert tie.position == pytest.approx(np.log(0.6))


def test_none_where_a_filter_lowers_the_noise():
    _, model, _ = knobs_and_model()
    smoothed = model.with_effect(catalogue()["denoise"]())
    known = Direct(((None, Known(0.9, 0.09, "recorded")),))
    assert not known.ties(smoothed, free_parameters(smoothed), SHAPE)


def test_rows_of_the_black_level_are_bound_at_their_temperatures():
    _, model, _ = knobs_and_model()
    points = tuple(OperatingPoint(t, None, 1.0) for t in (40.0, 80.0))
    level = BlackLevel(TableLaw(points, (60.0, 70.0)), np.array([0.1, 0.2]))
    moving = replace(model, pedestal=level.law)
    ties = Direct(level=level).ties(moving, free_parameters(moving), SHAPE)
    assert [(t.position, t.error) for t in ties] == [(60.0, 0.1), (70.0, 0.2)]
    assert Direct(level=level).ties(model, free_parameters(model), SHAPE) == ()  # one level for all


def test_the_black_level_of_frames_is_the_pedestal_with_the_median_of_fixed_offsets():
    _, model, _ = knobs_and_model()
    taps = catalogue()["column_taps"](sigma=6.0, kind="blocks", levels=(2.0, -0.5), begins=(24,))
    model = replace(model.with_effect(taps), pedestal=64.0)
    level = BlackLevel(TableLaw((OperatingPoint(40.0, None, 1.0),), (60.0,)), np.array([0.1]))
    (tie,) = Direct(level=level).ties(model, free_parameters(model), SHAPE)
    # 24 of 96 columns at a, 72 at -a / 3 with a mean square of 1
    assert tie.position == pytest.approx(60.0 + 6.0 / np.sqrt(3.0))
    rows = replace(model, pedestal=level.law)
    (tie,) = Direct(level=level).ties(rows, free_parameters(rows), SHAPE)
    assert tie.position == pytest.approx(60.0 + 6.0 / np.sqrt(3.0))


def moved_by(shift):
    """Four exposures at two temperatures, one of them a session of another black level."""
    sensor = replace(SENSOR, temperatures_c=(60.0, 80.0))
    made = with_bias(sensor)
    longest = max(s.point.exposure_s for s in made.settings)
    for n, share in enumerate((0.3, 0.6)):
        more = replace(sensor, exposure_s=longest * share)
        more = generate(more, {}, (96, 96), frames=4, seed=2, first=100 + 50 * n)
        made = replace(made, settings=(*made.settings, *more.settings))
    at = OperatingPoint(60.0, longest * 0.6, 1.0)
    stacks = {
        s.point: np.stack([f.read() for f in s.frames]) + (shift if s.point == at else 0)
        for s in made.settings
    }
    return from_arrays(stacks, bits=12), at


@pytest.mark.long
def test_a_session_of_another_black_level_is_told_and_its_row_bound():
    made, at = moved_by(40)
    sessions = direct(analyze(made, workers=1)).sessions
    assert sessions is not None
    assert sessions.moved == (at,)
    assert sessions.law.at(at) == pytest.approx(SENSOR.pedestal_dn + 40.0, abs=1.0)
    problem = fit_problem(design(made))
    model = baseline_model(problem)
    assert model.pedestal.points == tuple(point for point, _ in problem.plan.settings)
    assert model.pedestal.at(at) == problem.direct.sessions.law.at(at)
    bound = problem.ties(model, free_parameters(model), 1.0)
    assert len(bound) == len(problem.plan.settings)
    ended = fit_on(made, model, replicates=0, problem=problem)
    assert any("black level there differs by +4" in text for text in ended.undetermined)
    assert at not in [a.point for a in ended.direct]


def test_a_steady_black_level_has_no_sessions():
    assert direct(analyze(with_bias(), workers=1)).sessions is None


def test_misfits_are_in_standard_errors():
    ties = (Tie(1, 2.0, 0.5), Tie(0, 1.0, 2.0))
    np.testing.assert_allclose(misfits(ties, np.array([5.0, 1.0])), [-2.0, 2.0])


@pytest.mark.long
@pytest.mark.parametrize("factor", [1 / 30, 5.0])
def test_a_fit_ends_at_the_gain_wherever_it_begins(factor):
    problem, model, free = knobs_and_model()
    shot = model.get("dark_shot_noise")
    off = model.with_effect(replace(shot, dn_per_e=shot.dn_per_e * factor))
    ended = converge(problem, start(problem, off, free))
    assert ended.model.get("dark_shot_noise").dn_per_e == pytest.approx(0.5, rel=0.1)


def test_the_merit_counts_what_the_ties_are_off():
    problem, model, free = knobs_and_model()
    state = start(problem, model, free)
    off = misfits(state.ties, positions(model, free))
    assert state.merit == pytest.approx(replace(state, ties=()).merit + float(off @ off))
