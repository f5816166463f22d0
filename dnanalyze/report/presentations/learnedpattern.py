"""A learned pattern: its terminal text, document, table, page and figure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd
from rich.console import Console

from dnanalyze.report import documents
from dnanalyze.report.figures.learned_pattern import learned_pattern
from dnanalyze.report.pages.pattern import pattern_page
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.terminal.common import verdict


def _terminal(console: Console, result: Any) -> None:
    verdict(console, result.captures, result.sentence())


def _table(result: Any) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {**vars(p), "size": size, "se": se}
            for p, size, se in zip(result.points, result.sizes, result.errors, strict=True)
        ]
    )


def _plots(result: Any) -> Mapping[str, Draw]:
    return {"pattern": lambda: learned_pattern(result)}


PRESENTATION = Presentation(
    _terminal,
    lambda result: result.sentence(),
    lambda result: documents.learned_pattern(result.captures.name, result),
    _table,
    lambda result: pattern_page(result.captures, result),
    _plots,
)
