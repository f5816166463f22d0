"""Where in the field patches are cut, and which of them train and which test."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.loaders.captures import Window

BANDS = 8  # down and across: either half of them samples a slow shading from end to end
SIDE = 16, 8  # pixels of a patch, usual and least
BAND = 64  # pixels of a band at most: the eight bands of a large field hold 512 x 512
# Halves of the bands down and across, each in turn tested
FOLDS = tuple((row, column) for row in (0, 1) for column in (0, 1))


@dataclass(frozen=True)
class Bands:
    """Bands of one axis that are read, put side by side as the compact picture.

    Parameters
    ----------
    starts : tuple of int
        First pixel of each, in the field.
    width : int
        Pixels of each; a multiple of the side of a patch.
    """

    starts: tuple[int, ...]
    width: int

    @property
    def pixels(self) -> np.ndarray:
        """Index in the field of each pixel of the compact picture."""
        return (np.array(self.starts)[:, None] + np.arange(self.width)).ravel()

    def half(self, parity: int) -> np.ndarray:
        """Index in the compact picture of the pixels of every second band."""
        return np.arange(len(self.starts) * self.width).reshape(-1, self.width)[parity::2].ravel()


@dataclass(frozen=True)
class Places:
    """The bands of rows and columns of a field, and the patches in them.

    A classifier trains on the patches of every second band of rows and of columns and is tested on
    those of the other bands. So no row and no column is in both: what is drawn once per row, column
    or place of a sensor cannot be learned by heart. There are four such folds, and together they
    test every patch once.

    Parameters
    ----------
    side : int
        Rows and columns of a patch.
    rows, columns : Bands
    """

    side: int
    rows: Bands
    columns: Bands

    @property
    def shape(self) -> tuple[int, int]:
        """Of the compact picture, (rows, columns)."""
        return len(self.rows.pixels), len(self.columns.pixels)

    @property
    def count(self) -> int:
        """Patches that do not overlap."""
        return self.shape[0] * self.shape[1] // self.side**2

    @property
    def contiguous(self) -> bool:
        """Whether the bands leave nothing out between them."""
        return all(
            len(b.starts) * b.width == b.starts[-1] + b.width for b in (self.rows, self.columns)
        )

    def half(self, fold: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns in the compact picture of the bands of a fold."""
        return self.rows.half(fold[0]), self.columns.half(fold[1])

    def windows(self) -> list[Window]:
        """The rectangles of the field that design the compact picture, row by row."""
        return [
            Window(top, top + self.rows.width, left, left + self.columns.width)
            for top in self.rows.starts
            for left in self.columns.starts
        ]

    def compact(self, field: np.ndarray) -> np.ndarray:
        """The compact picture of a field."""
        return field[np.ix_(self.rows.pixels, self.columns.pixels)]


def places(shape: tuple[int, int]) -> Places | None:
    """The places of a field of (rows, columns) pixels; None where it is too small.

    Parameters
    ----------
    shape : tuple of int
        Of a colour plane.
    """
    usual, least = SIDE
    side = min(usual, min(shape) // BANDS)
    if side < least:
        return None
    return Places(side, _bands(shape[0], side), _bands(shape[1], side))


def _bands(length: int, side: int) -> Bands:
    """Eight bands, evenly spread from end to end."""
    width = min(BAND, length // BANDS) // side * side
    starts = np.linspace(0, length - width, BANDS).astype(int)
    return Bands(tuple(map(int, starts)), width)
