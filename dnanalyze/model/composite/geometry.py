"""Patterns of a known form: waves, rings, low-order surfaces, spots.

Each function takes the effect and the site and returns the pattern over the window, (rows,
columns), float32. All but `blob`, whose height is 1, have a mean square of 1 over many periods or
over the frame.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from dnanalyze.loaders.captures import Window
from dnanalyze.model.composite.elements import sized
from dnanalyze.model.effect import Site


def wave(effect: Any, site: Site) -> np.ndarray:
    """A plane wave sqrt2 cos(2 pi (u j + v i) + phase)."""
    u, v = effect.value("u", site.point), effect.value("v", site.point)
    angle = 2.0 * math.pi * (u * site.column_index[None, :] + v * site.row_index[:, None])
    made = math.sqrt(2.0) * np.cos(angle + effect.value("phase", site.point))
    return np.float32(sized(effect, site)) * (made * envelope(effect, site)).astype(np.float32)


def rings(effect: Any, site: Site) -> np.ndarray:
    """Rings sqrt2 cos(2 pi r / period + phase) about a centre in or beside the frame."""
    down = site.row_index[:, None] - effect.value("centre_y", site.point)
    along = site.column_index[None, :] - effect.value("centre_x", site.point)
    angle = 2.0 * math.pi * np.hypot(down, along) / effect.value("period", site.point)
    made = math.sqrt(2.0) * np.cos(angle + effect.value("phase", site.point))
    return np.float32(sized(effect, site)) * (made * envelope(effect, site)).astype(np.float32)


def surface(effect: Any, site: Site) -> np.ndarray:
    """a x + b y + c x^2 + d x y + e y^2, x and y from -1/2 to 1/2, less its mean."""
    whole = polynomial(effect, np.arange(site.shape[0]), np.arange(site.shape[1]), site.shape)
    own = polynomial(effect, site.row_index, site.column_index, site.shape)
    made = (own - whole.mean()) / whole.std()
    return np.float32(sized(effect, site)) * made.astype(np.float32)


def polynomial(
    effect: Any, row: np.ndarray, column: np.ndarray, shape: tuple[int, int]
) -> np.ndarray:
    """The surface of some rows and columns as the coefficients state it."""
    y, x = row[:, None] / shape[0] - 0.5, column[None, :] / shape[1] - 0.5
    a, b, c, d, e = effect.coefficients
    made: np.ndarray = a * x + b * y + c * x * x + d * x * y + e * y * y
    return made


def blob(effect: Any, site: Site) -> np.ndarray:
    """A Gaussian spot of height 1: in its place, or elsewhere in every frame."""
    if effect.when == "frame":
        place = site.frame_stream.child("place").uniform(Window(0, 1, 0, 2), 2)[0]
        centre = float(place[0]) * site.shape[0], float(place[1]) * site.shape[1]
        size = 1.0
    else:
        centre = effect.value("centre_y", site.point), effect.value("centre_x", site.point)
        size = sized(effect, site)
    down = (site.row_index - centre[0]) / effect.value("radius", site.point)
    along = (site.column_index - centre[1]) / effect.value("radius", site.point)
    made = np.exp(-0.5 * down**2)[:, None] * np.exp(-0.5 * along**2)[None, :]
    return np.float32(size) * made.astype(np.float32)


def envelope(effect: Any, site: Site) -> np.ndarray | float:
    """How the pattern grows over the frame, of mean square 1: not, by rows, or by columns."""
    if effect.envelope == "flat":
        return 1.0
    if effect.envelope in ("down", "up"):
        ramp = (site.row_index / (site.shape[0] - 1.0))[:, None]
    else:
        ramp = (site.column_index / (site.shape[1] - 1.0))[None, :]
    return math.sqrt(3.0) * (ramp if effect.envelope in ("down", "right") else 1.0 - ramp)
