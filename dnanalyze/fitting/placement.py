"""Window of a large field in which a model is fitted: that with most structure.

A window in the middle of a large sensor sees no glow of a corner, no stripe along a border and no
defect column elsewhere, and what no window sees no model can name. The field is surveyed first,
from afar, without any model.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.stats import norm

from dnanalyze.analyzers.field_profile import FieldProfile, field_profile
from dnanalyze.loaders.captures import CaptureSet, Setting, Window
from dnanalyze.robust import robust_deviation
from dnanalyze.significance import UNLIKELY

FRAMES = 2  # of an operating point; block means repeat to 1/45 of the noise of a pixel
# Columns of a window of all rows: 8 blocks of `BLOCK`, by which cosines of 4 orders are told.
LEAST_COLUMNS = 256


def surveyed(captures: CaptureSet, chosen: Sequence[Setting]) -> list[FieldProfile]:
    """Profiles of two settings: that with most signal, and that with least.

    Charge shows in the one, and what the readout places in the other.
    """

    def signal(setting: Setting) -> tuple[float, float]:
        return setting.point.exposure_s or 0.0, setting.point.temperature_c or 0.0

    ends = min(chosen, key=signal).point, max(chosen, key=signal).point
    return [field_profile(f.read() for f in s.frames[:FRAMES]) for s in chosen if s.point in ends]


def placed(
    profiles: Sequence[FieldProfile],
    shape: tuple[int, int],
    size: tuple[int, int],
    step: int,
    period: int = 1,
) -> Window:
    """The window of an area with most structure; that in the middle where none stands out.

    It has the aspect ratio of the field, or all its rows where most of the structure are columns:
    one that stands out by little is told by the mean of all its pixels.

    Also where that in the middle holds most of the field: what lies along a border, such as a few
    broken rows, is then held against the model by `whole_field`, and is not to weigh on the rest.

    Parameters
    ----------
    profiles : sequence of FieldProfile
        Of the measured field.
    shape, size : (int, int)
        Of the field and of a window of its aspect ratio, (rows, columns).
    step : int
        Pixels on whose multiples a window begins; its columns are a multiple, its rows of two.
    period : int
        Of the colour filter.

    Returns
    -------
    Window

    Notes
    -----
    Structure are the squares of block means about their median in the window, and of rows and
    columns about their neighbours, in standard deviations over the field, that exceed what chance
    gives once in 100 fields. A line counts by the share of it that lies in the window.
    """
    best, most = middle(shape, size, step), 0.0
    if 2 * size[0] * size[1] >= shape[0] * shape[1]:  # the error of the baseline of two CCDs of
        return best  # 1024 x 1024 is 26 and 9 in the middle, 216 and 27 at their broken borders
    for window in _tried(shape, size, step):
        found = sum(_structure(p, window, period) for p in profiles)
        if found > most:
            best, most = window, found
    for window in _tried(shape, _all_rows(shape, size, step), step):
        found = sum(_lines(p, "columns", window, period) for p in profiles)
        if found > most:
            best, most = window, found
    return best


def _all_rows(shape: tuple[int, int], size: tuple[int, int], step: int) -> tuple[int, int]:
    """The sides of a window of the same area that has all rows, or nearly so."""
    area = size[0] * size[1]
    rows = shape[0] // (2 * step) * (2 * step)
    columns = min(size[1], max(LEAST_COLUMNS, area // rows // step * step))
    return min(rows, area // columns // (2 * step) * (2 * step)), columns


def _tried(shape: tuple[int, int], size: tuple[int, int], step: int) -> Iterator[Window]:
    """The middle first, then windows that overlap by half, with the ends of the field."""
    yield middle(shape, size, step)
    down, across = (
        np.linspace(0.0, 1.0, 1 + int(np.ceil(2.0 * (n - m) / m))) if n > m else [0.0]
        for n, m in zip(shape, size, strict=True)
    )
    for y in down:
        for x in across:
            yield _at(shape, size, step, y, x)


def middle(shape: tuple[int, int], size: tuple[int, int], step: int) -> Window:
    """The window in the middle of the field."""
    return _at(shape, size, step, 0.5, 0.5)


def _at(
    shape: tuple[int, int], size: tuple[int, int], step: int, down: float, across: float
) -> Window:
    """The window at a share of the way it may move."""
    top, left = (
        int(share * (n - m)) // step * step
        for share, n, m in zip((down, across), shape, size, strict=True)
    )
    return Window(top, top + size[0], left, left + size[1])


def _structure(profile: FieldProfile, window: Window, period: int) -> float:
    own = profile.blocks_in(window)
    found = sum(_lines(profile, axis, window, period) for axis in ("rows", "columns"))
    if own.size:
        found += _excess(own - np.median(own), _roughness(profile.blocks), profile.blocks.size)
    return found


def _lines(profile: FieldProfile, axis: str, window: Window, period: int) -> float:
    """Of the "rows" or "columns": each counts by the share of it that lies in the window."""
    across, along = (0, 1) if axis == "rows" else (1, 0)
    lines = profile.lines(axis, period)
    share = window.shape[along] / (profile.rows.size, profile.columns.size)[along]
    return share * _excess(lines[window.slices[across]], robust_deviation(lines), lines.size)


def _roughness(blocks: np.ndarray) -> float:
    """Standard deviation of a block by its neighbours, which share its shading."""
    across = np.diff(blocks, axis=1) if blocks.shape[1] > 1 else np.diff(blocks, axis=0)
    return robust_deviation(across) / 2.0**0.5 if across.size else 0.0


def _excess(off: np.ndarray, deviation: float, count: int) -> float:
    """Sum of the significant squares, in standard deviations."""
    if deviation <= 0.0:
        return 0.0
    z = np.abs(off) / deviation
    return float(np.sum(z[z > norm.isf(UNLIKELY / (2 * count))] ** 2))
