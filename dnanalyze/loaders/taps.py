"""Readout taps in one frame: its level steps between columns or between rows."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from dnanalyze.robust import robust_deviation

COMPARED_COLUMNS = 8  # columns on either side that are compared
STEP_SCATTERS = 12.0  # robust scatters of such comparisons elsewhere in the frame
# Of the noise of a pixel: a smaller step adds less than a quarter to its variance
NOISE_SHARE = 1.0
STEP_SHARE = 0.7  # of the step that the next columns show, and whole taps: an edge, and no ramp
LEAST_TAP_SHARE = 8  # a tap is at least so large a part of the frame


@dataclass(frozen=True)
class Step:
    """A step of the level, DN, before column or row ``first`` (known to ``within``)."""

    axis: str
    first: int
    within: int
    height: float


def find_steps(sample: np.ndarray, tops: list[int], left: int) -> list[Step]:
    """The steps of the level in one frame.

    Parameters
    ----------
    sample : ndarray
        Strips of the frame, (strips, rows, columns), DN.
    tops : list of int
        First row of each strip.
    left : int
        First column of the strips.
    """
    values = sample.astype(np.float64)
    fine = np.abs(values[..., 2:] - values[..., :-2])
    noise = float(np.median(fine)) / 0.6745 / np.sqrt(2)
    columns = np.median(values, axis=(0, 1))
    steps = [Step("column", left + j, 1, height) for j, height in _columns(columns, noise)]
    found = _rows(np.median(values, axis=(1, 2)), noise)
    if found is not None:
        k, height = found
        last = tops[k - 1] + values.shape[1]
        steps.append(Step("row", last, tops[k] - last + 1, height))
    return steps


def words(steps: list[Step], label: str) -> str:
    """A note on the steps."""
    said = []
    for axis in ("column", "row"):
        here = [s for s in steps if s.axis == axis]
        if not here:
            continue
        places = [
            str(s.first) if s.within == 1 else f"{s.first} to {s.first + s.within - 1}"
            for s in here
        ]
        heights = " and ".join(f"{s.height:+.3g}" for s in here)
        said.append(f"by {heights} DN at {axis} {' and '.join(places)}")
    first = steps[0]
    return (
        f"The level steps {', '.join(said)} ({label}), as between readout taps with black levels "
        "of their own: DSNU, lines and dark current are those of all taps together; for one tap "
        f"set active_{first.axis}s: [0, {first.first}] in the sidecar."
    )


def _columns(profile: np.ndarray, noise: float) -> list[tuple[int, float]]:
    """First columns of the taps but the first, and the steps there."""
    pairs = (profile[1:] + profile[:-1]) / 2  # columns of two colours alternate
    if pairs.size < 4 * COMPARED_COLUMNS:
        return []
    windows = np.median(np.lib.stride_tricks.sliding_window_view(pairs, COMPARED_COLUMNS), axis=1)
    change = (
        windows[COMPARED_COLUMNS:] - windows[:-COMPARED_COLUMNS]
    )  # of pairs[j : j + COMPARED_COLUMNS] and those before j
    usual = robust_deviation(change)
    limit = max(STEP_SCATTERS * usual, NOISE_SHARE * noise)
    left, found = np.abs(change), list[int]()
    while left.max() > limit and len(found) < LEAST_TAP_SHARE:
        at = int(np.argmax(left))
        near = slice(max(at - COMPARED_COLUMNS, 0), at + COMPARED_COLUMNS + 1)
        j = at + COMPARED_COLUMNS
        around = slice(max(j - COMPARED_COLUMNS // 2, 0), j + COMPARED_COLUMNS // 2 + 1)
        jump = profile[around][2:] - profile[around][:-2]  # of one colour
        edge = int(np.argmax(np.abs(jump)))
        if np.abs(jump[edge]) > STEP_SHARE * np.abs(change[at]):
            # the jump is seen in two places: from the first column of the tap and the next
            found.append(_edge(profile, around.start + edge, change[at]))
        left[near] = 0.0
    return _lasting(profile, sorted(found), limit)


def _edge(profile: np.ndarray, start: int, height: float) -> int:
    """The column from which the level is the new one, near ``start``."""
    columns = np.arange(max(start - 2, 2), min(start + 5, profile.size - 2))
    sides = [
        (profile[j : j + 2].sum() - profile[j - 2 : j].sum()) * np.sign(height) for j in columns
    ]
    return int(columns[int(np.argmax(sides))])


def _lasting(profile: np.ndarray, edges: list[int], limit: float) -> list[tuple[int, float]]:
    """Edges between wide stretches whose levels differ, too."""
    bounds = [0, *edges, profile.size]
    if min(np.diff(bounds)) < profile.size / LEAST_TAP_SHARE:
        return []
    levels = [float(np.median(profile[a:b])) for a, b in pairwise(bounds)]
    heights = np.diff(levels)
    return [
        (edge, float(h))
        for edge, h in zip(edges, heights, strict=True)
        if abs(h) > STEP_SHARE * limit
    ]


def _rows(levels: np.ndarray, noise: float) -> tuple[int, float] | None:
    """The strip before which the level of strips steps, and the step."""
    best: tuple[int, float] | None = None
    for k in range(2, levels.size - 1):
        above, below = levels[:k], levels[k:]
        height = float(np.median(below) - np.median(above))
        usual = max(float(np.ptp(above)), float(np.ptp(below)))
        clear = abs(height) > max(NOISE_SHARE * noise, STEP_SCATTERS / 2 * usual)
        if clear and (best is None or abs(height) > abs(best[1])):
            best = k, height
    return best
