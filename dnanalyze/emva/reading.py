"""What the fits take from the statistics of one operating point: mean, variance, their errors.

Errors here are those of repeating the measurement on this sensor: its pixels are the same at all
operating points, so that their scatter is none of a slope.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.statistics import SATURATION, SettingStatistics
from dnanalyze.loaders.captures import OperatingPoint

CLIPPED = 0.005  # share of the values at an end code from which mean and noise are biased
STRAYS = 20  # values at an end code that say nothing
NOISE_GROUPS = (
    (0.5, "noise_at_50"),
    (0.09, "noise_at_90"),
    (0.009, "noise_at_99"),
    (0.001, "noise_at_999"),
)


@dataclass(frozen=True)
class Reading:
    """Mean dark signal and temporal variance of one operating point.

    Parameters
    ----------
    point : OperatingPoint
    frames : int
    mean : float
        Over pixels and frames, DN.
    drift : float
        Standard deviation of the frame means, DN; NaN for one frame.
    variance, variance_error : float
        Mean temporal variance of the pixels without the drift of whole frames, DN^2, and its
        standard error; NaN for one frame.
    typical_variance, typical_error : float
        Squared robust noise of the differences between frames, DN^2, and its error.
    """

    point: OperatingPoint
    frames: int
    mean: float
    drift: float
    variance: float
    variance_error: float
    typical_variance: float
    typical_error: float


def reading(setting: SettingStatistics) -> Reading:
    """From the statistics of an operating point."""
    values = setting.values

    def value(name: str) -> float:
        return values[name].value if name in values else math.nan

    drift = value("drift")
    variance = value("s2_temporal")
    core = value("temporal_noise_core") ** 2
    core_error = 2 * core * values["temporal_noise_core"].se if core > 0 else math.nan
    return Reading(
        setting.point, setting.frames, value("mean"), drift, variance, _variance_error(setting),
        core, core_error,
    )  # fmt: skip


def _variance_error(setting: SettingStatistics) -> float:
    """Of the mean of the pixels' variances over K frames: sqrt(2 E[sigma^4] / ((K - 1) pixels))."""
    values, frames = setting.values, setting.frames
    if frames < 2 or "s2_temporal" not in values:
        return math.nan
    mean = values["s2_temporal"].value
    fourth = mean**2
    if all(name in values for _, name in NOISE_GROUPS):
        known = [(share, values[name].value) for share, name in NOISE_GROUPS]
        rest_share = 1 - sum(share for share, _ in known)
        rest = max(mean - sum(share * v for share, v in known), 0.0) / rest_share
        fourth = sum(share * v**2 for share, v in [*known, (rest_share, rest)])
    pixels = setting.shape[0] * setting.shape[1]
    return max(math.sqrt(2 * fourth / ((frames - 1) * pixels)), 1e-9)


def biased(setting: SettingStatistics) -> str:
    """Why mean and noise of an operating point are not the sensor's; empty where they are."""
    if SATURATION in setting.missing:
        return setting.missing[SATURATION].split("; excluded")[0]
    low, high = clipped_shares(setting)
    for share, which in ((low, "lowest"), (high, "highest")):
        if share > CLIPPED:
            return f"{100 * share:.2g} % of the values lie at the {which} code: clipped"
    return ""


def clipped_shares(setting: SettingStatistics) -> tuple[float, float]:
    """Shares of the values that pile up at the lowest and at the highest code; 0 for none."""
    counts = _counts(setting)
    if counts.size < 2:
        return 0.0, 0.0
    total = float(counts.sum())
    ends = ((counts[0], counts[1]), (counts[-1], counts[-2]))
    low, high = (float(end) / total if end > max(STRAYS, beside) else 0.0 for end, beside in ends)
    return low, high


def code_step(setting: SettingStatistics) -> float:
    """Distance of the codes in use, DN; 0 for values that are no codes."""
    lattice = setting.values.get("lattice")
    codes = setting.curves.get("histogram_codes")
    if lattice is None or lattice.value < 0.999 or codes is None:
        return 0.0
    used = np.rint(np.asarray(codes, float)[np.asarray(setting.curves["histogram_counts"]) > 0])
    return float(np.gcd.reduce(np.diff(used).astype(np.int64))) if used.size > 1 else 1.0


def _counts(setting: SettingStatistics) -> np.ndarray:
    lattice = setting.values.get("lattice")
    counts = np.asarray(setting.curves.get("histogram_counts", ()))
    whole = lattice is not None and lattice.value >= 0.999
    return counts[counts > 0] if whole else np.empty(0)
