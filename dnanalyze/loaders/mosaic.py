"""A colour mosaic as its planes: each colour a capture set of every second row and column."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.digits import number
from dnanalyze.loaders.captures import CaptureSet, Frame, Setting, Window
from dnanalyze.loaders.recording import Cfa
from dnanalyze.robust import robust_deviation

COLOUR_SCATTER = 0.3  # of the scatter of the pixels of one colour: 1 % of its variance and more


def planes(captures: CaptureSet) -> list[tuple[str, CaptureSet]]:
    """Each colour plane by name, in reading order of the top-left block.

    Parameters
    ----------
    captures : CaptureSet
        Of a mosaic, or monochrome.

    Returns
    -------
    list of (str, CaptureSet)
        "R", "Gr" (green in a red row), "Gb" (green in a blue row), "B" on a Bayer sensor; other
        colours by their letter, numbered where one occurs more than once; [("", captures)] on a
        monochrome sensor. Windows of a plane are in plane coordinates.
    """
    cfa = captures.sensor.cfa
    if cfa is None:
        return [("", captures)]
    period = len(cfa), len(cfa[0])
    return [
        (name, _plane(captures, row, column, period))
        for (row, column), name in plane_names(cfa).items()
    ]


def plane_names(cfa: Cfa) -> dict[tuple[int, int], str]:
    """(row, column) in the block to the name of its plane."""
    places = {(r, c): cfa[r][c] for r in range(len(cfa)) for c in range(len(cfa[0]))}
    if len(places) == 4 and sorted(places.values()) == ["B", "G", "G", "R"]:
        return {
            (r, c): f"G{'r' if 'R' in cfa[r] else 'b'}" if colour == "G" else colour
            for (r, c), colour in places.items()
        }
    total = Counter(places.values())
    seen: Counter[str] = Counter()
    names = {}
    for place, colour in places.items():
        seen[colour] += 1
        names[place] = colour if total[colour] == 1 else f"{colour}{seen[colour]}"
    return names


def large_mosaic(cfa: Cfa, frame: np.ndarray) -> str:
    """A note on a mosaic of more than 2 x 2 pixels, and on colours that differ in level.

    Parameters
    ----------
    cfa : tuple of tuple of str
        Larger than 2 x 2.
    frame : ndarray
        One frame, (rows, columns), DN.
    """
    rows, columns = len(cfa), len(cfa[0])
    said = (
        f"The mosaic of {rows} x {columns} pixels is analysed as its four planes of every second "
        "row and column, 00 to 11."
    )
    letters = np.array(cfa)
    own: dict[str, np.ndarray] = {}
    for colour in dict.fromkeys(letters.flat):
        places = [frame[r::rows, c::columns].ravel() for r, c in np.argwhere(letters == colour)]
        own[str(colour)] = np.concatenate(places)
    levels = {colour: float(np.median(v)) for colour, v in own.items()}
    scatter = min(robust_deviation(v) for v in own.values())
    if np.ptp(list(levels.values())) <= max(COLOUR_SCATTER * scatter, 1.0):
        return said
    listed = ", ".join(f"{colour} {number(level, 5)}" for colour, level in levels.items())
    return (
        f"{said} Its colours differ in level ({listed} DN): the DSNU of these planes contains that."
    )


@dataclass(frozen=True)
class Strided:
    """``Frame.load`` of one plane of a mosaic.

    Parameters
    ----------
    load : callable
        Of the whole mosaic.
    shape : tuple of int
        (rows, columns) of the plane.
    row, column : int
        Its first pixel in the mosaic.
    period : tuple of int
        (rows, columns) from one of its pixels to the next.
    """

    load: Callable[[Window | None], np.ndarray]
    shape: tuple[int, int]
    row: int
    column: int
    period: tuple[int, int]

    def __call__(self, window: Window | None = None) -> np.ndarray:
        """Pixels of ``window``, in plane coordinates."""
        window = window or Window.whole(self.shape)
        down, right = self.period
        mosaic = self.load(
            Window(
                self.row + down * window.top,
                self.row + down * (window.bottom - 1) + 1,
                self.column + right * window.left,
                self.column + right * (window.right - 1) + 1,
            )
        )
        return np.ascontiguousarray(mosaic[::down, ::right])


def _plane(captures: CaptureSet, row: int, column: int, period: tuple[int, int]) -> CaptureSet:
    rows, columns = captures.sensor.shape
    shape = -(-(rows - row) // period[0]), -(-(columns - column) // period[1])
    settings = tuple(
        Setting(
            s.point,
            tuple(
                Frame(f.name, f.point, Strided(f.load, shape, row, column, period))
                for f in s.frames
            ),
        )
        for s in captures.settings
    )
    return replace(
        captures, sensor=replace(captures.sensor, shape=shape, cfa=None), settings=settings
    )
