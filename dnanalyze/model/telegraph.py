"""Random telegraph signals of a few pixels: a state that now and then is drawn anew.

A state is the one drawn at the latest renewal, looked for backwards from the present frame, so a
frame's states hang on no other frame having been made.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.model.draws import recordable
from dnanalyze.model.streams import Stream

BLOCK = 1024  # frames whose keys are made at a time
CERTAIN = 40.0  # a renewal further back than where the odds against it are e^-40 is not looked for


@dataclass(frozen=True)
class Telegraph:
    """Two-state signals of pixels, independent of one another.

    Parameters
    ----------
    root : Stream
        Of this setting.
    name : str
        Of the signal.
    frame : int
        The present one.
    index : ndarray of int
        The pixels, row x width + column.
    occupancy : ndarray of float32
        Probability of the upper state, of each pixel.
    renew : float
        Probability that a frame draws the state anew.
    """

    root: Stream
    name: str
    frame: int
    index: np.ndarray
    occupancy: np.ndarray
    renew: float

    def state(self) -> np.ndarray:
        """Whether each pixel is in its upper state, bool."""
        on = np.zeros(self.index.size, bool)
        open_ = np.arange(self.index.size)
        for n in range(abs(self.frame), -1, -1):  # before the first as after it: as likely
            renewal, level = self._streams(n)
            if n > 0:
                new = renewal.uniform_at(self.index[open_]) < self.renew
            else:
                new = np.ones(open_.size, bool)
            done = open_[new]
            on[done] = level.uniform_at(self.index[done]) < self.occupancy[done]
            open_ = open_[~new]
            if open_.size == 0:
                break
        return on

    def span(self) -> tuple[int, int]:
        """Frames [first, stop) among which the latest renewals are, in whole blocks."""
        odds = -math.log1p(-min(self.renew, 1 - 1e-16))
        back = (CERTAIN + math.log(max(1, self.index.size))) / odds
        first = max(0, BLOCK * math.floor((self.frame - back) / BLOCK))
        return first, BLOCK * (self.frame // BLOCK + 1)

    def keys(self, first: int, stop: int) -> np.ndarray:
        """Keys of the renewal and of the state of those frames, uint64, (frames, 2)."""
        pairs: Iterator[tuple[Stream, Stream]] = map(self._streams, range(first, stop))
        return np.array([(a.key, b.key) for a, b in pairs], np.uint64)

    def _streams(self, n: int) -> tuple[Stream, Stream]:
        return self.root.child(f"renew {self.name}", n), self.root.child(self.name, n)


@recordable
def add_telegraph(
    signal: np.ndarray,
    at: np.ndarray,
    step: np.ndarray,
    states: Sequence[Telegraph],
    below: np.ndarray | None = None,
) -> np.ndarray:
    """``signal`` + ``step`` (s1 - s2 ... - ``below``) in a few pixels, in place.

    Parameters
    ----------
    signal : ndarray of float32
    at : ndarray of int
        The pixels' places in the signal, in the order of its rows.
    step, below : ndarray of float32
        One a pixel.
    states : sequence of Telegraph
        s1, s2, ..., each 0 or 1.
    """
    level = states[0].state().astype(np.float32)
    for other in states[1:]:
        level -= other.state()
    if below is not None:
        level -= below
    rows, columns = np.divmod(at, signal.shape[1])
    signal[rows, columns] += step * level
    return signal
