"""Curves of a family of statistics, as numbers with axes: what an interactive figure draws."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report.words import point_label

BINS = 120  # of a histogram
REACH = 25.0  # robust standard deviations from the median to its ends at most
PARTS = "pattern", "temporal", "frame"
Change = tuple[Statistics, Statistics]  # of a window, before and after
FEWEST_MODES = 12  # in a drawn point of a spectrum: power scatters as 1 / sqrt(modes)
FEWEST_LINES = 3  # the same along one axis, where there are few at low frequencies
POINTS = 60  # of a drawn spectrum, at equal ratios of frequency
NYQUIST = 0.5  # cycles/pixel
BAND = re.compile(r"_(?:psd|columns|rows|u|v)_([\d.]+)_([\d.]+)$")
PERIOD = re.compile(r"(column|row)_periodic_(\d+)$")
PERIODIC = 0.1  # share of the variance of line means from which a period is marked


@dataclass(frozen=True)
class Axes:
    """Quantity and unit of both axes, and whether they are logarithmic."""

    x: str
    y: str
    log_x: bool = False
    log_y: bool = False


@dataclass(frozen=True)
class Mark:
    """A place on the abscissa with its name."""

    x: float
    text: str


@dataclass(frozen=True)
class Curve:
    """A curve with the band of two standard errors, where that is known.

    Parameters
    ----------
    x, y : ndarray
    low, high : ndarray
        Ends of the band; equal to ``y`` where no error is known.
    """

    x: np.ndarray
    y: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True)
class Spectrum:
    """A power spectrum that shows a statistic.

    Parameters
    ----------
    part : str
        One of PARTS: DSNU, temporal noise, single frame.
    axis : str
        "radial" without the axes of the plane, "whole" with them, "horizontal" or "vertical"
        along one frequency without the axes, "column" or "row" of the means of whole lines.
    """

    part: str
    axis: str

    @property
    def axes(self) -> Axes:
        """Axes of its figure."""
        along = {"horizontal": "horizontal", "column": "horizontal", "vertical": "vertical",
                 "row": "vertical"}.get(self.axis, "spatial")  # fmt: skip
        of = {"column": " of the column means", "row": " of the row means"}.get(self.axis, "")
        return Axes(f"{along} frequency{of} [cycles/pixel]", "power [DN²]", True, True)


@dataclass(frozen=True)
class Address:
    """A statistic at an operating point and colour plane.

    Parameters
    ----------
    name : str
    point : OperatingPoint
    plane : str
    spectrum : Spectrum, optional
        In which it is shown; by default that in which it is seen best.
    """

    name: str
    point: OperatingPoint
    plane: str = ""
    spectrum: Spectrum | None = None

    @property
    def family(self) -> str:
        """Family of the statistic."""
        return infos()[self.name].family


def whole_spectrum(part: str, point: OperatingPoint, plane: str = "") -> Address:
    """The radial spectrum of a part, with that of whole rows and columns, as in Wang 2025."""
    return Address(f"{part}_psd_0_0.01", point, plane, Spectrum(part, "whole"))


def find(statistics: Statistics, address: Address) -> SettingStatistics | None:
    """The statistics of an operating point and plane; None where there are none."""
    found = (s for s in statistics.settings if (s.point, s.plane) == (address.point, address.plane))
    return next(found, None)


def axes(address: Address, measured: Statistics) -> Axes | None:
    """Axes of the family's curve; None for a family that has none.

    Parameters
    ----------
    address : Address
    measured : Statistics
        Tells whether a spectral peak lies on the horizontal or on the vertical axis.
    """
    if address.family in ("spectrum", "lines"):
        return _shown(address, measured).axes
    if address.family == "distribution":
        return Axes("dark value [DN]", "share per DN", False, True)
    if address.family == "tails":
        return Axes("deviation [robust σ]", "share above", True, True)
    if address.name == "drift":
        return Axes("frame", "mean of the frame less the mean of all [DN]")
    return None


def band(address: Address) -> tuple[float, float] | None:
    """Frequencies over which a statistic takes the power, cycles/pixel; None for any other.

    Examples
    --------
    >>> from dnanalyze.loaders.captures import OperatingPoint
    >>> from dnanalyze.workbench.curves import Address, band
    >>> band(Address("pattern_columns_0.02_0.1", OperatingPoint()))
    (0.02, 0.1)
    """
    found = BAND.search(address.name)
    return None if found is None else (float(found[1]), float(found[2]))


def marks(address: Address, measured: Statistics) -> list[Mark]:
    """Frequencies to mark in a spectrum: Nyquist, periods of lines, the strongest peak."""
    if address.family not in ("spectrum", "lines"):
        return []
    which, here = _shown(address, measured), find(measured, address)
    found = [Mark(NYQUIST, "Nyquist")]
    if here is None:
        return found
    lines = {"horizontal": "column", "vertical": "row"}.get(which.axis, which.axis)
    for name, value in here.values.items():
        period = PERIOD.match(name)
        if period and period[1] == lines and value.value > PERIODIC and period[2] != "2":
            found.append(Mark(1.0 / int(period[2]), f"period {period[2]}"))
    line = "axis_line" if which.axis in ("column", "row") else "line"
    ends = [here.values.get(f"{which.part}_{line}_{x}") for x in "uv"]
    if all(end is not None for end in ends):
        u, v = (abs(end.value) for end in ends if end is not None)
        at = {"column": u, "horizontal": u, "row": v, "vertical": v}.get(
            which.axis, float(np.hypot(u, v))
        )
        if at > 0 and all(abs(at - m.x) > 0.004 for m in found):
            found.append(Mark(at, "strongest peak"))
    return found


def curve(
    statistics: Statistics, address: Address, measured: Statistics, change: Change | None = None
) -> Curve | None:
    """The curve of a family at an operating point.

    Parameters
    ----------
    statistics : Statistics
        Measured, or of a model.
    address : Address
    measured : Statistics
        Fixes the bins of a histogram.
    change : pair of Statistics, optional
        Of a small window before and after a change of that model, with the same random numbers.
        A power spectrum changes by their ratio, for the power of lines depends on the size of the
        window; a histogram and an exceedance do not, and are those after the change.
    """
    whole = _curve(statistics, address, measured)
    if change is None or address.name == "drift":
        return whole
    before, after = (_curve(s, address, measured) for s in change)
    if address.family not in ("spectrum", "lines"):
        return after
    return None if whole is None else _scaled(whole, before, after)


def residual(measured: Curve, model: Curve, log: bool) -> Curve | None:
    """Difference of two curves over its standard error, at the measured abscissas.

    Parameters
    ----------
    measured, model : Curve
        With bands of two standard errors; a curve without one counts as exact.
    log : bool
        Whether the difference is that of the logarithms.

    Returns
    -------
    Curve or None
        None where no standard error is known, or the curves share no abscissa.

    Examples
    --------
    >>> import numpy as np
    >>> from dnanalyze.workbench.curves import Curve, residual
    >>> x, y = np.array([0.0, 1.0]), np.array([4.0, 6.0])
    >>> residual(Curve(x, y, y - 2, y + 2), Curve(x, x, x, x), log=False).y.tolist()
    [4.0, 5.0]
    """
    keep = np.isfinite(measured.y) & ((measured.y > 0) | (not log))
    x = measured.x[keep]
    scale = np.log if log else np.asarray
    seen = np.isfinite(model.y) & ((model.y > 0) | (not log))
    if not x.size or not seen.any():
        return None

    def at(values: np.ndarray) -> np.ndarray:
        return np.interp(x, model.x[seen], scale(values[seen]), left=np.nan, right=np.nan)

    one = (scale(measured.high[keep]) - scale(measured.low[keep])) / 4.0
    two = (at(model.high) - at(model.low)) / 4.0
    error = np.hypot(one, two)
    told = np.isfinite(error) & (error > 0)
    if not told.any():
        return None
    y = ((scale(measured.y[keep]) - at(model.y)) / np.where(told, error, 1.0))[told]
    return Curve(x[told], y, y, y)


def _curve(statistics: Statistics, address: Address, measured: Statistics) -> Curve | None:
    here, reference = find(statistics, address), find(measured, address)
    if here is None or reference is None:
        return None
    if address.family in ("spectrum", "lines"):
        return _spectrum(here, _shown(address, measured))
    if address.family == "distribution":
        return _histogram(here, reference)
    if address.family == "tails":
        return _exceedance(here)
    if address.name == "drift":
        return _frame_means(here)
    return None


def _scaled(whole: Curve, before: Curve | None, after: Curve | None) -> Curve:
    """A spectrum times the ratio of two others, at the nearest of their frequencies."""
    if before is None or after is None or len(before.x) != len(after.x):
        return whole
    ratio = np.exp(np.interp(whole.x, before.x, np.log(after.y / before.y)))
    return Curve(whole.x, whole.y * ratio, whole.low * ratio, whole.high * ratio)


def over_points(
    statistics: Statistics, address: Address, measured: Statistics, change: Change | None = None
) -> tuple[list[str], Curve]:
    """A statistic at every operating point of its plane.

    Returns
    -------
    labels : list of str
        Operating points at which it is measured.
    curve : Curve
        Values with ``x`` the place of their operating point among the labels.
    """
    scale = infos()[address.name].scale

    def held(found: Statistics) -> dict[OperatingPoint, Value]:
        return {
            s.point: s.values[address.name]
            for s in found.settings
            if s.plane == address.plane and address.name in s.values
        }

    points = list(held(measured))
    here = {p: v for p, v in held(statistics).items() if p in points}
    at = np.array([scale.coordinate(v.value) for v in here.values()])
    if change is not None:
        before, after = (held(s) for s in change)
        for i, p in enumerate(here):
            if p in before and p in after:
                at[i] += scale.coordinate(after[p].value) - scale.coordinate(before[p].value)
    error = np.array([2 * v.se if np.isfinite(v.se) else 0.0 for v in here.values()])
    y, low, high = (np.array([scale.plain(x) for x in end]) for end in (at, at - error, at + error))
    x = np.array([points.index(p) for p in here], dtype=float)
    return [point_label(p) for p in points], Curve(x, y, low, high)


def _shown(address: Address, measured: Statistics) -> Spectrum:
    """The spectrum in which a statistic of the families spectrum and lines is seen."""
    if address.spectrum is not None:
        return address.spectrum
    first, _, rest = address.name.partition("_")
    part, rest = (first, rest) if first in PARTS else ("pattern", address.name)
    if rest.startswith("axis_line"):
        here = find(measured, address)
        u, v = (
            here.values[name].value if here and name in here.values else 0.0
            for name in (f"{part}_axis_line_u", f"{part}_axis_line_v")
        )
        return Spectrum(part, "row" if abs(v) > abs(u) else "column")
    kinds = {"column": "column", "row": "row", "u_": "horizontal", "v_": "vertical"}
    return Spectrum(part, next((k for n, k in kinds.items() if rest.startswith(n)), "radial"))


def _spectrum(here: SettingStatistics, which: Spectrum) -> Curve | None:
    """A power spectrum with the scatter of its modes.

    A ring of radius f and width df holds pi f df rows columns independent modes, for a spectrum is
    symmetric; a horizontal frequency holds one for each row, a mean of lines one.
    """
    part, axis = which.part, which.axis
    rows, columns = here.shape
    frequency, power, modes = {
        "radial": (f"{part}_radial_f", f"{part}_radial_s", 0),
        "whole": (f"{part}_radial_f", f"{part}_radial_full_s", 0),
        "horizontal": ("column_spectrum_f", f"{part}_horizontal_spectrum", rows),
        "vertical": ("row_spectrum_f", f"{part}_vertical_spectrum", columns),
        "column": ("column_spectrum_f", f"{part}_column_spectrum", 1),
        "row": ("row_spectrum_f", f"{part}_row_spectrum", 1),
    }[axis]
    f, s = here.curves.get(frequency), here.curves.get(power)
    if f is None or s is None:
        return None
    keep = (f > 0) & np.isfinite(s) & (s > 0)
    f, s = f[keep], s[keep]
    if len(f) < 2:
        return None
    n = np.full(len(f), float(modes)) if modes else np.pi * f * np.gradient(f) * rows * columns
    slots = _pooled(f, n, (f[-1] / f[0]) ** (1 / POINTS), FEWEST_LINES if modes else FEWEST_MODES)
    total = np.bincount(slots, n)
    f, s = (np.bincount(slots, x * n) / total for x in (f, s))
    n = total
    repeats = max(1, here.frames - 1) if part == "temporal" else 1
    ratio = np.exp(2 / np.sqrt(n * repeats))
    return Curve(f, s, s / ratio, s * ratio)


def _pooled(f: np.ndarray, modes: np.ndarray, ratio: float, fewest: int) -> np.ndarray:
    """Slot of each frequency, of so many modes at least and about so wide."""
    slots, begun, held = np.zeros(len(f), int), f[0], 0.0
    for i in range(1, len(f)):
        held += modes[i - 1]
        fresh = held >= fewest and f[i] >= begun * ratio
        slots[i] = slots[i - 1] + fresh
        if fresh:
            begun, held = f[i], 0.0
    return slots


def _histogram(here: SettingStatistics, reference: SettingStatistics) -> Curve | None:
    """Density of the values in bins of whole codes, the same for all curves of a figure.

    A few hot pixels do not make the bins wider: what is farther than ``REACH`` robust standard
    deviations from the median is left to the figure of the hot-pixel tail.
    """
    names = "histogram_codes", "histogram_counts"
    if any(n not in s.curves or len(s.curves[n]) < 2 for n in names for s in (here, reference)):
        return None
    codes, counts = (reference.curves[n] for n in names)
    share = np.cumsum(counts) / counts.sum()
    low, high = codes[np.searchsorted(share, 2e-5)], codes[np.searchsorted(share, 1 - 2e-5) - 1]
    step = float(np.median(np.diff(codes)))
    left, middle, right = (codes[np.searchsorted(share, q)] for q in (0.16, 0.5, 0.84))
    reach = REACH * max(step, float(right - left) / 2)
    low, high = max(low, middle - reach), min(high, middle + reach)
    width = step * max(1, round((high - low) / BINS / step))
    edges = np.arange(low - width - step / 2, high + 2 * width, width)
    found, weights = (here.curves[n] for n in names)
    n, _ = np.histogram(found, bins=edges, weights=weights)
    total = float(weights.sum())
    density = np.where(n > 0, n / total / width, np.nan)
    error = 2 * np.sqrt(n) / total / width
    least = 0.3 / total / width
    return Curve(
        (edges[:-1] + edges[1:]) / 2, density, np.maximum(density - error, least), density + error
    )


def _exceedance(here: SettingStatistics) -> Curve | None:
    k, n = here.curves.get("exceedance_k"), here.curves.get("exceedance_n")
    if k is None or n is None or not len(k):
        return None
    k, n = k[k > 0], n[k > 0]
    pixels = here.shape[0] * here.shape[1]
    y = np.where(n > 0, n / pixels, np.nan)
    error = 2 * np.sqrt(n) / pixels
    return Curve(k, y, np.maximum(y - error, 0.3 / pixels), y + error)


def _frame_means(here: SettingStatistics) -> Curve | None:
    means = here.curves.get("frame_means")
    if means is None or len(means) < 2:
        return None
    y = means - means.mean()
    return Curve(np.arange(len(y), dtype=float), y, y, y)
