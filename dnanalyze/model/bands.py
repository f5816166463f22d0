"""Frames drawn in bands of rows, which threads share."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.row_bands import band_rows, bands
from dnanalyze.model.simulator import Simulator

AHEAD = 2  # frames begun before the first of them is asked for


def drawn(
    simulator: Simulator, point: OperatingPoint, number: int, window: Window, threads: int
) -> np.ndarray:
    """A frame's pixels of ``window``, DN, float32, drawn by several threads."""
    cut = bands(window, band_rows(simulator.model, window.shape[1]))
    with ThreadPoolExecutor(threads) as pool:
        parts = pool.map(lambda band: simulator.frame(point, number, band), cut)
        return np.concatenate(list(parts))


def stream(
    simulator: Simulator,
    point: OperatingPoint,
    numbers: Iterable[int],
    threads: int,
    rows: int,
    bits: int,
) -> Iterator[np.ndarray]:
    """Whole frames as codes of so many bits, the next ones being drawn while one is in use."""
    cut = bands(Window.whole(simulator.shape), rows)
    dtype = np.uint8 if bits <= 8 else np.uint16
    top = np.float32(2**bits - 1)

    def draw(number: int, band: Window, out: np.ndarray) -> None:
        values = simulator.frame(point, number, band)
        np.rint(values, out=values)
        np.clip(values, np.float32(0), top, out=values)
        out[band.slices] = values

    with ThreadPoolExecutor(threads) as pool:
        begun: deque[tuple[np.ndarray, list[Future[None]]]] = deque()
        for number in numbers:
            out = np.empty(simulator.shape, dtype)
            begun.append((out, [pool.submit(draw, number, band, out) for band in cut]))
            if len(begun) > AHEAD:
                yield _finished(*begun.popleft())
        while begun:
            yield _finished(*begun.popleft())


def _finished(frame: np.ndarray, parts: list[Future[None]]) -> np.ndarray:
    for part in parts:
        part.result()
    return frame
