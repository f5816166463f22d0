"""The page of `diagnose`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.figures.candidates import candidates
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages import compare
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.tables import named
from dnanalyze.report.words import (
    candidates_of,
    diagnose_headline,
    naming,
    number,
    percent,
    plural,
    sentence,
    texts,
)

TONES = {"adequate": "good", "missing": "fair", "unexplained": "poor"}


def sections(result: Any) -> list[Section]:
    """Candidates with evidence, statistics not explained, recommended captures, limits."""
    found = list(result.candidates)
    others, every = candidates_of(result)
    evidence = [
        Section(
            f"evidence-{c.effect}",
            f"Evidence for {naming(c.effect, c.confidence)}",
            points=[sentence(e) for e in c.evidence],
        )
        for c in found[result.verdict == "missing" : 3]  # the best one's stands with the verdict
    ]
    return [
        Section(
            "candidates",
            "Candidates",
            pictures=[candidates(found, result.error, result.ordinary)],
            tables=[
                *_candidates("candidate", others),
                *_candidates("baseline effect, added step by step", every),
            ],
        ),
        *evidence,
        Section(
            "unexplained",
            "Statistics not explained",
            points=[sentence(named(n)) for n in result.unexplained],
        ),
        Section("next", "Recommended captures", points=texts(result.next_capture)),
        Section(
            "limits",
            "Detection limits",
            text=[
                "An effect weaker than its limit may be present and not detected in these captures."
            ]
            if result.detection_limits
            else [],
            tables=_limits(result.detection_limits),
        ),
    ]


def _candidates(title: str, found: Sequence[Any]) -> list[Table]:
    """A row a candidate, best first; no table without any."""
    columns = (
        title,
        "confounded with",
        "model error after",
        "share of the excess error",
        "confidence",
    )
    rows = [
        (
            naming(c.effect, c.confidence),
            ", ".join(c.confused_with) or "–",
            number(c.error_after),
            percent(c.explained),
            percent(c.confidence),
        )
        for c in found
    ]
    return [Table(columns, rows, words=2)] if rows else []


def _limits(limits: Any) -> list[Table]:
    """Detection limits, folded."""
    rows = [(text,) for text in texts(limits)]
    return [Table(("limit",), rows, title=plural(len(rows), "effect"), folded=True)] if rows else []


def diagnose_page(captures: Any, result: Any, comparison: Any = None) -> str:
    """HTML of the page; with a comparison its panels follow the diagnosis."""
    page = Page(
        "Diagnosis",
        capture.title(captures),
        diagnose_headline(result),
        [
            *sections(result),
            *([compare.overview(comparison), *compare.families(comparison)] if comparison else []),
            model_section(result.model),
        ],
        tone=TONES.get(result.verdict, "fair"),
        points=[sentence(e) for e in (result.candidates[0].evidence if result.candidates else [])]
        if result.verdict == "missing"
        else [],
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
