"""The quantities of one operating point."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from scipy import special

from dnanalyze.analyzers.estimators.arrhenius import misfit
from dnanalyze.analyzers.families.tails import MOST_LISTED
from dnanalyze.analyzers.statistics import SettingStatistics, Value
from dnanalyze.emva import kinds
from dnanalyze.emva.quantity import Kind, PointQuantities, Quantities, Quantity, known, unknown
from dnanalyze.emva.reading import biased, code_step, reading

LEAST_VARIANCE = 0.24  # DN^2 for a step of 1 DN: below it quantization rules (EMVA 1288, 6.2)
LIMIT = 0.40  # DN: upper limit of the dark noise there
SLOPE_BAND = (0.005, 0.05)  # cycles/pixel
FEWEST_MODES = 8
SURE_DEVIATIONS = 6.0  # standard deviations, above which the 5 of the list are surely passed
HOT_TIMES = 10.0  # median dark current, from which a pixel counts as hot
ONE_FRAME = "one frame does not separate temporal noise from DSNU"


def quantities(setting: SettingStatistics, gain: Quantity) -> PointQuantities:
    """All quantities of an operating point.

    Parameters
    ----------
    setting : SettingStatistics
    gain : Quantity
        Overall system gain K, DN/e-; may be not determined.
    """
    bad = biased(setting)
    items: list[Quantity] = []
    items.append(_mean(setting, bad))
    items += _noise(setting, bad, gain)
    for name, kind in kinds.PARTS.items():
        found = _of(setting, name, kind, bad)
        items += [found, found.scaled(kinds.IN_ELECTRONS[kind], gain)]
    items.append(_skewness(setting, bad))
    items += _slopes(setting, bad)
    items += [_hot_share(setting), _hot_current(setting, bad)]
    return PointQuantities(setting.point, setting.plane, setting.frames, Quantities(tuple(items)))


def _of(setting: SettingStatistics, name: str, kind: Kind, bad: str) -> Quantity:
    """A statistic as a quantity; its error in plain units."""
    if bad:
        return unknown(kind, bad)
    value = setting.values.get(name)
    if value is None:
        one = ONE_FRAME if setting.frames < 2 else "the frames are too small"
        return unknown(kind, one if setting.frames < 2 else setting.missing.get(name, one))
    return known(kind, value)


def _mean(setting: SettingStatistics, bad: str) -> Quantity:
    return _of(setting, "mean", kinds.MEAN, bad)


def _noise(setting: SettingStatistics, bad: str, gain: Quantity) -> Iterable[Quantity]:
    """sigma_y.dark, without the drift of whole frames; sigma_d, without quantization, in e-."""
    found = _of(setting, "temporal_noise", kinds.NOISE, bad)
    if not found.determined:
        return found, unknown(kinds.NOISE_E, found.reason)
    read = reading(setting)
    step = code_step(setting)
    if read.variance <= 0:
        text = "the frames are equal, or differ only by the drift of whole frames"
        return unknown(kinds.NOISE, text), unknown(kinds.NOISE_E, text)
    noise = math.sqrt(read.variance)
    # of the pixels alone, for whole frames that drift are no part of it
    spatial = setting.values.get("s2_temporal", Value(math.nan, 0.0)).se
    se = max(spatial, read.variance_error) / (2 * noise)
    made = known(kinds.NOISE, Value(noise, se))
    if read.variance < LEAST_VARIANCE * step**2:
        limit = LIMIT * step
        text = f"σ² below {LEAST_VARIANCE:g} step²: quantization dominates; noise < {limit:g} DN"
        if gain.value:
            text += f", {limit / gain.value:.3g} e⁻"
        return unknown(kinds.NOISE, text), unknown(kinds.NOISE_E, text)
    free = math.sqrt(read.variance - step**2 / 12)
    unquantized = known(kinds.NOISE, Value(free, se * noise / free))
    return made, unquantized.scaled(kinds.NOISE_E, gain)


def _skewness(setting: SettingStatistics, bad: str) -> Quantity:
    if setting.frames >= 2:
        return _of(setting, "pattern_skewness", kinds.SKEWNESS, bad)
    found = setting.values.get("frame_skewness")
    if bad or found is None:
        return unknown(kinds.SKEWNESS, bad or "the frame is constant")
    return known(kinds.SKEWNESS, found, "of a single frame, temporal noise included")


def _slopes(setting: SettingStatistics, bad: str) -> Iterable[Quantity]:
    parts = (("spatial", "pattern", 1.0), ("temporal", "temporal", setting.frames - 1.0))
    for name, part, repeats in parts:
        yield _of(setting, f"{part}_slope_low", kinds.SLOPES[name], bad)
        for lines, axis in (("rows", "row"), ("columns", "column")):
            kind = kinds.SLOPES[f"{name}_{lines}"]
            if bad or setting.frames < 2:
                yield unknown(kind, bad or ONE_FRAME)
                continue
            yield _line_slope(setting, kind, part, axis, repeats)


def _line_slope(
    setting: SettingStatistics, kind: Kind, part: str, axis: str, repeats: float
) -> Quantity:
    """Slope of ln power over ln frequency of the line means, from .005 to .05 cycles/pixel."""
    f = np.asarray(setting.curves.get(f"{axis}_spectrum_f", ()), float)
    power = np.asarray(setting.curves.get(f"{part}_{axis}_spectrum", ()), float)
    good = np.zeros(0, bool)
    if f.size == power.size:
        good = (f >= SLOPE_BAND[0]) & (f <= SLOPE_BAND[1]) & (power > 0)
    if good.sum() < FEWEST_MODES:
        low, high = SLOPE_BAND
        text = f"fewer than {FEWEST_MODES} modes from {low:g} to {high:g} cycles/pixel"
        return unknown(kind, text)
    x, y = np.log(f[good]), np.log(power[good])
    x = x - x.mean()
    slope = float(x @ y) / float(x @ x)
    spread = math.sqrt(float(special.polygamma(1, repeats)))
    wider = misfit((y - y.mean() - slope * x) / spread, 2)
    return known(kind, Value(slope, spread * wider / math.sqrt(float(x @ x))))


def _hot_share(setting: SettingStatistics) -> Quantity:
    """Pixels of the mean dark image above its median by more than 5 robust standard deviations."""
    name, factor = ("hot_density_pattern", 1e-4) if setting.frames > 1 else ("frame_above_5", 100.0)
    found = setting.values.get(name)
    if found is None:
        return unknown(kinds.HOT_5, setting.missing.get(name, "not counted"))
    note = "" if setting.frames > 1 else "of a single frame, temporal noise included"
    return known(kinds.HOT_5, Value(found.value * factor, found.se * factor), note)


def _hot_current(setting: SettingStatistics, bad: str) -> Quantity:
    """Pixels whose dark current exceeds 10 times the median one."""
    kind = kinds.HOT_CURRENT
    rate, exposure = setting.values.get("dark_rate_dn_s"), setting.point.exposure_s
    levels = setting.curves.get("hot_levels")
    if bad:
        return unknown(kind, bad)
    if setting.frames < 2:
        return unknown(kind, ONE_FRAME)
    if rate is None or exposure is None or exposure <= 0 or levels is None:
        return unknown(kind, "the black level or the exposure is not known")
    if rate.value <= 4 * rate.se:
        return unknown(kind, "the median dark current is not significant")
    above = (HOT_TIMES - 1) * rate.value * exposure
    threshold = setting.values["median"].value + above
    if not _all_listed(setting, levels, threshold, above):
        return unknown(kind, "the threshold lies within the noise of the mean dark image")
    pixels = setting.shape[0] * setting.shape[1]
    count = float(np.count_nonzero(levels > threshold))
    moved = (HOT_TIMES - 1) * rate.se * exposure
    fewer, more = (np.count_nonzero(levels > threshold + d) for d in (moved, -moved))
    se = math.hypot(math.sqrt(count + 1), float(more - fewer) / 2)
    return known(kind, Value(100 * count / pixels, 100 * se / pixels))


def _all_listed(
    setting: SettingStatistics, levels: np.ndarray, threshold: float, above: float
) -> bool:
    """Whether the list, of pixels 5 robust standard deviations up, has all above a threshold."""
    if levels.size and threshold >= float(np.min(levels)):
        return True
    core = setting.values.get("pattern_noise_core")
    return levels.size < MOST_LISTED and core is not None and above > SURE_DEVIATIONS * core.value
