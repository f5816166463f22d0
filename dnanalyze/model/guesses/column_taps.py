"""First guesses of column_taps: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.column_taps import ColumnTaps
from dnanalyze.model.guesses.change_points import equal_strips, strips
from dnanalyze.model.guesses.evidence import curve, shows, typical_positive
from dnanalyze.model.guesses.line_profile import line_profile, strip_profile
from dnanalyze.model.laws import Law, TableLaw, value_at

_PERIODS, _STRIPS = (2, 3, 4, 8), (2, 4, 8, 16)  # numbers of outputs, in turn and side by side
_SEAMS = ("column_taps_2", "column_taps_4", "column_taps_8", "shading_1_0", "shading_2_0",
          "shading_3_0")  # fmt: skip
_ROW_SEAMS = ("shading_0_1", "shading_0_2", "shading_0_3")
_PEAK = 14.0  # times the median: by chance in one of 1000 spectra of 1000 exponential modes
NEARLY = 0.8  # share of what any number of taps explains


def guess(effect: type[ColumnTaps], clues: Clues) -> list[Effect]:
    """For each kind, the least number of taps that explains nearly all that any number does.

    Strips whose edges stand out of the profile of the columns or rows come before equal ones.
    """
    unequal = [_unequal(effect, clues, axis) for axis in ("columns", "rows")]
    layouts = [
        ("interleaved", "columns", *_interleaved(clues)),
        ("interleaved", "rows", _odd_and_even_rows(clues), 0.0),
    ]
    if unequal[0] is None:
        layouts.append(("blocks", "columns", _blocks(clues), 0.0))
    equal = [
        effect(bounded(effect, "sigma", float(np.std(o))), kind, o.size, _told(o), slip, axis=axis)  # type: ignore[arg-type]
        for kind, axis, o, slip in layouts
        if o.size and np.ptp(o) > 0
    ]
    return [*equal, *(found for found in unequal if found is not None)]


def _unequal(effect: type[ColumnTaps], clues: Clues, axis: str) -> ColumnTaps | None:
    """Strips of lines whose edges stand out of their profile; None where there are none."""
    signs = _SEAMS if axis == "columns" else _ROW_SEAMS
    if not shows(clues, (*signs, f"pattern_{axis}_0_0.02"), 0):
        return None
    places, means = line_profile(clues, axis)
    if axis == "rows":
        means = means + _of_halves(clues, places)
    order = np.argsort(places)
    places, means = places[order], means[order]
    found = strips(means)
    if found is None:
        return None
    widths = np.diff([0, *found.begins, means.size])
    level = found.levels - np.average(found.levels, weights=widths)
    sigma = bounded(effect, "sigma", float(np.sqrt(np.average(level**2, weights=widths))))
    taps = equal_strips(found, means.size, _STRIPS) if means.size == clues.field[1] else None
    if axis == "columns" and taps and not found.share:
        inside = (np.arange(taps) + 0.5) * means.size / taps
        each = level[np.searchsorted(found.begins, inside)]
        return effect(sigma, "blocks", taps, _told(each))
    return effect(
        sigma,
        "blocks",
        levels=tuple(round(float(v), 4) for v in level / sigma),
        begins=tuple(float(places[b]) for b in found.begins),
        axis=axis,
        settle=found.share,
        length=bounded(effect, "length", found.length),
        side=found.side,
    )


def _of_halves(clues: Clues, places: np.ndarray) -> np.ndarray:
    """Mean level of the half of the field that each row lies in, DN.

    The rows of a half are told about their own mean; the blocks of both have one origin.
    """
    levels = []
    for setting in range(len(clues.points)):
        blocks = curve(clues, "block_means", setting)
        if blocks is not None and blocks.ndim == 2 and np.isfinite(blocks).all():
            upper, lower = np.array_split(blocks.mean(axis=1), 2)
            levels.append([upper.mean(), lower.mean()] - blocks.mean())
    if not levels:
        return np.zeros(places.size)
    half = np.repeat([0, 1], [(places.size + 1) // 2, places.size // 2])
    return np.asarray(np.median(levels, axis=0)[half])


def _told(levels: np.ndarray) -> tuple[float, ...]:
    return tuple(round(float(v), 4) for v in (levels - levels.mean()) / np.std(levels))


def _interleaved(clues: Clues) -> tuple[np.ndarray, Law]:
    """Mean level of each tap, DN, beside a parabola over the fitted half (empty: no sign); slip."""
    names = [f"column_periodic_{p}" for p in _PERIODS]
    if not shows(clues, names):
        return np.empty(0), 0.0
    share = dict(zip(_PERIODS, (typical_positive(clues.measured(n)) for n in names), strict=True))
    taps = _fewest(share)
    slips = _slips(clues, taps)
    if slips == 0.0:
        places, means = (part[: clues.shape[1]] for part in line_profile(clues, "columns"))
        return _tap_levels(places, means, taps), 0.0
    each = []
    for i, point in enumerate(clues.points):
        places, means = (part[: clues.shape[1]] for part in clues.lines("columns", i))
        if value_at(slips, point) == 0.0:  # the mean over frames that slipped is none of theirs
            each.append(_tap_levels(places, means, taps))
    return _aligned([levels for levels in each if levels.size]), slips


def _odd_and_even_rows(clues: Clues) -> np.ndarray:
    """Mean level of the even and of the odd rows, DN; empty: no sign."""
    if not shows(clues, ["row_periodic_2"]):
        return np.empty(0)
    return _tap_levels(*line_profile(clues, "rows"), 2)


def _tap_levels(places: np.ndarray, means: np.ndarray, taps: int) -> np.ndarray:
    """Mean level of each tap, DN, beside a parabola; empty where there are too few lines."""
    if means.size < 3 * taps:
        return np.empty(0)
    x = np.linspace(-1.0, 1.0, means.size)
    member = (places[:, None] % taps == np.arange(taps)).astype(float)
    terms = np.hstack([member, np.stack([x, x**2 - 1 / 3], axis=1)])
    return np.asarray(np.linalg.lstsq(terms, means, rcond=None)[0][:taps])


def _aligned(each: list[np.ndarray]) -> np.ndarray:
    """Mean of levels that start at different taps, each turned to agree with the strongest."""
    if not each:
        return np.empty(0)
    centred = [levels - levels.mean() for levels in each]
    best = max(centred, key=np.ptp)
    turns = range(best.size)
    return np.mean([max((np.roll(o, n) for n in turns), key=best.dot) for o in centred], axis=0)


def _slips(clues: Clues, taps: int) -> Law:
    """1 where the lines at n/P are new in a frame, 0 where they stand still, one a setting.

    At which tap a frame happened to start tells nothing of the sensor, so that the model may take
    it as it was.
    """
    rows = {}
    for i, point in enumerate(clues.points):
        power, at = (curve(clues, n, i) for n in ("temporal_column_spectrum", "column_spectrum_f"))
        if power is None or at is None or power.shape != at.shape or power.size < 8 * taps:
            continue
        away = np.abs(at * taps - np.rint(at * taps)) / taps
        line = (away < at[1] - at[0]) & (at > 0.5 / taps)
        rows[point] = float(power[line].max() > _PEAK * max(float(np.median(power)), 1e-30))
    return TableLaw(tuple(rows), tuple(rows.values())) if any(rows.values()) else 0.0


def _blocks(clues: Clues) -> np.ndarray:
    """Mean level of each strip of the whole field, DN; empty: no sign.

    Steps show in the columns, those of two wide taps as shading alone.
    """
    blocks = strip_profile(clues)
    counts = [p for p in _STRIPS if blocks.size >= 2 * p]
    if not counts or not shows(clues, _SEAMS, 0):
        return np.empty(0)
    levels, share = {}, {}
    for taps in counts:
        ends = np.linspace(0.0, taps, blocks.size + 1)  # of the blocks, in taps
        tap = np.arange(taps)[None, :]
        within = np.minimum(ends[1:, None], tap + 1) - np.maximum(ends[:-1, None], tap)
        member = np.clip(within, 0.0, None) / np.diff(ends)[:, None]
        levels[taps] = np.linalg.lstsq(member, blocks, rcond=None)[0]
        share[taps] = 1.0 - float(np.var(blocks - member @ levels[taps]) / np.var(blocks))
    taps = _fewest(share)
    return np.asarray(levels[taps]) if share[taps] > _of_curve(blocks, taps) else np.empty(0)


def _of_curve(profile: np.ndarray, numbers: int) -> float:
    """Share of a profile's variance that a polynomial of so many coefficients explains.

    A smooth profile is no staircase: steps must explain more than a curve of as many numbers.
    """
    terms = np.polynomial.legendre.legvander(np.linspace(-1, 1, profile.size), numbers - 1)
    left = profile - terms @ np.linalg.lstsq(terms, profile, rcond=None)[0]
    return 1.0 - float(np.var(left) / np.var(profile))


def _fewest(share: dict[int, float]) -> int:
    """The least number of taps that explains nearly as much as any."""
    best = max(share.values())
    return min(p for p in share if share[p] >= NEARLY * best)
