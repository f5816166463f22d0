"""The outcome of `detect` in the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from dnanalyze.report import words
from dnanalyze.report.terminal.common import MOST_ROWS, points, table, verdict
from dnanalyze.report.words import number


def detection(console: Console, captures: Any, result: Any) -> None:
    """The verdict and the tests behind it."""
    from dnanalyze.report.pages.detect import headline

    verdict(console, captures, headline(result))
    points(console, "Evidence", words.texts(list(result.evidence)))
    points(console, "Not determined from these captures", words.texts(list(result.ambiguous)))
    ranked = sorted(
        result.findings, key=lambda f: (not f.flagged, f.p_value if f.p_value is not None else 2)
    )
    shown = max(MOST_ROWS, min(2 * MOST_ROWS, sum(f.flagged for f in ranked)))
    table(
        console,
        ("test", "points to", "at", "p-value", "effect size", "flagged"),
        (
            (
                f.test,
                f.kind,
                words.celsius(f.temperature_c) if words.is_number(f.temperature_c) else "all",
                words.probability(f.p_value),
                number(f.effect_size, 2),
                _flag(f),
            )
            for f in ranked[:shown]
        ),
        left=2,
    )


def _flag(finding: Any) -> str:
    """Yes, or no; with the reason where the p-value alone would say yes."""
    from dnanalyze.detection.reasons import NOT_SIGNIFICANT

    if finding.flagged:
        return "yes"
    return "no" if finding.reason == NOT_SIGNIFICANT else f"no: {finding.reason}"
