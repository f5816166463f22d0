"""A refinement over HDR channels: its terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import channel_results, tables
from dnanalyze.report.figures.waterfall import waterfall, waterfalls
from dnanalyze.report.pages.hdr_channels import refinement_page
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.presentations.families import family_plots
from dnanalyze.report.presentations.fit import simulated
from dnanalyze.report.terminal.channels import refinement
from dnanalyze.report.words import sentence


def _terminal(console: Console, result: Any) -> None:
    refinement(console, result.captures, result)


def _page(result: Any) -> str:
    from dnanalyze.comparator.compare import compare_on

    found = result.captures
    return refinement_page(found, result, compare_on(found, result.model, held=result.bench))


def _plots(result: Any) -> Mapping[str, Draw]:
    own: dict[str, Draw] = {
        "steps": lambda: waterfall(result.steps),
        "channels": lambda: waterfalls({c: part.steps for c, part in result.channels.items()}),
    }
    return own | family_plots(lambda: simulated(result))


PRESENTATION = Presentation(
    _terminal,
    lambda result: sentence(channel_results.headline(result)),
    lambda result: channel_results.refinement(result.captures.name, "refine", result, None),
    tables.steps,
    _page,
    _plots,
)
