"""A pixel's ring: the (2 reach + 1)^2 - 1 neighbours around it; edges are left out."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce

import numpy as np


def neighbours(image: np.ndarray, reach: int = 1) -> Iterator[np.ndarray]:
    """The image moved by each neighbour, (rows - 2 reach, columns - 2 reach)."""
    side = 2 * reach + 1
    rows, columns = (n - 2 * reach for n in image.shape)
    for y, x in np.ndindex(side, side):
        if (y, x) != (reach, reach):
            yield image[y : y + rows, x : x + columns]


def ring_maximum(image: np.ndarray, reach: int = 1) -> np.ndarray:
    """Largest of the neighbours, (rows - 2 reach, columns - 2 reach)."""
    return reduce(np.maximum, neighbours(image, reach))


def ring_minimum(image: np.ndarray, reach: int = 1) -> np.ndarray:
    """Smallest of the neighbours, (rows - 2 reach, columns - 2 reach)."""
    return reduce(np.minimum, neighbours(image, reach))
