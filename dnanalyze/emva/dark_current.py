"""Dark current: slope of the mean dark signal over exposure (EMVA 1288, 7.1), and of its variance.

mu_y.dark(t) = mu_y.dark.0 + K mu_I t and sigma2_y.dark(t) = sigma2_y.dark.0 + K^2 mu_I t: the
slope of the mean in DN/s over K, and that of the variance in DN^2/s over K^2, are the dark current
in e-/s.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Value
from dnanalyze.emva import kinds
from dnanalyze.emva.fit import alike, line
from dnanalyze.emva.quantity import DarkCurrent, Line, Quantities, Quantity, known, unknown
from dnanalyze.emva.reading import Reading, reading
from dnanalyze.loaders.thermometer import clusters

NOT_LINEAR = 0.05  # of the span of the signal, from which a deviation from the line is told
OUTLYING_LEVEL = 4.0  # standard errors
ONE_EXPOSURE = "one exposure, and the black level is not known"
NO_EXPOSURE = "the exposure is not known"
NEGATIVE = 10.0  # standard errors, beyond which no statistic explains a negative dark current
NO_SCATTER = "two exposures of one frame each: no uncertainty"


def by_temperature(
    settings: Sequence[SettingStatistics],
) -> list[tuple[float | None, list[SettingStatistics]]]:
    """Operating points of like temperature (1.5 C), rising; those of unknown temperature first."""
    unknown_t = [s for s in settings if s.point.temperature_c is None]
    out: list[tuple[float | None, list[SettingStatistics]]] = []
    if unknown_t:
        out.append((None, unknown_t))
    told = [(s.point.temperature_c, s) for s in settings if s.point.temperature_c is not None]
    told.sort(key=lambda item: item[0])
    for first, last in clusters(np.array([t for t, _ in told])):
        part = told[first:last]
        out.append((float(np.mean([t for t, _ in part])), [s for _, s in part]))
    return out


def dark_current(
    temperature_c: float | None,
    settings: Sequence[SettingStatistics],
    frame_error: float | None,
    gain: Quantity,
    black_known: bool = True,
) -> DarkCurrent:
    """The dark current of operating points of one temperature.

    Parameters
    ----------
    temperature_c : float, optional
    settings : sequence of SettingStatistics
        Unbiased ones, of one gain, channel and colour plane.
    frame_error : float, optional
        Standard deviation of the mean of one frame, DN; None where no operating point has two.
    gain : Quantity
        Overall system gain K, DN/e-. ``note`` says where it came from.
    black_known : bool
        Whether the black level is recorded or told by other exposures. Else it comes from the law
        over temperature, and single frames, whose saturation does not show, are not used.
    """
    timed = [s for s in settings if s.point.exposure_s is not None]
    readings = [reading(s) for s in timed]
    exposures = tuple(sorted({float(s.point.exposure_s or 0.0) for s in timed}))
    means, text = _mean_line(readings, exposures, frame_error)
    offset = unknown(kinds.OFFSET, text)
    current = unknown(kinds.CURRENT, text)
    if means is not None:
        note = f"{len(exposures)} exposures"
        note += _linearity(means) if len(exposures) > 2 else ", linearity not checked"
        offset = known(kinds.OFFSET, means.intercept, note)
        current = known(kinds.CURRENT, means.slope, note)
    elif len(exposures) == 1:
        current = _above_black_level([s for s in timed if black_known or s.frames > 1])
    current = _believed(current)
    variances, why = _variance_line(readings)
    by_variance = _from_variance(variances, why, gain)
    items = (current, current.scaled(kinds.CURRENT_E, gain), by_variance, offset)
    return DarkCurrent(temperature_c, exposures, Quantities(items), means, variances)


def _believed(current: Quantity) -> Quantity:
    """A dark current that is negative beyond doubt tells of the black level."""
    value, se = current.value, current.se
    if value is None or se is None or value > -NEGATIVE * se:
        return current
    return unknown(
        current.kind,
        f"negative, {value:.3g} ± {se:.1g} DN/s: the black level is wrong, or it moves",
    )


def frame_error(settings: Sequence[SettingStatistics]) -> float | None:
    """Standard deviation of the mean of a frame, DN, pooled over operating points."""
    found = [(s.frames - 1, reading(s).drift) for s in settings if s.frames > 1]
    degrees = sum(n for n, _ in found)
    return float(np.sqrt(sum(n * d**2 for n, d in found) / degrees)) if degrees else None


def _mean_line(
    readings: Sequence[Reading], exposures: tuple[float, ...], frame_error: float | None
) -> tuple[Line | None, str]:
    """Mean dark signal over exposure, or the reason why there is no line."""
    if not readings:
        return None, NO_EXPOSURE
    if len(exposures) < 2:
        return None, ONE_EXPOSURE
    if frame_error is None and len(readings) < 3:
        return None, NO_SCATTER
    t = np.array([r.point.exposure_s for r in readings], float)
    y = np.array([r.mean for r in readings])
    repeats = np.sqrt([r.frames for r in readings])
    made = _fitted(t, y, (frame_error or 1e-9) / repeats)
    return made, ""


def _variance_line(readings: Sequence[Reading]) -> tuple[Line | None, str]:
    """Temporal variance over exposure, or the reason why it is no shot noise."""
    own = [r for r in readings if r.frames > 1 and r.variance > 0]
    t = np.array([r.point.exposure_s for r in own], float)
    if np.unique(t).size < 3:
        return None, "needs three exposures of two frames"
    every = _fitted(t, *_column(own, "variance"))
    typical = _fitted(t, *_column(own, "typical_variance", "typical_error"))
    if every is None or typical is None:
        return None, "the temporal noise of an operating point is not determined"
    if not alike(every.slope, typical.slope):
        text = (
            f"the variance grows by {every.slope.value:.3g} DN²/s for all pixels, by "
            f"{typical.slope.value:.3g} for typical ones: not by shot noise alone"
        )
        return None, text
    return every, ""


def _column(own: Sequence[Reading], value: str, error: str = "") -> tuple[np.ndarray, np.ndarray]:
    names = value, error or f"{value}_error"
    y, e = (np.array([getattr(r, name) for r in own]) for name in names)
    return y, e


def _fitted(x: np.ndarray, y: np.ndarray, error: np.ndarray) -> Line | None:
    good = bool(np.all(np.isfinite(y)) and np.all(error > 0))
    found = line(x, y, error) if good else None
    if found is None:
        return None
    return Line(tuple(x.tolist()), tuple(y.tolist()), tuple(error.tolist()), *found)


def _from_variance(found: Line | None, why: str, gain: Quantity) -> Quantity:
    kind = kinds.CURRENT_VARIANCE
    if found is None:
        return unknown(kind, why)
    if gain.value is None or gain.se is None:
        return unknown(kind, f"{kinds.GAIN.symbol} is not determined")
    if gain.kind == kinds.TRANSFER:
        return unknown(kind, "K itself comes from the variance")
    value = found.slope.value / gain.value**2
    se = np.hypot(found.slope.se / gain.value**2, 2 * value * gain.se / gain.value)
    return known(kind, Value(value, float(se)))


def _linearity(found: Line) -> str:
    """Largest deviation from the line over the span of the signal, where it matters."""
    x, y = np.array(found.x), np.array(found.y)
    off = float(np.max(np.abs(y - found.intercept.value - found.slope.value * x)))
    span = float(np.ptp(y))
    bent = off > NOT_LINEAR * span and off > OUTLYING_LEVEL * max(found.error)
    return f", off the line by up to {100 * off / span:.0f} %" if bent else ""


def _above_black_level(settings: Sequence[SettingStatistics]) -> Quantity:
    """(mean - black level) / exposure of an operating point whose black level is known."""
    found = []
    for s in settings:
        rate, exposure = s.values.get("dark_rate_dn_s"), s.point.exposure_s
        if rate is None or not exposure:
            continue
        above = (s.values["mean"].value - s.values["median"].value) / exposure
        found.append(Value(rate.value + above, rate.se))
    if not found:
        return unknown(kinds.CURRENT, ONE_EXPOSURE)
    # the black level is common to all
    value = float(np.mean([v.value for v in found]))
    return known(
        kinds.CURRENT,
        Value(value, max(v.se for v in found)),
        "above black level",
    )
