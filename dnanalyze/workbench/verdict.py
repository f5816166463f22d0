"""What is wrong with the model, in words, and what to do next."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Literal

from dnanalyze.comparator.words import failures
from dnanalyze.report.leads import worded
from dnanalyze.report.words import SURE, closeness, number, percent, sentence, statistics_named
from dnanalyze.workbench.fit_errors import two_yardsticks
from dnanalyze.workbench.session import WorkbenchSession

Tone = Literal["wait", "bad", "open", "good"]
Action = Literal["", "diagnose", "add", "complete"]


@dataclass(frozen=True)
class Verdict:
    """The state of the work in a few sentences, with the next step.

    Parameters
    ----------
    text : str
        Plain text; names of effects stand as ``{effect}`` for the page to print.
    tone : {"wait", "bad", "open", "good"}
    action : {"", "diagnose", "add", "complete"}
        What the button does; none for "".
    effect : str
        For "add".
    before, after : float, optional
        Model errors that the action leads from and to, where they are known.
    """

    text: str
    tone: Tone
    action: Action = ""
    effect: str = ""
    before: float | None = None
    after: float | None = None


def verdict(session: WorkbenchSession) -> Verdict:
    """The verdict on the present model of a session."""
    if session.problem is None:
        return Verdict(sentence(session.stage), "wait")
    history, evaluation = session.history, session.evaluation
    if history is None or evaluation is None:
        return Verdict(sentence(session.stage), "wait")
    if history.present.error is None:
        step = worded(history.present.title)
        return Verdict(f"Computing the model error of the step “{step}”.", "wait")
    node = history.present
    found = session.diagnosis
    if found is not None and found["node"] == node.number:
        if not found["finished"]:
            return _unfinished(found | {"error": node.error}, session.worker.runs("diagnose"))
        return _diagnosed(found | {"error": node.error})  # a search states that of its own start
    if (answer := session.answers.get(node.number)) is not None:
        return _answered(answer)
    worst = failures(evaluation.rows, most=1)
    said = sentence(worst[0]) if worst else sentence(closeness(node.error))
    if node.parent is not None:
        said = f"{said} {two_yardsticks(node, history.node(node.parent))}".strip()
    return Verdict(said, "bad" if worst else "open", "diagnose")


def _unfinished(found: dict[str, Any], goes_on: bool) -> Verdict:
    """What a diagnosis has found so far, or had when it was ended."""
    best = next((c for c in found["candidates"] if c["effect"] not in found["ordinary"]), None)
    if best is None:
        return Verdict("No candidate is confirmed yet.", "open")
    rest = "are still being tested" if goes_on else "were not tested"
    return Verdict(
        f"Best so far: {{{best['effect']}}}, with it the model error is "
        f"{number(best['error_after'])}. Other candidates {rest}.",
        "open", "add", best["effect"], found["error"], best["error_after"],
    )  # fmt: skip


def _diagnosed(found: dict[str, Any]) -> Verdict:
    """The verdict of a diagnosis."""
    candidates, ordinary = found["candidates"], found["ordinary"]
    others = [c for c in candidates if c["effect"] not in ordinary]
    if found["verdict"] == "adequate":
        return Verdict(_adequate(found.get("classifier", "")), "good")
    if found["verdict"] == "missing" and candidates:
        return _missing(found, others, ordinary)
    left = statistics_named(found["unexplained"])
    text = f"Unexplained: no effect of the catalogue accounts for {left or 'the residual'}."
    if others:
        best = others[0]
        text += (
            f" The closest is {{{best['effect']}}} ({percent(best['confidence'])}); "
            "these captures do not support it."
        )
        return Verdict(text, "bad", "add", best["effect"], found["error"], best["error_after"])
    return Verdict(text, "bad")


def _missing(found: dict[str, Any], others: list[dict[str, Any]], ordinary: list[str]) -> Verdict:
    first = found["candidates"][0]
    if first["effect"] in ordinary:
        named = [c for c in found["candidates"] if c["effect"] in ordinary]
        names = ", ".join(f"{{{c['effect']}}}" for c in named)
        return Verdict(
            f"Missing: what every sensor has ({names}); no other missing effect is detectable.",
            "bad", "complete", "", found["error"], named[-1]["error_after"],
        )  # fmt: skip
    best = others[0]
    text = sentence(best["evidence"][0].split("; with ")[0]) if best["evidence"] else ""
    unsure = "possibly " if best["confidence"] < SURE else ""
    text += f" Missing: {unsure}{{{best['effect']}}} ({percent(best['confidence'])})"
    if unsure and best["confused_with"]:
        text += ", or " + " or ".join(f"{{{n}}}" for n in best["confused_with"])
    text += "."
    if ordinary:
        text += " The effects that every sensor has are added with it."
    return Verdict(text.strip(), "bad", "add", best["effect"], found["error"], best["error_after"])


def _answered(answer: dict[str, Any]) -> Verdict:
    """What the command says of a step."""
    adequate = answer["verdict"] == "adequate" and not answer.get("tells")
    text, effect = answer["headline"], answer.get("effect", "")
    if effect:
        text = re.sub(rf"\b{effect}\b", f"{{{effect}}}", text)
    if classifier := answer.get("classifier"):
        text += f" {classifier}"
    return Verdict(text, "good" if adequate else "bad", "" if adequate else "diagnose")


def _adequate(classifier: str) -> str:
    said = "Adequate: no missing effect is detectable in these captures."
    return f"{said} {classifier}" if classifier else said
