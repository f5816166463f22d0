"""Steps of a search."""

import pytest

from dnanalyze.diagnosis.results import Step
from dnanalyze.diagnosis.search_path import descending, falling, last_change


def test_baseline_effects_that_raise_the_error_enter_with_the_first_that_lowers_it():
    rising = [Step(None, 20.0), Step("read_noise", 30.0), Step("quantization", 30.0)]
    assert descending(rising) == rising[:1]
    found = [*rising, Step("column_taps", 24.0), Step("column_fpn", 8.0, 0.9), Step("rts", 3.0)]
    steps = descending(found)
    assert [s.added for s in steps] == [s.added for s in found]
    assert [s.error for s in steps] == [20.0, 8.0, 8.0, 8.0, 8.0, 3.0]
    assert "enters with column_fpn" in steps[1].evidence[-1]


def test_falling_steps_stay_as_they_are():
    falling = [Step(None, 4.0), Step("read_noise", 2.0), Step("column_fpn", 0.9)]
    assert descending(falling) == falling


@pytest.mark.parametrize(
    ("errors", "expected"),
    [([3.0], True), ([3.0, 2.0, 2.0], True), ([3.0, 2.0, 2.1], False), ([1.0, 2.0, 0.5], False)],
)
def test_errors_fall_where_none_exceeds_the_one_before(errors, expected):
    assert falling(errors) is expected


@pytest.mark.parametrize(
    ("names", "errors", "count"),
    [
        ((None, "rts"), (4.0, 2.0), 1),
        ((None, "-rts", "persistence"), (4.0, 2.0, 2.0), 2),
        ((None, "-rts", "persistence"), (4.0, 3.0, 2.0), 1),  # a backward step, then an addition
        ((None, "-rts", "-persistence"), (4.0, 2.0, 2.0), 1),
        ((None, "rts", "persistence"), (4.0, 2.0, 2.0), 1),
    ],
)
def test_an_exchange_is_one_change(names, errors, count):
    steps = [Step(name, error) for name, error in zip(names, errors, strict=True)]
    assert last_change(steps) == count
