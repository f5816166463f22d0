"""What recorded temperatures can tell: which belong together, and whether they tell a slope."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

TOLERANCE_C = 1.5  # where a capture does not say; dark current changes by 15 % over it
GAP_RATIO = 10.0  # gap over the spread on either side of it, from which there are two set points
FEWEST = 3  # readings on either side that show such a spread; of six normal ones 1 in 1e4 does
# The slope of ln R over 1/T is as wrong as the difference of the temperatures, whatever the
# activation energy: below this span by more than a tenth, with a thermometer that errs by 0.2 C.
SLOPE_SPAN_C = 3.0
ROUNDING_C = 1e-9  # C; rounding


def tells_slope(temperatures: Iterable[float | None]) -> bool:
    """Whether temperatures, C, lie far enough apart for an activation energy."""
    known = [t for t in temperatures if t is not None]
    return bool(known) and max(known) - min(known) >= SLOPE_SPAN_C


def clusters(readings: np.ndarray, tolerance_c: float | None = None) -> list[tuple[int, int]]:
    """Ranges of sorted readings that belong together.

    What spans more than the tolerance is cut at its widest gap. Where the tolerance is the
    default one, so is what the scatter of the readings shows to be two set points: the gap is wide
    against the spread on both sides. Readings that repeat exactly show no scatter; their gap may be
    one step of the thermometer, and jitter over such a step is one set point.

    Parameters
    ----------
    readings : ndarray
        Sorted, C, one a frame.
    tolerance_c : float, optional
        Largest span of a cluster, C; 1.5 and the scatter decide where it is not given.

    Returns
    -------
    list of (int, int)
        First and one past the last, in order.
    """
    span = TOLERANCE_C if tolerance_c is None else tolerance_c
    runs, waiting = [], [(0, len(readings))] if len(readings) else []
    while waiting:
        first, last = waiting.pop()
        part = readings[first:last]
        at = _widest_gap(part)
        apart = tolerance_c is None and _two_set_points(part, at)
        if apart or part[-1] - part[0] > span + ROUNDING_C:
            waiting += [(first + at, last), (first, first + at)]
        else:
            runs.append((first, last))
    return runs


def isolated(readings: np.ndarray, first: int, last: int) -> bool:
    """Whether a range of sorted readings spans less than the gaps beside it.

    A regulated sensor's readings scatter about one temperature; those of a sensor that cools or
    warms follow one another at all temperatures.
    """
    span = readings[last - 1] - readings[first]
    below = np.inf if first == 0 else readings[first] - readings[first - 1]
    above = np.inf if last == len(readings) else readings[last] - readings[last - 1]
    return bool(span < min(below, above))


def _widest_gap(part: np.ndarray) -> int:
    """Where the part after the widest gap begins; of equal gaps the middle one."""
    if len(part) < 2:
        return len(part)
    gaps = np.diff(part)
    widest = np.flatnonzero(gaps >= gaps.max() - ROUNDING_C)
    return int(widest[np.argmin(np.abs(2 * widest + 2 - len(part)))]) + 1


def _two_set_points(part: np.ndarray, at: int) -> bool:
    if min(at, len(part) - at) < FEWEST:
        return False
    spread = max(part[at - 1] - part[0], part[-1] - part[at])
    return bool(spread > ROUNDING_C and part[at] - part[at - 1] >= GAP_RATIO * spread)
