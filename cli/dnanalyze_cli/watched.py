"""Captures whose frames tell when they are read, for a bar where the library call has none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.loaders.captures import CaptureSet, Window

Reader = Callable[[Window | None], np.ndarray]


@dataclass(frozen=True, repr=False)
class WatchedReader:
    """``Frame.load`` that tells its name; to the cache it is the reader that it wraps."""

    reader: Reader
    tell: Callable[[], None]

    def __call__(self, window: Window | None = None) -> np.ndarray:
        """Pixels of ``window``."""
        pixels = self.reader(window)
        self.tell()
        return pixels

    def __repr__(self) -> str:
        """That of the reader: the cache keeps statistics by it."""
        return repr(self.reader)


def watched(captures: CaptureSet, tick: Callable[[int, int], None]) -> CaptureSet:
    """The same captures; ``tick(done, total)`` after the first reading of each frame.

    Parameters
    ----------
    captures : CaptureSet
    tick : callable
    """
    seen: set[tuple[int, int]] = set()
    total = captures.frame_count

    def told(key: tuple[int, int]) -> Callable[[], None]:
        def tell() -> None:
            if key not in seen:
                seen.add(key)
                tick(len(seen), total)

        return tell

    settings = tuple(
        replace(
            s,
            frames=tuple(
                replace(f, load=WatchedReader(f.load, told((i, k)))) for k, f in enumerate(s.frames)
            ),
        )
        for i, s in enumerate(captures.settings)
    )
    return replace(captures, settings=settings)
