"""Room for frames that is used again: fresh pages from the system cost as much as the sums."""

from __future__ import annotations

import sys

import numpy as np

_OURS = 3  # references to an idle buffer: the list's, the loop's and the counting call's


class Buffers:
    """Arrays of float32 that are lent until nothing refers to them, or to a view of them."""

    def __init__(self) -> None:
        self._all: list[np.ndarray] = []

    def take(self, shape: tuple[int, ...]) -> np.ndarray:
        """An array of ``shape``, of any content, that no one else holds."""
        for buffer in self._all:
            # every view of an array refers to the array that owns the memory
            if sys.getrefcount(buffer) == _OURS and buffer.shape == shape:
                return buffer[...]
        buffer = np.empty(shape, np.float32)
        self._all.append(buffer)
        return buffer[...]
