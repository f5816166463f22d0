"""Widths of a converter's codes over a period, from histograms of what it gave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# Of the logarithm of a density: a Gaussian's, and, where there are many periods, one a period
# (which cannot follow what repeats with it) up to what a tail may need.
DEGREES = 2, 12
MANY, SPARE = 3, 1.25  # periods; as many must be left once the densities have their terms
ROUGH = 0.02  # relative error of a density's polynomial: more counts do not make it truer
CORE = 0.02  # of the largest count: codes that occur often enough
ROUNDS, STEPS = 4, 12  # of the places of the codes, and of each fit
LEAST = 1e-3  # width of a code that never occurs


def code_widths(histograms: Sequence[tuple[np.ndarray, np.ndarray]], period: int) -> np.ndarray:
    """Width of each code of a period relative to their mean, less 1.

    Counts are Poisson about a smooth density of the signal, one a histogram, times the width of
    the code's class: a generalised linear model, in which the classes are common to all
    histograms. The density is taken at the middle of each code, which follows from the widths, so
    the fit is repeated.

    Parameters
    ----------
    histograms : sequence of (codes, counts)
        Codes as whole numbers, rising.
    period : int
        Codes; the first class is that of its multiples.

    Returns
    -------
    ndarray
        (period,); empty where no histogram tells a class from the shape of the density.
    """
    parts = [p for p in (_core(*h) for h in histograms) if p[0].size > DEGREES[0] + 1]
    # those of few codes have no say on what repeats slowly, where others have seen many periods
    parts = [p for p in parts if p[0].size >= MANY * period] or parts
    if not parts or len({int(c) % period for codes, _ in parts for c in codes}) < period:
        return np.empty(0)
    codes, counts = (np.concatenate(p) for p in zip(*parts, strict=True))
    part = np.repeat(np.arange(len(parts)), [p[0].size for p in parts])
    kind = codes % period
    member = (kind[:, None] == np.arange(period)).astype(float)
    widths = np.ones(period)
    for _ in range(ROUNDS):
        starts = np.cumsum(widths) - widths
        middle = codes - kind + (starts + widths / 2.0)[kind] - 0.5
        shape = _densities(middle, part, period)
        if codes.size - shape.shape[1] < SPARE * period:
            return np.empty(0)
        told = _poisson(np.hstack([shape, member[:, 1:]]), counts)[shape.shape[1] :]
        widths = np.maximum(np.exp(np.clip(np.append(0.0, told), -20.0, 20.0)), LEAST)
        widths /= widths.mean()
    return np.asarray(widths - 1.0)


def _core(codes: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All codes, those that never occur too, from the first common one to the last."""
    common = np.flatnonzero(counts > CORE * counts.max())
    first, last = int(codes[common[0]]), int(codes[common[-1]])
    dense = np.zeros(last - first + 1)
    inside = slice(common[0], common[-1] + 1)
    dense[codes[inside].astype(int) - first] = counts[inside]
    return np.arange(first, last + 1), dense


def _densities(middle: np.ndarray, part: np.ndarray, period: int) -> np.ndarray:
    """Polynomials in the place of a code, of each histogram its own."""
    columns = []
    for n in range(part[-1] + 1):
        here = part == n
        x = middle[here]
        scaled = (x - x.mean()) / max(float(np.ptp(x)) / 2.0, 1.0)
        degree = int(np.clip(x.size // period, *DEGREES)) if x.size >= MANY * period else DEGREES[0]
        terms = np.zeros((part.size, degree + 1))
        terms[here] = np.polynomial.legendre.legvander(scaled, degree)
        columns.append(terms)
    return np.hstack(columns)


def _poisson(design: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Coefficients of log mean counts, by iterated weighted least squares."""
    eta = np.log(counts + 0.5)
    for _ in range(STEPS):
        mean = np.exp(np.clip(eta, -5.0, 40.0))
        weight = np.sqrt(mean / (1.0 + ROUGH**2 * mean))
        working = np.clip(eta, -5.0, 40.0) + (counts - mean) / mean
        found = np.linalg.lstsq(design * weight[:, None], working * weight, rcond=1e-10)[0]
        eta = design @ found
    return np.asarray(found)
