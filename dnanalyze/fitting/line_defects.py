"""Single lines that stand out, over both halves of the field and all settings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.analyzers.estimators.line_defects import standing_out
from dnanalyze.fitting.readings import Readings
from dnanalyze.loaders.captures import Window


def line_defects(
    profile: tuple[np.ndarray, np.ndarray],
    seen: Sequence[np.ndarray],
    gains: np.ndarray,
    axis: str,
    frame: tuple[int, int],
) -> np.ndarray:
    """Lines of a profile that deviate, each over the length that most settings show.

    Parameters
    ----------
    profile : tuple of ndarray
        Numbers of the lines and their offsets over all settings, DN at the reference gain.
    seen : sequence of ndarray
        `defects_of` each setting.
    gains : ndarray
        Of each setting, over the reference's.
    axis : str
        "columns" or "rows".
    frame : tuple of int
        Rows and columns of the frame.

    Returns
    -------
    ndarray
        (n, 4): number, offset in DN at the reference gain, begin, end; 0 and the length of the
        line where it is whole.
    """
    places, means = profile
    far, offsets = standing_out(means)
    length = frame[0 if axis == "columns" else 1]
    merged = np.concatenate([_merged(s) / [1, g, 1, 1] for s, g in zip(seen, gains, strict=True)])
    found = []
    for place, offset in zip(places[far], offsets, strict=True):
        here = merged[merged[:, 0] == place]
        _, own, begin, end = np.median(here, axis=0) if here.size else (0, offset, 0, length)
        whole = begin <= 0 and end >= length
        found.append((place, offset if whole else own, begin, end))
    return np.array(found, float).reshape(-1, 4)


def defects_of(
    halves: Sequence[Readings],
    windows: Sequence[Window],
    frame: tuple[int, int],
    axis: str,
    setting: int,
) -> np.ndarray:
    """Lines of either half in the full frame, an entry for each part of the field.

    To the edge of the field is to that of the frame.
    """
    across, along = (1, 0) if axis == "columns" else (0, 1)
    edges = np.array([[(w.top, w.bottom), (w.left, w.right)] for w in windows])
    found = []
    for window, half in zip(edges, halves, strict=True):
        part = half.defects(axis, setting)
        part[:, 0] += window[across, 0]
        part[:, 2:] += window[along, 0]
        found.append(part)
    seen = np.concatenate(found)
    seen[seen[:, 2] <= edges[:, along, 0].min(), 2] = 0
    seen[seen[:, 3] >= edges[:, along, 1].max(), 3] = frame[along]
    return seen


def _merged(seen: np.ndarray) -> np.ndarray:
    """One entry a line: from the first begin to the last end, with the longest part's offset."""
    found = []
    for line in np.unique(seen[:, 0]):
        parts = seen[seen[:, 0] == line]
        longest = parts[np.argmax(parts[:, 3] - parts[:, 2])]
        found.append((line, longest[1], parts[:, 2].min(), parts[:, 3].max()))
    return np.array(found).reshape(-1, 4)
