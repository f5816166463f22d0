"""Columns and rows: outliers, periods, readout taps, noise above that expected from the pixels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy import special

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.estimators.line_defects import against_neighbours, defects
from dnanalyze.analyzers.estimators.line_means import line_means
from dnanalyze.analyzers.estimators.quantiles import median
from dnanalyze.analyzers.families.family import FamilyResult
from dnanalyze.analyzers.families.lines_infos import INFOS
from dnanalyze.analyzers.spectra.modes import frame_repeats
from dnanalyze.analyzers.spectra.spectral_sums import Spectra
from dnanalyze.analyzers.statistics import Value
from dnanalyze.robust import MAD

__all__ = ["INFOS", "finish"]

PERIODS = {"column": (2, 3, 4, 8), "row": (2,)}
TAPS = (2, 4, 8)
OUTLIER_SIGMAS = 6.0
LINE_CLIP = 4.0  # robust sigmas
FEWEST = 16  # lines
# Lines: every period above divides it, so that the periods pass the filter unchanged
_TREND_WINDOW = 24
_RUNNING_MEAN = np.array([0.5, *(_TREND_WINDOW - 1) * [1.0], 0.5]) / _TREND_WINDOW
_TREND_DEGREE = 3
_LAGS = 64
_GUMBEL_SD = math.pi / math.sqrt(6)


def finish(acc: Accumulated) -> FamilyResult:
    """Values and curves of the means of columns and rows."""
    result = FamilyResult()
    lines, errors = line_means(acc.clipped_pattern), acc.plan.errors
    means = {"column": lines.columns, "row": lines.rows}
    for kind, mean in means.items():
        mean = mean - _mean(mean)
        if errors:
            result.curves[f"{kind}_mean"] = mean
            result.curves[f"acf_{kind}s"] = autocorrelation(mean)
            seen = acc.pattern if kind == "column" else acc.pattern.T
            result.curves[f"{kind}_defects"] = defects(seen, mean)
        if mean.size < FEWEST:
            result.missing[kind] = f"statistics of lines need {FEWEST} {kind}s"
            continue
        _outliers(kind, mean, result)
        flat = detrended(mean)
        result.values[f"{kind}_kurtosis"] = _kurtosis(flat)
        for period in PERIODS[kind]:
            result.values[f"{kind}_periodic_{period}"] = share_of_period(flat, period)
    if means["column"].size >= FEWEST:
        for taps in TAPS:
            result.values[f"column_taps_{taps}"] = share_of_taps(means["column"], taps, errors)
    _beyond_pixels(acc, result)
    return result


def _outliers(kind: str, mean: np.ndarray, result: FamilyResult) -> None:
    apart = np.abs(against_neighbours(mean))
    sigma = MAD * median(apart)
    if sigma <= 1e-6 * max(1.0, float(apart.max())) and not apart.any():
        why = f"all {kind}s are equal"
        result.missing.update({f"{kind}_outliers": why, f"{kind}_extreme": why})
        return
    # where most lines equal their neighbours the spread of the rest is the scale
    sigma = sigma or float(np.sqrt(np.mean(apart**2)))
    sigmas = apart / sigma
    count = int(np.count_nonzero(sigmas > OUTLIER_SIGMAS))
    result.values[f"{kind}_outliers"] = Value(float(count), 1.0)
    result.values[f"{kind}_extreme"] = Value(float(sigmas.max()), _extreme_error(mean.size))


@lru_cache(maxsize=64)
def _extreme_error(lines: int) -> float:
    """Standard error of the log of the largest of so many Gaussian deviations, by Gumbel's law.

    Also where lines stand out: one defect tells nothing of the defects of the next sensor, and none
    is there by chance. Replicates of a model show how far those that it draws scatter.
    """
    expected, step = (-float(special.ndtri(0.5 * p / lines)) for p in (1.0, 0.9))
    # exceeded by one line, and by .9 of a line: ln(1/.9) steps of Gumbel's scale apart
    return _GUMBEL_SD * (step - expected) / math.log(1 / 0.9) / expected


def detrended(mean: np.ndarray) -> np.ndarray:
    """Line means less their running mean over 24 lines, and without outliers.

    The outer lines of the window have half weight, so that any pattern of a period that divides 24
    has the same running mean everywhere and is kept.
    """
    half = _TREND_WINDOW // 2
    if mean.size > 2 * _TREND_WINDOW:
        smooth = np.convolve(mean, _RUNNING_MEAN, mode="valid")
        flat = mean[half:-half] - smooth
    else:
        x = np.linspace(-1, 1, mean.size)
        flat = mean - np.polyval(np.polyfit(x, mean, 1), x)
    middle = median(flat)
    reach = OUTLIER_SIGMAS * (MAD * median(np.abs(flat - middle)))
    return flat.clip(middle - reach, middle + reach) if reach else flat


def share_of_period(mean: np.ndarray, period: int) -> Value:
    """Share of the variance of line means that a pattern of this period explains (adjusted R^2)."""
    phase, lines = _phases(mean.size, period)
    each, middle = np.bincount(phase, mean, period) / lines, _mean(mean)
    return _share(mean - middle, (each - middle)[phase], period - 1, 1)


@lru_cache(maxsize=64)
def _phases(size: int, period: int) -> tuple[np.ndarray, np.ndarray]:
    """Where in the period each line stands, and how many lines stand there."""
    phase = np.arange(size) % period
    return phase, np.bincount(phase, minlength=period)


def share_of_taps(mean: np.ndarray, taps: int, errors: bool = True) -> Value:
    """Share that steps between equal taps explain beyond a cubic trend (adjusted R^2)."""
    trend, steps = _tap_basis(mean.size, taps)
    rest = mean - trend @ (trend.T @ mean)
    explained = steps @ (steps.T @ rest)
    alike = _alike(rest - explained) if errors else 1.0
    return _share(rest, explained, steps.shape[1], trend.shape[1], alike)


def _alike(rest: np.ndarray) -> float:
    """Lines that are worth one: 1 + 2 sum rho_k, up to where neighbours are no longer alike.

    Clouds over many columns make steps between taps by chance, so many times as great.
    """
    rho = autocorrelation(rest)[1:]
    apart = np.flatnonzero(rho < 2.0 / math.sqrt(rest.size))
    return 1.0 + 2.0 * float(rho[: apart[0] if apart.size else rho.size].sum())


@lru_cache(maxsize=64)
def _tap_basis(size: int, taps: int) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal bases of the trend, and of the steps less their trend: (size, n)."""
    x = np.linspace(-1, 1, size)
    trend, _ = np.linalg.qr(np.vander(x, _TREND_DEGREE + 1))
    tap = (np.arange(size) * taps // size)[:, None] == np.arange(1, taps)
    steps = tap - trend @ (trend.T @ tap)
    basis, weight, _ = np.linalg.svd(steps, full_matrices=False)
    return trend, basis[:, weight > 1e-6]


def _share(
    total: np.ndarray, explained: np.ndarray, freedom: int, removed: int, alike: float = 1.0
) -> Value:
    """Adjusted R^2 and its standard error, for lines of which ``alike`` are worth one."""
    n = total.size - removed
    all_of_it = float(total @ total)
    # what lines that are alike explain by chance, beyond what the adjustment takes off
    noise = math.hypot(alike * math.sqrt(2.0 * freedom), (alike - 1.0) * freedom) / n
    if all_of_it <= 1e-24 * n:
        return Value(0.0, noise)
    raw = float(explained @ explained) / all_of_it
    share = 1.0 - (1.0 - raw) * n / (n - freedom)
    sure = min(max(share - noise, 0.0), 1.0)  # what is not chance alone
    variance = (noise**2 + 4 * sure / n) * (1 - sure) ** 2
    return Value(share, math.sqrt(variance + 1e-8))


def autocorrelation(mean: np.ndarray) -> np.ndarray:
    """Autocorrelation of line means at lags 0 to 63."""
    n = mean.size
    x = mean - mean.mean()
    size = min(_LAGS, n)
    power = np.abs(np.fft.rfft(x, 2 * n)) ** 2
    covariance = np.fft.irfft(power)[:size] / (n - np.arange(size))
    return covariance / covariance[0] if covariance[0] > 0 else np.zeros(size)


def _kurtosis(x: np.ndarray) -> Value:
    d = x - _mean(x)
    variance = _mean(d**2)
    excess = _mean(d**4) / variance**2 - 3 if variance > 0 else 0.0
    return Value(excess, math.sqrt(24 / x.size))


def _mean(x: np.ndarray) -> float:
    """As ``x.mean()``, which takes twice as long on so few values."""
    return float(x.sum()) / x.size


def _beyond_pixels(acc: Accumulated, result: FamilyResult) -> None:
    """Line noise against the pixels', and its correlation from line to line."""
    errors = acc.plan.errors
    if errors:
        _beyond("", acc.end_frames, acc.plan.sigma, result)
        if acc.frames > 1:
            _beyond("temporal_", acc.end_differences, acc.plan.difference_sigma, result)
    spectra: Spectra = acc.spectra
    if not spectra.useful:
        result.missing["lines"] = "the frame is too small for line noise"
        return
    single = [power / spectra.frames for power in _axis_powers(spectra.power_sum)]
    rows, columns = spectra.shape
    means = [spectra.sum.mean(axis=axis) / spectra.frames for axis in (0, 1)]
    if acc.frames < 2:
        result.missing["lines"] = "one frame does not separate DSNU from temporal noise"
        repeats = [1.0, 1.0]
    else:
        fixed = _image_axis_powers(spectra.sum, spectra.frames, *means)
        k, own = acc.frames / (acc.frames - 1.0), acc.frames - 1.0
        temporal = tuple(np.maximum((a - b) * k, 0.0) for a, b in zip(single, fixed, strict=True))
        repeats = [
            frame_repeats(float(s.sum()), float(t.sum()), acc.frames) if errors else 1.0
            for s, t in zip(single[:2], temporal[:2], strict=True)
        ]
        for kind, power, length in (("column", temporal[0], rows), ("row", temporal[1], columns)):
            pixels = float(temporal[2])
            _line_noise(f"temporal_{kind}", power, pixels, length, own, errors, result)
            value = _lag_one(power, own)
            if value is None:
                why = f"the means of the {kind}s do not change in time"
                result.missing[f"temporal_{kind}_lag1"] = why
            else:
                result.values[f"temporal_{kind}_lag1"] = value
    pixels = float(single[2])
    _line_noise("column", single[0], pixels, rows, repeats[0], errors, result)
    _line_noise("row", single[1], pixels, columns, repeats[1], errors, result)


def _beyond(name: str, images: Sequence[np.ndarray], sigma: float, result: FamilyResult) -> None:
    """Spread of line means over what the pixels explain, from differences of neighbouring lines.

    The differences leave slow trends, which are shading, out. Pixels are clipped at a few robust
    sigma: hot pixels and defect lines would otherwise make most of either side.
    """
    measured = [line_means(image, median(image), LINE_CLIP * sigma) for image in images]
    for kind, axis in (("column", 0), ("row", 1)):
        ratios = []
        for lines in measured:
            means = (lines.columns, lines.rows)
            pixels = lines.variance - means[0].var() - means[1].var()
            if pixels > 0 and means[axis].size > 2:
                steps = np.diff(means[axis])
                ratios.append(np.mean(steps**2) / 2 / (pixels / means[1 - axis].size))
        if not ratios or min(ratios) <= 0:
            result.missing[f"{name}{kind}_noise"] = "the frames are constant"
            continue
        # neighbouring differences share a line: the variance of their mean square is 3 / lines
        error = 0.5 * math.sqrt(3.0 / images[0].shape[1 - axis])
        result.values[f"{name}{kind}_noise"] = Value(math.sqrt(float(np.mean(ratios))), error)


def _axis_powers(power: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Power of (u > 0, v = 0), of (u = 0, v > 0), and the mean power off the axes."""
    rows, half = power.shape
    inner = power[1:, 1:-1].sum() + power[1:, -1].sum() / 2
    return power[0, 1:], power[1 : rows // 2 + 1, 0], inner / ((rows - 1) * (half - 1.5))


def _image_axis_powers(
    total: np.ndarray, frames: int, by_column: np.ndarray, by_row: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`_axis_powers` of the mean image, from its line means and by Parseval's theorem.

    ``total`` is the sum over the frames.
    """
    rows, columns = total.shape
    middle = by_row.mean()
    on_columns = np.abs(np.fft.rfft(by_column - middle))[1:] ** 2 * (rows / columns)
    on_rows = np.abs(np.fft.rfft(by_row - middle))[1:] ** 2 * (columns / rows)
    square = float(np.einsum("ij,ij->", total, total)) / frames**2 / total.size
    rest = square - middle**2 - by_column.var() - by_row.var()
    return on_columns, on_rows, rest * total.size / ((rows - 1) * (columns - 1))


def _line_noise(
    name: str,
    power: np.ndarray,
    pixels: float,
    length: int,
    repeats: float,
    errors: bool,
    result: FamilyResult,
) -> None:
    """Spread of the line means, and what the pixels explain of it, DN."""
    weight, _ = _mode_weights(power.size)
    plain = float(weight @ power) / weight.sum()
    if not (pixels > 0 and plain > 0):
        return
    own = 0.0
    if errors:
        share = weight * power / plain
        squares = float((share**2 * np.where(weight < 1, 2.0, 1.0)).sum())
        # a mode's own square stands for that of its mean, which is 1 + 1/repeats times smaller
        own = 0.5 * math.sqrt(squares / repeats) / float(share.sum()) / math.sqrt(1 + 1 / repeats)
    result.values[f"{name}_mean_sd"] = Value(math.sqrt(plain / length), own)
    of_pixels = math.sqrt(0.25 / (power.size * length * repeats))
    result.values[f"{name}_mean_explained"] = Value(math.sqrt(pixels / length), of_pixels)


@lru_cache(maxsize=64)
def _mode_weights(modes: int) -> tuple[np.ndarray, np.ndarray]:
    """Weight of each mode above 0 in a sum over all lines, half at the last, and its cosine."""
    number = np.arange(1, modes + 1)
    return np.where(number == modes, 0.5, 1.0), np.cos(np.pi * number / modes)


def _lag_one(power: np.ndarray, repeats: float) -> Value | None:
    """Correlation of neighbouring line means, from their power spectrum (Wiener and Khinchin)."""
    modes = power.size
    lines = 2 * modes
    weight, cosine = _mode_weights(modes)
    total = float(weight @ power)
    if not total > 0 or modes < 4:
        return None
    correlation = float((weight * cosine) @ power) / total
    # the mean over the lines was removed, which takes 1 / (lines - 1) off every correlation
    value = correlation + (1 + correlation) / (lines - 1) * (1 - abs(correlation))
    # modes vary independently; a mode's own square is 1 + 1/repeats times that of its mean
    influence = weight * (cosine - correlation) * power / total
    error = math.sqrt(float(influence @ influence) / (repeats + 1))
    return Value(value, max(error, 0.2 / math.sqrt(lines * repeats)))
