"""The outcome of `analyze` in the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from dnanalyze.report.tables import laws
from dnanalyze.report.terminal.common import MOST_FAILURES, points, table, verdict
from dnanalyze.report.terminal.emva import emva_tables, undetermined
from dnanalyze.report.words import with_error


def statistics(console: Console, captures: Any, measured: Any, quantities: Any = None) -> None:
    """The EMVA 1288 quantities, the laws over temperature, what is not determined."""
    from dnanalyze.analyzers.families.trends import law_doubts
    from dnanalyze.report.emva import LAWS
    from dnanalyze.report.pages.analyze import headline

    quantities = measured.emva if quantities is None else quantities
    verdict(console, captures, headline(measured, quantities))
    emva_tables(console, quantities, table)
    columns, found = laws(measured, LAWS)
    table(
        console,
        ("over temperature", *columns),
        (
            (title, *(with_error(v.value, v.se, unit) if v else "–" for v in values))
            for title, values, unit in found
        ),
    )
    points(console, "Warnings", law_doubts(measured))
    not_determined = undetermined(quantities, measured, 2 * MOST_FAILURES)
    points(console, "Not determined from these captures", not_determined)
