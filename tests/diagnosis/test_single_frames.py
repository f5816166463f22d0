"""Captures of one frame an operating point: what a frame shows is named, in either form."""

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.residual import Residual
from dnanalyze.fitting.state import start


def captures(hidden, seed, frames=1, shape=(256, 256)):
    sensor = draw_sensor(np.random.default_rng(seed))
    return generate(sensor, hidden, shape, frames=frames, seed=seed)


def residual(**numbers):
    problem = fit_problem(design(captures(**numbers)))
    return Residual(problem, start(problem, baseline_model(problem)))


def test_statistics_of_the_frame_stand_for_those_of_pattern_and_noise():
    seen = residual(hidden={"periodic_pattern": "strong"}, seed=72, shape=(128, 128))
    frame = seen.measured("frame_columns_0.1_0.3")
    assert np.isfinite(frame).all()
    for part in ("pattern", "temporal"):
        np.testing.assert_array_equal(seen.measured(f"{part}_columns_0.1_0.3"), frame)
        for of in (seen.simulated, seen.z):
            np.testing.assert_array_equal(of(f"{part}_line"), of("frame_line"))
        assert len(seen.waves(part)) >= len(seen.points)
    assert np.isnan(seen.measured("temporal_r1")).all()  # no frame tells it


def test_of_several_frames_they_do_not():
    seen = residual(hidden={}, seed=73, frames=2, shape=(128, 128))
    assert np.isnan(seen.measured("frame_columns_0.1_0.3")).all()
    assert np.isfinite(seen.measured("pattern_columns_0.1_0.3")).all()


@pytest.mark.long
@pytest.mark.parametrize(
    ("hidden", "seed", "names"),
    [
        ("column_fpn", 70, {"column_fpn", "column_noise"}),
        ("row_noise", 71, {"row_noise", "row_fpn"}),
        ("periodic_pattern", 72, {"periodic_pattern"}),
        ("serial_noise", 75, {"serial_noise"}),
    ],
)
def test_what_a_single_frame_shows_is_named(hidden, seed, names):
    found = refine_on(captures({hidden: "middling"}, seed), classifier=False)
    (added,) = [s for s in found.steps if s.confidence is not None]
    assert added.added in names
    assert set(added.confused_with) <= names
    assert found.verdict == "adequate"


@pytest.mark.long
def test_nothing_is_added_to_an_ordinary_sensor_of_single_frames():
    found = refine_on(captures({}, 74), classifier=False)
    assert [s for s in found.steps if s.confidence is not None] == []
    assert found.verdict == "adequate"
