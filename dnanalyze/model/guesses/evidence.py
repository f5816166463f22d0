"""What a first guess asks of the clues: is there a sign, how much, and which curve shows it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from dnanalyze.model.fingerprints import LINE_BANDS, edges, named
from dnanalyze.significance import SIGN

if TYPE_CHECKING:
    from dnanalyze.model.clues import Clues

# Temporal noise, DN, from which codes change often enough to tell it: of two frames a third of the
# pixels then differ, 2 x 0.3 / sqrt(pi)
FLICKERS = 0.3


def quietest(noise: np.ndarray) -> int:
    """The setting of least temporal noise, DN, whose codes tell it: less seldom changes a code."""
    heard = np.where(np.isfinite(noise) & (noise > 0), noise, np.inf)
    clear = np.where(heard >= FLICKERS, heard, np.inf)
    return int(np.argmin(clear if np.isfinite(clear).any() else heard))


def shows(clues: Clues, names: Iterable[str], direction: int = 1, level: float = SIGN) -> bool:
    """Whether one of the statistics is above (+1), below (-1) or off (0) the model.

    At one setting by ``level``, or at all of them together by as much (Stouffer's sum).
    """
    for name in names:
        z = clues.z(name)
        z = z[np.isfinite(z)]
        together = z.sum() / np.sqrt(max(z.size, 1))
        z = np.append(z, together)
        if np.any((np.abs(z) if direction == 0 else direction * z) > level):
            return True
    return False


def excess(clues: Clues, name: str) -> np.ndarray:
    """Measured minus simulated, one a setting, plain units; NaN where either is absent."""
    return clues.measured(name) - clues.simulated(name)


def band_excess(clues: Clues, prefix: str, bands: Sequence[str] = LINE_BANDS) -> np.ndarray:
    """Unexplained power, DN^2, shape (bands, settings)."""
    return np.stack([excess(clues, name) for name in named(prefix, bands)])


def mean_power(power: np.ndarray, bands: Sequence[str] = LINE_BANDS) -> np.ndarray:
    """Mean over frequency of a line spectrum in bands, one a setting; absent bands are left out."""
    width = np.array([b - a for a, b in map(edges, bands)])[:, None]
    held = np.where(np.isfinite(power), width, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.nansum(power * width, axis=0) / held.sum(axis=0)


def known(values: np.ndarray) -> np.ndarray:
    """The finite ones."""
    held = np.asarray(values, float)
    return held[np.isfinite(held)]


def typical(values: np.ndarray) -> float:
    """Median of what is known; 0 where nothing is."""
    finite = known(values)
    return float(np.median(finite)) if finite.size else 0.0


def typical_positive(values: np.ndarray) -> float:
    """Median where that is positive, else the largest value; 0 where none is positive."""
    middle = typical(values)
    if middle > 0:
        return middle
    return float(known(values).max(initial=0.0))


def line_sigma(clues: Clues, prefix: str, length: int) -> float:
    """Standard deviation of line offsets, DN, from unexplained power on an axis of the spectrum.

    Offsets of variance s^2 on lines of ``length`` pixels have the power length s^2 there.
    """
    power = mean_power(band_excess(clues, prefix))
    return math.sqrt(typical_positive(power) / length)


def white_line_sigma(clues: Clues, prefix: str, length: int) -> float:
    """As `line_sigma`, of offsets that have the same power at all frequencies of the axis.

    The mean over the bands by their standard deviations: a band with a line of a periodic pattern
    tells little of what is at all frequencies, and may have too much of it.
    """
    power = band_excess(clues, prefix)
    z = np.stack([clues.z(name) for name in named(prefix, LINE_BANDS)])
    with np.errstate(invalid="ignore", divide="ignore"):
        weight = (z / power) ** 2  # of a power in units of its standard deviation
        weight = np.where(np.isfinite(weight), weight, 0.0)
        mean = np.nansum(weight * power, axis=0) / weight.sum(axis=0)
    return math.sqrt(typical_positive(mean) / length)


def curve(clues: Clues, name: str, setting: int) -> np.ndarray | None:
    """A measured curve, or None where these captures have none."""
    try:
        values = clues.curve(name, setting)
    except (KeyError, IndexError):
        return None
    return None if values is None or np.size(values) == 0 else np.asarray(values)


def histogram(clues: Clues, name: str, setting: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Abscissa and counts of a histogram of one setting, or None where there is none.

    ``name``: "histogram" of the codes, "pattern_hist" of the mean frame, or "difference_hist".
    """
    ends = ("codes", "counts") if name == "histogram" else ("x", "n")
    x, counts = (curve(clues, f"{name}_{end}", setting) for end in ends)
    return None if x is None or counts is None else (x, counts)


def over_signal(clues: Clues, values: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Dark signal above the lowest level, DN, and values, (..., settings), where both are known.

    None where the level hardly tells: fewer than two settings, or all alike.
    """
    level = clues.measured("mean")
    good = np.isfinite(level) & np.isfinite(values).all(axis=tuple(range(values.ndim - 1)))
    if good.sum() < 2 or np.ptp(level[good]) <= 0:
        return None
    return level[good] - level[good].min(), values[..., good]


def strongest(clues: Clues, names: Iterable[str]) -> int | None:
    """The setting in which one of the statistics is farthest off the model; None: none has any."""
    z = np.stack([np.abs(clues.z(name)) for name in names])
    z = np.where(np.isfinite(z), z, -1.0).max(axis=0)
    return int(np.argmax(z)) if z.size and z.max() >= 0 else None


def power_law(frequency: np.ndarray, power: np.ndarray, weight: np.ndarray) -> tuple[float, float]:
    """Least squares of power = C f^-alpha on log scales over its positive part: (C, alpha).

    (0, 0) where fewer than two points are positive.
    """
    good = np.isfinite(power) & (power > 0) & (weight > 0)
    if good.sum() < 2:
        return 0.0, 0.0
    x, y, w = np.log(frequency[good]), np.log(power[good]), weight[good]
    mx, my = np.average(x, weights=w), np.average(y, weights=w)
    slope = np.sum(w * (x - mx) * (y - my)) / max(np.sum(w * (x - mx) ** 2), 1e-12)
    return float(np.exp(my - slope * mx)), float(-slope)


def straight(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope of a line through values and its standard error, by least squares."""
    x, y = x - x.mean(), y - y.mean()
    square = float(x @ x)
    slope = float(x @ y) / square
    rest = y - slope * x
    return slope, math.sqrt(float(rest @ rest) / y.size / square)
