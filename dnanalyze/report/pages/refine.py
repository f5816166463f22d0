"""The page of `refine` and of `add`."""

from __future__ import annotations

from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.figures.waterfall import waterfall
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages import compare, diagnose
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.words import (
    add_headline,
    naming,
    number,
    percent,
    refine_headline,
    sentence,
    step_name,
    with_error,
)


def step_rows(steps: Any) -> list[tuple[str, str, str, str]]:
    """Step, confidence, what it may be confused with, error after."""
    return [
        (
            naming(step_name(s.added, place), s.confidence),
            percent(s.confidence),
            ", ".join(s.confused_with) or "–",
            number(s.error),
        )
        for place, s in enumerate(steps)
    ]


STEP_COLUMNS = ("step", "confidence", "confused with", "error after")


def parameter_section(result: Any) -> Section:
    """The numbers of the final model with their standard errors."""
    rows = [(p.name, with_error(p.value, p.se), p.unit) for p in result.parameters]
    return Section(
        "parameters",
        "The effects of the final model",
        text=["Value and standard error; the errors are those of one measured and one simulated "
              "sensor, which the estimate was made with."] if rows else [],
        tables=[Table(("parameter", "value", "unit"), rows)] if rows else [],
    )  # fmt: skip


def refine_page(captures: Any, result: Any, comparison: Any = None, by_hand: bool = False) -> str:
    """HTML of the page; with a comparison of the final model its panels follow.

    ``by_hand``: of `add`, where the user named the effect.
    """
    steps = list(result.steps)
    names = [step_name(s.added, place) for place, s in enumerate(steps)]
    why = [
        sentence(f"{naming(name, s.confidence)}: {e}")
        for name, s in zip(names, steps, strict=True)
        for e in s.evidence
    ]
    rest = result.diagnosis
    page = Page(
        "Refinement",
        capture.title(captures),
        add_headline(result) if by_hand else refine_headline(result),
        [
            Section(
                "steps",
                "The error, step by step",
                pictures=[waterfall(steps)],
                tables=[Table(STEP_COLUMNS, step_rows(steps))],
            ),
            Section("why", "Why each was added", points=why),
            parameter_section(result),
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
