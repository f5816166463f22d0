"""All significant lines of a spectrum: a source and its harmonics, or several sources.

The search of `peaks` is repeated with each line taken out, as CLEAN does with the beam of a radio
telescope.

References
----------
Hogbom, Astron. Astrophys. Suppl. 15 (1974) 417.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from dnanalyze.analyzers.spectra.location import Location
from dnanalyze.analyzers.spectra.peaks import (
    LOWEST_LINE,
    Peak,
    largest_axis_peak,
    largest_peak,
)

MAX_LINES = 6  # lines off the axes, and as many on them, beside the strongest
NUMBERS = 7  # of a line, see `as_curve`
_SPAN = 2  # modes on either side that are the line itself
# Mode of the lowest line on the axes of what changes in time, which has no shading: from here on
# the floor is no lower than a spectrum of 1/f or steeper.
_LOWEST_MODE = 6
# Of the power of a mode, the share from which on a line makes it: noise would have to be 20 times
# as strong as what a line between two modes spreads there.
_LEAK = 0.05
_REACH = 16  # modes to either side that tell the floor
_FEWEST = 8  # of them
_SAMPLED = 256  # modes along each side that tell the quiet power


@dataclass(frozen=True)
class Line:
    """A peak that more than chance made.

    Parameters
    ----------
    peak : Peak
        The mode at which it stands.
    at : Location
        Where it lies, between the modes.
    amplitude : float
        Of the sine wave, DN.
    """

    peak: Peak
    at: Location
    amplitude: float

    @property
    def axis(self) -> int:
        """1 where whole rows share it, 2 where whole columns do, else 0."""
        return 1 if self.peak.u == 0.0 else 2 if self.peak.v == 0.0 else 0


def as_curve(lines: Sequence[Line]) -> np.ndarray:
    """(n, 7): u, v, their errors in cycles/pixel, amplitude in DN, ratio, axis as in `Line`."""
    rows = [
        (k.at.u, k.at.v, k.at.u_error, k.at.v_error, k.amplitude, k.peak.ratio, k.axis)
        for k in lines
    ]
    return np.array(rows, float).reshape(-1, NUMBERS)


def further_lines(
    power: np.ndarray,
    shape: tuple[int, int],
    repeats: float,
    temporal: bool,
    first: Sequence[Line],
    place: Callable[[Peak], Line],
) -> list[Line]:
    """Lines beside the strongest, up to 6 off the axes and 6 on them.

    Of the strongest peaks off and on the axes that of the larger amplitude is next, for what it
    spreads may make the other.

    Parameters
    ----------
    power, shape, repeats, temporal
        As in `largest_peak`.
    first : sequence of Line
        The strongest off the axes and on them, where they are real.
    place : callable
        What is measured of the line at a peak.
    """
    left, quiet = _Left(power.copy(), np.zeros(power.shape, bool)), _quiet(power)
    below = _LOWEST_MODE if temporal else math.inf
    lowest = min(LOWEST_LINE, below / shape[0]), min(LOWEST_LINE, below / shape[1])
    for line in first:
        _take_out(left, shape, line, repeats, quiet)
    # where the strongest off the axes is not real no other is
    wanted = {True: MAX_LINES, False: MAX_LINES if any(not line.axis for line in first) else 0}
    lines: list[Line] = []
    while any(wanted.values()):
        seen = [
            largest_axis_peak(left.power, shape, repeats, temporal, lowest)
            if wanted[True]
            else None,
            largest_peak(left.power, shape, repeats, temporal) if wanted[False] else None,
        ]
        real = [peak for peak in seen if peak is not None and peak.real]
        if not real:
            break
        line = place(max(real, key=lambda p: p.amplitude))
        _take_out(left, shape, line, repeats, quiet)
        lines.append(line)
        wanted[line.axis > 0] -= 1
    return lines


def _quiet(power: np.ndarray) -> float:
    """Median power of the modes off the axes, of an even sample of them."""
    steps = [max(1, n // _SAMPLED) for n in power.shape]
    return float(np.median(power[1 :: steps[0], 1 :: steps[1]]))


@dataclass(frozen=True)
class _Left:
    """Power with lines taken out, changed in place, and the modes that were of one."""

    power: np.ndarray
    taken: np.ndarray


def _take_out(
    left: _Left, shape: tuple[int, int], line: Line, repeats: float, quiet: float
) -> None:
    """Cut a line and what it spreads to the noise around.

    A line between two modes spreads sinc^2 along both axes. What a line on an axis has beside it is
    cut to the ``quiet`` power there, and one next to an axis leaves the lines there. Where the
    noise is that of the floor the modes are set to it: cut at their mean, they would have a lower.
    """
    of_line = _spread_of(left.power, shape, line)
    i, k = _modes_around(line.peak, shape)
    of_line[i, k] |= (line.axis > 0) | ((i > 0) & (k > 0))
    left.taken[of_line] = True
    mode = _mode(line.peak, shape)
    otherwise = float(left.power[mode]) / line.peak.ratio if line.axis else quiet
    floor = _floor(left, mode, repeats, otherwise)
    i, k = np.nonzero(of_line)
    limit = np.where((i == 0) | (k == 0), floor, min(floor, quiet) if line.axis else floor)
    near = [
        (np.abs((i - s * mode[0] + shape[0] // 2) % shape[0] - shape[0] // 2) <= _REACH)
        & (np.abs(k - s * mode[1]) <= _REACH)
        for s in (1, -1)
    ]
    cut = np.minimum(left.power[i, k], limit)
    left.power[i, k] = np.where(near[0] | near[1], limit, cut)


def _mode(peak: Peak, shape: tuple[int, int]) -> tuple[int, int]:
    """Row and column of a peak's mode."""
    return round(peak.v * shape[0]) % shape[0], round(peak.u * shape[1])


def _spread_of(power: np.ndarray, shape: tuple[int, int], line: Line) -> np.ndarray:
    """Modes whose power may well be of a line that lies between others."""
    from dnanalyze.analyzers.kernels import mode_loops

    rows, columns = shape
    whole = line.amplitude**2 / 4.0 * rows * columns
    down, across = (
        np.array([_spread(sign * f * size, np.arange(count), size) for sign in (1, -1)])
        for f, size, count in ((line.at.v, rows, rows), (line.at.u, columns, power.shape[1]))
    )
    return np.asarray(mode_loops.exceeds(power, whole / _LEAK * down, across))


def _floor(left: _Left, at: tuple[int, int], repeats: float, otherwise: float) -> float:
    """Power of the noise around a mode by the median of what is of no line; too few: otherwise."""
    (rows, half), (i, k) = left.power.shape, at
    reach = np.arange(-_REACH, _REACH + 1)
    down = (i + reach) % rows if i else np.array([0])
    wide = reach if i == 0 else reach[abs(reach) <= _SPAN] if k else np.array([0])
    around = np.ix_(down, np.clip(k + wide, min(k, 1), half - 1))
    noise = left.power[around][~left.taken[around]]
    if noise.size < _FEWEST:
        return otherwise
    return float(np.median(noise) / special.gammaincinv(repeats, 0.5) * repeats)


def _spread(at: float, modes: np.ndarray, size: int) -> np.ndarray:
    """Share of a line's power in each mode of an axis, which closes on itself."""
    away = (modes - at + size / 2.0) % size - size / 2.0
    return np.asarray(np.sinc(away) ** 2)


def _modes_around(peak: Peak, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Row and column, in the half plane u >= 0, of the modes next to a peak and to its mirror."""
    rows, columns = shape
    near = np.arange(-_SPAN, _SPAN + 1)
    down, across = (part.ravel() for part in np.meshgrid(near, near))
    at = _mode(peak, shape)
    sign = np.repeat([1, -1], down.size)
    i = sign * np.tile(at[0] + down, 2) % rows
    k = sign * np.tile(at[1] + across, 2) % columns
    stored = k <= columns // 2
    return i[stored], k[stored]
