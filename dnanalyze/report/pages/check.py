"""The page of `check`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dnanalyze.digits import resolving
from dnanalyze.report import capture
from dnanalyze.report.check import excess, headline, limit, value
from dnanalyze.report.figures.targets import targets
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.words import number, plural, symbol


def check_page(captures: Any, result: Any) -> str:
    """HTML of the page."""
    met = [c for c in result.checks if c.passed]
    page = Page(
        "Check",
        result.captures.name if captures is None else capture.title(captures),
        headline(result),
        [
            Section(
                "violated",
                "Violated targets",
                pictures=[targets(result.checks)],
                tables=_rows("target", result.failures),
            ),
            Section(
                "known",
                "Known violations, not enforced",
                tables=_rows("target", result.known_misses),
            ),
            Section("met", "Targets that are met", tables=_met(met)),
        ],
        tone="good" if result.passed else "poor",
        facts={} if captures is None else capture.facts(captures),
        notes=() if captures is None else captures.notes,
    )
    return render(page)


def _rows(title: str, checks: Sequence[Any]) -> list[Table]:
    cells = [
        (c.name, limit(c), value(c), number(c.measured, resolving(c.lower, c.upper)), excess(c))
        for c in checks
    ]
    columns = (title, "limit", "simulated", "measured", "deviation")
    return [Table(columns, cells, words=2)] if cells else []


def _met(checks: Sequence[Any]) -> list[Table]:
    cells = [(c.name, limit(c), value(c), symbol(c.unit)) for c in checks]
    columns = ("target", "limit", "simulated", "unit")
    title = plural(len(cells), "target")
    return [Table(columns, cells, words=2, title=title, folded=True)] if cells else []
