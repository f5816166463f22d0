"""Scores of the hidden-effect benchmark, as Markdown tables.

A row is what `hidden_effects.run_case` gives: key, effect (the true one), level, and either failed
(why) or named (what is in the final model besides an ordinary sensor), first (the first of these
that was added), verdict, additions [(effect, confidence)], error_before, error_after, seconds.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from statistics import median
from typing import Any

import numpy as np

from dnanalyze.demo import CATALOGUED, EFFECTS, LEVELS, OUTSIDE

ORDINARY = "ordinary"
TOGETHER = "+"  # between the names of effects that are hidden together


def hidden_in(row: dict[str, Any]) -> set[str]:
    """Names of what is hidden."""
    return set(row["effect"].split(TOGETHER)) - {ORDINARY}


def right(row: dict[str, Any]) -> bool:
    """Ordinary: nothing added. Outside: unexplained. Else: the right name first; of two, both."""
    if row.get("failed"):
        return False
    hidden = hidden_in(row)
    if not hidden:
        return not row["named"]
    if not hidden.isdisjoint(OUTSIDE):
        return row["verdict"] == "unexplained"
    return row["first"] in hidden and hidden <= set(row["named"])


def called(row: dict[str, Any]) -> str:
    """The column of the confusion matrix."""
    if row.get("failed"):
        return "(failed)"
    if row["first"] is None or (row["effect"] in OUTSIDE and row["verdict"] == "unexplained"):
        return "unexplained" if row["verdict"] == "unexplained" else "nothing"
    return row["first"]


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table, padded to be read as text too."""
    text = [[str(c) for c in row] for row in (head, *rows)]
    width = [max(len(row[i]) for row in text) for i in range(len(head))]
    lines = [
        "| " + " | ".join(c.ljust(w) for c, w in zip(r, width, strict=True)) + " |" for r in text
    ]
    return "\n".join([lines[0], "|" + "|".join("-" * (w + 2) for w in width) + "|", *lines[1:]])


def share(rows: Sequence[dict[str, Any]]) -> str:
    """``9/10``, or a dash."""
    return f"{sum(map(right, rows))}/{len(rows)}" if rows else "-"


def confusion(rows: list[dict[str, Any]]) -> str:
    """True effects down, what was named first across; columns are numbered to keep it narrow."""
    counts = Counter((r["effect"], called(r)) for r in rows if len(hidden_in(r)) < 2)
    order = [*EFFECTS, ORDINARY, "nothing", "unexplained", "(failed)"]
    true = [n for n in order if any(t == n for t, _ in counts)]
    seen = {c for _, c in counts}
    named = [n for n in order if n in seen] + sorted(seen - set(order))
    body = [[t, *(counts[t, c] or "." for c in named)] for t in true]
    legend = ", ".join(f"{i} {n}" for i, n in enumerate(named, 1))
    return table(["true \\ named", *range(1, len(named) + 1)], body) + f"\n\n{legend}"


def by_effect(rows: list[dict[str, Any]]) -> str:
    """Recall by amplitude, error before and after, time."""
    body = []
    for name in [*EFFECTS, ORDINARY]:
        mine = [r for r in rows if r["effect"] == name]
        done = [r for r in mine if not r.get("failed")]
        if not mine:
            continue
        levels = [share([r for r in mine if r["level"] == level]) for level in LEVELS]
        if name == ORDINARY:
            levels = [share(mine), "", ""]
        numbers = [_middle(r[k] for r in done) for k in ("error_before", "error_after", "seconds")]
        body.append([name, *levels, *numbers])
    return table(["effect", *LEVELS, "error before", "after", "seconds"], body)


def of_two(rows: list[dict[str, Any]]) -> str:
    """What was named where two are hidden."""
    body = [
        [r["effect"], called(r), ", ".join(r.get("named", [])), r.get("verdict", ""),
         *(_middle([r.get(k)]) for k in ("error_before", "error_after", "seconds"))]
        for r in rows
        if len(hidden_in(r)) > 1
    ]  # fmt: skip
    head = ["hidden", "first", "named", "verdict", "error before", "after", "seconds"]
    return table(head, body) if body else ""


def _middle(values: Iterable[float]) -> str:
    held = [v for v in values if v is not None]
    return f"{median(held):.3g}" if held else "-"


def reliability(rows: list[dict[str, Any]]) -> str:
    """Of the additions made with such a confidence, how many belong there."""
    additions = [
        (confidence, name in hidden_in(r))
        for r in rows
        for name, confidence in r.get("additions", [])
        if confidence is not None and hidden_in(r).isdisjoint(OUTSIDE)
    ]
    body = []
    for low, high in [(0, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 0.99), (0.99, 1.001)]:
        inside = [a for a in additions if low <= a[0] < high]
        if inside:
            said, held = np.mean(inside, axis=0)
            body.append([f"{low:g}-{min(high, 1):g}", len(inside), f"{said:.2f}", f"{held:.2f}"])
    return table(["confidence", "additions", "mean", "right"], body)


def summary(rows: list[dict[str, Any]]) -> list[tuple[str, str, float]]:
    """(aim, count, share wanted)."""
    middling = [r for r in rows if r["level"] == "middling"]
    catalogued = [r for r in middling if r["effect"] in CATALOGUED]
    outside = [r for r in middling if r["effect"] in OUTSIDE]
    ordinary = [r for r in rows if r["effect"] == ORDINARY]
    hidden = [r for r in rows if r["effect"] in CATALOGUED]
    pairs = [r for r in middling if len(hidden_in(r)) > 1]
    aims = [
        ("right name first, middling", share(catalogued), 0.95),
        ("ordinary sensor, nothing added", share(ordinary), 0.95),
        ("outside the catalogue, unexplained, middling", share(outside), 0.90),
        ("one hidden effect, nothing false beside it", _without_false(hidden), 0.95),
    ]
    if pairs:
        aims += [
            ("two hidden effects, both named, middling", share(pairs), 0.90),
            ("two hidden effects, nothing false beside them", _without_false(pairs), 0.95),
        ]
    return aims


def _without_false(rows: list[dict[str, Any]]) -> str:
    clean = [r for r in rows if not r.get("failed") and set(r["named"]) <= hidden_in(r)]
    return f"{len(clean)}/{len(rows)}" if rows else "-"


def report(rows: list[dict[str, Any]]) -> str:
    """All tables."""
    aims = table(["aim", "found", "wanted"], [(a, n, f"{w:.0%}") for a, n, w in summary(rows)])
    missed = [
        [
            r["key"],
            called(r),
            ", ".join(r.get("named", [])),
            r.get("verdict") or _last_line(r["failed"]),
        ]
        for r in rows
        if not right(r) and r["level"] != "weak"
    ]
    parts = {
        "Aims": aims,
        "Right answers by amplitude; medians of error and time": by_effect(rows),
        "Two at once": of_two(rows),
        "Confusion matrix, all levels": confusion(rows),
        "Reliability of the confidence": reliability(rows),
        "Wrong, weak apart": table(["case", "called", "named", "verdict"], missed),
    }
    return "\n\n".join(f"### {title}\n\n{text}" for title, text in parts.items() if text)


def _last_line(text: str) -> str:
    return text.strip().splitlines()[-1]
