"""The verdict in a sentence."""

from __future__ import annotations

from typing import Any

from dnanalyze.digits import number

MOST = 2  # descriptors that are named


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
            f"(AUC {spread}; control {_two(best.control)})."
        )
    at = best.point.label()
    at = "" if at == "one operating point" else f" at {at}"
    by = f" by the {' and the '.join(result.telling[:MOST])}" if result.telling else ""
    return (
        f"A classifier tells the simulated frames from the measured ones{at}{by} "
        f"(AUC {_two(best.auc)}; control {_two(best.control)})."
    )


def _two(area: float) -> str:
    """Two decimals, without the zero before the point."""
    text = f"{area:.2f}"
    return text[1:] if text.startswith("0") else text


def short_point(point: Any) -> str:
    """The temperature where it is known, else all of the operating point."""
    return f"{number(point.temperature_c)} °C" if point.temperature_c is not None else point.label()
