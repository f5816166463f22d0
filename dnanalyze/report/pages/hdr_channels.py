"""The pages of `refine`, `add` and `diagnose` over HDR channels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.channel_results import COLUMNS, headline, rows
from dnanalyze.report.figures.waterfall import waterfall
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages import compare, diagnose
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.pages.refine import step_tables
from dnanalyze.report.words import (
    diagnose_headline,
    number,
    refine_headline,
    sentence,
)


def refinement_page(captures: Any, result: Any, comparison: Any) -> str:
    """HTML of the page: which effect belongs where, each channel's steps, the one model held."""
    page = Page(
        "Refinement over channels",
        capture.title(captures),
        sentence(headline(result)),
        [
            Section(
                "belongs",
                "Effects by channel",
                tables=[Table(COLUMNS, rows(result), words=3)],
            ),
            *(_steps(name, part) for name, part in result.channels.items()),
            compare.overview(comparison),
            model_section(result.model),
            *compare.families(comparison),
        ],
        tone=diagnose.TONES.get(result.verdict, "fair"),
        points=[sentence(f) for f in result.findings],
        figures=[
            (number(result.steps[0].error), "model error at the start"),
            (number(result.error), "error of one model of all channels"),
            (str(len(result.channels)), "channels"),
        ],
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)


def _steps(channel: str, part: Any) -> Section:
    return Section(
        f"channel-{channel}",
        f"Channel {channel}",
        text=[refine_headline(part)],
        pictures=[waterfall(part.steps)],
        tables=step_tables(part.steps),
    )


def diagnosis_page(captures: Any, found: Mapping[str, Any], verdict: str) -> str:
    """HTML of the page: every channel's diagnosis, one after another."""
    said = {name: diagnose_headline(d) for name, d in found.items()}
    page = Page(
        "Diagnosis over channels",
        capture.title(captures),
        sentence(f"{len(found)} channels, each diagnosed separately: {verdict}"),
        [
            replace(s, key=f"{name}-{s.key}", title=f"{name}: {s.title}")
            for name, d in found.items()
            for s in diagnose.sections(d)
        ],
        tone=diagnose.TONES.get(verdict, "fair"),
        points=[f"{name}: {text}" for name, text in said.items()],
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
