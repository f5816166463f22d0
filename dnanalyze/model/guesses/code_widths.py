"""Widths of a converter's codes over a period, from histograms of what it gave."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

LEAST, MOST = 2, 14  # degree of the logarithm of a density: a Gaussian's, and a skewed tail's
CODES = 16, 8, 5, 3  # of a histogram for each degree, as they are tried
# Relative error of a density's polynomial: more counts do not make it truer, and codes that occur
# less often than by its error at the top tell nothing
ROUGH = 0.02
WIDEST = 256  # codes about the most frequent: four of the longest periods
MOVES = 0.3  # DN, rms that edges are out of place by before anything is seen
THIN = 1e-3  # DN, of a code that never occurs
NODES = 4  # of the integral of a density over a code


@dataclass(frozen=True)
class _Histograms:
    """All codes of all histograms, with the number, middle and half width of the histogram."""

    codes: np.ndarray
    counts: np.ndarray
    part: np.ndarray
    middle: np.ndarray
    half: np.ndarray

    @property
    def sizes(self) -> np.ndarray:
        return np.bincount(self.part)

    def basis(self, at: np.ndarray, degrees: np.ndarray) -> np.ndarray:
        """Polynomials of each histogram's own density at (..., codes), with a last axis."""
        x = (at - self.middle) / self.half
        all_of = np.polynomial.legendre.legvander(x, int(degrees.max()))
        columns = [
            np.where((self.part == n)[:, None], all_of[..., : degree + 1], 0.0)
            for n, degree in enumerate(degrees)
        ]
        return np.concatenate(columns, axis=-1)


@dataclass(frozen=True)
class _Fit:
    widths: np.ndarray
    squares: float
    price: float  # of its terms: less the logarithm of what the prior leaves them
    free: int


def code_widths(
    histograms: Sequence[tuple[np.ndarray, np.ndarray]], periods: Iterable[int]
) -> list[np.ndarray]:
    """Width of each code of a period, less 1, as told best by one edge out of place and by all.

    A count is the integral of a smooth density, one a histogram, from one edge of its code to the
    next; the edges are out of place by what repeats with the period in all histograms. Periods,
    and how far a density may bend, are weighed by the evidence for each (Laplace's method, with
    edges out of place by a normal prior), so that a slow pattern that any density could make is
    not called the converter's.

    ``histograms``: pairs of codes, rising whole numbers, and counts. Two arrays of (period,) from a
    code that is a multiple of the period on: where one edge in a period is out of place, then where
    all may be. Empty where no histogram tells. The histogram test of IEEE Std 1241, with densities
    that are not known; of the evidence: MacKay, Bayesian interpolation, Neural Computation 4
    (1992).
    """
    stacked = _stacked(histograms)
    if stacked is None:
        return []
    bends = [np.clip(stacked.sizes // codes, LEAST, MOST) for codes in CODES]
    starts = [_plain(stacked, d) for d in bends]
    one: list[_Fit] = []
    every: list[_Fit] = []
    for period in periods:
        if np.unique(stacked.codes % period).size < period:
            continue
        fits = [_fit(stacked, d, s, np.eye(period)) for d, s in zip(bends, starts, strict=True)]
        edge = _edge(min(fits, key=lambda f: f.squares + f.price).widths)
        one += [_fit(stacked, d, s, edge) for d, s in zip(bends, starts, strict=True)]
        every += fits
    if not one:
        return []
    # no density is quite a polynomial: what the best of all leaves is what any may leave
    unit = max(1.0, min(f.squares / max(f.free, 1) for f in [*one, *every]))
    return [min(f, key=lambda f: f.squares / unit + f.price).widths for f in (one, every)]


def _stacked(histograms: Sequence[tuple[np.ndarray, np.ndarray]]) -> _Histograms | None:
    parts = [p for p in (_core(*h) for h in histograms) if p[0].size > LEAST + 1]
    if not parts:
        return None
    sizes = [codes.size for codes, _ in parts]
    middle = np.repeat([(codes[0] + codes[-1]) / 2.0 for codes, _ in parts], sizes)
    half = np.repeat([(codes[-1] - codes[0]) / 2.0 for codes, _ in parts], sizes)
    codes, counts = (np.concatenate(p) for p in zip(*parts, strict=True))
    return _Histograms(codes, counts, np.repeat(np.arange(len(parts)), sizes), middle, half)


def _core(codes: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All codes, those that never occur too, from the first common one to the last."""
    common = codes[counts > ROUGH * counts.max()].astype(int)
    most = int(codes[np.argmax(counts)])
    first = max(int(common[0]), most - WIDEST // 2)
    last = min(int(common[-1]), most + WIDEST // 2)
    dense = np.zeros(last - first + 1)
    inside = (codes >= first) & (codes <= last)
    dense[codes[inside].astype(int) - first] = counts[inside]
    return np.arange(first, last + 1), dense


def _plain(stacked: _Histograms, degrees: np.ndarray) -> np.ndarray:
    """Coefficients of densities of equal codes."""
    weight = np.sqrt(stacked.counts + 0.5)
    basis = stacked.basis(stacked.codes.astype(float), degrees)
    told_by = np.log(stacked.counts + 0.5) * weight
    return np.asarray(np.linalg.lstsq(basis * weight[:, None], told_by, rcond=1e-10)[0])


def _edge(widths: np.ndarray) -> np.ndarray:
    """The edge that is farthest out of place beside its neighbours, (period, 1)."""
    at = (int(np.argmax(np.abs(widths - np.roll(widths, -1)))) + 1) % widths.size
    return np.asarray(np.eye(widths.size)[:, at : at + 1])


def _fit(stacked: _Histograms, degrees: np.ndarray, start: np.ndarray, moved: np.ndarray) -> _Fit:
    """Densities and ``moved`` @ a, the places of a period's edges, (period, terms) @ (terms,)."""
    import scipy.optimize

    terms, period = start.size, len(moved)
    lower, upper = moved[stacked.codes % period], moved[(stacked.codes + 1) % period]
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    inside, weights = (nodes[:, None] + 1.0) / 2.0, weights[:, None] / 2.0
    scale = np.sqrt(stacked.counts + 1.0 + (ROUGH * stacked.counts) ** 2)

    def density(at: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        basis = stacked.basis(at, degrees)
        return np.exp(np.clip(basis @ f, -30.0, 40.0)), basis

    def edges(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        low = stacked.codes - 0.5 + lower @ a
        return low, np.maximum(stacked.codes + 0.5 + upper @ a - low, THIN)

    def residual(x: np.ndarray) -> np.ndarray:
        low, width = edges(x[terms:])
        mean = np.sum(density(low + width * inside, x[:terms])[0] * weights, axis=0) * width
        return np.append((mean - stacked.counts) / scale, x[terms:] / MOVES)

    def slopes(x: np.ndarray) -> np.ndarray:
        low, width = edges(x[terms:])
        within, basis = density(low + width * inside, x[:terms])
        by_density = np.einsum("tn,tnk->nk", within * weights * width, basis)
        ends = [density(at, x[:terms])[0][:, None] for at in (low, low + width)]
        by_edge = ends[1] * upper - ends[0] * lower
        data = np.hstack([by_density, by_edge]) / scale[:, None]
        prior = np.hstack([np.zeros((x.size - terms, terms)), np.eye(x.size - terms) / MOVES])
        return np.vstack([data, prior])

    x0 = np.append(start, np.zeros(moved.shape[1]))
    end = scipy.optimize.least_squares(residual, x0, slopes, method="lm", xtol=1e-5, ftol=1e-5)
    _, spread = np.linalg.slogdet(end.jac.T @ end.jac)
    a = end.x[terms:]
    price = float(np.sum((a / MOVES) ** 2) + spread + 2.0 * a.size * math.log(MOVES))
    places = moved @ a
    squares = float(np.sum(end.fun[: stacked.codes.size] ** 2))
    return _Fit(np.roll(places, -1) - places, squares, price, stacked.codes.size - x0.size)
