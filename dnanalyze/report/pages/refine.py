"""The page of `refine` and of `add`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.figures.waterfall import waterfall
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages import compare, diagnose
from dnanalyze.report.pages.classifier import classifier_section
from dnanalyze.report.pages.model import direct_section, model_section
from dnanalyze.report.stages import Stage, stages
from dnanalyze.report.words import (
    add_headline,
    naming,
    number,
    percent,
    refine_headline,
    sentence,
    step_name,
)

STEP_COLUMNS = ("step", "model error", "confidence", "confounded with")


def step_tables(steps: Sequence[Any]) -> list[Table]:
    """The steps with the baseline model as one, and its parts, folded."""
    whole = stages(steps)
    rows = [(_name(s, place), *_cells(s.parts[-1])) for place, s in enumerate(whole)]
    made = [Table(STEP_COLUMNS, rows, words=1)]
    for stage in whole:
        if len(stage.parts) > 1:
            parts = [(step_name(p.added, 1), *_cells(p)) for p in stage.parts]
            title = f"Effects of the {stage.name}"
            made.append(Table(STEP_COLUMNS, parts, words=1, title=title, folded=True))
    return made


def _name(stage: Stage, place: int) -> str:
    if len(stage.parts) > 1:
        return stage.name
    return naming(step_name(stage.parts[0].added, place), stage.parts[0].confidence)


def _cells(step: Any) -> tuple[str, str, str]:
    return number(step.error), percent(step.confidence), ", ".join(step.confused_with) or "–"


def evidence(steps: Sequence[Any]) -> list[str]:
    """Why each effect was added; the baseline model needs no evidence."""
    return [
        sentence(f"{_name(stage, place)}: {text}")
        for place, stage in enumerate(stages(steps))
        if len(stage.parts) == 1
        for text in stage.parts[0].evidence
    ]


def refine_page(captures: Any, result: Any, comparison: Any = None, by_hand: bool = False) -> str:
    """HTML of the page; with a comparison of the final model its panels follow.

    ``by_hand``: of `add`, where the user named the effect.
    """
    steps, told = list(result.steps), getattr(result, "classification", None)
    rest = result.diagnosis
    page = Page(
        "Refinement",
        capture.title(captures),
        add_headline(result) if by_hand else refine_headline(result),
        [
            Section(
                "steps",
                "Refinement steps",
                pictures=[waterfall(steps)],
                tables=step_tables(steps),
            ),
            model_section(result.model, result.parameters),
            *direct_section(result),
            Section("why", "Evidence for each step", points=evidence(steps)),
            *([] if told is None else [classifier_section(told)]),
            *(diagnose.sections(rest) if rest is not None else []),
            *([compare.overview(comparison), *compare.families(comparison)] if comparison else []),
        ],
        tone=diagnose.TONES.get(result.verdict, "fair"),
        figures=[
            (number(steps[0].error), "model error at the start"),
            (number(steps[-1].error), "model error at the end"),
            (str(len(result.effects)), "effects in the model"),
        ],
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
