"""The outcome of `refine` and of `add` in the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from dnanalyze.report import words
from dnanalyze.report.stages import stages
from dnanalyze.report.terminal.classifier import classifier_line
from dnanalyze.report.terminal.common import MOST_FAILURES, bar, points, table, verdict
from dnanalyze.report.terminal.diagnosis import unexplained
from dnanalyze.report.terminal.fit import directly, parameters
from dnanalyze.report.words import number


def refinement(console: Console, captures: Any, result: Any, by_hand: bool | None = None) -> None:
    """The model error step by step, the evidence, the final model, and what is not explained.

    ``by_hand``: of `add`, where the user named the effect; by default as the result says.
    """
    by_hand = getattr(result, "by_hand", False) if by_hand is None else by_hand
    headline = words.add_headline(result) if by_hand else words.refine_headline(result)
    verdict(console, captures, headline)
    steps = list(result.steps)
    top = max([s.error for s in steps if words.is_number(s.error)] + [1.0])
    sure = any(words.is_number(s.confidence) for s in steps)
    table(
        console,
        ("step", "", "model error", *(("confidence",) if sure else ())),
        (
            (
                words.naming(stage.name, stage.parts[-1].confidence),
                bar(stage.error / top if words.is_number(stage.error) else 0),
                number(stage.error),
                *((words.percent(stage.parts[-1].confidence),) if sure else ()),
            )
            for stage in stages(steps)
        ),
        left=2,
    )
    kept = words.net_additions([s.added for s in steps])
    why = {s.added: s for s in steps if s.added in kept and words.is_number(s.confidence)}
    title = "Evidence" if by_hand else "Evidence for each effect added"
    points(console, title, [_reason(s) for s in why.values()])
    parameters(console, "final model", result)
    directly(console, result)
    undetermined = list(getattr(result, "undetermined", []))
    points(console, "Not determined from these captures", undetermined, MOST_FAILURES)
    unexplained(console, result.unexplained)
    if getattr(result, "classification", None) is not None:
        classifier_line(console, result.classification)
    console.print(f"Effects in the model: {words.listing(result.effects)}.")


def not_kept(console: Console) -> None:
    """The model was shown and is in no file."""
    console.print("The model was not written; -o FILE writes it.", style="dim")


def continued(console: Console, line: str) -> None:
    """The time limit ended the search: the command that goes on."""
    console.print(f"To continue the search: {line}", style="dim", soft_wrap=True)


def _reason(step: Any) -> str:
    """The most telling evidence of a step, with what the effect is confounded with."""
    name = words.with_rivals(step.added, step.confidence, step.confused_with)
    return f"{name}: {step.evidence[0]}"
