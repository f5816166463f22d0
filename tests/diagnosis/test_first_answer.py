"""The first answer of a search, from a quarter of the field."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.diagnose import diagnose_on, first_answer
from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.fitting.design import PART_FROM_PIXELS, design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.model.memo import Memo
from dnanalyze.model.registry import built_in

FEW = {name: built_in()[name] for name in ("column_fpn", "row_noise")}


def sensor(side, frames):
    drawn = draw_sensor(np.random.default_rng(3))
    return generate(drawn, {"column_fpn": "strong"}, (side, side), (25.0, 65.0), frames, 3)


@pytest.fixture(scope="module")
def large():
    problem = fit_problem(design(sensor(512, 6)))
    assert problem.plan.pixels >= PART_FROM_PIXELS
    return problem


def test_a_quarter_of_the_field_tells_the_hidden_effect(large):
    assert first_answer(large, paper_start(large), FEW)[:1] == ["column_fpn"]


def test_it_keeps_the_time_limit_where_it_has_to_simulate(large):
    unseen = replace(large, part=replace(large.part, predictions=Memo()))
    with pytest.raises(TimeUp):
        first_answer(unseen.within(TimeLimit(0.0)), paper_start(large), FEW)


@pytest.mark.parametrize("search", [diagnose_on, refine_on])
def test_a_search_of_small_captures_has_none(search):
    told = []
    search(sensor(64, 3), known=FEW, budget=1e-6, first=told.append)
    assert told == [[]]
