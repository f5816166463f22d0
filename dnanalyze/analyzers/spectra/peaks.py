"""Single modes above the local floor: interference lines and the Nyquist modes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import special

LOWEST_LINE = 0.02  # cycles/pixel; below it shading is steeper than any local floor
_REACH = 16  # modes on either side, along v, that design the floor
_GUARD = 2  # modes on either side that a line itself may reach
_GUMBEL_SD = math.pi / math.sqrt(6)
_NYQUIST_NEIGHBOURS = 16


@dataclass(frozen=True)
class Peak:
    """The mode that stands highest above the mean of the modes around it.

    Parameters
    ----------
    ratio : float
        Its power over that mean.
    log_error : float
        Standard error of ln(ratio).
    u, v : float
        Frequency, cycles/pixel; v is signed.
    amplitude : float
        Amplitude of the sine wave that makes such a line, DN; from the 3 x 3 modes around, over
        which a wave between two modes spreads.
    real : bool
        Chance makes such a peak in fewer than one frame of a thousand.
    """

    ratio: float
    log_error: float
    u: float
    v: float
    amplitude: float
    real: bool


_REAL_MODE_CHANCE = 8.0  # ratio that chance reaches once in 200
_REAL_MODE_ERROR = 0.518  # standard deviation of ln(1 + chi-square of one degree)


def largest_peak(
    power: np.ndarray, shape: tuple[int, int], repeats: float, temporal: bool = False
) -> Peak | None:
    """The largest off-axis mode over its floor (cell averaging, as in radar's CA-CFAR detectors).

    The floor is the mean of 3 x 32 modes next to it in u and around it in v, without the nearest.

    Parameters
    ----------
    power : ndarray
        (rows, columns // 2 + 1), DN^2.
    shape : tuple of int
        (rows, columns) of the image.
    repeats : float
        Independent spectra that were averaged.
    temporal : bool
        The spectrum is of what changes from frame to frame.

    Returns
    -------
    Peak or None
        None where the frame is too small or has no power.
    """
    from dnanalyze.analyzers.kernels import mode_loops

    rows, columns = shape
    reach = min(_REACH, rows // 4)
    if reach <= _GUARD + 1 or columns < 8:
        return None
    ratio, i, k, floor, searched = mode_loops.search(power, columns, reach, _GUARD, LOWEST_LINE)
    if not ratio > 0 or searched < 16:
        return None
    near = np.arange(i - 1, i + 2)[:, None] % rows
    around = power[near, np.arange(max(1, k - 1), min(k + 2, power.shape[1]))]
    line = max(float(around.sum()) - around.size * floor, float(power[i, k]) - floor)
    amplitude = 2.0 * math.sqrt(line / (rows * columns))
    v = (i if i <= rows // 2 else i - rows) / rows
    cells = 6.0 * (reach - _GUARD)
    error, real = _peak_error(ratio, searched, repeats, cells, temporal)
    return Peak(ratio, error, k / columns, v, amplitude, real)


def largest_axis_peak(
    power: np.ndarray,
    shape: tuple[int, int],
    repeats: float,
    temporal: bool = False,
    lowest: tuple[float, float] = (LOWEST_LINE, LOWEST_LINE),
) -> Peak | None:
    """As `largest_peak` of the modes that whole rows (u = 0) or whole columns (v = 0) share.

    The floor is the mean of the modes around along the axis. The Nyquist modes are left out, and
    those below ``lowest`` along v and along u, cycles/pixel.
    """
    rows, columns = shape
    best: Peak | None = None
    axes = power[1 : rows // 2, 0], power[0, 1 : columns // 2]
    searched = sum(p.size for p in axes)
    for axis, line in enumerate(axes):
        reach = min(_REACH, line.size // 4)
        if reach <= _GUARD + 1:
            continue
        floor = _floor_along(line, reach)
        f = np.arange(1, line.size + 1) / shape[axis]
        ratios = np.where((f >= lowest[axis]) & (floor > 0), line / np.maximum(floor, 1e-300), 0.0)
        at = int(np.argmax(ratios))
        ratio = float(ratios[at])
        if not ratio > (best.ratio if best else 0.0):
            continue
        near = line[max(0, at - 1) : at + 2]
        left = max(float(near.sum()) - near.size * floor[at], line[at] - floor[at])
        amplitude = 2.0 * math.sqrt(max(left, 0.0) / (rows * columns))
        error, real = _peak_error(ratio, searched, repeats, 2.0 * (reach - _GUARD), temporal)
        place = (0.0, float(f[at])) if axis == 0 else (float(f[at]), 0.0)
        best = Peak(ratio, error, *place, amplitude, real)
    return best


def _floor_along(line: np.ndarray, reach: int) -> np.ndarray:
    """Mean of the modes around each on a line, without the nearest; fewer at the ends."""
    kernel = np.ones(2 * reach + 1)
    kernel[reach - _GUARD : reach + _GUARD + 1] = 0.0
    count = np.convolve(np.ones(line.size), kernel, "same")
    return np.convolve(line, kernel, "same") / np.maximum(count, 1.0)


def _peak_error(
    ratio: float, searched: int, repeats: float, cells: float, temporal: bool
) -> tuple[float, bool]:
    """Standard error of the log of the largest of many ratios, and whether a real line made it.

    A ratio of mean powers follows Fisher's F law, the largest of many Gumbel's. A real line of
    power L above a floor S has the variance (S^2 + 2 L S) / repeats; in the temporal spectrum also
    that of the mean of repeats + 1 random phases.
    """
    chance, least = _by_chance(searched, repeats, cells)
    if ratio < least:
        return chance, False
    variance = (2 * ratio - 1) / ratio**2 / repeats
    if temporal:
        variance += 1 / (repeats * (repeats + 1))
    return max(chance, math.sqrt(variance)), True


@lru_cache(maxsize=256)
def _by_chance(searched: int, repeats: float, cells: float) -> tuple[float, float]:
    """Standard error of the log of the largest ratio that chance makes, and what it hardly makes.

    The second is exceeded in one frame of a thousand.
    """
    one, other = 2 * repeats, 2 * repeats * cells
    expected, step, least = (
        float(special.fdtri(one, other, 1 - p / searched)) for p in (1.0, 0.9, 1e-3)
    )
    # exceeded by one in `searched`, and by .9 of it: ln(1/.9) steps of Gumbel's scale apart
    return _GUMBEL_SD * (step - expected) / math.log(1 / 0.9) / expected, least


def nyquist_ratios(power: np.ndarray, shape: tuple[int, int]) -> dict[str, tuple[float, float]]:
    """Power at (1/2, 0), (0, 1/2), (1/2, 1/2) over its neighbours: value and error of ln(1 + r).

    Parameters
    ----------
    power, shape
        As in `largest_peak`.

    Returns
    -------
    dict
        "10", "01", "11" (odd/even columns, rows, checkerboard); absent where there is no power.
    """
    rows, columns = shape
    middle, last = rows // 2, columns // 2
    n = max(1, min(_NYQUIST_NEIGHBOURS, last // 4, middle // 4))
    corner = power[middle - n : middle + n + 1, last - n : last]
    floors = {
        "10": (power[0, last], power[0, last - n : last]),
        "01": (power[middle, 0], power[middle - n : middle, 0]),
        "11": (power[middle, last], np.concatenate([corner[:n], corner[n + 1 :]])),
    }
    out = {}
    for name, (peak, around) in floors.items():
        floor = float(np.mean(around))
        if peak > 0 and floor > 0:
            ratio = float(peak) / floor
            out[name] = ratio, _real_mode_error(ratio, np.size(around))
    return out


def _real_mode_error(ratio: float, around: int) -> float:
    """Standard error of ln(1 + r) of a mode that is its own conjugate: chi-square with one degree.

    A fixed offset over a floor makes it non-central, with variance 2 + 4 (E r - 1); the floor
    itself is a mean over ``around`` modes.
    """
    chance = ratio < _REAL_MODE_CHANCE
    own = _REAL_MODE_ERROR if chance else math.sqrt(4.0 * ratio - 2.0) / (1.0 + ratio)
    return math.hypot(own, min(ratio, 1.0) / math.sqrt(around))
