"""Results in the terminal: the verdict first, then small tables that fit 80 columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from dnanalyze.report import capture, words
from dnanalyze.report.tables import laws, named, worst
from dnanalyze.report.words import number, point_label, with_error

BAR = 24
MOST_FAILURES, MOST_ROWS = 6, 8


def _verdict(console: Console, line: str, verdict: str, style: str = "bold") -> None:
    console.print(Text(line, style="dim"))
    console.print()
    console.print(Padding(Text(verdict, style=style), (0, 0, 0, 2)))
    console.print()


def _points(console: Console, title: str, sentences: Sequence[str]) -> None:
    """A heading and a numbered list; nothing where the list is empty."""
    if not sentences:
        return
    console.print(Text(title, style="bold"))
    grid = Table.grid(padding=(0, 1))
    grid.add_column(justify="right", style="dim", min_width=4)
    grid.add_column()
    for place, text in enumerate(sentences, 1):
        grid.add_row(f"{place}", Text(words.sentence(text)))
    console.print(grid)
    console.print()


def _table(
    console: Console, columns: Sequence[str], rows: Iterable[Sequence[Any]], left: int = 1
) -> None:
    """A table whose first ``left`` columns are words, the others numbers."""
    table = Table(
        box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1), show_edge=False, header_style="dim"
    )
    for place, name in enumerate(columns):
        table.add_column(Text(name), justify="left" if place < left else "right", overflow="fold")
    empty = True
    for row in rows:
        empty = False
        table.add_row(*(cell if isinstance(cell, Text) else Text(str(cell)) for cell in row))
    if not empty:
        console.print(Padding(table, (0, 0, 0, 2)))
        console.print()


def _bar(share: float, style: str = "blue") -> Text:
    """A bar of up to ``BAR`` cells; even a small share shows."""
    cells = max(0.0, min(1.0, share)) * BAR
    whole = int(cells)
    part = " ▏▎▍▌▋▊▉"[int((cells - whole) * 8)] if cells < BAR else ""
    return Text(("█" * whole + part).rstrip() or "▏", style=style)


def inspection(console: Console, captures: Any, seen: Mapping[str, Any]) -> None:
    """Operating points, format, and what is missing."""
    console.print(Text(capture.one_line(captures), style="bold"))
    console.print()
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim", min_width=18)
    grid.add_column()
    for key, text in (capture.facts(captures) | capture.codes(seen["codes"])).items():
        grid.add_row(key, Text(text))
    console.print(Padding(grid, (0, 0, 0, 2)))
    console.print()
    _table(
        console,
        ("operating point", "temperature spans", "frames"),
        (
            (point_label(p), _span(p["temperature_span_c"]), p["frames"])
            for p in seen["operating_points"]
        ),
        left=2,
    )
    if seen["missing"]:
        _points(console, "For a full analysis this is missing", seen["missing"])
    else:
        console.print("Nothing is missing for a full analysis.")


def _span(span: Sequence[float] | None) -> str:
    """Width of the temperatures in one operating point."""
    return f"{span[1] - span[0]:.2g} °C" if span and span[1] > span[0] else "–"


def statistics(console: Console, captures: Any, measured: Any, quantities: Any) -> None:
    """The EMVA 1288 quantities, the laws over temperature, what is not determined."""
    from dnanalyze.analyzers.trends import law_doubts
    from dnanalyze.report.emva import LAWS
    from dnanalyze.report.pages.analyze import headline
    from dnanalyze_cli.show_emva import emva_tables, undetermined

    _verdict(console, capture.one_line(captures), headline(measured, quantities))
    emva_tables(console, quantities, _table)
    columns, found = laws(measured, LAWS)
    _table(
        console,
        ("over temperature", *columns),
        (
            (title, *(with_error(v.value, v.se, unit) if v else "–" for v in values))
            for title, values, unit in found
        ),
    )
    _points(console, "Warnings", law_doubts(measured))
    reasons = sorted({reason for s in measured.settings for reason in s.missing.values()})
    not_determined = undetermined(quantities, reasons, 2 * MOST_FAILURES)
    _points(console, "Not determined from these captures", not_determined)


def fit(console: Console, captures: Any, result: Any) -> None:
    """Parameters with uncertainties, and the pairs that cannot be told apart."""
    from dnanalyze.report.pages.fit import headline

    _verdict(console, capture.one_line(captures), headline(result))
    _table(
        console,
        ("parameter", "value", "unit"),
        ((p.name, with_error(p.value, p.se), p.unit) for p in result.parameters),
    )
    _points(console, "What the data cannot tell apart", list(result.undetermined))


def comparison(console: Console, captures: Any, result: Any) -> None:
    """The error, where the model fails, family by family, and the worst statistics."""
    headline = words.compare_headline(result.error, result.baselines)
    headline = words.with_remarks(headline, result)
    _verdict(console, capture.one_line(captures), headline)
    _points(console, "Where it fails, worst first", result.failures[:MOST_FAILURES])
    _families(console, result.families)
    rows = worst(result.statistics, most=MOST_ROWS)
    parts = words.varied(result.statistics)
    _table(
        console,
        ("statistic", "where", "measured", "model", "gap", "floors"),
        (
            (
                r["name"],
                point_label(r, parts),
                number(r["measured"]),
                number(r["simulated"]),
                words.gap(r["measured"], r["simulated"], r.get("unit", ""), r.get("scale", "")),
                number(r["discrepancy"], 2),
            )
            for r in rows
        ),
        left=2,
    )


def _families(console: Console, families: Mapping[str, float]) -> None:
    known = {k: v for k, v in families.items() if words.is_number(v)}
    if not known:
        return
    top = max([*known.values(), 1.0])
    ranked = sorted(known.items(), key=lambda item: -item[1])
    _table(
        console,
        ("family", "", "error"),
        ((words.family_title(k), _bar(v / top), number(v)) for k, v in ranked),
        left=2,
    )


def diagnosis(console: Console, captures: Any, result: Any) -> None:
    """The verdict, the candidates with their evidence, the limits, the next capture."""
    _verdict(console, capture.one_line(captures), words.diagnose_headline(result))
    candidates, every = words.candidates_of(result)
    _candidates(console, "candidate", candidates)
    _candidates(console, "what every sensor has", every)
    if best := words.leading(result):
        title = f"Evidence for {words.naming(best.effect, best.confidence)}"
        _points(console, title, list(best.evidence))
    _unexplained(console, result.unexplained)
    _points(
        console, "What would not have been seen", words.texts(result.detection_limits)[:MOST_ROWS]
    )
    if result.next_capture:
        _points(console, "The next capture", words.texts(result.next_capture))


def _unexplained(console: Console, names: Sequence[str]) -> None:
    """Statistics that stay unexplained, worst first, and how many are not shown."""
    shown = [named(n) for n in names[:MOST_FAILURES]]
    more = len(names) - len(shown)
    title = "What stays unexplained" + (f", {more} more in --json" if more > 0 else "")
    _points(console, title, shown)


def _candidates(console: Console, title: str, found: Sequence[Any]) -> None:
    """Effects with the error after each, best first; rivals where there are any."""
    rivals = any(c.confused_with for c in found)
    _table(
        console,
        (title, "error after", "explains", "confidence", *(("confused with",) if rivals else ())),
        (
            (
                words.naming(c.effect, c.confidence),
                number(c.error_after),
                words.percent(c.explained),
                words.percent(c.confidence),
                *((", ".join(c.confused_with) or "–",) if rivals else ()),
            )
            for c in found[:MOST_ROWS]
        ),
    )


def refinement(
    console: Console, captures: Any, result: Any, output: Path | None, by_hand: bool = False
) -> None:
    """The error step by step, why, the final model's numbers, and what stays unexplained.

    ``by_hand``: of `add`, where the user named the effect.
    """
    headline = words.add_headline(result) if by_hand else words.refine_headline(result)
    _verdict(console, capture.one_line(captures), headline)
    steps = list(result.steps)
    top = max([s.error for s in steps if words.is_number(s.error)] + [1.0])
    sure = any(words.is_number(s.confidence) for s in steps)
    _table(
        console,
        ("step", "", "error", *(("confidence",) if sure else ())),
        (
            (
                words.naming(words.step_name(step.added, place), step.confidence),
                _bar(step.error / top if words.is_number(step.error) else 0),
                number(step.error),
                *((words.percent(step.confidence),) if sure else ()),
            )
            for place, step in enumerate(steps)
        ),
        left=2,
    )
    kept = words.net_additions([s.added for s in steps])
    why = {s.added: s for s in steps if s.added in kept and words.is_number(s.confidence)}
    _points(console, "Why" if by_hand else "Why each was added", [_reason(s) for s in why.values()])
    _table(
        console,
        ("the final model", "value", "unit"),
        ((p.name, with_error(p.value, p.se), p.unit) for p in result.parameters),
    )
    _unexplained(console, result.unexplained)
    console.print(f"The model holds {words.listing(result.effects)}.")
    if output is None:
        console.print("It was not kept; name a file with -o to keep it.", style="dim")


def _reason(step: Any) -> str:
    """The most telling evidence of a step, with what the effect may be instead."""
    name = words.with_rivals(step.added, step.confidence, step.confused_with)
    return f"{name}: {step.evidence[0]}"


def detection(console: Console, captures: Any, result: Any) -> None:
    """The verdict and the tests behind it."""
    from dnanalyze.report.pages.detect import headline

    _verdict(console, capture.one_line(captures), headline(result))
    _points(console, "Evidence", words.texts(list(result.evidence)))
    _points(console, "What cannot be told apart here", words.texts(list(result.ambiguous)))
    flagged = sorted(
        result.findings, key=lambda f: (not f.flagged, f.p_value if f.p_value is not None else 2)
    )
    _table(
        console,
        ("test", "points to", "at", "p", "effect", "flagged"),
        (
            (
                f.test,
                f.kind,
                f"{f.temperature_c:g} °C" if words.is_number(f.temperature_c) else "all",
                words.probability(f.p_value),
                number(f.effect_size, 2),
                _flag(f),
            )
            for f in flagged[: 2 * MOST_ROWS]
        ),
        left=2,
    )


def _flag(finding: Any) -> str:
    """Yes, or no; with the reason where the p-value alone would say yes."""
    from dnanalyze.detection.reasons import NOT_SIGNIFICANT

    if finding.flagged:
        return "yes"
    return "no" if finding.reason == NOT_SIGNIFICANT else f"no: {finding.reason}"


def catalogue(console: Console, known: Mapping[str, Any]) -> None:
    """All effects along the signal chain."""
    table = Table(box=None, pad_edge=False, padding=(0, 1), show_header=False)
    table.add_column(no_wrap=True)
    table.add_column(no_wrap=True, style="dim")
    table.add_column()
    stage = None
    for kind in sorted(known.values(), key=lambda e: (e.stage, e.name)):
        if kind.stage is not stage:
            if stage is not None:
                table.add_row()
            stage = kind.stage
            table.add_row(Text(stage.name.lower().replace("_", " "), style="dim"))
        table.add_row(Text(kind.name, style="bold"), kind.varies, Text(kind.summary))
    console.print(table)
    console.print()
    console.print("`dnanalyze effects NAME` tells the physics of one.", style="dim")


def effect(console: Console, kind: Any) -> None:
    """One effect in full."""
    stage = kind.stage.name.lower().replace("_", " ")
    console.print(
        Text(kind.name, style="bold"), Text(f" {stage}, {kind.varies}", style="dim"), sep=""
    )
    for text in (kind.summary, " ".join(kind.physics.split())):
        if text:
            console.print()
            console.print(Padding(Text(text), (0, 0, 0, 2)))
    if kind.formula:
        console.print()
        console.print(Padding(Text(kind.formula, style="italic"), (0, 0, 0, 4)))
    console.print()
    rows = (
        (
            name,
            p.unit or "–",
            " | ".join(map(str, p.choices)) or "numbers, or none"
            if p.scale == "choice"
            else f"{p.lower:g} to {p.upper:g}",
            p.doc,
        )
        for name, p in kind.parameters().items()
    )
    _table(console, ("parameter", "unit", "range", "meaning"), rows, left=4)
    if kind.fingerprint:
        console.print(Padding(Text(f"Moves most: {', '.join(kind.fingerprint)}"), (0, 0, 1, 2)))
    _points(console, "Confused with", [f"{k}: {v}" for k, v in kind.confused_with.items()])
    _points(console, "References", list(kind.references))


def written(console: Console, made: Any, out: Path, form: str) -> None:
    """What was simulated and where it lies."""
    rows, columns = made.sensor.shape
    console.print(
        f"{words.plural(made.frame_count, 'frame')} of {rows} × {columns} at "
        f"{words.plural(len(made.settings), 'operating point')} as {form} in {out}"
    )
