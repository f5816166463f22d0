"""Which axis of a stack counts the frames: the first, or the last as ``numpy.dstack`` makes it."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.checks import MIN_COLUMNS

PAIRS = 32  # of planes that are compared
LOOKED_AT = 1 << 15  # pixels of each plane
CORRELATION_ERRORS = 6.0  # standard errors of a correlation
NOTE = (
    "The last axis counts the frames, as their likeness tells; frame_axis in the sidecar decides."
)


def doubtful(shape: tuple[int, ...]) -> bool:
    """Whether a stack is narrower than it is long and high, as one with the frames last is."""
    return len(shape) == 3 and shape[2] < min(shape[:2]) and shape[2] not in (1, 3, 4)


def frames_last(name: str, stack: Any, asked: str | None) -> bool:
    """Whether the last axis of a doubtful stack counts the frames.

    Frames of one sensor share their fixed pattern; successive rows, or columns, of many frames do
    not.

    Parameters
    ----------
    name : str
        For the message.
    stack : array
        (a, b, c); sliced, so that a file is read in part.
    asked : str or None
        "first" or "last", where the sidecar says it.

    Raises
    ------
    InputError
        Neither order is clearly the likelier.
    """
    if asked is not None:
        return asked == "last"
    a, b, c = stack.shape
    rows = min(b, max(MIN_COLUMNS, LOOKED_AT // c))
    part = slice((b - rows) // 2, (b + rows) // 2)
    firsts = np.unique(np.linspace(0, a - 2, min(PAIRS, a - 1)).astype(int))
    pairs = [np.asarray(stack[k : k + 2, part], dtype=np.float64) for k in firsts.tolist()]
    along_first = float(np.mean([_likeness(p[0], p[1]) for p in pairs]))
    all_pairs = np.concatenate(pairs)  # (2 pairs, rows, c)
    along_last = float(
        np.mean([_likeness(all_pairs[..., k], all_pairs[..., k + 1]) for k in range(c - 1)])
    )
    error = 1.0 / np.sqrt(all_pairs.size / 2)
    if c < MIN_COLUMNS or along_last > along_first + CORRELATION_ERRORS * error:
        return True
    if along_first > along_last + CORRELATION_ERRORS * error:
        return False
    raise InputError(
        f"{name}: has shape {(a, b, c)}; whether the first or the last axis counts the frames is "
        "not told by their likeness; set frame_axis: first or last in the sidecar, or save "
        "numpy.moveaxis(stack, -1, 0)"
    )


def _likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Correlation of two planes, hits and hot pixels clipped."""
    x, y = (_clipped(v) for v in (one, other))
    scale = float(np.sqrt((x * x).sum() * (y * y).sum()))
    return float((x * y).sum()) / scale if scale > 0 else 0.0


def _clipped(v: np.ndarray) -> np.ndarray:
    middle = float(np.median(v))
    reach = 4 * float(np.quantile(np.abs(v - middle), 0.68)) or np.inf
    d = np.clip(v - middle, -reach, reach)
    return d - d.mean()
