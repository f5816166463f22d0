"""HDR channels side by side: a refinement over all of them, and their diagnoses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import pandas as pd

from dnanalyze.channels.refinement import ChannelRefinement
from dnanalyze.diagnosis.results import Diagnosis, Refinement
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.report.documents import Document, fields_of
from dnanalyze.report.figures.families import family_plots, simulated
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.figures.waterfall import waterfall, waterfalls
from dnanalyze.report.page import Page, Section, Table, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.results import comparison as compare
from dnanalyze.report.results import diagnosis, refinement
from dnanalyze.report.sections.model import model_section
from dnanalyze.report.words import (
    error_way,
    is_number,
    leading,
    listing,
    naming,
    number,
    percent,
    refine_headline,
    sentence,
)

table = refinement.table


def headline(result: ChannelRefinement) -> str:
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
    return sentence(f"{text}{shown}, with one model of all channels")


def sections(result: ChannelRefinement) -> list[Section]:
    """The effects of each channel, its model error, and that of the one model of all channels."""
    rows = [
        (
            name,
            part.verdict,
            listing(_names(part, result.own[name])) or "–",
            number(part.steps[0].error),
            number(part.steps[-1].error),
        )
        for name, part in result.channels.items()
    ]
    columns = ("channel", "verdict", "own effects", "initial error", "final error")
    note = f"One model of all channels: model error {number(result.error)}."
    findings = [sentence(f) for f in result.findings]
    return [
        Section("findings", "Effects by channel", points=findings, paged=False),
        Section(
            "belongs", "Effects by channel", tables=[Table(columns, rows, words=3, note=note)]
        ),
    ]  # fmt: skip


def _names(part: Refinement, effects: Iterable[str]) -> list[str]:
    """Effects of one channel, those that are not sure as such."""
    sure = {step.added: step.confidence for step in part.steps}
    return [naming(effect, sure.get(effect)) for effect in effects]


def page(result: ChannelRefinement) -> Page:
    """The report: which effect belongs where, each channel's steps, the one model compared."""
    from dnanalyze.comparator.compare import compare_on

    comparison = compare_on(result.captures, result.model, problem=result.problem)
    return page_of(
        result.captures,
        "Refinement over channels",
        headline(result),
        [
            *sections(result),
            *(
                Section(
                    f"channel-{name}",
                    f"Channel {name}",
                    text=[refine_headline(part)],
                    pictures=[waterfall(part.steps)],
                    tables=refinement.step_tables(part.steps),
                )
                for name, part in result.channels.items()
            ),
            compare.overview(comparison),
            model_section(result.model),
            *compare.families(comparison),
        ],
        tone=diagnosis.TONES.get(result.verdict, "fair"),
        points=[sentence(f) for f in result.findings],
        figures=[
            (number(result.steps[0].error), "model error at the start"),
            (number(result.error), "error of one model of all channels"),
            (str(len(result.channels)), "channels"),
        ],
    )


def document(result: ChannelRefinement) -> Document:
    """As of one channel, with what each channel needed."""
    found = refinement.body(result)
    for step, own in zip(found["steps"], result.steps, strict=True):
        if own.channel is not None:
            step["channel"] = own.channel
    searches = result.channels.values()
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
    return made(
        "refine",
        result.captures.name,
        **found,
        headline=headline(result),
        error=result.error,
        undetermined=[],
        direct=[],
        level=None,
        coverage=None,
        finished=all(part.finished for part in searches),
        timed_out=any(part.timed_out for part in searches),
        **fields_of(result, "findings", "shared", "own"),
        channels=parts,
    )


def plots(result: ChannelRefinement) -> Mapping[str, Draw]:
    """The steps together and by channel, then each family of statistics."""
    own: dict[str, Draw] = {
        "steps": lambda: waterfall(result.steps),
        "channels": lambda: waterfalls({c: part.steps for c, part in result.channels.items()}),
    }
    return own | family_plots(lambda: simulated(result))


def diagnoses_headline(found: Mapping[str, Diagnosis], verdict: str) -> str:
    """The verdict over all channels."""
    return sentence(f"{len(found)} channels, each diagnosed separately: {verdict}")


def diagnoses_sections(found: Mapping[str, Diagnosis]) -> list[Section]:
    """Each channel's verdict and best candidate, with the evidence for it."""
    best = {name: leading(d) for name, d in found.items()}
    rows = [
        (
            name,
            d.verdict,
            naming(c.effect, c.confidence) if (c := best[name]) else "–",
            number(d.error),
            number(c.error_after) if c else "–",
            percent(c.confidence) if c else "–",
        )
        for name, d in found.items()
    ]
    said = [
        f"{name}: {sentence(text)}"
        for name, d in found.items()
        if d.verdict == "missing" and (c := best[name])
        for text in c.evidence[:2]
    ]
    columns = ("channel", "verdict", "candidate", "model error", "error after", "confidence")
    return [
        Section("channels", "Channels", tables=[Table(columns, rows, words=3)]),
        Section("evidence", "Evidence", points=said, paged=False),
    ]


def diagnoses_page(captures: CaptureSet, found: Mapping[str, Diagnosis], verdict: str) -> Page:
    """The report: every channel's diagnosis, one after another."""
    return page_of(
        captures,
        "Diagnosis over channels",
        diagnoses_headline(found, verdict),
        [
            *diagnoses_sections(found),
            *(
                replace(s, key=f"{name}-{s.key}", title=f"{name}: {s.title}")
                for name, d in found.items()
                for s in diagnosis.sections(d)
            ),
        ],
        tone=diagnosis.TONES.get(verdict, "fair"),
        points=[f"{name}: {diagnosis.headline(d)}" for name, d in found.items()],
    )


def diagnoses_document(where: str, found: Mapping[str, Diagnosis], verdict: str) -> Document:
    """Every channel's diagnosis, and all their candidates in one list, most telling first."""
    parts = {name: diagnosis.document(d) for name, d in found.items()}
    candidates = [c | {"channel": name} for name, part in parts.items() for c in part["candidates"]]
    candidates.sort(key=lambda c: -(c["confidence"] or 0.0) * (c["explained"] or 0.0))
    errors = [d.error for d in found.values()]
    keys = ("error", "verdict", "candidates", "unexplained", "detection_limits", "next_capture")
    return made(
        "diagnose",
        where,
        error=(sum(e * e for e in errors) / len(errors)) ** 0.5,
        verdict=verdict,
        candidates=candidates,
        unexplained=list(dict.fromkeys(n for p in parts.values() for n in p["unexplained"])),
        channels={name: {k: part[k] for k in keys} for name, part in parts.items()},
    )


def diagnoses_table(found: Mapping[str, Diagnosis]) -> pd.DataFrame:
    """The candidates of every channel."""
    parts = [diagnosis.table(d).assign(channel=name) for name, d in found.items()]
    return pd.concat(parts, ignore_index=True)
