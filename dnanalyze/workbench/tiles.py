"""Windows of an image, cut at tiles of the field: what is seen again is not made again."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from dnanalyze.loaders.captures import Window

SIDE = 512  # pixels of a tile, about; a frame of it is simulated in 10 to 20 ms


def aligned(window: Window, side: int, shape: tuple[int, int]) -> Window:
    """A window grown to whole blocks of ``side`` x ``side`` pixels, which begin at the corner.

    So a block is the same one wherever the window is moved to.

    Examples
    --------
    >>> from dnanalyze.loaders.captures import Window
    >>> from dnanalyze.workbench.tiles import aligned
    >>> aligned(Window(4, 7, 2, 9), 3, (8, 10))
    Window(top=3, bottom=8, left=0, right=9)
    """
    (top, bottom), (left, right) = (
        (low // side * side, min(most, -(-high // side) * side))
        for low, high, most in (
            (window.top, window.bottom, shape[0]), (window.left, window.right, shape[1]),
        )
    )  # fmt: skip
    return Window(top, bottom, left, right)


def tiled(
    window: Window, side: int, shape: tuple[int, int], tile: Callable[[Window], np.ndarray]
) -> np.ndarray:
    """Block means of an aligned window, from those of the tiles that it touches.

    Parameters
    ----------
    window : Window
        As `aligned` gives it.
    side : int
        Pixels to a side of the blocks.
    shape : (int, int)
        Rows and columns of the image.
    tile : callable
        Block means of a tile.
    """
    out = np.empty([-(-n // side) for n in window.shape], np.float32)
    for part in _tiles(window, side, shape):
        means = tile(part)
        top, left = max(part.top, window.top), max(part.left, window.left)
        bottom, right = min(part.bottom, window.bottom), min(part.right, window.right)
        common = Window(top, bottom, left, right)
        out[_blocks(common, window, side)] = means[_blocks(common, part, side)]
    return out


def _tiles(window: Window, side: int, shape: tuple[int, int]) -> Iterator[Window]:
    """The tiles that a window touches; each holds whole blocks but at the far edges."""
    step = side * max(1, SIDE // side)
    for top in range(window.top // step * step, window.bottom, step):
        for left in range(window.left // step * step, window.right, step):
            yield Window(top, min(top + step, shape[0]), left, min(left + step, shape[1]))


def _blocks(window: Window, outer: Window, side: int) -> tuple[slice, slice]:
    """Blocks of a window within those of an outer one."""
    return (
        slice((window.top - outer.top) // side, -(-(window.bottom - outer.top) // side)),
        slice((window.left - outer.left) // side, -(-(window.right - outer.left) // side)),
    )
