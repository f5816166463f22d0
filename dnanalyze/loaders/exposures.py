"""Which recorded exposures are one: a time that was set, and what a clock measured of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.loaders.captures import Setting

RELATIVE = 0.01  # dark charge, and the mean with it, changes by as much: less than most noise
# A clock that counts or a header that rounds to a millisecond; of a short exposure at most a tenth,
# and only where the times do not repeat: what was set repeats exactly.
ROUNDED_S = 1e-3
EXPOSURE_SHARE = 0.1
FEWEST = 3  # times that differ in every frame


def states(exposures: Sequence[float | None], tolerance_s: float | None = None) -> list[int | None]:
    """The group of each frame's exposure; None where it is unknown.

    What spans more than the tolerance is cut at its widest gap.

    Parameters
    ----------
    exposures : sequence of float or None
        s, one a frame.
    tolerance_s : float, optional
        Largest span of a group, s; by default 1 %, or 1 ms where the times are measured ones.
    """
    known = sorted({t for t in exposures if t is not None})
    counts = list(np.unique([t for t in exposures if t is not None], return_counts=True)[1])
    group: dict[float, int] = {}
    waiting = [(0, len(known))] if known else []
    number = 0
    while waiting:
        first, last = waiting.pop()
        part = known[first:last]
        if part[-1] - part[0] <= _tolerance(part, counts[first:last], tolerance_s):
            group |= dict.fromkeys(part, number)
            number += 1
        else:
            at = first + int(np.argmax(np.diff(part))) + 1
            waiting += [(at, last), (first, at)]
    return [None if t is None else group[t] for t in exposures]


def notes(settings: Sequence[Setting]) -> list[str]:
    """That several exposures were taken as one."""
    spans = [sorted({f.point.exposure_s or 0.0 for f in s.frames}) for s in settings]
    several = [(s, span) for s, span in zip(settings, spans, strict=True) if _differ(span)]
    if not several:
        return []
    setting, span = max(several, key=lambda pair: pair[1][-1] / pair[1][0])
    others = len(several) - 1
    more = f" (and so at {others} other point{'s' * (others > 1)})" if others else ""
    return [
        f"Exposures from {span[0]:.6g} to {span[-1]:.6g} s are one operating point, "
        f"{setting.point.exposure_s:.6g} s{more}: they differ by less than 1 %, or 1 ms where no "
        "two are the same; tolerance_s of the sidecar replaces this."
    ]


def _differ(span: list[float]) -> bool:
    """More than in the sixth digit, which is rounding."""
    return span[-1] - span[0] > 1e-6 * span[-1]


def _tolerance(part: list[float], counts: list[int], tolerance_s: float | None) -> float:
    if tolerance_s is not None:
        return tolerance_s
    middle = (part[0] + part[-1]) / 2
    measured = len(part) >= FEWEST and max(counts) == 1
    return max(RELATIVE * middle, min(ROUNDED_S, EXPOSURE_SHARE * middle) if measured else 0.0)
