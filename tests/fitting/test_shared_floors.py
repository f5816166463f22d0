"""The floor of a statistic where one half of the field shows little of its scatter."""

from types import SimpleNamespace

import pytest

from dnanalyze.analyzers.statistics import Value
from dnanalyze.fitting.vectors import _shared_error


def half(se):
    return SimpleNamespace(values={} if se is None else {"ties_max8": Value(0.1, se)})


@pytest.mark.parametrize(
    ("left", "right", "shared"),
    [(3.0, 4.0, 12.5**0.5), (4.0, 3.0, 4.0), (2.0, 2.0, 2.0), (2.0, None, 2.0)],
)
def test_a_floor_is_no_smaller_than_that_of_both_halves_together(left, right, shared):
    found = _shared_error([half(left), half(right)], "ties_max8", left)
    assert found == pytest.approx(shared)
