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

from dnanalyze.analyzers.spectra.coherence import block_amplitudes

BLOCKS = 8  # along each side: 1/64 of what the pixels tell of a frequency is lost
UNIFORM = 1 / math.sqrt(12)  # modes: all that is known where the line does not tell more
# Of the line's power over the noise in its mode, all images together. Below it noise makes the
# larger maximum somewhere in the span once in a hundred, e^(-R/2) / 2 times its three independent
# places (Rife and Boorstyn's threshold), and the peak's own mode is the better answer.
_THRESHOLD = 10.0
_GRID = 9  # frequencies tried along each axis
# Modes to either side: half a mode and what noise moves a peak by; then what a sum of blocks, to
# which a slow wave's mirror frequency is no wave, is off by.
_COARSE, _FINE = (0.75, 0.2, 0.05), (0.12, 0.03)


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
    shape = rows, columns = images[0].shape
    level = [np.asarray(i - i.mean(dtype=float), np.float32) for i in images]
    amplitudes = np.array([block_amplitudes(i, u, v, BLOCKS) for i in level])
    at = np.zeros(2)
    for span in _COARSE:
        tried = at[:, None] + np.linspace(-span, span, _GRID)
        down, across = (_turns(n, m) for n, m in zip(shape, tried, strict=True))
        at = _best(down @ amplitudes @ across.T, tried)
    for span in _FINE:
        tried = at[:, None] + np.linspace(-span, span, _GRID)
        waves = [
            np.exp(-2j * math.pi * np.outer(f + m / n, np.arange(n)))
            for f, m, n in zip((v, u), tried, shape, strict=True)
        ]
        mirror = [np.square(w).mean(axis=1) for w in waves]
        at = _best(np.array([waves[0] @ _times(i, waves[1]) for i in level]), tried, mirror)
    ratios = [independent * _ratio(amplitudes, at, axis) for axis in (0, 1)]
    told = [math.inf if r == math.inf else r * (1.0 - 1.0 / BLOCKS**2) for r in ratios]
    if min(told) < _THRESHOLD:
        return Location(*_wrapped(u, v), UNIFORM / columns, UNIFORM / rows)
    errors = [math.sqrt(1.5 / (math.pi**2 * r)) for r in told]
    place = _wrapped(float(u + at[1] / columns), float(v + at[0] / rows))
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


def _times(image: np.ndarray, waves: np.ndarray) -> np.ndarray:
    """image @ waves.T of a real image, by real products in its own precision."""
    even, odd = (np.ascontiguousarray(w.T, image.dtype) for w in (waves.real, waves.imag))
    return np.asarray(image @ even + 1j * (image @ odd))


def _best(
    sums: np.ndarray, tried: np.ndarray, mirror: Sequence[np.ndarray] | None = None
) -> np.ndarray:
    """Where a sine takes most of the images' sum of squares, by a parabola through the largest.

    Parameters
    ----------
    sums : ndarray
        (images, rows, columns) of the images times e^(-2 pi i (u x + v y)).
    tried : ndarray
        Frequencies (2, n) along v and u, in any unit.
    mirror : sequence of ndarray, optional
        Mean along each axis of the square of these waves: a slow wave is not orthogonal to its own
        mirror frequency.
    """
    d = np.zeros(sums.shape[1:]) if mirror is None else np.outer(*mirror)
    free = np.maximum(1.0 - np.abs(d) ** 2, 1e-6)
    energy = np.sum(np.abs(sums) ** 2 - np.real(np.conj(d) * sums**2), axis=0) / free
    a, b = divmod(int(np.argmax(energy)), energy.shape[1])
    return np.array([_vertex(tried[0], energy[:, b], a), _vertex(tried[1], energy[a], b)])


def _vertex(x: np.ndarray, y: np.ndarray, largest: int) -> float:
    """Of the parabola through the largest of evenly spaced values and its neighbours."""
    if not 0 < largest < x.size - 1:
        return float(x[largest])
    below, here, above = y[largest - 1 : largest + 2]
    bend = below - 2.0 * here + above
    return float(x[largest] + (0.5 * (below - above) / bend if bend < 0 else 0.0) * (x[1] - x[0]))


def _ratio(amplitudes: np.ndarray, at: np.ndarray, axis: int) -> float:
    """Power of the line over that of the noise in its mode, as it disturbs the place on an axis.

    Noise is what is out of step, over the field or, where that is more, along the axis once the
    other one is summed in step: whole rows that move by themselves disturb v alone.
    """
    steps = np.exp(-2j * math.pi * np.outer(at, np.arange(BLOCKS)) / BLOCKS)
    turned = amplitudes * np.outer(*steps)
    line = turned.sum(axis=2 - axis)
    coherent = float(np.sum(np.abs(line.sum(axis=1)) ** 2)) / BLOCKS**2
    field = (float(np.sum(np.abs(turned) ** 2)) - coherent) / (BLOCKS**2 - 1)
    along = (float(np.sum(np.abs(line) ** 2)) / BLOCKS - coherent) / (BLOCKS - 1)
    noise = max(field, along)
    return coherent / noise - 1.0 if noise > 0 else math.inf
