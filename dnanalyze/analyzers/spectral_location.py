"""Where between the modes a spectral line lies, and how well that is known.

The frequency of most energy by least squares of a sine a frame, phases free, is the most likely
one. Its variance is the bound of Cramer and Rao: of N lines along an axis and a line of R times the
power of the noise in its mode, 3 / (2 pi^2 R) modes squared (6 sigma^2 / (pi^2 A^2 N^3) in units of
frequency, for one row).

References
----------
Rife and Boorstyn, IEEE Trans. Inform. Theory 20 (1974) 591, for one tone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.spectral_coherence import block_amplitudes

BLOCKS = 8  # along each side: 1/64 of what the pixels tell of a frequency is lost
UNIFORM = 1 / math.sqrt(12)  # modes: all that is known where the line does not tell more
_REACH = 0.75  # modes from the peak that are searched; half of one, and what noise may move it
_GRID, _STEPS = 9, 6  # tried along each axis, in a span a quarter of the last each time


@dataclass(frozen=True)
class Location:
    """A line between the modes.

    Parameters
    ----------
    u, v : float
        Horizontal and vertical frequency, cycles/pixel.
    u_error, v_error : float
        Standard errors, cycles/pixel; at most those of a mode in which it lies anywhere.
    """

    u: float
    v: float
    u_error: float
    v_error: float


def located(images: Sequence[np.ndarray], u: float, v: float, independent: float) -> Location:
    """The line of most energy within .75 modes of a peak.

    Parameters
    ----------
    images : sequence of ndarray
        (rows, columns) each, DN, that share the line, each with a phase of its own.
    u, v : float
        Mode at which the peak stands, cycles/pixel.
    independent : float
        How many of the images are; a frame less the mean of K counts 1 - 1/K.
    """
    amplitudes = np.array([block_amplitudes(i - i.mean(), u, v, BLOCKS) for i in images])
    shape = images[0].shape
    at, span = np.zeros(2), _REACH
    for _ in range(_STEPS):
        tried = [c + np.linspace(-span, span, _GRID) for c in at]
        energy = _energy(amplitudes, shape, (v, u), tried)
        a, b = np.unravel_index(int(np.argmax(energy)), energy.shape)
        at = np.array([tried[0][a], tried[1][b]])
        span /= 4.0
    errors = [_error(amplitudes, at, axis, independent) for axis in (0, 1)]
    rows, columns = shape
    place = _wrapped(u + at[1] / columns, v + at[0] / rows)
    return Location(*place, errors[1] / columns, errors[0] / rows)


def _wrapped(u: float, v: float) -> tuple[float, float]:
    """The same wave with |u| and |v| up to 1/2, and u not below 0."""
    u, v = ((f + 0.5) % 1.0 - 0.5 for f in (u, v))
    return (-u, -v) if u < 0 else (u, v)


def seen_share(modes: np.ndarray | float, reach: int) -> np.ndarray:
    """Share of a line's power, so far from a mode, that is in this and ``reach`` on either side."""
    near = np.arange(-reach, reach + 1)
    return np.asarray(np.sum(np.sinc(np.subtract.outer(modes, near)) ** 2, axis=-1))


def _turns(size: int, modes: np.ndarray) -> np.ndarray:
    """Factors that turn the blocks along an axis of this size back by a frequency, (modes, n)."""
    width = size // BLOCKS
    centres = width * np.arange(BLOCKS) + (width - 1) / 2.0
    return np.exp(-2j * math.pi * np.outer(modes / size, centres))


def _energy(
    amplitudes: np.ndarray,
    shape: tuple[int, int],
    peak: tuple[float, float],
    tried: Sequence[np.ndarray],
) -> np.ndarray:
    """What a sine at each frequency takes of the images' sum of squares, up to a factor.

    Slow waves are not orthogonal to their own mirror frequency: d is the mean of e^(-2i) of the
    phase over the field.
    """
    down, across = (_turns(n, m) for n, m in zip(shape, tried, strict=True))
    sums = down @ amplitudes @ across.T
    mirror = [
        _mean_wave(2.0 * (f + m / n), n // BLOCKS * BLOCKS)
        for f, m, n in zip(peak, tried, shape, strict=True)
    ]
    d = np.outer(*mirror)
    free = np.maximum(1.0 - np.abs(d) ** 2, 1e-6)
    return np.asarray(np.sum(np.abs(sums) ** 2 - np.real(np.conj(d) * sums**2), axis=0) / free)


def _mean_wave(frequency: np.ndarray, size: int) -> np.ndarray:
    """Mean of e^(-2 pi i f x) over x = 0 to size - 1."""
    x = np.arange(size)
    return np.asarray(np.exp(-2j * math.pi * np.multiply.outer(frequency, x)).mean(axis=-1))


def _error(amplitudes: np.ndarray, at: np.ndarray, axis: int, independent: float) -> float:
    """Standard error along an axis, modes.

    Noise is what is out of step, over the field or, where that is more, along the axis once the
    other one is summed in step: whole rows that move by themselves disturb v alone.
    """
    steps = np.exp(-2j * math.pi * np.outer(at, np.arange(BLOCKS)) / BLOCKS)
    turned = amplitudes * np.outer(*steps)
    line = turned.sum(axis=2 - axis)
    coherent = float(np.sum(np.abs(line.sum(axis=1)) ** 2)) / BLOCKS**2
    field = (float(np.sum(np.abs(turned) ** 2)) - coherent) / (BLOCKS**2 - 1)
    along = (float(np.sum(np.abs(line) ** 2)) / BLOCKS - coherent) / (BLOCKS - 1)
    noise = max(field, along)  # of all images together, in one mode
    if not coherent > noise:
        return UNIFORM
    if not noise > 0:
        return 0.0
    ratio = independent * (coherent / noise - 1.0)
    told = math.sqrt(1.5 / (math.pi**2 * ratio * (1.0 - 1.0 / BLOCKS**2)))
    return min(told, UNIFORM)
