"""The outcome of `detect` in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from dnanalyze.report import words
from dnanalyze.report.terminal.common import MOST_ROWS, points, table, verdict
from dnanalyze.report.words import number, sentence


def detection(console: Console, captures: Any, result: Any) -> None:
    """The verdict and the tests behind it."""
    from dnanalyze.report.pages.detect import headline

    verdict(console, captures, headline(result))
    points(console, "Evidence", words.texts(list(result.evidence)))
    points(console, "Not determined from these captures", words.texts(list(result.ambiguous)))
    ranked = sorted(
        result.findings, key=lambda f: (not f.flagged, f.p_value if f.p_value is not None else 2)
    )
    shown = ranked[: max(MOST_ROWS, min(2 * MOST_ROWS, sum(f.flagged for f in ranked)))]
    reasons = list(dict.fromkeys(filter(None, map(_reason, shown))))
    table(
        console,
        ("test", "on", "at", "p-value", "effect size", "flagged"),
        (
            (
                f.test,
                f.view,
                words.celsius(f.temperature_c) if words.is_number(f.temperature_c) else "all",
                words.probability(f.p_value),
                number(f.effect_size, 2),
                _flag(f, reasons),
            )
            for f in shown
        ),
        left=2,
    )
    for place, text in enumerate(reasons, 1):
        console.print(Padding(Text(f"({place}) {sentence(text)}", style="dim"), (0, 0, 0, 2)))


def _reason(finding: Any) -> str:
    """Why a finding does not count where the p-value alone would say that it does."""
    from dnanalyze.detection.reasons import NOT_SIGNIFICANT

    return "" if finding.flagged or finding.reason == NOT_SIGNIFICANT else finding.reason


def _flag(finding: Any, reasons: Sequence[str]) -> str:
    """Yes, or no with the number of the reason below the table."""
    reason = _reason(finding)
    if finding.flagged:
        return "yes"
    return f"no ({reasons.index(reason) + 1})" if reason else "no"
