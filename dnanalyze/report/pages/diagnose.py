"""The page of `diagnose`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dnanalyze.comparator.rivals import Rivals
from dnanalyze.report import capture
from dnanalyze.report.figures.candidates import candidates
from dnanalyze.report.leads import diagnose_lead
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages import compare
from dnanalyze.report.pages.front import (
    candidate_layers,
    curves_sections,
    direct_front,
    effect_section,
    frames_section,
    labels_of,
    numbers_section,
    place_of,
)
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.tables import named
from dnanalyze.report.words import (
    candidates_of,
    diagnose_headline,
    leading,
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
    others, every = candidates_of(result)
    evidence = [
        Section(
            f"evidence-{c.effect}",
            f"Evidence for {naming(c.effect, c.confidence)}",
            points=[sentence(e) for e in c.evidence],
        )
        for c in others[result.verdict == "missing" : 3]  # the best one's stands with the verdict
    ]
    return [
        Section(
            "candidates",
            "Candidates",
            pictures=[candidates(result.candidates, result.error, result.ordinary)],
            tables=[
                *_candidates("candidate", others),
                *_candidates("baseline effect", every, "Effects of the baseline model"),
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


def _told(result: Any) -> list[str]:
    """The evidence for the effect that is missing."""
    best = leading(result)
    if result.verdict != "missing" or best is None or best.effect in result.ordinary:
        return []
    return [sentence(e) for e in best.evidence]


def _candidates(head: str, found: Sequence[Any], folded: str = "") -> list[Table]:
    """A row a candidate, best first; no table without any."""
    columns = (
        head,
        "confounded with",
        "model error after",
        "excess error explained",
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
    return [Table(columns, rows, words=2, title=folded, folded=bool(folded))] if rows else []


def _limits(limits: Any) -> list[Table]:
    """Detection limits, folded."""
    rows = [(text,) for text in texts(limits)]
    return [Table(("limit",), rows, title=plural(len(rows), "effect"), folded=True)] if rows else []


def diagnose_page(
    captures: Any, result: Any, comparison: Any = None, rivals: Rivals | None = None
) -> str:
    """HTML of the page; with a comparison its panels follow the diagnosis."""
    page = Page(
        "Diagnosis",
        capture.title(captures),
        diagnose_lead(result),
        [
            *sections(result),
            *([compare.overview(comparison), *compare.families(comparison)] if comparison else []),
            model_section(result.model),
        ],
        tone=TONES.get(result.verdict, "fair"),
        points=[diagnose_headline(result), *_told(result)],
        facts=capture.facts(captures),
        notes=captures.notes,
        front=_front(captures, result, comparison, rivals or Rivals()),
        about=capture.about(captures),
    )
    return render(page)


def _front(captures: Any, result: Any, comparison: Any, rivals: Rivals) -> list[Section]:
    place = place_of(comparison, rivals)
    models = {"model": result.model}
    if rivals.after is not None:
        models[labels_of(rivals.effect)[1]] = rivals.after.model
    made = [frames_section(captures, place, models)]
    if comparison is not None:
        raw = None if rivals.raw is None else rivals.raw.statistics
        made += curves_sections(
            candidate_layers(comparison, rivals), place, comparison.simulated, raw
        )
        made += effect_section(comparison.measured, rivals)
        made += numbers_section(comparison.measured, compare.HALF)
    return [*made, *direct_front(result)]
