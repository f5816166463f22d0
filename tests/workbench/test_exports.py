"""The report of a session: the named effect before and after."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

import dnanalyze
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.model.registry import built_in
from dnanalyze.workbench import exports
from dnanalyze.workbench.history import History


@pytest.fixture(scope="module")
def session(folder, fitted):
    captures = dnanalyze.load(str(folder))
    known = built_in()
    with_rows = fitted.with_effect(known["row_noise"]())
    with_both = with_rows.with_effect(known["column_fpn"]())
    history = History.begun(fitted, "Wang 2025 model, fitted").measured(0, 9.0, {})
    for action, model, error in (
        ("add row_noise", with_rows, 8.5),
        ("add column_fpn", with_both, 2.0),
        ("set column_fpn.sigma", with_both, 1.9),
    ):
        history = history.grown(action, model)
        history = history.measured(history.at, error, {})
    return SimpleNamespace(
        captures=captures, problem=fit_problem(design(captures)), known=known, history=history,
        present=history.present,
    )  # fmt: skip


def test_the_report_shows_the_effect_with_the_largest_fall_before_and_after(session):
    text = exports.report(session)
    assert "Column FPN: before and after" in text
    assert text.index('id="effect"') < text.index('id="figure-1"')


def test_a_report_without_an_addition_names_no_effect(session):
    start = SimpleNamespace(**vars(session) | {"history": session.history.moved(0)})
    found = exports._beside(start, session.problem)
    assert (found.effect, found.before, found.raw) == ("", None, None)
