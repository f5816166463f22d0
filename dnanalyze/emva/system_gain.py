"""The overall system gain K: as recorded or given, else by photon transfer in the dark.

Dark charge is counted as light is: where the mean dark signal grows with exposure or temperature,
sigma2_y.dark = sigma2_0 + K (mu_y.dark - mu_0) (Janesick, Photon Transfer, SPIE 2007).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dnanalyze.analyzers.estimators.arrhenius import misfit
from dnanalyze.analyzers.statistics import SettingStatistics, Value
from dnanalyze.emva import kinds
from dnanalyze.emva.fit import AGREES, SURE, alike, common_slope
from dnanalyze.emva.noise_covariance import covariances, shared
from dnanalyze.emva.quantity import Kind, Line, Quantity, known, unknown
from dnanalyze.robust import robust_deviation

TOLD = 5.0  # standard errors that the slope stands above 0
# Columns of the points of a curve: abscissa, ordinate, their errors; numbers of what may have an
# intercept of its own; whether of typical pixels; pixels; exposure; `covariances` of typical ones.
LEVEL, VARIANCE, ERROR, LEVEL_ERROR, ALL, EXPOSED, POINT, TYPICAL, PIXELS, EXPOSURE = range(10)
SHARED = slice(10, 14)
FEWEST = 3  # points: a line and a check of it
STEADY = 0.5  # of the squared level, see `_of_charge`
GROWN = 2.0  # over the least level of hot pixels, see `_of_charge`
# Of the covariances: correlations are of pixels that are not noisy, variances of those that are not
# bright. Of charge with a spread of 1 that makes 14 % (RESULTS), of less spread less.
SHARED_UNLIKE = 0.1
OUTLYING_LEVEL = 4.0  # robust standard deviations from which a level is left out


def photon_transfer(
    temperatures: Sequence[tuple[float | None, Sequence[SettingStatistics]]],
    frame_error: float | None,
) -> tuple[Quantity, Line | None]:
    """Slope of the temporal variance over the mean dark signal.

    Two lines are fitted: over the typical pixels of the operating points, and over the levels
    within the operating points, where hot pixels hold more charge. Where both are determined they
    must agree; all points together then give the gain. Pixels with telegraph noise and hits are
    left out of a level, and a few levels of the fit. Where adjacent pixels share noise that grows
    with the signal, their covariances count (`noise_covariance`); where that is not clear, its
    standard error does.

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
        point is left to check it, or where the two lines differ.
    Line or None
        What was fitted.
    """
    kind = kinds.TRANSFER
    points = _points(temperatures, frame_error or 0.0)
    if len(points) < FEWEST:
        text = "too few operating points of two frames that move by less than their noise"
        return unknown(kind, text), None
    together = EXPOSED if _exposed(points) else ALL
    usual = points[points[:, TYPICAL] == 1]
    typical = _plain_line(usual, together)
    if typical is None or not _stands_out(typical):
        return _of_lines(kind, typical, points, together)
    group = np.unique(usual[:, together], return_inverse=True)[1]
    common = shared(usual[:, LEVEL], usual[:, SHARED], group)
    if common is None:
        return _of_lines(kind, typical, points, together)
    if common.filtered:
        text = "pixels two apart share noise that grows with the signal: a filter, or tracks"
        return unknown(kind, text), None
    if common.coupled:
        return _coupled(kind, usual, together, common.near.value)
    found, line = _of_lines(kind, typical, points, together)
    if found.se is not None:
        found = replace(found, se=float(np.hypot(found.se, common.near.se)))
    return found, line


def _of_lines(
    kind: Kind, typical: Line | None, points: np.ndarray, together: int
) -> tuple[Quantity, Line | None]:
    """The gain by the lines over operating points and over hot pixels, which must agree."""
    points = points[_of_charge(points)]
    within = _robust_line(points, POINT)
    found = {"operating points": typical, "hot pixels": within}
    clear = {k: f for k, f in found.items() if f is not None and _stands_out(f)}
    bent = [k for k, f in clear.items() if _curvature(f) > 2.0 * AGREES]
    if bent:
        text = (
            f"the temporal variance over {bent[0]} is no straight line over the mean: noise other "
            "than shot noise grows with the signal"
        )
        return unknown(kind, text), None
    if not clear:
        line = typical or within
        if line is None:
            text = "the mean dark signal does not change, or the noise is not determined"
            return unknown(kind, text), None
        text = f"{line.slope.value:.2g} ± {line.slope.se:.1g} DN/e⁻"
        return unknown(kind, f"variance over mean has no clear slope ({text})"), None
    if len(clear) == 1:
        ((over, line),) = clear.items()
        return known(kind, line.slope, f"photon transfer over {over}"), line
    assert typical is not None
    assert within is not None
    if not alike(typical.slope, within.slope):
        text = (
            f"variance over mean gives {typical.slope.value:.3g} DN/e⁻ over the operating points, "
            f"{within.slope.value:.3g} over hot pixels: noise other than shot noise grows with "
            "the signal"
        )
        return unknown(kind, text), None
    both = _robust_line(points, together) or typical
    return known(kind, both.slope, "photon transfer over operating points and hot pixels"), both


def _points(
    temperatures: Sequence[tuple[float | None, Sequence[SettingStatistics]]], frame_error: float
) -> np.ndarray:
    """The levels of all operating points, (levels, columns)."""
    rows, number = [], 0
    for temperature, (_, settings) in enumerate(temperatures):
        for s in settings:
            levels = s.curves.get("photon_transfer")
            if levels is None or s.frames < 2:
                continue
            shaken = frame_error / np.sqrt(s.frames)
            for n, (level, variance, error, pixels) in enumerate(np.asarray(levels, float)):
                own = level, variance, error, shaken, 0, temperature, number, n == 0, pixels
                exposure = s.point.exposure_s
                common = covariances(s, variance)
                rows.append((*own, np.nan if exposure is None else exposure, *common))
            number += 1
    found = np.array(rows, float).reshape(-1, SHARED.stop)
    return found[found[:, VARIANCE] > 0]


def _coupled(
    kind: Kind, points: np.ndarray, together: int, near: float
) -> tuple[Quantity, Line | None]:
    """The gain of typical pixels that share noise with adjacent ones; hot pixels do not count.

    What a hot pixel shares is less: of its charge it keeps the share 1 - 4 a, of its shot noise
    the square, so that the slope over hot pixels is low by 4 a, that over typical pixels by 8 a.
    ``near``: slope of the covariances, DN/e-.
    """
    whole = points.copy()
    whole[:, VARIANCE] += points[:, SHARED.start]
    whole[:, ERROR] = np.hypot(points[:, ERROR], points[:, SHARED.start + 1])
    line = _plain_line(whole, together)
    if line is None or not _stands_out(line) or _curvature(line) > 2.0 * AGREES:
        text = "adjacent pixels share noise that grows with the signal, not in proportion to it"
        return unknown(kind, text), None
    note = "photon transfer over operating points, with the covariances of adjacent pixels"
    se = float(np.hypot(line.slope.se, SHARED_UNLIKE * near))
    return known(kind, Value(line.slope.value, se), note), line


def _of_charge(points: np.ndarray) -> np.ndarray:
    """Which levels are of typical pixels, or of hot ones whose level is charge that is counted.

    The hot pixels of an operating point count where their level in all is twice that of the
    operating point with the least: else most of it may be an offset, which has no shot noise. A
    pixel that is bright in one of its frames, or half of the time, has a variance of its squared
    level at least: levels of more than half of that are of hits and telegraph noise.
    """
    numbers = points[:, POINT].astype(int)
    centre = np.full(numbers.max() + 1, np.nan)
    typical = points[:, TYPICAL] == 1
    centre[numbers[typical]] = points[typical, LEVEL]
    above = points[:, LEVEL] - centre[numbers]
    steady = points[:, VARIANCE] <= STEADY * above**2
    total = np.bincount(numbers, np.where(typical | ~steady, 0.0, above * points[:, PIXELS]))
    charged = total > GROWN * total[np.unique(numbers)].min()
    return typical | (steady & charged[numbers])


def _exposed(points: np.ndarray) -> bool:
    """Whether some temperature has several exposures.

    Each temperature then has an intercept of its own, for read noise and black level may depend on
    it; else the temperatures share one.
    """
    timed = np.isfinite(points[:, EXPOSURE])
    return any(
        np.unique(points[(points[:, EXPOSED] == t) & timed, EXPOSURE]).size > 1
        for t in np.unique(points[:, EXPOSED])
    )


def _curvature(line: Line) -> float:
    """Change of the slope from end to end over the slope, where it stands out; else 0.

    Twice `AGREES` at most, for the slopes of the two halves then differ by that share.
    """
    x, y, error = (np.array(v) for v in (line.x, line.y, line.error))
    if np.unique(x).size < 4:
        return 0.0
    at = (x - x.min()) / np.ptp(x)
    design = np.stack([np.ones_like(at), at, at**2], axis=1) / error[:, None]
    inverse = np.linalg.pinv(design.T @ design)
    solution = inverse @ (design.T @ (y / error))
    wider = misfit(y / error - design @ solution, 3)
    curve, se = float(solution[2]), float(np.sqrt(inverse[2, 2])) * wider
    if abs(curve) < SURE * se:
        return 0.0
    return abs(2.0 * curve) / max(abs(float(solution[1] + solution[2])), 1e-30)


def _stands_out(line: Line) -> bool:
    return line.slope.value > TOLD * line.slope.se


def _robust_line(points: np.ndarray, by: int) -> Line | None:
    """Line through levels, all groups shifted to the intercept of the first.

    Levels that lie off by 4 robust standard deviations are left out, while half of them stay.
    """
    kept = np.ones(len(points), bool)
    found = None
    for _ in range(5):
        here = points[kept]
        group = np.unique(here[:, by], return_inverse=True)[1]
        if len(here) < int(group.max(initial=0)) + FEWEST:
            return found
        found, off = _line(here, group)
        if found is None:
            return None
        spread = max(robust_deviation(off, 0.0), 1.0)
        good = np.abs(off) <= OUTLYING_LEVEL * spread
        if good.all() or 2 * (kept.sum() - np.count_nonzero(~good)) < len(points):
            return found
        kept[np.flatnonzero(kept)[~good]] = False
    return found


def _plain_line(points: np.ndarray, by: int) -> Line | None:
    """Line through all of the points, with one that checks it."""
    group = np.unique(points[:, by], return_inverse=True)[1]
    enough = len(points) >= int(group.max(initial=0)) + FEWEST
    return _line(points, group)[0] if enough else None


def _line(points: np.ndarray, group: np.ndarray) -> tuple[Line | None, np.ndarray]:
    """The line, and how far each level lies off it, in standard errors."""
    x, y, error = points[:, LEVEL], points[:, VARIANCE], points[:, ERROR]
    found = common_slope(x, y, error, group)
    if found is None:
        return None, np.empty(0)
    widened = error
    for _ in range(2):  # errors of the abscissa count by the slope
        widened = np.hypot(error, found[1].value * points[:, LEVEL_ERROR])
        found = common_slope(x, y, widened, group) or found
    intercepts, slope = found
    own = np.array([intercepts[g].value for g in group])
    shifted = y - own + intercepts[0].value
    line = Line(
        tuple(x.tolist()), tuple(shifted.tolist()), tuple(widened.tolist()), intercepts[0], slope
    )
    return line, (y - own - slope.value * x) / widened


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
