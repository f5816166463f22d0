"""The verdict in a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

from dnanalyze.loaders.captures import OperatingPoint

MAX_NAMED = 2  # descriptors that are named
OF = " of the "  # between a descriptor and its picture


def sentence(result: Any) -> str:
    """Whether the simulated frames can be told from the measured ones, where and by what."""
    if result.reason:
        return f"No classifier was trained: {result.reason}."
    best = result.best
    if not result.tells:
        areas = [c.auc for c in result.cells]
        spread = f"{_two(min(areas))} to {_two(max(areas))}"
        return (
            "A classifier cannot tell the simulated frames from the measured ones "
            f"(AUC {spread}; control {_two(max(c.control for c in result.cells))})."
            + _opposite(result)
        )
    at = where([c.point for c in result.cells], best.point)
    by = f" by the {named(result.telling[:MAX_NAMED])}" if result.telling else ""
    return (
        f"A classifier tells the simulated frames from the measured ones{at}{by} "
        f"(AUC {_two(best.auc)}; control {_two(best.control)})."
    )


def _opposite(result: Any) -> str:
    """That the parts of the field differ from the model in opposite ways, where they do."""
    cells = [c for c in (*result.cells, *result.together) if c.reversed]
    if not cells:
        return ""
    least = min(cells, key=lambda cell: cell.high)
    at = where([c.point for c in result.cells], least.point)
    return (
        f" In the {least.name}{at} the AUC of {_two(least.auc)} is below chance: the two parts of "
        "the field on which it is trained and tested differ from the model in opposite ways."
    )


def where(points: Sequence[OperatingPoint], point: OperatingPoint | None) -> str:
    """What sets an operating point apart, such as " at 50 °C"; empty where it is the only one."""
    if point is None:
        return " at all operating points together"
    same = {f.name: None for f in fields(point) if len({getattr(p, f.name) for p in points}) == 1}
    return "" if len(set(points)) == 1 else f" at {replace(point, **same).label()}"


def named(telling: Sequence[str]) -> str:
    """Descriptors in a row; the picture is named once for those that share it."""
    by_picture: dict[str, list[str]] = {}
    for words in telling:
        what, _, picture = words.partition(OF)
        by_picture.setdefault(picture, []).append(what)
    return " and the ".join(
        f"{' and the '.join(what)}{OF}{picture}" for picture, what in by_picture.items()
    )


def _two(area: float) -> str:
    """Two decimals, without the zero before the point."""
    text = f"{area:.2f}"
    return text[1:] if text.startswith("0") else text
