"""Scores of the suite: shares with their intervals, by generator, and two results in pairs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import median
from typing import Any

from third_party.answers import BASELINE, IN_EVERY_SENSOR, names_of

Row = Mapping[str, Any]
SURE = 0.9  # an addition with at least this confidence is said for certain


def wilson(count: int, total: int, z: float = 1.959964) -> tuple[float, float]:
    """Interval of a share from counts (Wilson 1927); z standard deviations, by default 95 %."""
    if total == 0:
        return 0.0, 1.0
    share, w = count / total, z * z / total
    centre = (share + w / 2) / (1 + w)
    half = z / (1 + w) * math.sqrt(share * (1 - share) / total + w / (4 * total))
    return max(0.0, centre - half), min(1.0, centre + half)


def mcnemar(gained: int, lost: int) -> float:
    """Two-sided exact p-value of McNemar's test: gains and losses are equally likely."""
    total = gained + lost
    if total == 0:
        return 1.0
    tail = sum(math.comb(total, k) for k in range(min(gained, lost) + 1)) / 2**total
    return min(1.0, 2 * tail)


def hidden_only(row: Row) -> dict[str, Any]:
    """The row without the effects that every sensor of its generator has."""
    own = IN_EVERY_SENSOR.get(row["generator"], frozenset())
    if row.get("failed") or not own & set(row["named"]):
        return dict(row)
    named = [name for name in row["named"] if name not in own]
    additions = [[name, sure] for name, sure in row["additions"] if name not in own]
    first = next((name for name, _ in additions if name in named), None)
    return dict(row) | {"named": named, "additions": additions, "first": first}


def accepted(row: Row) -> list[set[str]]:
    """For each kind that is hidden the right names that this version's catalogue has."""
    known = set(row.get("catalogue", ())) or None
    sets = (set(names_of(kind)) for kind in row["hides"])
    return [s if known is None else s & (known | {BASELINE}) for s in sets]


def is_ordinary(row: Row) -> bool:
    """Whether nothing is hidden."""
    return not row["hides"]


def is_outside(row: Row) -> bool:
    """Whether something is hidden that no effect of the catalogue explains."""
    return any(not names for names in accepted(row))


def right(row: Row) -> bool:
    """Ordinary: nothing added. Outside: unexplained. Else: a right name first; of two, both."""
    if row.get("failed"):
        return False
    if is_ordinary(row):
        return not row["named"]
    if is_outside(row):
        return row["verdict"] == "unexplained"
    named, sets = set(row["named"]), accepted(row)
    if all(BASELINE in names for names in sets):
        return named <= set().union(*sets)
    needed = [names for names in sets if BASELINE not in names]
    return row["first"] in set().union(*sets) and all(named & names for names in needed)


def falsely_sure(row: Row) -> bool:
    """Whether an effect that is not there was added with a confidence of at least `SURE`.

    Where something outside the catalogue is hidden, an effect kept in the model counts too.
    """
    if row.get("failed"):
        return False
    true = set().union(*accepted(row)) if row["hides"] else set()
    return any(
        name not in true and name in row["named"] and (confidence or 0.0) >= SURE
        for name, confidence in row["additions"]
    )


def detected_right(row: Row) -> bool:
    """Whether `detect` says of the filters what is so."""
    if row.get("failed"):
        return False
    filters = {"dpc", "denoise", "temporal_denoise"} & set(row["hides"])
    return row["detected"] in (filters or {"none"})


def counted(rows: Sequence[Row], test: Callable[[Row], bool]) -> str:
    """``9/10 (60-98 %)``, or a dash."""
    if not rows:
        return "-"
    count = sum(map(test, rows))
    low, high = wilson(count, len(rows))
    return f"{count}/{len(rows)} ({100 * low:.0f}-{100 * high:.0f} %)"


def by_generator(rows: Sequence[Row]) -> list[list[str]]:
    """A line for each generator and one for all."""
    lines = []
    for generator in [*dict.fromkeys(r["generator"] for r in rows), "all"]:
        mine = [r for r in rows if generator in ("all", r["generator"])]
        done = [r for r in mine if not r.get("failed")]
        catalogued = [r for r in mine if not is_ordinary(r) and not is_outside(r)]
        numbers = ("error_before", "error_after", "seconds", "cpu_seconds")
        lines.append(
            [
                generator,
                counted(catalogued, right),
                counted([r for r in mine if is_outside(r)], right),
                counted([r for r in mine if is_ordinary(r)], right),
                counted(mine, falsely_sure),
                counted(mine, detected_right),
                *(_middle(r.get(n) for r in done) for n in numbers),
                _most(r["seconds"] for r in done),
                str(len(mine) - len(done)),
            ]
        )
    return lines


HEAD = (
    "generator", "right name first", "outside: unexplained", "ordinary: nothing added",
    "false, confidence >= .9", "detect right", "error before", "after", "seconds", "CPU s",
    "most s", "failed",
)  # fmt: skip


def paired(rows: Sequence[Row], others: Mapping[str, Row]) -> list[list[str]]:
    """Each score of two results on the cases that both have: gained, lost, exact p."""
    pairs = [(others[r["key"]], r) for r in rows if r["key"] in others]
    lines = []
    for title, test in (
        ("right", right),
        ("nothing false, confidence >= .9", lambda r: not falsely_sure(r)),
        ("detect right", detected_right),
    ):
        before = [test(a) for a, _ in pairs]
        after = [test(b) for _, b in pairs]
        gained = sum(b and not a for a, b in zip(before, after, strict=True))
        lost = sum(a and not b for a, b in zip(before, after, strict=True))
        p = f"{mcnemar(gained, lost):.3g}"
        total = len(pairs)
        lines.append(
            [title, f"{sum(before)}/{total}", f"{sum(after)}/{total}", str(gained), str(lost), p]
        )
    return lines


PAIRED_HEAD = ("score", "other result", "this result", "gained", "lost", "p (McNemar, exact)")


def wrong(rows: Sequence[Row]) -> list[list[str]]:
    """Cases that went wrong or were falsely sure."""
    lines = []
    for r in rows:
        if right(r) and not falsely_sure(r):
            continue
        if r.get("failed"):
            lines.append([r["key"], ", ".join(r["hides"]), "failed", "", _last(r["failed"])])
            continue
        said = (f"{n} {c:.2f}" if c is not None else n for n, c in r["additions"])
        mark = "false" if falsely_sure(r) else ""
        lines.append(
            [r["key"], ", ".join(r["hides"]) or "nothing", ", ".join(said), r["verdict"], mark]
        )
    return lines


WRONG_HEAD = ("case", "hidden", "added (confidence)", "verdict", "")


def _middle(values: Iterable[float | None]) -> str:
    held = [v for v in values if v is not None]
    return f"{median(held):.3g}" if held else "-"


def _most(values: Iterable[float]) -> str:
    return f"{max(values, default=0):.3g}"


def _last(text: str) -> str:
    return text.strip().splitlines()[-1]
