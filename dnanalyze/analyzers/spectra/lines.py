"""All significant lines of a spectrum: a source and its harmonics, or several sources.

The search of `peaks` is repeated with each line taken out, as CLEAN does with the beam of a radio
telescope.

References
----------
Hogbom, Astron. Astrophys. Suppl. 15 (1974) 417.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.spectra.location import Location
from dnanalyze.analyzers.spectra.peaks import (
    LOWEST_LINE,
    Peak,
    largest_axis_peak,
    largest_peak,
)

MOST = 6  # lines off the axes, and as many on them, beside the strongest
NUMBERS = 7  # of a line, see `as_curve`
_SPAN = 2  # modes on either side that are the line itself
# Mode of the lowest line on the axes of what changes in time, which has no shading: from here on
# the floor is no lower than a spectrum of 1/f or steeper.
_LOWEST_MODE = 6
# Of the power of a mode, the share from which on a line makes it: noise would have to be 20 times
# as strong as what a line between two modes spreads there.
_LEAK = 0.05
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
    left, quiet = power.copy(), _quiet(power)
    lowest = min(LOWEST_LINE, _LOWEST_MODE / min(shape)) if temporal else LOWEST_LINE
    for line in first:
        _take_out(left, shape, line, _floor(power, shape, line.peak), quiet)
    # where the strongest off the axes is not real no other is
    wanted = {True: MOST, False: MOST if any(not line.axis for line in first) else 0}
    lines: list[Line] = []
    while any(wanted.values()):
        seen = [
            largest_axis_peak(left, shape, repeats, temporal, lowest) if wanted[True] else None,
            largest_peak(left, shape, repeats, temporal) if wanted[False] else None,
        ]
        real = [peak for peak in seen if peak is not None and peak.real]
        if not real:
            break
        line = place(max(real, key=lambda p: p.amplitude))
        _take_out(left, shape, line, _floor(left, shape, line.peak), quiet)
        lines.append(line)
        wanted[line.axis > 0] -= 1
    return lines


def _floor(power: np.ndarray, shape: tuple[int, int], peak: Peak) -> float:
    """Mean power of the modes around a peak."""
    i, k = round(peak.v * shape[0]) % shape[0], round(peak.u * shape[1])
    return float(power[i, k]) / peak.ratio


def _quiet(power: np.ndarray) -> float:
    """Median power of the modes off the axes, of an even sample of them."""
    steps = [max(1, n // _SAMPLED) for n in power.shape]
    return float(np.median(power[1 :: steps[0], 1 :: steps[1]]))


def _take_out(
    power: np.ndarray, shape: tuple[int, int], line: Line, floor: float, quiet: float
) -> None:
    """Cut a line and what it spreads to its floor, in place.

    A line between two modes spreads sinc^2 along both axes. What a line on an axis has beside it is
    cut to the ``quiet`` power there.
    """
    from dnanalyze.analyzers.kernels import mode_loops

    rows, columns = shape
    beside = min(floor, quiet) if line.axis else floor
    whole = line.amplitude**2 / 4.0 * rows * columns
    down, across = (
        np.array([_spread(sign * f * size, np.arange(count), size) for sign in (1, -1)])
        for f, size, count in ((line.at.v, rows, rows), (line.at.u, columns, power.shape[1]))
    )
    mode_loops.cut_line(power, whole / _LEAK * down, across, floor, beside)
    i, k = _modes_around(line.peak, shape)
    if not line.axis:  # next to an axis it leaves the lines there
        i, k = i[(i > 0) & (k > 0)], k[(i > 0) & (k > 0)]
    power[i, k] = np.minimum(power[i, k], np.where((i == 0) | (k == 0), floor, beside))


def _spread(at: float, modes: np.ndarray, size: int) -> np.ndarray:
    """Share of a line's power in each mode of an axis, which closes on itself."""
    away = (modes - at + size / 2.0) % size - size / 2.0
    return np.asarray(np.sinc(away) ** 2)


def _modes_around(peak: Peak, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Row and column, in the half plane u >= 0, of the modes next to a peak and to its mirror."""
    rows, columns = shape
    near = np.arange(-_SPAN, _SPAN + 1)
    down, across = (part.ravel() for part in np.meshgrid(near, near))
    i = round(peak.v * rows) + np.concatenate([down, down])
    k = round(peak.u * columns) + np.concatenate([across, across])
    sign = np.repeat([1, -1], down.size)
    i, k = sign * i % rows, sign * k % columns
    stored = k <= columns // 2
    return i[stored], k[stored]
