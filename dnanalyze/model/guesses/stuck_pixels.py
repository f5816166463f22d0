"""First guesses of stuck_pixels: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.stuck_pixels import StuckPixels
from dnanalyze.model.guesses.evidence import (
    curve,
    excess,
    shows,
    strongest,
    typical,
    typical_positive,
)

OFFSET_SHARE = 0.9  # share of the largest offset of a line from which others are as far off
MORE = 1.1  # times the pixels that never change, in columns; rows may lie where none are counted


def guess(effect: type[StuckPixels], clues: Clues) -> list[Effect]:
    """The share from pixels without temporal variance; the code at which most of them stand, or
    where none stands out both ends of what occurs.

    Where the noise is below a code many pixels never change, and what piles up at the ends of
    the histogram and stands far off in the pattern tells.
    """
    if shows(clues, ["dead_count"]):
        count = typical_positive(excess(clues, "dead_count"))
    elif shows(clues, ["low_spike", "high_spike"]):
        far = ("hot_count_64", "cold_count_8")
        count = sum(typical_positive(excess(clues, name)) for name in far)
    else:
        return []
    fraction = bounded(effect, "fraction", count / (clues.shape[0] * clues.shape[1]))
    setting = strongest(clues, ["dead_count"]) or 0
    stuck = curve(clues, "dead_codes", setting)
    lines = {} if stuck is None else _lines(clues, float(stuck[0]), count)
    if stuck is not None and any(lines.values()):
        rows, columns = clues.shape
        count = max(count - len(lines["columns"]) * rows, 0.0)
        count -= columns * min(len(lines["rows"]), count // columns)  # some in the other half
        rest = bounded(effect, "fraction", count / (rows * columns))
        code = bounded(effect, "code", float(stuck[0]))
        return [effect(rest, code, "one", lines["columns"], lines["rows"])]
    if stuck is not None:
        most, top = (bounded(effect, "code", float(c)) for c in (stuck[0], np.max(stuck)))
        return [effect(fraction, top, "any"), effect(fraction, most)]
    codes = curve(clues, "histogram_codes", setting)
    ends = (0.0, 4095.0) if codes is None else (float(np.min(codes)), float(np.max(codes)))
    low, high = (bounded(effect, "code", end) for end in ends)
    return [effect(fraction, high, "any"), effect(fraction, high), effect(fraction, low)]


def _lines(clues: Clues, code: float, count: float) -> dict[str, tuple[float, ...]]:
    """Whole columns and rows that may stand at a code.

    The profile bounds what pixels are off by, so that saturated lines are all alike off, and off
    the most.
    """
    none: dict[str, tuple[float, ...]] = {"columns": (), "rows": ()}
    sign = 1.0 if code > typical(clues.measured("mean")) else -1.0
    seen = {axis: clues.defects(axis) for axis in none}
    most = max((sign * float(o) for lines in seen.values() for o in lines[:, 1]), default=0.0)
    if most <= 0:
        return none
    found = {}
    for axis, along in (("columns", 0), ("rows", 1)):
        places, offsets, begins, ends = seen[axis].T
        whole = (begins <= 0) & (ends >= clues.field[along])
        found[axis] = tuple(
            float(p) for p in places[whole & (sign * offsets >= OFFSET_SHARE * most)]
        )
    return found if len(found["columns"]) * clues.shape[0] <= MORE * count else none
