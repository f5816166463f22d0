"""Over temperature and exposure: laws of the dark signal, and hot pixels that repeat."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from dnanalyze.analyzers.estimators.arrhenius import arrhenius_laws, doubts, misfit
from dnanalyze.analyzers.statistics import (
    SATURATION,
    SettingStatistics,
    StatisticInfo,
    Statistics,
    Value,
)
from dnanalyze.loaders.captures import OperatingPoint, Sensor
from dnanalyze.loaders.thermometer import tells_slope
from dnanalyze.thermal import KELVIN, activation, over_constant

BIAS_SHARE = 1e-3  # of the longest exposure, up to which a frame counts as bias
BLACK_LEVEL_ERROR = 0.5  # DN, of a recorded black level
ENERGIES_EV = np.linspace(0.05, 3.0, 60)  # of whatever grows with temperature
LEVEL_ERROR = 0.02  # DN, of a median of codes
UNKNOWN_DRIFT = 0.1  # DN, how far a single frame may stand off
RELATIVE_ERROR = 0.02  # of the dark signal: a thermometer good to about 0.2 C
GAP = 5.0  # standard errors of the mean; of a normal distribution the median has 1.25
HEADROOM = 4.0  # standard errors above 0 from which a dark rate tells an activation energy

INFOS = (
    StatisticInfo("pedestal", "trends", "DN", "black level", compared=False),
    StatisticInfo("activation_energy_ev", "trends", "eV", "activation energy", compared=False),
    StatisticInfo(
        "activation_energy_1_ev", "trends", "eV", "lower activation energy of two", compared=False
    ),
    StatisticInfo(
        "activation_energy_2_ev", "trends", "eV", "higher activation energy of two", compared=False
    ),
    StatisticInfo(
        "activation_share", "trends", "1", "share of the higher activation energy", compared=False
    ),
    StatisticInfo("doubling_step_c", "trends", "C", "doubling temperature", compared=False),
    StatisticInfo("dark_rate_dn_s", "trends", "DN/s", "median dark current", compared=False),
    StatisticInfo(
        "hot_repeat_settings", "trends", "1", "share of hot pixels still hot at the next "
        "temperature",
        compared=False,
    ),
)  # fmt: skip


def trends(
    settings: Sequence[SettingStatistics], sensor: Sensor
) -> tuple[dict[str, Value], list[SettingStatistics]]:
    """Laws over temperature and exposure of the median dark signal, which hot pixels do not move.

    Settings of one gain and channel go together; the laws are those of the largest such group.
    Colour planes are averaged. Settings most of whose pixels are saturated are left out.

    Returns
    -------
    laws : dict
        By name, see ``INFOS``; what the settings cannot tell is absent.
    settings : list of SettingStatistics
        As given, with ``dark_rate_dn_s`` added where the pedestal is known.
    """
    out: dict[str, Value] = {}
    rates: dict[OperatingPoint, Value] = {}
    groups: dict[object, list[OperatingPoint]] = {}
    saturated = {s.point for s in settings if SATURATION in s.missing}
    for point in dict.fromkeys(s.point for s in settings if s.point not in saturated):
        groups.setdefault((point.channel, point.gain), []).append(point)
    for points in sorted(groups.values(), key=len, reverse=True):
        series = _series(points, settings)
        laws, dark = dark_signal(series, sensor.black_level_at(points))
        rates |= dict(zip(points, dark, strict=True)) if dark else {}
        if "pedestal" in laws:
            known = laws["pedestal"]
            apart = _between_levels(points, settings)
            laws["pedestal"] = replace(known, se=math.hypot(known.se, apart)) if apart else known
        for name, value in laws.items():
            out.setdefault(name, value)
    repeat = hot_repeat([s for s in settings if s.point not in saturated])
    if repeat is not None:
        out["hot_repeat_settings"] = repeat
    return out, [
        replace(s, values=s.values | {"dark_rate_dn_s": rates[s.point]}) if s.point in rates else s
        for s in settings
    ]


def law_doubts(measured: Statistics) -> list[str]:
    """Laws over temperature that are not believed, a sentence each, channel by channel."""
    channels = channel_trends(measured)
    named = [f"Channel {name}: {text}" for name, laws in channels.items() for text in doubts(laws)]
    return named if channels else doubts(measured.trends)


def channel_trends(measured: Statistics) -> dict[str, dict[str, Value]]:
    """Laws of each readout channel by itself; empty where there are fewer than two."""
    names = dict.fromkeys(s.point.channel for s in measured.settings)
    named = [n for n in names if n is not None]
    return {
        name: trends([s for s in measured.settings if s.point.channel == name], measured.sensor)[0]
        for name in (named if len(named) > 1 else ())
    }


@dataclass(frozen=True)
class Series:
    """Dark level of settings of one gain: temperature (K; NaN unknown), exposure (s), DN."""

    kelvin: np.ndarray
    exposure: np.ndarray
    level: np.ndarray
    error: np.ndarray
    timed: bool  # exposures are known, else they count as 1 s


def _series(points: list[OperatingPoint], settings: Sequence[SettingStatistics]) -> Series:
    """Errors are those within this sensor: its DSNU is common to all settings."""
    level, error = [], []
    for point in points:
        here = [s for s in settings if s.point == point]
        level.append(float(np.mean([s.values["median"].value for s in here])))
        drifts = [s.values["drift"].value / math.sqrt(s.frames) for s in here if s.frames > 1]
        error.append(math.hypot(LEVEL_ERROR, np.mean(drifts)) if drifts else UNKNOWN_DRIFT)
    timed = all(p.exposure_s is not None for p in points)
    kelvin = [math.nan if p.temperature_c is None else p.temperature_c + KELVIN for p in points]
    exposure = [p.exposure_s if timed and p.exposure_s is not None else 1.0 for p in points]
    return Series(np.array(kelvin), np.array(exposure), np.array(level), np.array(error), timed)


def _between_levels(points: list[OperatingPoint], settings: Sequence[SettingStatistics]) -> float:
    """How uncertain a median is that lies between two levels of the pixels; 0 where it does not.

    Half the pixels lie at another level where readout taps have black levels of their own.
    """
    here = [s for s in settings if s.point in points]
    lowest = min(here, key=lambda s: s.values["median"].value).values
    error = lowest["median"].se
    return error if "mean" in lowest and error > GAP * lowest["mean"].se else 0.0


def dark_signal(
    series: Series, black_level: float | None = None
) -> tuple[dict[str, Value], list[Value]]:
    """Pedestal, activation energies and doubling step of a series, and its dark rates, DN/s.

    The pedestal is that of bias frames (interpolated over temperature) where there are some, else
    one constant, fitted along with the rates, to which a recorded black level counts as one
    more measurement. What cannot be told is absent; no rates without a pedestal.
    """
    bias = series.timed & (series.exposure <= BIAS_SHARE * series.exposure.max())
    dark = ~bias
    if not dark.any() or (len(series.level) < 2 and black_level is None):
        return {}, []
    out: dict[str, Value] = {}
    if bias.any():
        pedestal = _bias_level(series, bias)
        pedestal_se = np.full(series.level.size, float(np.max(series.error[bias])))
        middle = float(np.mean(series.level[bias]))
        out["pedestal"] = Value(middle, max(float(pedestal_se[0]), float(np.ptp(pedestal)) / 4))
    else:
        fitted = _fit_pedestal(series, black_level)
        if fitted is None:
            return {}, []
        out["pedestal"] = fitted
        pedestal = np.full(series.level.size, fitted.value)
        pedestal_se = np.full(series.level.size, fitted.se)
    signal = series.level - pedestal
    error = np.hypot(series.error, pedestal_se)
    seconds = np.where(bias, np.inf, series.exposure)
    rates = [
        Value(float(r), float(e)) for r, e in zip(signal / seconds, error / seconds, strict=True)
    ]
    rates = [
        r if keep else Value(0.0, float(e)) for r, keep, e in zip(rates, dark, error, strict=True)
    ]
    told = dark & np.isfinite(series.kelvin) & (signal > HEADROOM * error)
    if tells_slope(series.kelvin[told]):
        rate = signal[told] / series.exposure[told]
        relative = np.hypot(error[told] / signal[told], RELATIVE_ERROR)
        out |= arrhenius_laws(series.kelvin[told], rate, relative)
    return out, rates


def _bias_level(series: Series, bias: np.ndarray) -> np.ndarray:
    known = bias & np.isfinite(series.kelvin)
    if not known.any() or not np.all(np.isfinite(series.kelvin)):
        return np.full(series.level.size, float(np.mean(series.level[bias])))
    order = np.argsort(series.kelvin[known], kind="stable")
    return np.interp(series.kelvin, series.kelvin[known][order], series.level[known][order])


def _fit_pedestal(series: Series, black_level: float | None) -> Value | None:
    """One constant under a dark signal t R(T): R free at each temperature, or an Arrhenius law.

    Free rates need two exposures at some temperature; the law needs three temperatures, far enough
    apart for a slope.
    """
    kelvin = np.where(np.isfinite(series.kelvin), series.kelvin, 0.0)
    temperatures, index = np.unique(np.round(kelvin), return_inverse=True)
    repeated = any(
        np.unique(series.exposure[index == k]).size > 1 for k in range(temperatures.size)
    )
    pinned = black_level is not None
    if repeated:
        design = np.zeros((series.level.size, 1 + temperatures.size))
        design[:, 0] = 1.0
        design[np.arange(series.level.size), 1 + index] = series.exposure
        return _linear_pedestal(design, series, black_level)
    if temperatures.size >= 3 and np.all(kelvin > 0) and tells_slope(kelvin):
        by_law = _law_pedestal(series, black_level)
        if by_law is not None:
            return by_law
    return (
        Value(float(black_level), BLACK_LEVEL_ERROR) if pinned and black_level is not None else None
    )


def _linear_pedestal(design: np.ndarray, series: Series, black_level: float | None) -> Value:
    """Weighted least squares; twice, for the error holds a share of the signal itself."""
    y = series.level
    if black_level is not None:
        design = np.vstack([design, np.eye(1, design.shape[1])])
        y = np.append(y, black_level)
    sigma = np.append(series.error, BLACK_LEVEL_ERROR)[: y.size]
    solution = np.zeros(design.shape[1])
    for _ in range(3):
        a = design / sigma[:, None]
        inverse = np.linalg.pinv(a.T @ a)
        solution = inverse @ (a.T @ (y / sigma))
        signal = design[: series.level.size, 1:] @ solution[1:]
        sigma[: series.level.size] = np.hypot(series.error, RELATIVE_ERROR * signal)
    scale = misfit((y - design @ solution) / sigma, design.shape[1])
    return Value(float(solution[0]), math.sqrt(float(inverse[0, 0])) * scale)


def _law_pedestal(series: Series, black_level: float | None) -> Value | None:
    level, error = series.level, series.error
    if float(np.ptp(level)) <= 5 * float(error.max()):
        return None
    sigma = np.hypot(error, RELATIVE_ERROR * (level - level.min()))
    x = activation(series.kelvin, float(np.median(series.kelvin)))
    known = None if black_level is None else (black_level, BLACK_LEVEL_ERROR)
    found = over_constant(x, series.exposure, level, sigma, ENERGIES_EV, known)
    return Value(found.constant, max(found.error * misfit(found.pulls, 3), 1e-6))


def hot_repeat(settings: Sequence[SettingStatistics]) -> Value | None:
    """Share of the hot pixels of the setting with fewer that are hot in the next one, too.

    Over successive settings (of one plane, in the order of operating points) that list at least
    20 hot pixels each in the curve ``hot_pixels``; None where there are none.
    """
    both, fewer = 0, 0
    known = [s for s in settings if s.curves.get("hot_pixels", np.empty(0)).size >= 20]
    for plane in dict.fromkeys(s.plane for s in known):
        listed = [s for s in known if s.plane == plane]
        for a, b in pairwise(listed):
            one, two = a.curves["hot_pixels"], b.curves["hot_pixels"]
            both += np.intersect1d(one, two, assume_unique=True).size
            fewer += min(one.size, two.size)
    if not fewer:
        return None
    share = both / fewer
    shrunk = (both + 1) / (fewer + 2)
    return Value(share, math.sqrt(shrunk * (1 - shrunk) / fewer))
