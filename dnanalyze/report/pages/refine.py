"""The page of `refine` and of `add`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dnanalyze.comparator.rivals import Rivals
from dnanalyze.report import capture
from dnanalyze.report.figures.waterfall import waterfall
from dnanalyze.report.leads import named_effects, refine_lead
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages import compare, diagnose
from dnanalyze.report.pages.classifier import classifier_section
from dnanalyze.report.pages.front import (
    classifier_front,
    curves_sections,
    direct_front,
    effect_section,
    frames_section,
    labels_of,
    model_layers,
    numbers_section,
    place_of,
)
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


def refine_report(captures: Any, result: Any) -> str:
    """HTML of the page, the final model compared with the captures, and the step before it."""
    from dnanalyze.comparator.compare import compare_on
    from dnanalyze.comparator.rivals import of_steps

    comparison = compare_on(captures, result.model, held=result.bench)
    beside = of_steps(result.bench, result.steps, named_effects(result.steps))
    return refine_page(captures, result, comparison, beside)


def refine_page(
    captures: Any, result: Any, comparison: Any = None, rivals: Rivals | None = None
) -> str:
    """HTML of the page; with a comparison of the final model its panels follow."""
    steps, told = list(result.steps), getattr(result, "classification", None)
    by_hand = getattr(result, "by_hand", False)  # of `add`: the user named the effect
    rest = result.diagnosis
    said = add_headline(result) if by_hand else refine_headline(result)
    page = Page(
        "Refinement",
        capture.title(captures),
        said if by_hand else refine_lead(result),
        [
            Section(
                "steps",
                "Refinement steps",
                pictures=[waterfall(steps)],
                tables=step_tables(steps),
            ),
            model_section(result.model, result.parameters),
            *direct_section(result),
            *([] if told is None else [classifier_section(told)]),
            *(diagnose.sections(rest) if rest is not None else []),
            *([compare.overview(comparison), *compare.families(comparison)] if comparison else []),
        ],
        tone=diagnose.TONES.get(result.verdict, "fair"),
        points=[*([] if by_hand else [said]), *evidence(steps)],
        figures=[
            (number(steps[0].error), "model error at the start"),
            (number(steps[-1].error), "model error at the end"),
            ("1", "a second sensor of the same design"),
        ],
        facts=capture.facts(captures),
        notes=captures.notes,
        front=_front(captures, result, comparison, rivals or Rivals()),
        about=capture.about(captures),
    )
    return render(page)


def _front(captures: Any, result: Any, comparison: Any, rivals: Rivals) -> list[Section]:
    place = place_of(comparison, rivals)
    models = {"model": result.model}
    if rivals.before is not None and rivals.after is not None:
        names = labels_of(rivals.effect)
        models = dict(zip(names, (rivals.before.model, rivals.after.model), strict=True))
    made = [frames_section(captures, place, models)]
    if comparison is not None:
        raw = None if rivals.raw is None else rivals.raw.statistics
        made += effect_section(comparison.measured, rivals)
        made += curves_sections(model_layers(comparison, rivals), place, comparison.simulated, raw)
        made += numbers_section(comparison.measured, compare.HALF)
    made += direct_front(result)
    return [*made, *classifier_front(getattr(result, "classification", None))]
