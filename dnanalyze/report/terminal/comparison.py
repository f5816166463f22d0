"""The outcome of `compare` in the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import words
from dnanalyze.report.tables import worst
from dnanalyze.report.terminal.common import (
    MOST_FAILURES,
    MOST_ROWS,
    bar,
    points,
    table,
    verdict,
)
from dnanalyze.report.words import number, point_label


def comparison(console: Console, captures: Any, result: Any) -> None:
    """The error, where the model fails, family by family, and the largest discrepancies."""
    headline = words.compare_headline(result.error, result.baselines)
    verdict(console, captures, words.with_remarks(headline, result))
    points(console, "Largest discrepancies", result.failures, MOST_FAILURES)
    _families(console, result.families)
    rows = worst(result.statistics, most=MOST_ROWS)
    parts = words.varied(result.statistics)
    table(
        console,
        ("statistic", "at", "measured", "model", "difference", "sigma"),
        (
            (
                r["name"],
                point_label(r, parts),
                number(r["measured"]),
                number(r["simulated"]),
                words.gap(r["measured"], r["simulated"], r.get("unit", ""), r.get("scale", "")),
                number(r["discrepancy"], 3),
            )
            for r in rows
        ),
        left=2,
    )
    if rows:
        console.print("sigma: difference over the reproducibility standard deviation.", style="dim")


def _families(console: Console, families: Mapping[str, float]) -> None:
    known = {k: v for k, v in families.items() if words.is_number(v)}
    if not known:
        return
    top = max([*known.values(), 1.0])
    ranked = sorted(known.items(), key=lambda item: -item[1])
    table(
        console,
        ("family", "", "model error"),
        ((words.family_title(k), bar(v / top), number(v)) for k, v in ranked),
        left=2,
    )
