"""Counter-based random numbers: a pixel's number depends on its key and place, on nothing else.

A stream is a 64-bit key. The number of pixel (r, c) is a mix of the key and the pixel's index in
the full frame, so any window, tile, thread or device draws the same numbers, in any order.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from dnanalyze.loaders.captures import Window
from dnanalyze.model import draws


@dataclass(frozen=True)
class Stream:
    """Random numbers keyed by name and place.

    Parameters
    ----------
    key : int
        64 bits.
    """

    key: int

    @classmethod
    def from_seed(cls, seed: int) -> Stream:
        """The root stream of a seed."""
        return cls(_hash(0, "seed", int(seed)))

    def child(self, *names: object) -> Stream:
        """An independent stream; ``names`` are strings or integers."""
        return Stream(_hash(self.key, *names))

    def normal(self, window: Window, width: int) -> np.ndarray:
        """Standard normals, float32, one a pixel of ``window`` in a frame ``width`` wide."""
        return draws.normal(self.key, window, width)

    def uniform(self, window: Window, width: int) -> np.ndarray:
        """Uniform deviates in (0, 1), float32, one a pixel."""
        return draws.uniform(self.key, window, width)

    def uniform_at(self, index: np.ndarray) -> np.ndarray:
        """Uniform deviates of a few pixels, by index (row x width + column); as in the field."""
        return draws.uniform_at(self.key, index)

    def generator(self) -> np.random.Generator:
        """A NumPy generator for what is not a field of pixels (a handful of tracks, phases)."""
        return np.random.Generator(np.random.Philox(key=self.key))


@lru_cache(maxsize=1 << 14, typed=True)  # the same streams are asked for frame by frame
def _hash(key: int, *names: object) -> int:
    text = "/".join([f"{key:016x}", *map(str, names)])
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")
