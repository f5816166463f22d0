"""What a time limit leaves for the search of a command."""

import pytest
from dnanalyze_cli import session as sessions

from dnanalyze.errors import InputError


@pytest.fixture
def begun(monkeypatch):
    """A command that began 10 s ago, on a machine where a report takes 30 s."""
    monkeypatch.setattr(sessions, "monotonic", lambda: 10.0)
    monkeypatch.setattr("dnanalyze.report.drawing_time.drawing_time", lambda: 30.0)

    def made(**outputs):
        own = sessions.Session("refine", **outputs)
        own._begun = 0.0
        return own

    return made


def test_without_a_report_a_search_has_what_is_left(begun):
    assert begun().remaining(100.0) == pytest.approx(90.0)


@pytest.mark.parametrize(("budget", "left"), [(100.0, 60.0), (50.0, 20.0), (5.0, 1e-3)])
def test_a_report_is_drawn_within_the_limit_and_a_search_has_half_of_it(
    begun, tmp_path, budget, left
):
    assert begun(report=tmp_path / "r.html").remaining(budget) == pytest.approx(left)


def test_the_simulations_of_a_report_take_as_long_as_the_frames_took_to_be_read(
    begun, tmp_path, monkeypatch
):
    session = begun(report=tmp_path / "r.html")
    clock = iter([10.0, 17.0])
    monkeypatch.setattr(sessions, "monotonic", lambda: next(clock, 17.0))
    assert session.fit_problem(Reader(), "captures") == ("captures", None)
    assert session.remaining(100.0) == pytest.approx(100.0 - 17.0 - 30.0 - 7.0)


class Reader:
    """A progress that reads nothing."""

    def fit_problem(self, captures, executor=None):
        return captures, executor


def test_no_limit_and_one_that_is_no_time():
    assert sessions.Session("refine").remaining(None) is None
    with pytest.raises(InputError, match="seconds above 0"):
        sessions.Session("refine").remaining(0.0)
