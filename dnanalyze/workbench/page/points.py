"""Operating points as short labels."""

from __future__ import annotations

import re

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report.words import point_label


def labelled(point: OperatingPoint, plane: str = "") -> str:
    """Such as ``65 °C, 0.05 s, Gr``."""
    return point_label(vars(point) | {"plane": plane})


def without_shared(labels: list[str]) -> list[str]:
    """Labels without the parts that all of them share."""
    parts = [label.split(", ") for label in labels]
    shared = set.intersection(*(set(p) for p in parts)) if len(parts) > 1 else set()
    return [
        ", ".join(x for x in p if x not in shared) or label
        for p, label in zip(parts, labels, strict=True)
    ]


def unbroken(text: str) -> str:
    """A text whose numbers stay on one line with their units, and a last one with its word.

    Examples
    --------
    >>> from dnanalyze.workbench.page.points import unbroken
    >>> unbroken("mu, 65 °C, 0.05 s, gain 1") == "mu, 65\u00a0°C, 0.05\u00a0s, gain\u00a01"
    True
    """
    return re.sub(r"(?<=\d) (?=[^\W\d]|[°%])|(?<=[^\W\d]) (?=\d+$)", "\u00a0", text)
