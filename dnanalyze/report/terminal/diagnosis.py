"""The outcome of `diagnose` in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console

from dnanalyze.report import words
from dnanalyze.report.tables import named
from dnanalyze.report.terminal.common import MOST_FAILURES, MOST_ROWS, points, table, verdict
from dnanalyze.report.words import number


def diagnosis(console: Console, captures: Any, result: Any) -> None:
    """The verdict, the candidates with their evidence, the limits, the recommended captures."""
    verdict(console, captures, words.diagnose_headline(result))
    candidates, baseline = words.candidates_of(result)
    _candidates(console, "candidate", candidates)
    _candidates(console, "baseline effect", baseline)
    if best := words.leading(result):
        title = f"Evidence for {words.naming(best.effect, best.confidence)}"
        points(console, title, list(best.evidence))
    unexplained(console, result.unexplained)
    points(console, "Detection limits", words.texts(result.detection_limits), MOST_ROWS)
    if result.next_capture:
        points(console, "Recommended captures", words.texts(result.next_capture))


def unexplained(console: Console, names: Sequence[str]) -> None:
    """Statistics that are not explained, worst first, and how many are not shown."""
    points(console, "Statistics not explained", [named(n) for n in names], MOST_FAILURES)


def _candidates(console: Console, title: str, found: Sequence[Any]) -> None:
    """Effects with the model error after each, best first; what each is confounded with."""
    rivals = any(c.confused_with for c in found)
    table(
        console,
        (
            title,
            "error after",
            "accounts for",
            "confidence",
            *(("confounded with",) if rivals else ()),
        ),
        (
            (
                words.naming(c.effect, c.confidence),
                number(c.error_after),
                words.percent(c.explained),
                words.percent(c.confidence),
                *((", ".join(c.confused_with) or "–",) if rivals else ()),
            )
            for c in found[:MOST_ROWS]
        ),
    )
