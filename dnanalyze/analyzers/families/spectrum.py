"""Spectra of the single frame, of the DSNU and of the temporal noise.

The off-axis modes are averaged over bands of the radial frequency rho; the modes on the axes, which
whole columns or whole rows share, stand apart. Column and row offsets alone make a radial 1/rho
that vanishes off the axes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from scipy import special

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.estimators.line_means import line_means
from dnanalyze.analyzers.families.family import FamilyResult
from dnanalyze.analyzers.families.spectrum_infos import INFOS, band_names, profile_names
from dnanalyze.analyzers.plan import CLIP
from dnanalyze.analyzers.spectra.coherence import in_step
from dnanalyze.analyzers.spectra.lines import Line, as_curve, further_lines
from dnanalyze.analyzers.spectra.location import UNIFORM, Location, located, seen_share
from dnanalyze.analyzers.spectra.modes import (
    FIRST_MODES,
    HIGH_BAND,
    MID_BAND,
    RADIAL_BANDS,
    SLOPE_BANDS,
    SMALLEST_SIDE,
    STRUCTURE_BANDS,
    Modes,
    ReducedPower,
    frame_repeats,
    modes_of,
    power_of,
    reduce_power,
)
from dnanalyze.analyzers.spectra.peaks import (
    Peak,
    largest_axis_peak,
    largest_peak,
    nyquist_ratios,
)
from dnanalyze.analyzers.spectra.shape import CORNER_RISE, corner, picture, slope
from dnanalyze.analyzers.spectra.spreads import (
    excess_kurtosis,
    pattern_spread,
    temporal_spread,
    tile_spread,
)
from dnanalyze.analyzers.statistics import Value

__all__ = ["INFOS", "PATTERN_ALONE", "finish"]

PATTERN_ALONE = "pattern_spectrum"  # of the family, what the mean frame alone tells

_COARSE = 0.16  # c/px; waves longer than this take a hit on several pixels for one
QUIET = 3.0  # robust sigmas beyond which a pixel counts as hit
_LEFT = 0.2  # a line of random phase leaves 5 times its mean power in one of e^5 patterns


@dataclass(frozen=True)
class _Part:
    """One of the three spectra, with its independent repeats.

    ``spread`` is the relative variance of the total power beyond that of Gaussian noise: heavy
    tails move all modes together. ``coarse_spread`` is the same of 4 x 4 pixels together, for hits
    that cover several pixels. ``line_spread`` is the same of the means of columns, and of rows.
    ``residue`` is the power of the temporal noise, DN^2, of which 1/``frames`` is left in the
    pattern. Without ``errors`` all spreads are 0, and standard errors are not worked out.
    """

    name: str
    power: np.ndarray
    reduced: ReducedPower
    repeats: float
    spread: float
    coarse_spread: float = 0.0
    line_spread: tuple[float, float] = (0.0, 0.0)
    residue: np.ndarray | None = None
    frames: int = 1
    errors: bool = True

    def spread_at(self, frequency: float) -> float:
        """The spread that a band up to this frequency sees, c/px."""
        return max(self.spread, self.coarse_spread) if frequency <= _COARSE else self.spread


def finish(acc: Accumulated) -> FamilyResult:
    """Values and curves of the spectra of one setting."""
    if not acc.spectra.useful:
        why = f"a spectrum needs {SMALLEST_SIDE} pixels along each side"
        return FamilyResult(missing={"spectrum": why})
    result = FamilyResult()
    alone = acc.frames < 2
    if alone:
        result.missing["spectrum"] = (
            "one frame does not separate DSNU and temporal noise: only frame_ spectra"
        )
    whole = acc.plan.wants(INFOS[0].family)
    for part in _parts(acc) if whole else _pattern_alone(acc):
        _bands(part, result)
        if part.name != "frame" or alone:
            _structure(part, result)
            _profiles(part, result)
            _peaks(part, _images(part, acc), result)
        _curves(part, result)
        if part.errors:
            _shape(part, result)
    if acc.plan.errors and whole:
        quiet = reduce_power(power_of(_quiet(acc)), modes_of(acc.plan.shape))
        _high_to_mid("frame_hf_mf_quiet", quiet, 1.0, result)
    return result


def _parts(acc: Accumulated) -> list[_Part]:
    modes, errors = modes_of(acc.plan.shape), acc.plan.errors
    power = acc.spectra.frame_power()
    frame = reduce_power(power, modes)
    temporal = acc.spectra.temporal_power()
    if temporal is None:
        lines = _line_tails(acc)
        return [_Part("frame", power, frame, 1.0, *_tails(acc), lines, errors=errors)]
    pattern, changing = _pattern(acc, temporal), reduce_power(temporal, modes)
    repeats, spread = 1.0, 0.0
    if errors:
        repeats = frame_repeats(float(frame.radial.sum()), float(changing.radial.sum()), acc.frames)
        assert acc.temporal_variance is not None
        reach, cut = CLIP * acc.pattern_sigma, CLIP * acc.plan.sigma
        spread = temporal_spread(acc.temporal_variance, acc.clipped_pattern, reach, cut, acc.frames)
    tails = pattern.spread, pattern.coarse_spread
    return [
        _Part("frame", power, frame, repeats, *tails, errors=errors),
        pattern,
        _Part("temporal", temporal, changing, acc.frames - 1.0, spread, errors=errors),
    ]


def _pattern_alone(acc: Accumulated) -> list[_Part]:
    """The spectrum of the mean frame, by one transform; the temporal noise is taken for white."""
    if acc.frames < 2:
        return []
    rows, columns = acc.spectra.shape
    return [_pattern(acc, np.full((rows, columns // 2 + 1), acc.temporal_mean))]


def _pattern(acc: Accumulated, residue: np.ndarray) -> _Part:
    power = power_of(acc.clipped_pattern)
    reduced = reduce_power(power, modes_of(acc.plan.shape))
    if not acc.plan.errors:
        return _Part("pattern", power, reduced, 1.0, 0.0, errors=False)
    tails, lines = _tails(acc), _line_tails(acc)
    return _Part("pattern", power, reduced, 1.0, *tails, lines, residue, acc.frames)


def _tails(acc: Accumulated) -> tuple[float, float]:
    """``spread`` and ``coarse_spread`` of the pattern."""
    if not acc.plan.errors:
        return 0.0, 0.0
    pixels, centre, sigma = acc.pattern_ordered, acc.pattern_centre, acc.pattern_sigma
    return pattern_spread(pixels, centre, sigma), tile_spread(acc.clipped_pattern)


def _line_tails(acc: Accumulated) -> tuple[float, float]:
    """``line_spread`` of the pattern."""
    if not acc.plan.errors:
        return 0.0, 0.0
    means = line_means(acc.clipped_pattern)
    return excess_kurtosis(means.columns), excess_kurtosis(means.rows)


@dataclass(frozen=True)
class _Band:
    """Modes along a line that lie together: where, their upper end, c/px, weight and number."""

    label: str
    high: float
    at: slice
    weight: np.ndarray
    modes: float


def _log_error(part: _Part, power: float, square: float, modes: float, spread: float) -> float:
    """Standard error of the log of a mean over independent exponential modes.

    Equal modes have a mean square of 1 + 1/repeats times the squared mean; where it is larger, few
    of the modes hold the power, and count as so many less. The log of a gamma deviate of shape n
    has the variance trigamma(n) = zeta(2, n).
    """
    alike = min(1.0, power**2 * (1 + 1 / part.repeats) / square) if square > 0 else 1.0
    effective = max(modes * alike, min(modes, 1.0)) * part.repeats
    return math.sqrt(float(special.zeta(2.0, effective)) + spread)


def _bands(part: _Part, result: FamilyResult) -> None:
    radial, squares = part.reduced.radial, part.reduced.radial_square
    for label, high, where, n in _radial_bands(part.reduced.modes):
        name = f"{part.name}_psd_{label}"
        if n < 1:
            result.missing[name] = "the frame is too small for a mode in this band"
            continue
        mean, error = float(radial[where].sum()) / n, 0.0
        if not mean > 0:
            result.missing[name] = "there is no power in this band"
            continue
        if part.errors:
            square = float(squares[where].sum()) / n
            error = _log_error(part, mean, square, n, part.spread_at(high))
        result.values[name] = Value(mean, error)


@lru_cache(maxsize=16)
def _radial_bands(modes: Modes) -> list[tuple[str, float, slice, float]]:
    """Label, upper end, fine bins and number of modes of each band of the radial frequency."""
    bands = [(label, high, modes.bins(low, high)) for label, low, high in band_names(RADIAL_BANDS)]
    return [(label, high, bins, float(modes.count[bins].sum())) for label, high, bins in bands]


def _structure(part: _Part, result: FamilyResult) -> None:
    """Bands along the two axes: what whole columns, and whole rows, share."""
    reduced = part.reduced
    for kind, power, spread, size in (
        ("columns", reduced.columns, part.line_spread[0], reduced.modes.shape[1]),
        ("rows", reduced.rows, part.line_spread[1], reduced.modes.shape[0]),
    ):
        # a fixed line, such as odd and even columns, belongs to the type: no less certain
        square = power**2 if part.name == "temporal" else 0.0 * power
        for band in _axis_bands(size):
            name = f"{part.name}_{kind}_{band.label}"
            _mean_into(result, name, part, power, square, band, spread)


@lru_cache(maxsize=64)
def _axis_bands(size: int) -> list[_Band]:
    """The bands of the modes above 0 on an axis of this length."""
    f = np.arange(1, size // 2 + 1) / size
    return [
        _band(label, high, f, (f > low) & (f <= high), 1.0)
        for label, low, high in band_names(STRUCTURE_BANDS)
    ]


@lru_cache(maxsize=64)
def _profile_bands(size: int, across: int) -> list[_Band]:
    """As `_axis_bands` of a profile, the mean over so many modes across."""
    f = np.arange(1, size // 2 + 1) / size
    first = np.arange(1, f.size + 1) <= FIRST_MODES
    out = []
    for label, low, high in profile_names():
        inside = first if label == "first" else ~first & (f > low) & (f <= high)
        out.append(_band(label, high, f, inside, float(across)))
    return out


def _band(label: str, high: float, f: np.ndarray, inside: np.ndarray, across: float) -> _Band:
    """The last mode is its own conjugate, and has half the weight."""
    where = np.flatnonzero(inside)
    at = slice(int(where[0]), int(where[-1]) + 1) if where.size else slice(0, 0)
    weight = across * np.where(f[at] == 0.5, 0.5, 1.0)
    return _Band(label, high, at, weight, float(weight.sum()))


def _profiles(part: _Part, result: FamilyResult) -> None:
    """Bands along u, averaged over v != 0, and along v, averaged over u != 0."""
    rows, columns = part.reduced.modes.shape
    reduced = part.reduced
    for axis, power, square, size, across in (
        ("u", reduced.horizontal, reduced.horizontal_square, columns, rows - 1),
        ("v", reduced.vertical, reduced.vertical_square, rows, columns - 1),
    ):
        for band in _profile_bands(size, across):
            name = f"{part.name}_{axis}_{band.label}"
            _mean_into(result, name, part, power, square, band, part.spread_at(band.high))


def _mean_into(
    result: FamilyResult,
    name: str,
    part: _Part,
    power: np.ndarray,
    square: np.ndarray,
    band: _Band,
    spread: float,
) -> None:
    n = band.modes
    mean, error = float(power[band.at] @ band.weight) / n if n > 0 else 0.0, 0.0
    if not mean > 0:
        result.missing[name] = "no power, or no mode of this frame, in this band"
        return
    if part.errors:
        error = _log_error(part, mean, float(square[band.at] @ band.weight) / n, n, spread)
    result.values[name] = Value(mean, error)


def _images(part: _Part, acc: Accumulated) -> tuple[np.ndarray, ...]:
    """Images that hold the part: the pattern, or the first and the last frame less the mean."""
    if part.name != "temporal":
        return (acc.clipped_pattern,)
    return tuple(frame - acc.pattern for frame in acc.end_frames)


def _peaks(part: _Part, images: tuple[np.ndarray, ...], result: FamilyResult) -> None:
    shape = part.reduced.modes.shape
    peak = largest_peak(part.power, shape, part.repeats, part.name == "temporal")
    name, strongest = f"{part.name}_line", list[Line]()
    if peak is None:
        why = "the frame is too small, or has no power, to search for lines"
        for what in ("", "_in_step", "_u", "_v", "_amplitude"):
            result.missing[f"{name}{what}"] = why
    else:
        error = math.hypot(peak.log_error, _residue(part, peak))
        result.values[name] = Value(peak.ratio, error)
        share = Value(*in_step(images, peak.u, peak.v, peak.real))
        if math.isfinite(share.value):
            result.values[f"{name}_in_step"] = share
        else:
            result.missing[f"{name}_in_step"] = "the frames at the ends of the series are equal"
        strongest.append(_place(part, peak, error, images, result))
    if part.errors:
        axis = largest_axis_peak(part.power, shape, part.repeats, part.name == "temporal")
        if axis is not None and axis.real:
            name = f"{part.name}_axis_line"
            error = math.hypot(axis.log_error, _residue(part, axis))
            result.values[name] = Value(axis.ratio, error)
            strongest.append(_place(part, axis, error, images, result, name))
        else:
            for what in ("", "_u", "_v", "_amplitude"):
                why = "no peak of whole rows or columns is significant"
                result.missing[f"{part.name}_axis_line{what}"] = why
        result.curves[f"{part.name}_lines"] = _lines(part, strongest, images)
    if part.name != "temporal":
        ratios = nyquist_ratios(part.power, shape)
        for label in ("10", "01", "11"):
            name = f"{part.name}_nyquist_{label}"
            if label in ratios:
                result.values[name] = Value(*ratios[label])
            else:
                result.missing[name] = "there is no power at or next to this mode"


def _place(
    part: _Part,
    peak: Peak,
    error: float,
    images: tuple[np.ndarray, ...],
    result: FamilyResult,
    name: str = "",
) -> Line:
    """Frequency and amplitude of a line: between the modes, where it is one."""
    name = name or f"{part.name}_line"
    found = _line(part, peak, images)
    result.values[f"{name}_u"] = Value(found.at.u, found.at.u_error)
    result.values[f"{name}_v"] = Value(found.at.v, found.at.v_error)
    result.values[f"{name}_amplitude"] = Value(found.amplitude, found.amplitude * error / 2)
    return found


def _lines(part: _Part, strongest: Sequence[Line], images: tuple[np.ndarray, ...]) -> np.ndarray:
    """All lines of the part, as `as_curve` has them: these where they are real, and others.

    Of the pattern's others those are left out that are what is left of lines that change in time.
    """
    first = [line for line in strongest if line.peak.real]
    shape, temporal = part.reduced.modes.shape, part.name == "temporal"
    place = partial(_line, part, images=images)
    others = further_lines(part.power, shape, part.repeats, temporal, first, place)
    return as_curve([*first, *(k for k in others if _residue(part, k.peak) < _LEFT)])


def _line(part: _Part, peak: Peak, images: tuple[np.ndarray, ...]) -> Line:
    """Where the line at a peak lies, and its amplitude."""
    rows, columns = part.reduced.modes.shape
    amplitude = peak.amplitude
    # chance puts its peak anywhere
    line = Location(peak.u, peak.v, 0.5 * UNIFORM, UNIFORM)
    if peak.real and part.errors:
        cropped = [image[:rows, :columns] for image in images]
        share = part.repeats / (part.repeats + 1.0) if part.name == "temporal" else 1.0
        line = located(cropped, peak.u, peak.v, share * len(images))
        amplitude /= math.sqrt(_seen(peak, line, (rows, columns)))
    elif peak.real:
        line = Location(peak.u, peak.v, UNIFORM / columns, UNIFORM / rows)
    return Line(peak, line, amplitude)


def _seen(peak: Peak, line: Location, shape: tuple[int, int]) -> float:
    """Share of a line's power in the modes that its amplitude was taken from."""
    share = 1.0
    for at, place, size in zip((peak.v, peak.u), (line.v, line.u), shape, strict=True):
        away = min(abs(sign * place - at - n) for sign in (1, -1) for n in (-1, 0, 1)) * size
        share *= float(seen_share(away, 0 if at == 0.0 else 1))
    return max(share, 0.1)


def _residue(part: _Part, peak: Peak) -> float:
    """Share of a peak of the pattern that is what K frames leave of a line that changes in time.

    The mean of K lines of random phase has an exponential power, whose relative spread is 1.
    """
    if part.residue is None or not peak.real:
        return 0.0
    rows, columns = part.reduced.modes.shape
    at = round(peak.v * rows) % rows, round(peak.u * columns)
    return min(1.0, float(part.residue[at] / part.frames / part.power[at]))


def _shape(part: _Part, result: FamilyResult) -> None:
    """Slopes, corner frequency, high-to-mid ratio: for information, they follow from the bands."""
    modes, mean = part.reduced.modes, part.reduced.radial_mean()
    n = modes.count * part.repeats
    for label, (low, high) in SLOPE_BANDS.items():
        where = modes.bins(low, high)
        rise = slope(modes.rho[where], mean[where], n[where])
        if rise is None:
            result.missing[f"{part.name}_slope_{label}"] = "too few modes in this band"
        else:
            result.values[f"{part.name}_slope_{label}"] = rise
    knee = corner(modes.rho, mean, modes.count)
    if knee is None:
        result.missing[f"{part.name}_corner_frequency"] = (
            f"the power does not rise to {CORNER_RISE:g} times the white noise"
        )
    else:
        result.values[f"{part.name}_corner_frequency"] = knee
    _high_to_mid(f"{part.name}_hf_mf", part.reduced, part.repeats, result)


def _high_to_mid(name: str, reduced: ReducedPower, repeats: float, result: FamilyResult) -> None:
    """Power above .45 c/px over that from .03 to .12, off the axes (physics: the HF/MF ratio)."""
    modes = reduced.modes
    bands = modes.bins(*HIGH_BAND), modes.bins(*MID_BAND)
    counts = [float(modes.count[band].sum()) * repeats for band in bands]
    powers = [float(reduced.radial[band].sum()) for band in bands]
    if min(counts) > 0 and min(powers) > 0:
        ratio = (powers[0] / counts[0]) / (powers[1] / counts[1])
        result.values[name] = Value(ratio, math.sqrt(1 / counts[0] + 1 / counts[1]))
    else:
        result.missing[name] = "no modes, or no power, in one of the two bands"


def _quiet(acc: Accumulated) -> np.ndarray:
    """The first frame less its median, with hits and their 8 neighbours taken out.

    Hits that span pixels are smooth by themselves; what is left tells whether the noise is.
    """
    image = acc.end_frames[0] - np.float32(acc.plan.centre)
    reach = QUIET * acc.plan.sigma
    wide = (image > reach) | (image < -reach)
    for axis in (0, 1):
        wide |= np.roll(wide, 1, axis) | np.roll(wide, -1, axis)
    np.copyto(image, np.float32(0), where=wide)
    return image


def _curves(part: _Part, result: FamilyResult) -> None:
    modes, curves, name = part.reduced.modes, result.curves, part.name
    seen = modes.seen
    curves[f"{name}_radial_f"] = modes.rho[seen]
    curves[f"{name}_radial_s"] = part.reduced.radial_mean()[seen]
    curves[f"{name}_radial_full_s"] = part.reduced.radial_mean_full()[seen]
    curves[f"{name}_horizontal_spectrum"] = part.reduced.horizontal
    curves[f"{name}_vertical_spectrum"] = part.reduced.vertical
    curves[f"{name}_column_spectrum"] = part.reduced.columns
    curves[f"{name}_row_spectrum"] = part.reduced.rows
    curves["column_spectrum_f"] = modes.u
    curves["row_spectrum_f"] = modes.v
    if part.errors and name != "frame":
        curves[f"{name}_psd2d"] = picture(part.power)
