"""Is a spectral line one plane wave, in step over the whole field?

A wave has the same amplitude in every block of the field, and phases that advance evenly from block
to block. Rings, a chirp, a beat or a bright patch put a peak into the spectrum as well, but their
blocks are out of step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

BLOCKS = 4  # along each side
_REACH = math.pi / 2  # of the phase between neighbouring blocks: a line one mode off its peak
_GRID = 9  # phases tried along each axis, between -reach and reach of each of so many steps
_STEPS = 4
_LEAK = 0.03  # of a slow wave's own mirror frequency, block by block


def in_step(
    images: Sequence[np.ndarray], u: float, v: float, real: bool = True
) -> tuple[float, float]:
    """Share of the power at a frequency that is in step over the field, and its standard error.

    |sum a_q|^2 / (n sum |a_q|^2) of the amplitudes a_q of n = 16 blocks, at the frequency within a
    mode of (u, v) where it is largest (the coherence of n looks in radar). A wave of power R over
    the floor gives R / (R + n - 1), white noise 1 / n where it is asked at any frequency.

    Parameters
    ----------
    images : sequence of ndarray
        (rows, columns) each, DN; they share the frequency, each with phases of its own.
    u, v : float
        Horizontal and vertical frequency, cycles/pixel.
    real : bool
        Whether more than chance made the line, which then may be weak in some images.

    Returns
    -------
    value, error : float
        0 to 1; NaN where there is no power.
    """
    amplitudes = np.array([block_amplitudes(image, u, v, BLOCKS) for image in images])
    whole = float(np.sum(np.abs(amplitudes) ** 2)) * BLOCKS**2
    if not whole > 0:
        return math.nan, math.nan
    share = _largest(amplitudes) / whole
    # the power out of step is a sum of n - 1 exponentials an image; that in step stands over them
    line = share / max(1.0 - share, 1e-9) * (BLOCKS**2 - 1)
    among = len(images) * (BLOCKS**2 - 1)
    weak = 0.5 / len(images) if real and len(images) > 1 else 0.0
    chance = share * (1.0 - share) * math.sqrt(1.0 / among + 1.0 / max(line, 1.0) + weak)
    return share, math.hypot(chance, _LEAK)


def block_amplitudes(image: np.ndarray, u: float, v: float, blocks: int) -> np.ndarray:
    """Sum over each of blocks x blocks parts of an image times e^(-2 pi i (u x + v y)), complex."""
    from dnanalyze.analyzers.kernels import mode_loops

    rows, columns = image.shape
    across = mode_loops.block_waves(np.asarray(image, np.float32), *_wave(u, columns), blocks)
    height = rows // blocks
    line = across[: height * blocks, :, 0] - 1j * across[: height * blocks, :, 1]
    down = _turning(v, height * blocks)
    return np.asarray((line * down[:, None]).reshape(blocks, height, blocks).sum(axis=1))


@lru_cache(maxsize=64)
def _wave(frequency: float, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Cosine and sine along a line of this size, float32."""
    turn = 2.0 * math.pi * frequency * np.arange(size)
    return np.cos(turn).astype(np.float32), np.sin(turn).astype(np.float32)


@lru_cache(maxsize=64)
def _turning(frequency: float, size: int) -> np.ndarray:
    """e^(-2 pi i f x) along a line of this size."""
    return np.asarray(np.exp(-2j * math.pi * frequency * np.arange(size)))


def _largest(amplitudes: np.ndarray) -> float:
    """Sum over images of |sum of the blocks|^2, phases turned evenly so that it is largest."""
    down, across, reach, best = 0.0, 0.0, _REACH, 0.0
    for _ in range(_STEPS):
        (rows, by_row), (columns, by_column) = (_turns(at, reach) for at in (down, across))
        power = np.sum(np.abs(by_row @ amplitudes @ by_column.T) ** 2, axis=0)
        a, b = divmod(int(np.argmax(power)), _GRID)
        down, across, best = rows[a], columns[b], float(power[a, b])
        reach *= 2.0 / (_GRID - 1)
    return best


@lru_cache(maxsize=1024)
def _turns(centre: float, reach: float) -> tuple[list[float], np.ndarray]:
    """Phases tried about a centre, and what they turn each block by, (phases, blocks).

    Each search meets some of the same thousand centres.
    """
    tried = centre + np.linspace(-reach, reach, _GRID)
    return tried.tolist(), np.exp(-1j * np.outer(tried, np.arange(BLOCKS)))
