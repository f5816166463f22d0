"""Where a model fails most, as something to look at."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.workbench.frames import Kind, View

UNSEEN = "codes", "level", "trends"  # families that no picture shows
FAMILIES: dict[str, Kind] = {"shading": "mean", "lines": "mean", "time": "temporal noise"}
KINDS: dict[str, Kind] = {"temporal": "temporal noise", "pattern": "mean", "dsnu": "mean"}


def worst_row(rows: Sequence[dict[str, Any]], names: Sequence[str] = ()) -> dict[str, Any] | None:
    """The row with the largest difference, of some statistics or of those a picture shows."""
    seen = [r for r in rows if r["name"] in names]
    seen = seen or [r for r in rows if r["family"] not in UNSEEN]
    return max(seen, key=lambda r: min(abs(r["discrepancy"]), 1e4), default=None)


def worst_view(
    rows: Sequence[dict[str, Any]], captures: CaptureSet, names: Sequence[str] = ()
) -> View | None:
    """The image in which the largest difference of a comparison can be seen; None for none.

    Parameters
    ----------
    rows : sequence of dict
        As a comparison gives them.
    captures : CaptureSet
    names : sequence of str
        Statistics that are meant; all that a picture shows by default.
    """
    worst = worst_row(rows, names)
    if worst is None:
        return None
    points = [s.point for s in captures.settings]
    keys = ("temperature_c", "exposure_s", "gain", "channel")
    point = OperatingPoint(*(worst[k] for k in keys))
    if point not in points:
        return None
    at = points.index(point)
    first = str(worst["name"]).split("_")[0]
    kind = KINDS.get(first) or FAMILIES.get(str(worst["family"]), "frame")
    if len(captures.settings[at].frames) < 2:
        kind = "frame"
    return View(at, kind)
