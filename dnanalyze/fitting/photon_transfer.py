"""The conversion gain from how the noise varies over the field with the level."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.loaders.captures import OperatingPoint

TOLD = 5.0  # standard errors that a slope must stand above 0
FEWEST = 32  # blocks


def gain_over_field(measured: Sequence[Statistics], reference: OperatingPoint) -> float | None:
    """Slope of the temporal variance of blocks over their mean level: photon transfer in the dark.

    Where the charge is shaded (a warm side, a glow, rows that wait), its counting noise is too,
    whatever the pedestal and the read noise are. Shaded offsets have none: they make the slope too
    small. Theil and Sen's slope, which few blocks with defects do not bend.

    Parameters
    ----------
    measured : sequence of Statistics
        Of the parts of the field; their curves ``block_means``, DN, and ``noise_blocks``, DN^2.
    reference : OperatingPoint
        Whose gain the conversion gain is stated at.

    Returns
    -------
    float or None
        DN/e-, the mean over settings; None where none of the slopes stands out.
    """
    slopes, errors = [], []
    for parts in zip(*(s.settings for s in measured), strict=True):
        found = _slope(parts)
        if found is not None:
            gain = (parts[0].point.gain or 1.0) / (reference.gain or parts[0].point.gain or 1.0)
            slopes.append(found[0] / gain)
            errors.append(found[1] / gain)
    if not slopes:
        return None
    weight = np.array(errors) ** -2.0
    mean, error = float(np.average(slopes, weights=weight)), float(weight.sum()) ** -0.5
    return mean if mean > TOLD * error else None


def _slope(parts: Sequence[SettingStatistics]) -> tuple[float, float] | None:
    """Slope of a setting, DN, and its standard error."""
    from scipy.stats import theilslopes

    if not all({"block_means", "noise_blocks"} <= set(p.curves) for p in parts):
        return None
    level, noise = (
        np.concatenate([p.curves[name].ravel() for p in parts])
        for name in ("block_means", "noise_blocks")
    )
    good = np.isfinite(level) & np.isfinite(noise)
    if good.sum() < FEWEST or np.ptp(level[good]) == 0:
        return None
    slope, _, low, high = theilslopes(noise[good], level[good], alpha=0.6827)
    return float(slope), max(float(high - low) / 2.0, 1e-12)
