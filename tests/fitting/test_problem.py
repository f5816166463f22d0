"""What is predicted of one half and of both."""

import numpy as np
import pytest
import small_series as small

from dnanalyze.fitting.problem import FitProblem

BAYER = (("R", "G"), ("G", "B"))


@pytest.mark.parametrize("cfa", [None, BAYER])
def test_either_half_alone_is_what_it_is_beside_the_other(cfa):
    here, other = small.fit_problem_of(cfa), small.model(read_noise={"sigma": 2.5})
    both = here.coordinates(other)
    np.testing.assert_array_equal(here.fitted_coordinates(other), both[0])
    np.testing.assert_array_equal(here.fitted_z(other), here.train.z(both[0]))
    np.testing.assert_array_equal(here.held_out_z(other), here.test.z(both[1]))
    for half, seen in zip((here.train, here.test), both, strict=True):
        assert np.isfinite(seen).mean() > 0.9
        shaded = [k.name.startswith("shading_") for k in half.keys]
        assert np.isfinite(seen[shaded]).all()
        assert sum(shaded) > 0


def test_what_was_simulated_is_not_simulated_again(monkeypatch):
    here, made = small.fit_problem_of(), []
    whole = FitProblem._simulated
    monkeypatch.setattr(
        FitProblem, "_simulated", lambda self, jobs: made.extend(jobs) or whole(self, jobs)
    )
    first, second = small.model(), small.model(read_noise={"sigma": 2.5})
    begun = here.several([first, second, first])
    assert [job.model for job in made] == [first, second]
    assert begun[0] is begun[2]
    again = here.several([second, first])
    assert again[0] is begun[1]
    assert again[1] is begun[0]
    assert len(made) == 2
    here.evened(first).fitted_coordinates(first)  # half of the field: other numbers
    here.only([0]).fitted_coordinates(first)
    assert len(made) == 4


def test_another_sensor_of_the_make_is_drawn_once(monkeypatch):
    here, made = small.fit_problem_of(), []
    whole = FitProblem.coordinates
    monkeypatch.setattr(
        FitProblem, "coordinates", lambda self, model: made.append(model) or whole(self, model)
    )
    first = here.replicate(small.model(), 0)
    assert here.replicate(small.model(), 0) is first
    assert len(made) == 1
    others = (
        here.replicate(small.model(), 1),
        here.replicate(small.model(read_noise={"sigma": 2.5}), 0),
        here.only([0]).replicate(small.model(), 0),
    )
    assert len(made) == 4
    assert len(others[2][0]) < len(first[0])
    for other in others[:2]:
        assert not np.array_equal(other[0], first[0], equal_nan=True)


@pytest.mark.parametrize(
    ("effect", "even"), [("rts", True), ("crosstalk", True), ("row_fpn", False)]
)
def test_half_of_the_field_is_left_out_only_where_nothing_lies_somewhere(effect, even):
    here = small.fit_problem_of()
    assert here.evened(small.model()).even
    assert here.evened(small.model().with_effect(small.KNOWN[effect]())).even == even
    assert here.evened(small.model()).evened(small.model()).even
