"""HDR channels side by side: what `refine`, `add` and `diagnose` say over all of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from dnanalyze.report import documents
from dnanalyze.report.plain import document
from dnanalyze.report.words import error_way, is_number, listing, naming, number, sentence

Document = dict[str, Any]
COLUMNS = ("channel", "verdict", "own effects", "initial error", "final error")


def refinement(where: str, command: str, result: Any, output: Path | None) -> Document:
    """As of one channel, with what each channel needed."""
    made = documents.refinement(where, result, output, sentence(headline(result)))
    made |= {"schema": f"dnanalyze/{command}/1", "error": result.error}
    for plain, step in zip(made["steps"], result.steps, strict=True):
        if step.channel is not None:
            plain["channel"] = step.channel
    parts = {
        name: {
            "effects": part.effects,
            "error": part.steps[-1].error,
            "verdict": part.verdict,
            "unexplained": part.unexplained,
            "model": part.model.to_plain(),
        }
        for name, part in result.channels.items()
    }
    more = document(
        command,
        where,
        findings=result.findings,
        shared=result.shared,
        own=result.own,
        channels=parts,
    )
    return made | {k: more[k] for k in ("findings", "shared", "own", "channels")}


def diagnosis(where: str, found: Mapping[str, Any], verdict: str) -> Document:
    """Every channel's diagnosis, and all their candidates in one list, most telling first."""
    parts = {name: documents.diagnosis(where, d) for name, d in found.items()}
    candidates = [c | {"channel": name} for name, part in parts.items() for c in part["candidates"]]
    candidates.sort(key=lambda c: -(c["confidence"] or 0.0) * (c["explained"] or 0.0))
    errors = [d.error for d in found.values()]
    keys = ("error", "verdict", "candidates", "unexplained", "detection_limits", "next_capture")
    return document(
        "diagnose",
        where,
        error=(sum(e * e for e in errors) / len(errors)) ** 0.5,
        verdict=verdict,
        candidates=candidates,
        unexplained=list(dict.fromkeys(n for p in parts.values() for n in p["unexplained"])),
        channels={name: {k: part[k] for k in keys} for name, part in parts.items()},
    )


def rows(result: Any) -> list[tuple[str, ...]]:
    """A row a channel, in the order of `COLUMNS`."""
    return [
        (
            name,
            part.verdict,
            listing(_names(part, result.own[name])) or "–",
            number(part.steps[0].error),
            number(part.steps[-1].error),
        )
        for name, part in result.channels.items()
    ]


def _names(part: Any, effects: Iterable[str]) -> list[str]:
    """Effects of one channel, those that are not sure as such."""
    sure = {step.added: step.confidence for step in part.steps}
    return [naming(effect, sure.get(effect)) for effect in effects]


def headline(result: Any) -> str:
    """The verdict in one sentence."""
    own = {c: names for c, names in result.own.items() if names}
    places = [f"{listing(_names(result.channels[c], names))} in {c}" for c, names in own.items()]
    found = [*result.shared, *places]
    text = (
        f"Identified: {listing(found)}"
        if found
        else "No channel needs more than the baseline effects"
    )
    first, last = result.steps[0].error, result.error
    shown = f"; {error_way(first, last)}" if is_number(last) else ""
    return f"{text}{shown}, with one model of all channels"
