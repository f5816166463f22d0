"""Strips of unequal width and level in a profile of lines: a search for change points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dnanalyze.robust import MAD
from dnanalyze.significance import CERTAIN

DEGREE = 3  # of the smooth trend beside the strips
MAX_EDGES = 15  # edges: the 16 outputs of the widest readout in the catalogue
NARROWEST = 8  # lines: from which a level is told from a defect of a few lines
_FEWEST = 4 * NARROWEST  # lines
_WITHOUT_GAIN = 3  # edges in a row that the criterion does not want: the search ends
_BESIDE = 64  # lines at either side, at most, by which an edge is seen where it is
_BEYOND = 1.5  # standard deviations: e^(-1.5 sqrt(2 ln n)), 1 % of profiles of 300 lines
_LENGTHS = 8  # lengths of a settling that are tried, from half a line to half a strip


@dataclass(frozen=True)
class Strips:
    """Strips of lines, each with its level."""

    begins: np.ndarray  # place in the profile of the first line of every strip but the first
    levels: np.ndarray  # of each strip, DN, beside the trend
    # Share of each step left beside its edge, the lines over which it settles by e, and the side
    # ("after", "before", "both"); 0 where nothing settles.
    share: float = 0.0
    length: float = 1.0
    side: str = "after"


@dataclass(frozen=True)
class _Fit:
    edges: tuple[int, ...]
    left: np.ndarray
    squares: float
    steps: np.ndarray
    settling: tuple[float, float, str] | None = None


def strips(profile: np.ndarray) -> Strips | None:
    """The strips of a profile of lines, DN, beside a cubic trend; None where it has none.

    Edges are added one by one where each explains most, and moved until none explains more. Their
    number has the least modified Bayesian information criterion for change points,
    n ln(squares) + 3 K ln n + sum ln(n_i / n) for K edges and strips of n_i of n lines (Zhang and
    Siegmund, Biometrics 63 (2007) 22): the place of an edge is chosen among n, and is told to a
    line or so whatever n, so that an edge costs more than the 2 ln n of two regular numbers. n is
    taken as the number of lines over 1 + 2 sum rho_k of what is left, for neighbours that are
    alike count once. A settling has two regular numbers. Strips are taken where they leave less
    than a polynomial of as many numbers, for a smooth profile is no staircase, and only edges that
    are seen in the lines beside them.
    """
    n = profile.size
    if n < _FEWEST or not np.isfinite(profile).all():
        return None
    level = _without_outliers(np.asarray(profile, float))
    level = level - level.mean()
    floor = 1e-12 * float(level @ level) + 1e-30  # rounding
    trend = np.polynomial.legendre.legvander(np.linspace(-1, 1, n), DEGREE)
    found = [_fit(level, trend, ())]
    alone, best = found[0], 0
    while len(found) <= min(MAX_EDGES, n // NARROWEST - 1):
        edges = _moved(level, trend, _with_another(level, trend, found[-1].edges))
        if len(edges) < len(found):
            break
        found.append(_fit(level, trend, edges))
        independent = n / _alike(found[-1].left)
        costs = [_cost(f, independent, n, floor) for f in found]
        best = int(np.argmin(costs))
        if len(found) - 1 - best >= _WITHOUT_GAIN:
            break
    if best == 0:
        return None
    chosen = min(
        (_settled(level, trend, f, independent, n, floor) for f in found[1 : best + 1]),
        key=lambda f: _cost(f, independent, n, floor),
    )
    chosen = _seen(level, trend, chosen)
    if not chosen.edges or not _beats_a_curve(level, chosen, alone):
        return None
    levels = np.concatenate([[0.0], np.cumsum(chosen.steps)])
    begins = np.array(chosen.edges)
    return Strips(begins, levels, *(chosen.settling or ()))


def _without_outliers(profile: np.ndarray) -> np.ndarray:
    """Single lines far off the median of the five about them replaced by it; steps stay."""
    wide = np.pad(profile, 2, mode="edge")
    middle = np.median(np.lib.stride_tricks.sliding_window_view(wide, 5), axis=1)
    apart = np.abs(profile - middle)
    sigma = MAD * float(np.median(apart))
    return np.where(apart > CERTAIN * sigma, middle, profile) if sigma > 0 else profile


def _shapes(
    n: int, edges: tuple[int, ...], settling: tuple[float, float, str] | None = None
) -> np.ndarray:
    """Unit steps at the edges, (n, edges), settled within the strips beside them."""
    line = np.arange(n)[:, None]
    at = np.array(edges, int)
    shapes = (line >= at).astype(float)
    if settling is None:
        return shapes
    share, length, side = settling
    after, before = _tails(n, edges, length)
    if side != "before":
        shapes -= share * after
    if side != "after":
        shapes += share * before
    return shapes


def _tails(n: int, edges: tuple[int, ...], length: float) -> tuple[np.ndarray, np.ndarray]:
    """Decay after and before each edge, within the strip that it bounds: two of (n, edges)."""
    line = np.arange(n)[:, None]
    at = np.array(edges, int)
    bounds = np.concatenate([[0], at, [n]])
    after = np.where((line >= at) & (line < bounds[2:]), np.exp(-np.abs(line - at) / length), 0.0)
    before = np.where(
        (line < at) & (line >= bounds[:-2]), np.exp(-np.abs(line - at + 1) / length), 0.0
    )
    return after, before


def _solved(terms: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least squares: weights of the terms, and what they leave."""
    weights = np.linalg.lstsq(terms.T @ terms, terms.T @ level, rcond=None)[0]
    return weights, level - terms @ weights


def _fit(
    level: np.ndarray,
    trend: np.ndarray,
    edges: tuple[int, ...],
    settling: tuple[float, float, str] | None = None,
) -> _Fit:
    terms = np.hstack([trend, _shapes(level.size, edges, settling)])
    weights, left = _solved(terms, level)
    return _Fit(edges, left, float(left @ left), weights[trend.shape[1] :], settling)


def _gains(level: np.ndarray, trend: np.ndarray, edges: tuple[int, ...]) -> np.ndarray:
    """By how much a further edge at each line would lower the sum of squares.

    Of a step, what the present terms do not explain: its product with what they leave is a sum
    over the lines from it on, and so is that with each of their orthonormal basis.
    """
    n = level.size
    basis, _ = np.linalg.qr(np.hstack([trend, _shapes(n, edges)]))
    left = level - basis @ (basis.T @ level)
    product = np.cumsum(left[::-1])[::-1]
    inside = np.cumsum(basis[::-1], axis=0)[::-1]
    norm = (n - np.arange(n)) - np.sum(inside**2, axis=1)
    gain = np.where(norm > 1e-6, product**2 / np.maximum(norm, 1e-6), 0.0)
    for edge in (0, *edges, n):
        gain[max(edge - NARROWEST + 1, 0) : edge + NARROWEST] = 0.0
    return gain


def _with_another(level: np.ndarray, trend: np.ndarray, edges: tuple[int, ...]) -> tuple[int, ...]:
    gain = _gains(level, trend, edges)
    best = int(np.argmax(gain))
    return tuple(sorted((*edges, best))) if gain[best] > 0 else edges


def _moved(level: np.ndarray, trend: np.ndarray, edges: tuple[int, ...]) -> tuple[int, ...]:
    """Each edge where it explains most beside the others, until none moves."""
    for _ in range(3):
        before = edges
        for edge in before:
            edges = _with_another(level, trend, tuple(e for e in edges if e != edge))
        if edges == before:
            break
    return edges


def _alike(left: np.ndarray) -> float:
    """Lines that are worth one: 1 + 2 sum rho_k, up to where neighbours are no longer alike."""
    power = np.abs(np.fft.rfft(left, 2 * left.size)) ** 2
    rho = np.fft.irfft(power)[1 : left.size // 2]
    total = float(left @ left)
    if total <= 0:
        return 1.0
    rho = rho / total
    apart = np.flatnonzero(rho < 2.0 / math.sqrt(left.size))
    return 1.0 + 2.0 * float(rho[: apart[0] if apart.size else rho.size].sum())


def _cost(fit: _Fit, independent: float, n: int, floor: float) -> float:
    """Modified Bayesian information criterion, for so many independent lines of n."""
    widths = np.diff([0, *fit.edges, n]) / n
    price = 3.0 * len(fit.edges) + (2.0 if fit.settling else 0.0)
    squares = max(fit.squares, floor)
    return (
        independent * math.log(squares)
        + price * math.log(independent)
        + float(np.log(widths).sum())
    )


def _settled(
    level: np.ndarray, trend: np.ndarray, fit: _Fit, independent: float, n: int, floor: float
) -> _Fit:
    """The fit with the settling that the criterion wants, or as it is.

    With an amplitude of its own at each edge the terms are linear; the share is their common one.
    """
    best = fit
    longest = 0.5 * float(np.diff([0, *fit.edges, n]).max())
    for length in np.geomspace(0.5, longest, _LENGTHS):
        after, before = _tails(n, fit.edges, float(length))
        steps = _shapes(n, fit.edges)
        for side, tail in (("after", -after), ("before", before), ("both", before - after)):
            weights, _ = _solved(np.hstack([trend, steps, tail]), level)
            step, amplitude = np.split(weights[trend.shape[1] :], 2)
            share = float(step @ amplitude / max(step @ step, 1e-30))
            settling = (min(max(share, -1.0), 1.0), float(length), side)
            made = _fit(level, trend, fit.edges, settling)
            if _cost(made, independent, n, floor) < _cost(best, independent, n, floor):
                best = made
    return best


def _seen(level: np.ndarray, trend: np.ndarray, fit: _Fit) -> _Fit:
    """The fit with the edges alone that stand out of the steps that the profile has anywhere.

    A step beside a slope, by least squares over the lines near it: at an edge, and at all other
    lines of what the strips leave. The largest of n Gaussian ones is about sqrt(2 ln n) standard
    deviations; `_BEYOND` more is seldom by chance, however alike neighbouring lines are.
    """
    n = level.size
    while fit.edges:
        units = _shapes(n, fit.edges, fit.settling)
        bounds = (0, *fit.edges, n)
        worst, least = -1, math.sqrt(2.0 * math.log(n)) + _BEYOND
        for k, edge in enumerate(fit.edges):
            near = min(edge - bounds[k], bounds[k + 2] - edge)
            reach = min(max(near // 2, NARROWEST // 2), _BESIDE)
            kernel = _step_beside_slope(reach)
            anywhere = np.correlate(fit.left, kernel, mode="valid")
            spread = max(MAD * float(np.median(np.abs(anywhere))), 1e-15)
            own = fit.left + fit.steps[k] * units[:, k]
            seen = abs(float(kernel @ own[edge - reach : edge + reach])) / spread
            if seen < least:
                worst, least = k, seen
        if worst < 0:
            return fit
        edges = tuple(e for k, e in enumerate(fit.edges) if k != worst)
        fit = _fit(level, trend, edges, fit.settling)
    return fit


def _step_beside_slope(reach: int) -> np.ndarray:
    """Weights of 2 x reach lines whose sum is the step in their middle, whatever their slope."""
    line = np.arange(2 * reach) - reach + 0.5
    terms = np.stack([np.ones(line.size), line, (line > 0).astype(float)], axis=1)
    return np.asarray(np.linalg.pinv(terms)[2])


def _beats_a_curve(level: np.ndarray, fit: _Fit, alone: _Fit) -> bool:
    """Whether strips leave less than a polynomial of as many numbers: place and height each."""
    degree = DEGREE + 2 * len(fit.edges) + (2 if fit.settling else 0)
    curve = np.polynomial.legendre.legvander(np.linspace(-1, 1, level.size), degree)
    left = _solved(curve, level)[1]
    return fit.squares < min(float(left @ left), alone.squares)


def equal_strips(found: Strips, n: int, counts: tuple[int, ...]) -> int | None:
    """The least number of equal strips of n lines whose seams the edges are, to a line; or None.

    At least half of the seams must be edges, for some lie on the many seams of narrow strips by
    chance.
    """
    for count in counts:
        seams = np.arange(1, count) * n / count
        off = np.abs(found.begins[:, None] - seams).min(axis=1)
        if off.max() <= 1.5 and found.begins.size >= count // 2:
            return count
    return None
