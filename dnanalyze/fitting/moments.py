"""Moments of the series: level, signal, variances, black level over temperature."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import nnls

from dnanalyze.fitting.readings import Readings
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect
from dnanalyze.model.laws import Law, TableLaw
from dnanalyze.significance import CLEAR
from dnanalyze.thermal import KELVIN, activation, over_constant

LINKED = 0.01  # least serial correlation
DARK_EV = np.linspace(0.3, 1.28, 50)  # eV; what grows more slowly looks like a constant
# Share of the temporal variance that may be of whole frames for the quartiles of differences to
# tell the rest: beyond it, few frames make lumps of differences that are no Gaussian.
MOVED = 0.5
FAINTEST = 0.05  # DN, of a dark signal that nothing tells
REST = 0.02  # share of a moment that is the sensor's at least
NEAR_C, SAME_C = 5.0, 1.0  # C: no row of its own is needed; taken for one temperature


@dataclass(frozen=True)
class Moments:
    """Mean and variances over the operating points, DN and DN^2, and estimates from them.

    ``signal`` is the mean dark signal above the pedestal; ``temporal`` and ``pattern`` are
    variances; a point with one frame cannot tell them apart: it is given the temporal variance of
    the other points, or half of its own. ``black`` is the pedestal over temperature, where it is
    seen to move.
    """

    points: list[OperatingPoint]
    pedestal: float
    signal: np.ndarray
    temporal: np.ndarray
    pattern: np.ndarray
    black: Law | None = None

    @property
    def reference(self) -> OperatingPoint:
        """The middle of the temperatures, the longest exposure, the first gain."""
        known = sorted(p.temperature_c for p in self.points if p.temperature_c is not None)
        exposures = [p.exposure_s for p in self.points if p.exposure_s]
        gains = [p.gain for p in self.points if p.gain]
        return OperatingPoint(
            known[len(known) // 2] if known else None,
            max(exposures) if exposures else None,
            gains[0] if gains else None,
        )

    @property
    def gains(self) -> np.ndarray:
        """Analog gain of each point over that of the reference."""
        return np.array([p.gain_over(self.reference) for p in self.points])

    @property
    def readout(self) -> np.ndarray:
        """How a variance of the readout goes with the points, (points, 1 or 2).

        That of what is added before the analog gain, and, where there are several gains, after it.
        """
        before = self.gains**2
        several = np.ptp(before) > 0
        return np.column_stack([before, np.ones_like(before)] if several else [before])

    @property
    def total(self) -> np.ndarray:
        """Variance of a single frame."""
        return self.temporal + self.pattern


def moments(readings: Readings, black_level: float | None, black: Law | None = None) -> Moments:
    """Moments of the statistics of a capture set.

    ``black``: the black level over temperature, where all operating points show that it moves.
    """
    mean = readings.value("mean")
    frames = readings.frames
    single = readings.value("frame_noise_core") ** 2
    whole = readings.value("temporal_noise_core") ** 2
    # what moves whole frames is no noise of pixels, and tells nothing of the charge
    levels = [readings.curve("frame_means", i) for i in range(len(readings.points))]
    moved = np.array([np.var(np.diff(x)) / 2.0 if x.size > 1 else 0.0 for x in levels])
    seen = np.where(moved <= MOVED * whole, whole - moved, readings.value("s2_temporal"))
    usual = float(np.nanmedian(seen)) if np.isfinite(seen).any() else np.inf
    temporal = np.where(np.isfinite(seen), seen, np.minimum(usual, single / 2))
    stack = readings.value("pattern_noise") ** 2 - temporal / frames
    fixed = np.where(frames > 1, stack, single - temporal)
    pattern = np.fmax(fixed, 1e-4 * single)  # of frames that are all alike nothing else is told
    error = readings.error("mean")
    most = most_signal(mean, temporal, pattern)
    pedestal = pedestal_guess(readings.points, mean, black_level, error, most)
    signal = np.maximum(mean - pedestal, _least_signal(temporal + pattern))
    return Moments(readings.points, pedestal, signal, temporal, pattern, black)


def less(m: Moments, effect: Effect, shape: tuple[int, int]) -> Moments:
    """The moments less the contribution of an effect, where that is known; ``shape``: full frame.

    Shot noise is of all charge: the temporal variance that the effect's charge makes goes with it,
    in proportion to the signal, or what is left would seem to have a larger gain.
    """
    contributions = [effect.adds(p, m.reference, shape) for p in m.points]
    if None in contributions:
        return m
    level, variance = np.array(contributions, float).T
    rest = np.maximum(m.signal - level, REST * m.signal)
    design = np.column_stack([m.readout, m.gains * m.signal]) / m.total[:, None]
    slope = float(nnls(design, m.temporal / m.total)[0][-1])
    temporal = np.maximum(m.temporal - slope * m.gains * (m.signal - rest), REST * m.temporal)
    pattern = np.maximum(m.pattern - variance, REST * m.pattern)
    return replace(m, signal=rest, temporal=temporal, pattern=pattern)


@dataclass(frozen=True)
class BlackLevel:
    """Black level at temperatures where exposures show it.

    Parameters
    ----------
    law : TableLaw
        DN.
    errors : ndarray
        Standard errors of its rows, DN.
    """

    law: TableLaw
    errors: np.ndarray

    @property
    def mean(self) -> float:
        """Weighted mean of the rows, DN."""
        return float(np.average(self.law.values, weights=self.errors**-2.0))

    @property
    def error(self) -> float:
        """Standard error of that mean, DN."""
        return float(np.sum(self.errors**-2.0) ** -0.5)

    def at(self, celsius: float | None) -> tuple[float, float] | None:
        """Black level at a temperature and its standard error, DN; None where none is measured."""
        if not self.moves:
            return self.mean, self.error
        if celsius is None:
            return None
        for point, level, error in zip(self.law.points, self.law.values, self.errors, strict=True):
            if point.temperature_c is not None and abs(point.temperature_c - celsius) < SAME_C:
                return level, float(error)
        return None

    @property
    def moves(self) -> bool:
        """Whether the rows differ beyond `CLEAR` standard errors."""
        away = (np.array(self.law.values) - self.mean) / self.errors
        return bool(np.sum(away**2) >= CLEAR**2 * max(away.size - 1, 1))


def black_level(
    points: list[OperatingPoint], mean: np.ndarray, error: np.ndarray
) -> BlackLevel | None:
    """Black level over temperature, where exposures of zero, or two of them, show it.

    A reference voltage and an amplifier have temperature coefficients. With one exposure a
    temperature that is not told from dark current, which then takes it up.

    Parameters
    ----------
    points : list of OperatingPoint
    mean, error : ndarray
        DN, one a point: the level and its standard error.

    Returns
    -------
    BlackLevel or None
        The line through the two shortest exposures of a temperature, at exposure 0; None where no
        temperature has them, or gains or channels have levels of their own.
    """
    rows: dict[OperatingPoint, tuple[float, float]] = {}
    for kind in dict.fromkeys((p.gain, p.channel) for p in points):
        timed = [
            (i, p.temperature_c, p.exposure_s)
            for i, p in enumerate(points)
            if (p.gain, p.channel) == kind
            and p.temperature_c is not None
            and p.exposure_s is not None
        ]
        for at in temperature_knots([t for _, t, _ in timed]):
            near = [(e, i) for i, t, e in timed if abs(t - at) < SAME_C]
            level = _at_zero(sorted(near), mean, error)
            if level is not None:
                rows[OperatingPoint(at, None, *kind)] = level
    if not rows or len({(p.gain, p.channel) for p in rows}) > 1:
        return None
    level, spread = np.array(list(rows.values())).T
    return BlackLevel(TableLaw(tuple(rows), tuple(float(v) for v in level)), spread)


def _at_zero(
    near: list[tuple[float, int]], mean: np.ndarray, error: np.ndarray
) -> tuple[float, float] | None:
    """Level at exposure 0 and its error, from (exposure, point) in order; None: not told."""
    if not near:
        return None
    (first, i), others = near[0], [(e, j) for e, j in near if e > near[0][0]]
    if first == 0:
        return float(mean[i]), max(float(error[i]), 1e-3)
    if not others:
        return None
    second, j = others[0]
    share = first / (second - first)
    level = mean[i] - share * (mean[j] - mean[i])
    return float(level), max(math.hypot((1 + share) * error[i], share * error[j]), 1e-3)


def pedestal_guess(
    points: list[OperatingPoint],
    mean: np.ndarray,
    black_level: float | None,
    error: np.ndarray | float = 0.0,
    most: float = FAINTEST,
) -> float:
    """Black level from the series, mean = pedestal + A t exp(-Ea/k (1/T - 1/T0)), Ea on a grid.

    Where the series cannot tell, ``most`` below the lowest mean: from there a fit can make the
    signal smaller, while one that is 0 has no derivative.

    Parameters
    ----------
    points : list of OperatingPoint
    mean : ndarray
        DN, one a point.
    black_level : float, optional
        What the files state; used where the series cannot tell.
    error : ndarray, optional
        DN, of the means.
    most : float
        Dark signal of the faintest point at most, DN, see `most_signal`.
    """
    lowest = float(np.min(mean))
    series = _series(points)
    if series is None:
        return min(black_level, lowest) if black_level is not None else lowest - most
    x, exposure = series
    sigma = np.hypot(0.03 * (mean - lowest) + 0.05, error)
    pedestal = over_constant(x, exposure, mean, sigma, DARK_EV).constant
    return min(pedestal, lowest)


def _least_signal(variance: np.ndarray) -> float:
    """Of a dark signal that a fit begins with, DN: of less there are no derivatives."""
    return 0.01 * math.sqrt(np.nanmin(variance)) + 1e-3


def _series(points: list[OperatingPoint]) -> tuple[np.ndarray, np.ndarray] | None:
    """How the dark signal goes with temperature and exposure; None where that tells no level."""
    celsius = [25.0 if p.temperature_c is None else p.temperature_c for p in points]
    exposure = np.array([1.0 if p.exposure_s is None else p.exposure_s for p in points])
    exposure = exposure * [p.gain_over(points[0]) for p in points]  # of the charge, in DN
    x = activation(np.array(celsius) + KELVIN, 25.0 + KELVIN)
    grown = exposure * np.exp(x)
    alike = len(points) < 3 or np.ptp(grown) <= 1e-6 * np.max(grown)
    return None if alike else (x, exposure)


def with_faint(m: Moments) -> list[Moments]:
    """The moments and, where no series tells the black level, those of the least dark signal.

    Fixed patterns, such as strong row offsets, make the most that the faintest point may have far
    too large.
    """
    faint, least = float(np.min(m.signal)), _least_signal(m.total)
    if m.black is not None or not faint > max(least, FAINTEST) or _series(m.points) is not None:
        return [m]
    shift = faint - FAINTEST
    return [m, replace(m, pedestal=m.pedestal + shift, signal=np.maximum(m.signal - shift, least))]


def most_signal(mean: np.ndarray, temporal: np.ndarray, pattern: np.ndarray) -> float:
    """The dark signal of the faintest point at most, DN.

    All of its temporal variance, and all of that of its pattern, are then of the charge, whose shot
    noise is in proportion to the signal, and whose spread over the pixels is to its square:
    (s + d) / s is the ratio of the variances of the points, or its root, d the difference of the
    means. `FAINTEST` where no other point is brighter and noisier.
    """
    faint, bright = int(np.argmin(mean)), int(np.argmax(mean))
    rise = float(mean[bright] - mean[faint])
    ratios = temporal[bright] / temporal[faint], math.sqrt(pattern[bright] / pattern[faint])
    if not rise > 0 or not min(ratios) > 1.0 + REST:
        return FAINTEST
    return max(min(rise / (ratio - 1.0) for ratio in ratios), FAINTEST)


def converter_bits(readings: Readings, stated: int | None) -> int:
    """Bits of the converter: where codes pile up at 2^n - 1 it is n, else as stated, else 16."""
    top = readings.value("highest_code")
    highest = float(np.nanmax(top)) if np.isfinite(top).any() else 0.0
    full = np.log2(highest + 1.0)
    if full >= 8 and full == round(full):
        return min(int(full), 16)
    return stated if stated is not None and highest < 2**stated else 16


def serial_correlation(readings: Readings) -> tuple[float, float]:
    """Of read noise along a row at lags 1 and 2, from the quietest setting; 0 unless it stands out.

    Crosstalk and filters act along columns too, row noise and 1/f noise at all lags alike, row
    noise of two converters at odd lags as at even ones with the other sign. Where no setting has
    several frames, the noise of the single frame stands for that of the readout.
    """
    part = "temporal" if np.isfinite(readings.value("temporal_noise_core")).any() else "frame"
    noise = readings.value(f"{part}_noise_core")
    if not np.isfinite(noise).any():
        return 0.0, 0.0
    quietest = int(np.nanargmin(noise))
    error = readings.error(f"{part}_corr_10")[quietest]
    lags = ("10", "20", "01", "02")
    along, farther, *across = (readings.value(f"{part}_corr_{k}")[quietest] for k in lags)

    def clear(value: float, *others: float) -> bool:
        away = np.abs(value - np.array([0.0, *others]))
        return bool(np.all(away > max(CLEAR * error, LINKED)))

    if not clear(along, across[0], farther) or (along < 0.0 and not clear(along + farther)):
        return 0.0, 0.0
    second = farther if clear(farther, across[1]) else 0.0
    return float(np.clip(along, -0.4, 0.4)), float(np.clip(second, -0.4, 0.4))


def shared_pixels(halves: Sequence[Readings]) -> str:
    """Rows x columns of pixels that share an amplifier, as `read_noise` has it.

    Those whose temporal variances are correlated in pairs, over all operating points of all parts
    of the field; colours of a mosaic are no neighbours.
    """
    if any(len(planes) > 1 for half in halves for planes in half.planes):
        return "1x1"

    def pairs(lines: str) -> int:
        name = f"noise_shared_{lines}"
        value, error = (
            np.concatenate([of(half, name) for half in halves])
            for of in (Readings.value, Readings.error)
        )
        told = np.isfinite(value)
        found = np.sum(value[told] / error[told] ** 2)
        return 2 if found > CLEAR * math.sqrt(np.sum(error[told] ** -2.0)) else 1

    return f"{pairs('rows')}x{pairs('columns')}"


def temperature_knots(temperatures: list[float]) -> list[float]:
    """The coldest, the warmest, and those between that are `NEAR_C` from the knots beside them."""
    ordered = sorted(set(temperatures))
    knots = ordered[:1]
    for t in ordered[1:-1]:
        if min(t - knots[-1], ordered[-1] - t) >= NEAR_C:
            knots.append(t)
    return knots + (ordered[-1:] if len(ordered) > 1 else [])
