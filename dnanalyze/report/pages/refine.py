"""The page of `refine` and of `add`."""

from __future__ import annotations

from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.figures.waterfall import waterfall
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages import compare, diagnose
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.words import (
    number,
    percent,
    refine_headline,
    sentence,
    step_name,
    with_remarks,
)


def refine_page(captures: Any, result: Any, comparison: Any = None) -> str:
    """HTML of the page; with a comparison of the final model its panels follow."""
    steps = list(result.steps)
    names = [step_name(s.added, place) for place, s in enumerate(steps)]
    rows = [
        (name, percent(getattr(s, "confidence", None)), number(s.error))
        for name, s in zip(names, steps, strict=True)
    ]
    why = [
        sentence(f"{name}: {e}")
        for name, s in zip(names, steps, strict=True)
        for e in getattr(s, "evidence", None) or ()
    ]
    rest = getattr(result, "diagnosis", None)
    page = Page(
        "Refinement",
        capture.title(captures),
        with_remarks(refine_headline(steps, result.verdict), result),
        [
            Section(
                "steps",
                "The error, step by step",
                pictures=[waterfall(names, [s.error for s in steps])],
                tables=[Table(("step", "confidence", "error after"), rows)],
            ),
            Section("why", "Why each was added", points=why),
            *(diagnose.sections(rest) if rest is not None else []),
            *(
                compare.sections(comparison)
                if comparison is not None
                else [model_section(result.model)]
            ),
        ],
        tone=diagnose.TONES.get(result.verdict, "fair"),
        figures=[
            (number(steps[0].error), "error at the start"),
            (number(steps[-1].error), "error at the end"),
            (str(len(result.effects)), "effects in the model"),
        ],
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
