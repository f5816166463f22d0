"""A diagnosis: verdict, sections, page, document, table and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from dnanalyze.comparator.compare import Comparison
from dnanalyze.diagnosis.results import Candidate, Diagnosis, Refinement
from dnanalyze.report.documents import Document, coverage, direct, fields_of, level
from dnanalyze.report.figures.candidates import candidates
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.leads import diagnose_lead
from dnanalyze.report.page import Page, Section, Table, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.results import comparison as compare
from dnanalyze.report.rivals import Rivals
from dnanalyze.report.sections.front import candidate_layers, front, labels_of
from dnanalyze.report.sections.model import model_section
from dnanalyze.report.statistic_rows import named
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
headline = diagnose_headline


def sections(result: Diagnosis) -> list[Section]:
    """Candidates with evidence, statistics not explained, limits, recommended captures."""
    others, baseline = candidates_of(result)
    best = leading(result)
    first = result.verdict == "missing"  # on the page its evidence stands with the verdict
    evidence = [
        Section(
            f"evidence-{c.effect}",
            f"Evidence for {naming(c.effect, c.confidence)}",
            points=[sentence(e) for e in c.evidence],
            printed=c is best,
            paged=c in others[first:3],
        )
        for c in (others[:3] or baseline[:1])
    ]
    limits = texts(result.detection_limits)
    rows = [(text,) for text in limits]
    said = "An effect weaker than its limit may be present and not detected in these captures."
    return [
        Section(
            "candidates",
            "Candidates",
            pictures=[lambda: candidates(result.candidates, result.error, result.ordinary)],
            tables=[
                _candidates("candidate", others),
                _candidates("baseline effect", baseline, "Effects of the baseline model"),
            ],
        ),
        *evidence,
        unexplained_section(result),
        Section("found", "Detection limits", points=limits, most=8, paged=False),
        Section("next", "Recommended captures", points=texts(result.next_capture)),
        Section(
            "limits", "Detection limits", text=[said] if rows else [], printed=False,
            tables=[Table(("limit",), rows, title=plural(len(rows), "effect"), folded=True)],
        ),
    ]  # fmt: skip


def unexplained_section(result: Diagnosis | Refinement) -> Section:
    """Statistics that are not explained, worst first."""
    said = [sentence(named(n)) for n in result.unexplained]
    return Section("unexplained", "Statistics not explained", points=said, most=6)


def _candidates(head: str, found: Sequence[Candidate], title: str = "") -> Table:
    """A row a candidate, best first; what each is confounded with, where any is."""
    rivals = any(c.confused_with for c in found)
    between = ("confounded with",) if rivals else ()
    rows = [
        (
            naming(c.effect, c.confidence),
            *((", ".join(c.confused_with) or "–",) if rivals else ()),
            number(c.error_after),
            percent(c.explained),
            percent(c.confidence),
        )
        for c in found
    ]
    columns = (head, *between, "error after", "accounts for", "confidence")
    return Table(columns, rows, words=1 + rivals, title=title, most=8)


def page(
    result: Diagnosis, comparison: Comparison | None = None, rivals: Rivals | None = None
) -> Page:
    """The report; with a comparison its panels follow the diagnosis."""
    rivals, models, best = rivals or Rivals(), {"model": result.model}, leading(result)
    if rivals.after is not None:
        models[labels_of(rivals.effect)[1]] = rivals.after.model
    told = result.verdict == "missing" and best is not None and best.effect not in result.ordinary
    evidence = best.evidence if told and best is not None else []
    return page_of(
        result.captures,
        "Diagnosis",
        diagnose_lead(result),
        [
            *sections(result),
            *([compare.overview(comparison), *compare.families(comparison)] if comparison else []),
            model_section(result.model),
        ],
        tone=TONES.get(result.verdict, "fair"),
        points=[headline(result), *map(sentence, evidence)],
        front=front(result, models, comparison, rivals, candidate_layers),
    )


CANDIDATE = "effect", "error_after", "explained", "confidence", "confused_with"


def document(result: Diagnosis) -> Document:
    """The verdict and the candidates, best first."""
    return made(
        "diagnose",
        result.captures.name,
        error=result.error,
        verdict=result.verdict,
        headline=headline(result),
        ordinary=result.ordinary,
        candidates=[fields_of(c, *CANDIDATE, "evidence", "leaves") for c in result.candidates],
        unexplained=result.unexplained,
        detection_limits={n: str(v) for n, v in result.detection_limits.items()},
        next_capture=result.next_capture,
        law=result.law or None,
        direct=direct(result),
        finished=result.finished,
        screened=result.screened,
        **level(result),
        **coverage(result),
    )


def table(result: Diagnosis) -> pd.DataFrame:
    """The candidates, best first."""
    return pd.DataFrame(
        [
            fields_of(c, *CANDIDATE) | {"confused_with": " ".join(c.confused_with)}
            for c in result.candidates
        ]
    )


def plots(result: Diagnosis) -> Mapping[str, Draw]:
    """The candidates."""
    return {"candidates": lambda: candidates(result.candidates, result.error, result.ordinary)}
