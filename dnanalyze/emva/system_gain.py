"""The overall system gain K: as recorded or given, else by photon transfer in the dark.

Dark charge is counted as light is: where the mean dark signal grows with exposure or temperature,
sigma2_y.dark = sigma2_0 + K (mu_y.dark - mu_0) (Janesick, Photon Transfer, SPIE 2007).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Value
from dnanalyze.emva import kinds
from dnanalyze.emva.fit import alike, common_slope
from dnanalyze.emva.quantity import Line, Quantity, known, unknown
from dnanalyze.emva.reading import Reading, reading

TOLD = 5.0  # standard errors that the slope stands above 0


def photon_transfer(
    temperatures: Sequence[tuple[float | None, Sequence[SettingStatistics]]],
    frame_error: float | None,
) -> tuple[Quantity, Line | None]:
    """Slope of the temporal variance over the mean dark signal.

    Where some temperature has several exposures, each temperature has an intercept of its own, for
    read noise and black level may depend on it; else the temperatures share one.

    Parameters
    ----------
    temperatures : sequence of (temperature, operating points)
        Unbiased ones, of one gain, channel and colour plane.
    frame_error : float, optional
        Standard deviation of the mean of a frame, DN.

    Returns
    -------
    Quantity
        DN/e-; not determined where the slope does not stand out by 5 standard errors, where no
        point is left to check it, or where that of typical pixels differs: then blinking pixels
        or hits have a share in the variance.
    Line or None
        What was fitted.
    """
    kind = kinds.TRANSFER
    each = [
        (number, reading(s))
        for number, (_, settings) in enumerate(temperatures)
        for s in settings
        if s.frames > 1
    ]
    each = [(n, r) for n, r in each if r.variance > 0]
    numbers = np.array([n for n, _ in each], int)
    readings = [r for _, r in each]
    exposed = any(
        len({r.point.exposure_s for n, r in each if n == one} - {None}) > 1 for one in set(numbers)
    )
    group = np.unique(numbers, return_inverse=True)[1] if exposed else np.zeros(numbers.size, int)
    parameters = (int(group.max()) + 2) if group.size else 2
    if numbers.size <= parameters:
        return unknown(kind, "too few operating points of two frames for photon transfer"), None
    repeats = np.sqrt([r.frames for r in readings])
    shaken = (frame_error or 0.0) / repeats
    every = _slope(readings, ("mean", "variance", "variance_error"), group, shaken)
    typical = _slope(readings, _TYPICAL, group, shaken)
    if every is None or typical is None:
        text = "the mean dark signal does not change, or the noise is not determined"
        return unknown(kind, text), None
    slope = every.slope
    if not slope.value > TOLD * slope.se:
        text = f"variance over mean has no clear slope ({slope.value:.2g} ± {slope.se:.1g} DN/e⁻)"
        return unknown(kind, text), None
    if not alike(slope, typical.slope):
        text = (
            f"variance over mean gives {slope.value:.3g} DN/e⁻ for all pixels, "
            f"{typical.slope.value:.3g} for typical ones: noise other than shot noise grows with "
            "the signal"
        )
        return unknown(kind, text), None
    over = "exposure" if exposed else "temperature"
    return known(kind, slope, f"photon transfer over {over}"), every


_TYPICAL = ("typical_level", "typical_variance", "typical_error")


def _slope(
    readings: Sequence[Reading], names: tuple[str, str, str], group: np.ndarray, shaken: np.ndarray
) -> Line | None:
    """Line of a variance over a level, all groups shifted to the intercept of the first.

    ``names`` are those of level, variance and its error in a reading; ``shaken`` is the error of
    the level because frames drift, DN.
    """
    x, y, error = (np.array([getattr(r, name) for r in readings]) for name in names)
    if not (np.all(np.isfinite(y)) and np.all(error > 0)):
        return None
    found = common_slope(x, y, error, group)
    if found is None:
        return None
    widened = error
    for _ in range(2):  # errors of the abscissa count by the slope
        widened = np.hypot(error, found[1].value * shaken)
        found = common_slope(x, y, widened, group) or found
    intercepts, slope = found
    shifted = y - np.array([intercepts[g].value for g in group]) + intercepts[0].value
    return Line(
        tuple(x.tolist()), tuple(shifted.tolist()), tuple(widened.tolist()), intercepts[0], slope
    )


def system_gain(
    given: float | None, recorded: float | None, alone: bool, transfer: Quantity
) -> Quantity:
    """K, and in its note where it comes from.

    Parameters
    ----------
    given : float, optional
        By the user, DN/e-.
    recorded : float, optional
        By the files, DN/e-.
    alone : bool
        Whether the captures hold one gain and channel only; else one K is not that of all.
    transfer : Quantity
        What photon transfer tells.
    """
    for value, note in ((given, "given"), (recorded, "recorded in files")):
        if value is not None and alone:
            return known(kinds.GAIN, Value(value, 0.0), note)
    return transfer
