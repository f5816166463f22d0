"""The low-order surface of the block means, setting by setting.

The block means of a large sensor are those of a window; there the terms are told apart, and then
stated as a surface over the whole frame (`over_frame`).
"""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.guesses.evidence import curve
from dnanalyze.model.surface import TERMS, legendre

LEAST_SHADING = 3.5  # standard deviations; shading has one realization, so that no half can deny it


def shading(clues: Clues) -> np.ndarray | None:
    """Size of the unexplained low-order shading, z, (terms, settings); None: no sign."""
    names = ("shading_0_1", "shading_1_0", "shading_0_2", "shading_2_0", "shading_1_1")
    seen = np.array([np.abs(np.nan_to_num(clues.z(name))) for name in names])
    return seen if (seen > LEAST_SHADING).any() else None


def surfaces(clues: Clues) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients, DN rms over the area, (settings, terms), and their standard errors.

    NaN without blocks.
    """
    raw = np.full((len(clues.points), len(TERMS)), np.nan)
    errors = np.full(len(clues.points), np.nan)
    for j in range(len(clues.points)):
        blocks = curve(clues, "block_means", j)
        if blocks is not None and min(blocks.shape) >= 3:
            raw[j], errors[j] = surface(blocks)
    return raw, errors


def surface(blocks: np.ndarray) -> tuple[np.ndarray, float]:
    """Coefficients x, y, xx, yy, xy (DN rms) of the surface closest to the block means, and the
    standard error of each.
    """
    rows, columns = blocks.shape
    px, qx = legendre(np.arange(columns), columns)
    py, qy = legendre(np.arange(rows), rows)
    one_r, one_c = np.ones(rows), np.ones(columns)
    basis = [
        np.outer(one_r, one_c), np.outer(one_r, px), np.outer(py, one_c),
        np.outer(one_r, qx), np.outer(qy, one_c), np.outer(py, px),
    ]  # fmt: skip
    design = np.stack([b.ravel() for b in basis], 1)
    coefficients = np.linalg.lstsq(design, blocks.ravel(), rcond=None)[0]
    rest = blocks.ravel() - design @ coefficients
    return coefficients[1:], float(np.std(rest)) / math.sqrt(blocks.size)


def over_frame(terms: np.ndarray, clues: Clues) -> np.ndarray:
    """The coefficients x, y, xx, yy, xy over the frame of a surface stated over the area.

    Both are the same polynomial of the second degree, but for a constant. With s from -1 to 1 over
    the frame, t = (s - c) / w runs from -1 to 1 over the area.
    """
    area, frame = clues.area, clues.field
    (cy, wy), (cx, wx) = (
        ((begin + end) / size - 1.0, (end - begin) / size)
        for begin, end, size in (
            (area.top, area.bottom, frame[0]), (area.left, area.right, frame[1]),
        )
    )  # fmt: skip
    x, y, xx, yy, xy = np.asarray(terms, float)
    # powers of s: sqrt(3) t, sqrt(5) (3 t^2 - 1) / 2 and 3 t_x t_y written out
    xx, yy, xy = xx / wx**2, yy / wy**2, xy / (wx * wy)
    bend = 3.0 * math.sqrt(5.0)
    return np.array(
        [
            x / wx - (bend * xx * cx + 3.0 * xy * cy) / math.sqrt(3.0),
            y / wy - (bend * yy * cy + 3.0 * xy * cx) / math.sqrt(3.0),
            xx, yy, xy,
        ]
    )  # fmt: skip
