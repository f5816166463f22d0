"""A refinement, or one effect added by hand: verdict, sections, page, document, table, figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import pandas as pd

from dnanalyze.channels.refinement import ChannelRefinement
from dnanalyze.comparator.compare import Comparison
from dnanalyze.diagnosis.results import Refinement, Step
from dnanalyze.fitting.fit import Parameter
from dnanalyze.report import words
from dnanalyze.report.documents import PARAMETER, Document, coverage, direct, fields_of, level
from dnanalyze.report.figures.families import family_plots, simulated
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.figures.waterfall import waterfall
from dnanalyze.report.leads import named_effects, refine_lead
from dnanalyze.report.page import Page, Section, Table, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.refinement_stages import Stage, stages
from dnanalyze.report.results import classification, diagnosis
from dnanalyze.report.results import comparison as compare
from dnanalyze.report.rivals import Rivals
from dnanalyze.report.sections.front import front, labels_of, model_layers
from dnanalyze.report.sections.model import (
    direct_section,
    model_section,
    parameters_section,
    undetermined_section,
)
from dnanalyze.report.words import naming, number, percent, sentence, step_name


def headline(result: Refinement) -> str:
    """The verdict of the search, or of the effect that the user chose."""
    by_hand = result.by_hand
    return words.add_headline(result) if by_hand else words.refine_headline(result)


def sections(result: Refinement) -> list[Section]:
    """The model error step by step, the final model, and what is not explained."""
    kept = words.net_additions([s.added for s in result.steps])
    why = {n: s for s in result.steps if (n := s.added) in kept and words.is_number(s.confidence)}
    said = [
        f"{words.with_rivals(name, s.confidence, s.confused_with)}: {s.evidence[0]}"
        for name, s in why.items()
        if name
    ]
    title = "Evidence" if result.by_hand else "Evidence for each effect added"
    effects = f"Effects in the model: {words.listing(result.effects)}."
    return [
        Section(
            "steps",
            "Refinement steps",
            pictures=[lambda: waterfall(list(result.steps))],
            tables=step_tables(result.steps),
        ),
        Section("reasons", title, points=said, paged=False),
        parameters_section("final model", result),
        model_section(result.model, result.parameters),
        *direct_section(result),
        undetermined_section(result),
        replace(diagnosis.unexplained_section(result), paged=False),
        *classification.line(result.classification),
        Section("effects", "Effects", text=[effects], paged=False),
    ]


def step_tables(steps: Sequence[Step]) -> list[Table]:
    """The steps with the baseline model as one, and its parts, folded."""
    whole = stages(steps)
    known = [s.error for s in steps if words.is_number(s.error)]
    rows = [(_name(s, place), *_cells(s.parts[-1])) for place, s in enumerate(whole)]
    shares = [s.error / max([*known, 1.0]) if words.is_number(s.error) else 0 for s in whole]
    columns = ("step", "model error", "confidence", "confounded with")
    shown = [Table(columns, rows, words=1, bars=shares, wide=1)]
    for stage in whole:
        if len(stage.parts) > 1:
            parts = [(step_name(p.added, 1), *_cells(p)) for p in stage.parts]
            title = f"Effects of the {stage.name}"
            shown.append(Table(columns, parts, words=1, title=title, folded=True))
    return shown


def _name(stage: Stage, place: int) -> str:
    if len(stage.parts) > 1:
        return stage.name
    return naming(step_name(stage.parts[0].added, place), stage.parts[0].confidence)


def _cells(step: Step) -> tuple[str, str, str]:
    return number(step.error), percent(step.confidence), ", ".join(step.confused_with) or "–"


def evidence(steps: Sequence[Step]) -> list[str]:
    """Why each effect was added; the baseline model needs no evidence."""
    return [
        sentence(f"{_name(stage, place)}: {text}")
        for place, stage in enumerate(stages(steps))
        if len(stage.parts) == 1
        for text in stage.parts[0].evidence
    ]


def page(result: Refinement) -> Page:
    """The report: the final model compared with the captures, and the step before it."""
    from dnanalyze.comparator.compare import compared, paper_model
    from dnanalyze.report.rivals import of_steps

    paper = paper_model(result.problem, result.steps[0].model, in_time=not result.timed_out)
    comparison = compared(result.captures, result.problem, result.model, paper)
    beside = of_steps(result.problem, result.steps, named_effects(result.steps))
    return page_so_far(result, comparison, beside)


def page_so_far(
    result: Refinement, comparison: Comparison | None = None, rivals: Rivals | None = None
) -> Page:
    """The report of a search that may go on; with a comparison of the model its panels follow."""
    steps, told = list(result.steps), result.classification
    by_hand = result.by_hand  # of `add`: the user named the effect
    rest, said = result.diagnosis, headline(result)
    rivals, models = rivals or Rivals(), {"model": result.model}
    if rivals.before is not None and rivals.after is not None:
        names = labels_of(rivals.effect)
        models = dict(zip(names, (rivals.before.model, rivals.after.model), strict=True))
    return page_of(
        result.captures,
        "Refinement",
        said if by_hand else refine_lead(result),
        [
            *sections(result),
            *([] if told is None else classification.sections(told)),
            *(diagnosis.sections(rest) if rest is not None else []),
            *([compare.overview(comparison), *compare.families(comparison)] if comparison else []),
        ],
        tone=diagnosis.TONES.get(result.verdict, "fair"),
        points=[*([] if by_hand else [said]), *evidence(steps)],
        figures=[
            (number(steps[0].error), "model error at the start"),
            (number(steps[-1].error), "model error at the end"),
            ("1", "a second sensor of the same design"),
        ],
        front=front(result, models, comparison, rivals, model_layers, told),
    )


def body(result: Refinement | ChannelRefinement) -> Document:
    """The error step by step and what the final model holds, of one channel or of several."""
    return {
        "steps": [_step(s) for s in result.steps],
        **fields_of(result, "effects", "verdict", "unexplained"),
        "parameters": [_parameter(p) for p in result.parameters],
        "model": None,
        "fitted": result.model.to_plain(),
    }


def document(result: Refinement) -> Document:
    """The error step by step and what the final model holds.

    A refinement that is not finished has verdict "missing", and no errors of its parameters.
    """
    told = result.classification
    found = made(
        "refine",
        result.captures.name,
        **body(result),
        headline=headline(result),
        direct=direct(result),
        **fields_of(result, "undetermined", "finished", "timed_out"),
        **level(result),
        **coverage(result),
        **({} if told is None else {"classifier": classification.body(told)}),
    )
    if not result.by_hand:
        return found
    first, last = found["steps"][0], found["steps"][-1]
    return found | {
        "schema": "dnanalyze/add/1",
        "supported": result.steps[-1].supported,
        "added": last["added"],
        "error_before": first["error"],
        "error_after": last["error"],
    }


def _parameter(parameter: Parameter) -> Document:
    """A number of a model with its standard error and the effect that it belongs to."""
    effect = parameter.name.split(".")[0].split("[")[0]
    return {"effect": effect} | fields_of(parameter, *PARAMETER)


def _step(step: Step) -> Document:
    """A step; what was taken out again stands under "removed"."""
    name, error = step.added, step.error
    gone = {"removed": name[1:]} if name and name.startswith("-") else {}
    return (
        {"added": None if gone else name, "error": error}
        | gone
        | fields_of(step, "confidence", "confused_with", "evidence")
    )


def table(result: Refinement | ChannelRefinement) -> pd.DataFrame:
    """The error step by step."""
    return pd.DataFrame(
        [
            {"step": n}
            | fields_of(s, "added", "error", "confidence")
            | {"confused_with": " ".join(s.confused_with)}
            for n, s in enumerate(result.steps)
        ]
    )


def plots(result: Refinement) -> Mapping[str, Draw]:
    """The steps, then each family of statistics."""
    own: dict[str, Draw] = {"steps": lambda: waterfall(result.steps)}
    return own | family_plots(lambda: simulated(result))
