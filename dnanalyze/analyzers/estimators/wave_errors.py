"""Errors of statistics where a wave runs through the frames, its phase another in each.

K phases are few: how much of the wave's power c = A^2 / 2 is left in their mean has the standard
deviation c sqrt(1 - 1/K) / K, and what two frames share of it varies as the cosine of their phases
apart. Whole frames move together so, which no count of pixels tells.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from dnanalyze.analyzers.statistics import Value

_CHANCE = 0.1  # c/px; the frequency of a peak that chance made is told no better
_CLIPPED = 0.7  # share of a wave's effect on memory that a median over pixels keeps
_BLUNT = 0.35  # and that is left where variances are told over their mean
_QUARTILE = 0.6745
_STEP = 0.3  # how far a peak of chance and one of a wave differ in the share that is in step

Values = dict[str, Value]


def widened(values: Values, frames: int) -> Values:
    """The values with the error of a wave's phases; as they are where there is no wave.

    Parameters
    ----------
    values : dict
        Of one setting. The line of its temporal spectrum tells the wave.
    frames : int

    Returns
    -------
    dict
        The same names; errors are not smaller.
    """
    needed = ("temporal_line_u", "temporal_line_amplitude", "temporal_noise", "pattern_noise")
    if frames < 2 or any(name not in values for name in needed):
        return values
    if values["temporal_line_u"].se > _CHANCE:
        return values
    power = values["temporal_line_amplitude"].value ** 2 / 2.0
    return {
        name: Value(v.value, math.hypot(v.se, _moves(name, values, power, frames)))
        for name, v in values.items()
    }


def _moves(name: str, values: Values, power: float, frames: int) -> float:
    """Standard deviation of a statistic's coordinate through the phases alone."""
    starts = next((law for start, law in _LAWS.items() if name.startswith(start)), None)
    law = _WHOLE_NAMES.get(name, starts)
    return law(name, values, power, frames) if law is not None else 0.0


def _bands(name: str, values: Values, frames: int) -> float:
    """Log of how far the power of the band that holds the wave may lie above the measured one.

    What is left of the wave is exponential: where it happens to be little, the measurement does not
    tell that it could be more.
    """
    kind, _, band = name.removeprefix("pattern_").partition("_")
    at = {
        "psd": math.hypot(values["temporal_line_u"].value, values["temporal_line_v"].value),
        "u": values["temporal_line_u"].value,
        "v": abs(values["temporal_line_v"].value),
    }[kind]
    low, _, high = band.partition("_")
    if not high or not float(low) <= at < float(high):
        return 0.0
    alike = [v.value for n, v in values.items() if n.startswith(f"temporal_{kind}_")]
    left = (values[f"temporal_{kind}_{band}"].value - min(alike)) / frames
    return math.log1p(left / values[name].value)


def _line(values: Values, power: float, frames: int) -> float:
    """Ratio at which what is left of the wave stands over the floor, times that of the peak."""
    amplitude = values["pattern_line_amplitude"].value
    return 2.0 * power / frames / amplitude**2 if amplitude > 0 else 0.0


def _left(power: float, frames: int) -> float:
    """Standard deviation of the wave's power in the mean of the frames, DN^2."""
    return power * math.sqrt(1.0 - 1.0 / frames) / frames


def _of_temporal(values: Values, power: float, frames: int) -> float:
    """Relative, of the variance between frames."""
    return _left(power, frames) * frames / (frames - 1) / values["temporal_noise"].value ** 2


def _of_pattern(values: Values, power: float, frames: int) -> float:
    """Relative, of the variance of the pattern."""
    return _left(power, frames) / values["pattern_noise"].value ** 2


def _of_pairs(power: float, pairs: float, variance: float) -> float:
    """Relative, of the mean square of so many differences: cosines have the variance 1/2."""
    return power / math.sqrt(2.0 * pairs) / variance


def _differences(values: Values, power: float, frames: int) -> float:
    return _of_pairs(power, frames - 1, values["temporal_noise"].value ** 2)


def _ends(values: Values, power: float, frames: int) -> float:
    """Of the first difference and the last."""
    return _of_pairs(power, min(frames - 1, 2), values["temporal_noise"].value ** 2)


def _pattern_quantile(name: str, values: Values, power: float, frames: int) -> float:
    """-1/2 p'/p for each DN^2 more of variance; of a Gaussian as wide as this side's quartile.

    Beyond the upper decile, in the tail of hot pixels, the density falls too slowly to be moved.
    """
    level = float(name.removeprefix("pattern_q"))
    quarter = values.get("pattern_q0.25" if level < 0.5 else "pattern_q0.75")
    if quarter is None or not quarter.value or level > 0.95:
        return 0.0
    width = quarter.value / _QUARTILE
    return 0.5 * _left(power, frames) * abs(values[name].value) / width**2


def _correlation(name: str, values: Values, power: float, frames: int) -> float:
    whole = values["temporal_noise"].value ** 2 + values["pattern_noise"].value ** 2
    return _of_pairs(power, frames - 1, whole)


_LAWS: dict[str, Callable[[str, Values, float, int], float]] = {
    "temporal_noise_core": lambda name, v, c, k: _ends(v, c, k) / 2,
    "temporal_noise": lambda name, v, c, k: _of_temporal(v, c, k) / 2,
    "temporal_q": lambda name, v, c, k: abs(v[name].value) * _differences(v, c, k) / 2,
    "temporal_kurtosis": lambda name, v, c, k: _ends(v, c, k),
    "temporal_r1": lambda name, v, c, k: _CLIPPED * _differences(v, c, k),
    "temporal_variance_q": lambda name, v, c, k: _BLUNT * _of_temporal(v, c, k),
    "blink_repeat": lambda name, v, c, k: _BLUNT * _differences(v, c, k),
    "noise_at_": lambda name, v, c, k: _left(c, k) * k / (k - 1) / v[name].value,
    "pattern_correlation": _correlation,
    "pattern_corr_": lambda name, v, c, k: _of_pattern(v, c, k),
    "pattern_pmax8": lambda name, v, c, k: _of_pattern(v, c, k),
    "pattern_pmin8": lambda name, v, c, k: _of_pattern(v, c, k),
    "pattern_noise_core": lambda name, v, c, k: _left(c, k) / v[name].value ** 2 / 2,
    "pattern_noise": lambda name, v, c, k: _of_pattern(v, c, k) / 2,
    "pattern_q": _pattern_quantile,
    "pattern_psd_": lambda name, v, c, k: _bands(name, v, k),
    "pattern_u_": lambda name, v, c, k: _bands(name, v, k),
    "pattern_v_": lambda name, v, c, k: _bands(name, v, k),
}
_WHOLE_NAMES: dict[str, Callable[[str, Values, float, int], float]] = {
    "pattern_line": lambda name, v, c, k: math.log1p(_line(v, c, k)),
    "pattern_line_in_step": lambda name, v, c, k: _STEP * (1.0 - 1.0 / (1.0 + _line(v, c, k))),
}
