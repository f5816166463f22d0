"""The outcome of a check: verdict, sections, page, document, JUnit XML and Markdown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import pandas as pd

from dnanalyze.checking.check import Check, CheckResult
from dnanalyze.checking.targets import Targets
from dnanalyze.digits import minus, resolving
from dnanalyze.report.documents import Document, fields_of, point
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.figures.targets import targets as picture
from dnanalyze.report.page import Page, Section, Table, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.words import family_title, number, plural, symbol, unit_text

MOST_ROWS = 20


def limit(check: Check) -> str:
    """``1.9 to 2.1 DN``, ``at most 1.3``."""
    unit = unit_text(check.unit)
    low, high = math.isfinite(check.lower), math.isfinite(check.upper)
    if low and high:
        digits = resolving(check.lower, check.upper)
        return f"{number(check.lower, digits)} to {number(check.upper, digits)}{unit}"
    if low or high:
        side, edge = ("least", check.lower) if low else ("most", check.upper)
        return f"at {side} {number(edge)}{unit}"
    return "any value"


def value(check: Check) -> str:
    """The value of the simulation to the digits of its limits."""
    return number(check.value, resolving(check.lower, check.upper))


def excess(check: Check) -> str:
    """By how much a value is outside: ``+0.31 DN (+12 %, 5.2 sigma)``."""
    if math.isnan(check.value):
        return f"no value: {check.reason}"
    edge = check.upper if check.beyond > 0 else check.lower
    unit = unit_text(check.unit)
    sign = "+" if check.beyond > 0 else minus("-")
    more = []
    if edge and math.isfinite(edge):
        more.append(f"{sign}{number(100 * abs(check.beyond / edge), 2)} %")
    if check.floors_beyond is not None:
        more.append(f"{number(abs(check.floors_beyond), 2)} sigma")
    tail = f" ({', '.join(more)})" if more else ""
    return f"{sign}{number(abs(check.beyond), 3)}{unit} beyond its limit{tail}"


def look(check: Check) -> str:
    """Which figure shows it."""
    if check.family == "model":
        return "the model file"
    if check.family == "error":
        return "'Differences between sensor and model'"
    return f"'{family_title(check.family)}'"


def headline(result: CheckResult) -> str:
    """Passed or failed, in one sentence."""
    total = plural(len(result.checks), "target")
    known = len(result.known_misses)
    tail = f"; {known} known to be violated and not enforced" if known else ""
    if result.passed:
        return f"Passed: {total} met{tail}."
    return f"Failed: {len(result.failures)} of {total} violated{tail}."


def junit(result: CheckResult) -> str:
    """JUnit XML: one test case a target, its suite the captures."""
    counts = {
        "tests": str(len(result.checks)),
        "failures": str(len(result.failures)),
        "errors": "0",
        "skipped": str(len(result.known_misses)),
    }
    root = Element("testsuites", {"name": "dnanalyze check", **counts})
    suite = SubElement(root, "testsuite", {"name": _clean(result.captures.name), **counts})
    for check in result.checks:
        group = f"dnanalyze.{check.kind}.{check.family}"
        case = SubElement(suite, "testcase", {"classname": group, "name": _clean(check.name)})
        if check.passed:
            continue
        text = _clean(f"{_off(check)}; limit {limit(check)}; see {look(check)}")
        if check.enforced:
            SubElement(case, "failure", message=text).text = text
        else:
            SubElement(case, "skipped", message=f"known violation, not enforced: {text}")
    indent(root, "")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{tostring(root, "unicode")}\n'


def _off(check: Check) -> str:
    """The value and by how much it is outside."""
    has_value = not math.isnan(check.value)
    return f"{value(check)} is {excess(check)}" if has_value else excess(check)


def _clean(text: str) -> str:
    """Without the control characters that XML 1.0 forbids."""
    return "".join(c for c in text if c >= " " or c in "\t\n")


def markdown(result: CheckResult, targets: str, model: str | None = None) -> str:
    """A summary for a pull request or a job's page."""
    lines = [f"### {'✅' if result.passed else '❌'} Dark noise: {headline(result)}", ""]
    rows = result.failures[:MOST_ROWS]
    lines += _table("violated target", rows)
    if len(result.failures) > MOST_ROWS:
        lines += [f"and {len(result.failures) - MOST_ROWS} more.", ""]
    if result.known_misses:
        lines += ["<details><summary>Known violations, not enforced</summary>", ""]
        lines += [*_table("target", result.known_misses[:MOST_ROWS]), "</details>", ""]
    if rows:
        own = f" --model {model}" if model else ""
        command = f"dnanalyze compare {result.captures.name}{own} --report compare.html"
        lines += [f"To see the figures: `{command.replace('`', '')}`", ""]
    rate = result.false_failures
    if rate:
        lines += [
            "A correct simulation with a new seed fails these targets "
            f"about once in {1 / rate:,.0f} runs.",
            "",
        ]
    lines.append(
        f"Checked: {_cell(model or result.simulation)} with the targets of {_cell(targets)}."
    )
    return "\n".join(lines) + "\n"


def _table(title: str, rows: Sequence[Check]) -> list[str]:
    if not rows:
        return []
    lines = [
        f"| {title} | limit | simulated | measured | deviation | figure |",
        "|---|---|---|---|---|---|",
    ]
    for c in rows:
        digits = resolving(c.lower, c.upper)
        cells = (c.name, limit(c), value(c), number(c.measured, digits), excess(c), look(c))
        lines.append("| " + " | ".join(map(_cell, cells)) + " |")
    return [*lines, ""]


def _cell(text: str) -> str:
    return " ".join(str(text).split()).replace("|", "\\|").replace("<", "&lt;")


def sections(result: CheckResult) -> list[Section]:
    """Each violated target with its size and its figure, then those that are met."""
    said = [
        f"{c.name}: {'' if math.isnan(c.value) else f'{value(c)}, '}{excess(c)}; "
        f"limit {limit(c)}; see {look(c)}."
        for c in result.failures
    ]
    met = [(c.name, limit(c), value(c), symbol(c.unit)) for c in result.checks if c.passed]
    columns = ("target", "limit", "simulated", "unit")
    more = "`dnanalyze compare CAPTURES --model M.yaml --report R.html` shows them."
    return [
        Section("failures", "Violated targets", points=said, most=12, paged=False),
        Section("look", "", text=[more] if said else [], paged=False),
        Section(
            "violated", "Violated targets", pictures=[lambda: picture(result.checks)],
            tables=[_rows(result.failures)], printed=False,
        ),
        Section(
            "known", "Known violations, not enforced",
            tables=[_rows(result.known_misses)], printed=False,
        ),
        Section(
            "met", "Targets that are met",
            tables=[Table(columns, met, words=2, title=plural(len(met), "target"), folded=True)],
        ),
    ]  # fmt: skip


def _rows(checks: Sequence[Check]) -> Table:
    cells = [
        (c.name, limit(c), value(c), number(c.measured, resolving(c.lower, c.upper)), excess(c))
        for c in checks
    ]
    return Table(("target", "limit", "simulated", "measured", "deviation"), cells, words=2)


def proposed(made: Targets) -> tuple[str, list[Section]]:
    """What a new targets file contains: the verdict and its sections."""
    assert made.false_failures is not None
    missed = [t for t in made.targets if not t.enforced]
    runs = f"{1 / made.false_failures:,.0f} runs"
    names = ", ".join(dict.fromkeys(str(t.statistic) for t in missed))
    text = f"Not enforced, since the model violates them now ({len(missed)}): {names}"
    return (
        f"{plural(len(made.targets), 'target')}; a correct simulation fails once in {runs}",
        [Section("missed", "", text=[text] if missed else [])],
    )


def page(result: CheckResult) -> Page:
    """The report."""
    tone = "good" if result.passed else "poor"
    return page_of(result.captures, "Check", headline(result), sections(result), tone=tone)


KEYS = "name", "kind", "plane", "value", "measured", "unit", "passed", "enforced"


def document(result: CheckResult) -> Document:
    """The JSON document."""
    checks = [
        point(c.point)
        | {k: getattr(c, k) for k in (*KEYS, "subject", "family")}
        | {
            "limit": limit(c),
            "min": c.lower,
            "max": c.upper,
            "off_by": None if c.passed else c.beyond,
            "off_by_floors": c.floors_beyond,
            "reason": "" if c.passed else c.reason,
            "figure": look(c),
        }
        for c in result.checks
    ]
    return made(
        "check",
        result.captures.name,
        **fields_of(result, "passed", "simulation", "false_failures"),
        targets=None,
        model=None,
        checks=checks,
    )


def table(result: CheckResult) -> pd.DataFrame:
    """The targets with their limits and values."""
    return pd.DataFrame(
        [
            point(c.point)
            | {"name": c.name, "kind": c.kind, "plane": c.plane, "min": c.lower, "max": c.upper}
            | {k: getattr(c, k) for k in KEYS[3:]}
            for c in result.checks
        ]
    )


def plots(result: CheckResult) -> Mapping[str, Draw]:
    """The targets."""
    return {"targets": lambda: picture(result.checks)}
