"""What a user sees while a command works: frames as they are read, and one note on compiling."""

from types import SimpleNamespace

import numpy as np
import pytest
import report_fakes as fakes
from dnanalyze_cli.progress import Progress, clock, remaining, watched
from dnanalyze_cli.session import Session

from dnanalyze.analyzers.streaming.cache import held
from dnanalyze.loaders import load, write_captures


class Bars:
    """As rich's, but remembered."""

    def __init__(self):
        self.seen = []

    def update(self, task, **fields):
        self.seen.append(fields)

    reset = update


def test_each_frame_moves_the_bar_once_and_is_what_it_was():
    plain, ticks = fakes.captures(), []
    seen = watched(plain, lambda done, total: ticks.append((done, total)))
    for a, b in zip(plain.frames(), seen.frames(), strict=True):
        for _ in range(2):
            assert np.array_equal(a.read(), b.read())
    assert ticks == [(n, 12) for n in range(1, 13)]


def test_the_cache_does_not_see_the_watching(tmp_path):
    folder = write_captures(fakes.captures(), tmp_path / "darks")
    plain = load(folder).cached(str(tmp_path / "kept"))
    seen = watched(plain, lambda *_: None)
    assert held(plain, "x").path == held(seen, "x").path


def test_reading_and_fitting_are_told_apart(monkeypatch):
    monkeypatch.setattr(
        "dnanalyze.fitting.problem.fit_problem",
        lambda plan, _: [f.read() for f in plan.captures.frames()],
    )
    bars = Bars()
    Progress(bars, 0).fit_problem(fakes.captures())
    told = [s.get("description") or s["count"] for s in bars.seen if any(s.values())]
    assert told == ["Reading frames", *(f"{n} of 12" for n in range(1, 13)), "Fitting"]


def test_without_a_terminal_nothing_is_told(monkeypatch, capsys):
    monkeypatch.setattr("dnanalyze.fitting.problem.fit_problem", lambda plan, _: plan)
    with Session("fit").progress("Fitting") as progress:
        plan = progress.fit_problem(fakes.captures())
        progress.now("still")
    assert plan.captures.frame_count == 12
    assert capsys.readouterr().err == ""


def test_compiling_is_told_once_in_a_run(capsys):
    from numba.core import event

    session = Session("demo")
    for _ in range(2):
        with session.progress("Working"), event.trigger_event("numba:compile"):
            pass
    assert capsys.readouterr().err.count("compiling for this machine") == 1


@pytest.mark.parametrize(
    ("done", "total", "elapsed", "left"),
    [(5, 10, 20.0, 20.0), (10, 10, 20.0, 0.0), (1, 1000, 20.0, None), (5, 10, 0.5, None),
     (5, None, 20.0, None), (0, 10, None, None)],
)  # fmt: skip
def test_what_remains_is_told_where_steps_are_counted(done, total, elapsed, left):
    assert remaining(done, total, elapsed) == left


def test_times_read_as_clocks():
    assert [clock(s) for s in (5.9, 65, 3723)] == ["0:05", "1:05", "1:02:03"]


def test_a_phase_within_a_phase_shares_its_bar(monkeypatch):
    session = Session("fit")
    with session.progress("Writing the results") as outer, session.progress("Comparing") as inner:
        assert inner is outer
    with session.progress("Again") as later:
        assert later is not outer


def test_the_first_answer_of_a_search_stays_in_the_terminal():
    said = []
    bars = SimpleNamespace(console=SimpleNamespace(print=lambda text, **_: said.append(text)))
    watched_by = Progress(bars, 0).first
    watched_by([])
    watched_by(["rts", "dpc", "hot_pixels", "crosstalk"])
    assert len(said) == 1
    assert "rts, dpc and hot_pixels" in said[0]
    assert Progress().first is None
