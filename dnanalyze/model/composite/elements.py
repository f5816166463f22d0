"""Random values of the elements of a composite effect: pixels, lines, blocks, diagonals.

Each function takes the effect and the site and returns the pattern over the window, (rows,
columns), float32. An element's value is a function of its place, so that any window of a frame has
the pixels of the whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from dnanalyze.loaders.captures import Window
from dnanalyze.model import pink
from dnanalyze.model.effect import Site
from dnanalyze.model.streams import Stream

MOST_PAST = 64  # earlier frames that a value may depend on


def over_time(
    effect: Any, site: Site, draw: Callable[[Stream], np.ndarray], cells: Window, width: int
) -> np.ndarray:
    """Values at this frame; ``draw`` makes independent ones of unit variance from a stream.

    ``cells`` in a row of ``width``: what switches by itself.

    Persisting: x_n = sum_k rho^k n_(n-k), rho = exp(-1 / tau), of unit variance. Switching: the
    value of the last frame that drew anew, each with probability 1 - rho.
    """
    if effect.when == "fixed":
        return draw(site.fixed_stream.child("values"))
    if effect.when == "frame":
        return draw(site.frame_stream.child("values"))
    if effect.when == "drifting":
        return np.float32(site.frame) * draw(site.fixed_stream.child("values"))
    tau = effect.value("tau", site.point)
    rho = math.exp(-1.0 / tau)
    count = min(MOST_PAST, max(2, math.ceil(8.0 * tau)))
    past = [
        site.fixed_stream.child("frame", repr(site.point), site.frame - back)
        for back in range(count)
    ]
    if effect.when == "persisting":
        weight = rho ** np.arange(count)
        weight /= np.sqrt(np.sum(weight**2))
        made = np.float32(weight[0]) * draw(past[0])
        for share, stream in zip(weight[1:], past[1:], strict=True):
            made += np.float32(share) * draw(stream)
        return made
    made = draw(past[-1])
    for stream in past[-2::-1]:
        anew = stream.child("anew").uniform(cells, width) < 1.0 - rho
        made = np.where(anew, draw(stream), made)
    return made


def drawn(effect: Any, stream: Stream, cells: Window, width: int) -> np.ndarray:
    """Independent values of unit variance of some cells in a row of ``width``, float32.

    Normal; heavy: Laplace, with an excess kurtosis of 3; two_level: -1 or 1. Not of unit variance:
    on_off, 0 or 1.
    """
    if effect.distribution == "normal":
        return stream.normal(cells, width)
    off = stream.uniform(cells, width).astype(float) - 0.5
    if effect.distribution == "two_level":
        return np.where(off < 0, -1.0, 1.0).astype(np.float32)
    if effect.distribution == "on_off":
        return np.where(off < 0, 0.0, 1.0).astype(np.float32)
    rest = np.maximum(1.0 - 2.0 * np.abs(off), 2.0**-32)
    return (-np.sign(off) * np.log(rest) / math.sqrt(2.0)).astype(np.float32)


def values(effect: Any, site: Site, cells: Window, width: int) -> np.ndarray:
    """Values of some cells at this frame; 0 in those that the silicon does not choose."""
    made = over_time(effect, site, lambda stream: drawn(effect, stream, cells, width), cells, width)
    if effect.share < 1.0:
        made = made * (site.fixed_stream.child("chosen").uniform(cells, width) < effect.share)
    return made


def pixel(effect: Any, site: Site) -> np.ndarray:
    """Every pixel has a value of its own."""
    return values(effect, site, site.window, site.shape[1])


def row(effect: Any, site: Site) -> np.ndarray:
    """Every row has a value."""
    line = Window(0, 1, site.window.top, site.window.bottom)
    return np.broadcast_to(of_lines(effect, site, line, site.shape[0]).T, site.window.shape)


def column(effect: Any, site: Site) -> np.ndarray:
    """Every column has a value."""
    line = Window(0, 1, site.window.left, site.window.right)
    return np.broadcast_to(of_lines(effect, site, line, site.shape[1]), site.window.shape)


def of_lines(effect: Any, site: Site, line: Window, width: int) -> np.ndarray:
    """Values of rows or columns: 0 in those that are not named, or not chosen by the silicon."""
    if not effect.lines:
        return values(effect, site, line, width)
    number = np.arange(line.left, line.right)
    named = np.zeros(number.size, bool)
    for first, last in zip(effect.lines[::2], effect.lines[1::2], strict=True):
        named |= (number >= first) & (number <= last)
    made = over_time(effect, site, lambda stream: drawn(effect, stream, line, width), line, width)
    return made * named[None, :].astype(np.float32)


def row_before(signal: np.ndarray) -> np.ndarray:
    """The signal of the row before; 0 before the first."""
    moved = np.zeros_like(signal)
    moved[1:] = signal[:-1]
    return moved


def block(effect: Any, site: Site) -> np.ndarray:
    """Blocks of height x width pixels share a value, all their pixels or one diagonal of them."""
    rows = (site.row_index + effect.top) // effect.height
    columns = (site.column_index + effect.left) // effect.width
    made = gathered(effect, site, rows, columns, (site.shape[1] + effect.left) // effect.width + 1)
    if effect.mask == "all":
        return made
    down = (site.row_index + effect.top) % effect.height
    along = (site.column_index + effect.left) % effect.width
    if effect.mask == "antidiagonal":
        along = effect.width - 1 - along
    return made * (down[:, None] == along[None, :])


def quadrants(effect: Any, site: Site) -> np.ndarray:
    """The four quadrants have a value each, or known steps between them."""
    rows = 2 * site.row_index // site.shape[0]
    columns = 2 * site.column_index // site.shape[1]
    if effect.coefficients:
        return stepped(effect, site, rows, columns)
    return gathered(effect, site, rows, columns, 2)


def halves(effect: Any, site: Site) -> np.ndarray:
    """The upper and lower half, or the left and right one: a value each, or a known step."""
    rows, columns = np.zeros_like(site.row_index), np.zeros_like(site.column_index)
    if effect.axis == "rows":
        rows = 2 * site.row_index // site.shape[0]
    else:
        columns = 2 * site.column_index // site.shape[1]
    if effect.coefficients:
        return stepped(effect, site, rows, columns)
    return gathered(effect, site, rows, columns, 2)


def stepped(effect: Any, site: Site, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Steps of known sign and size, of mean square 1, from the halves' numbers 0 and 1.

    Of halves: of the second over the first; of quadrants: of the rows, the columns, and both.
    """
    down, along = 2.0 * rows[:, None] - 1.0, 2.0 * columns[None, :] - 1.0
    if effect.where == "halves":
        size = math.copysign(1.0, effect.coefficients[0])
        made = size * (down if effect.axis == "rows" else along) + 0.0 * down * along
    else:
        a, b, c = effect.coefficients
        made = (a * down + b * along + c * down * along) / math.hypot(a, b, c)
    return np.float32(sized(effect, site)) * made.astype(np.float32)


def sized(effect: Any, site: Site) -> float:
    """Sign and size of a known pattern in this frame: 1 if it is fixed, n if it drifts."""
    if effect.when == "fixed":
        return 1.0
    if effect.when == "drifting":
        return float(site.frame)
    one = Window(0, 1, 0, 1)
    made = over_time(effect, site, lambda stream: drawn(effect, stream, one, 1), one, 1)
    return float(made[0, 0])


def gathered(
    effect: Any, site: Site, rows: np.ndarray, columns: np.ndarray, width: int
) -> np.ndarray:
    """Values of cells by the number of their row and column, rising along the window."""
    cells = Window(int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1)
    made = values(effect, site, cells, width)
    return made[rows - cells.top][:, columns - cells.left]


def diagonal(effect: Any, site: Site) -> np.ndarray:
    """Every diagonal has a value: those that fall to the right, or those that rise."""
    i, j = site.row_index[:, None], site.column_index[None, :]
    number = i - j + site.shape[1] - 1 if effect.slant == "down" else i + j
    first = int(number.min())
    line = Window(0, 1, first, int(number.max()) + 1)
    return values(effect, site, line, site.shape[0] + site.shape[1])[0][number - first]


def smooth(effect: Any, site: Site) -> np.ndarray:
    """A cloudy field with power rho^-alpha."""
    whole = Window.whole(site.shape)
    alpha = effect.value("alpha", site.point)

    def draw(stream: Stream) -> np.ndarray:
        return pink.field(stream.normal(whole, site.shape[1]), alpha)[site.window.slices]

    return over_time(effect, site, draw, Window(0, 1, 0, 1), 1)


def row_segments(effect: Any, site: Site) -> np.ndarray:
    """Rows that jump from their value to its opposite at some column."""
    line = Window(0, 1, site.window.top, site.window.bottom)
    turn = turns(effect, site, line, site.shape[0]) * np.float32(site.shape[1])
    value = of_lines(effect, site, line, site.shape[0])
    before = site.column_index[None, :] < turn.T
    return np.where(before, value.T, -value.T)


def column_segments(effect: Any, site: Site) -> np.ndarray:
    """Columns that jump from their value to its opposite at some row."""
    line = Window(0, 1, site.window.left, site.window.right)
    turn = turns(effect, site, line, site.shape[1]) * np.float32(site.shape[0])
    value = of_lines(effect, site, line, site.shape[1])
    before = site.row_index[:, None] < turn
    return np.where(before, value, -value)


def turns(effect: Any, site: Site, line: Window, width: int) -> np.ndarray:
    """Where lines jump, as a share of their length; new in every frame unless all is fixed."""
    stream = site.fixed_stream if effect.when == "fixed" else site.frame_stream
    return stream.child("turns").uniform(line, width)
