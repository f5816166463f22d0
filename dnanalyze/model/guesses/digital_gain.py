"""First guesses of digital_gain: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.digital_gain import DigitalGain, rounded_products
from dnanalyze.model.guesses.evidence import histogram, shows

_CODES = 300  # of the histogram's body that are looked at
_DEGREE = 6  # of the smooth log density under the comb
_PHASES = 20  # whole codes about the level that are tried as the offset
_CANDIDATES = 24  # of the factors by their misfit, of which phases and parts are then looked at
_PLAIN = 4, 20, 100, 32  # parts of one of which factors are likely multiples
_TIE = 0.003  # misfit by which chance tells factors apart


def guess(effect: type[DigitalGain], clues: Clues) -> list[Effect]:
    """The factor whose gaps and spikes fit the histogram best; b is the lowest mean level."""
    if not shows(clues, effect.fingerprint):
        return []
    bodies = []
    for setting in range(len(clues.points)):
        seen = histogram(clues, "histogram", setting)
        if seen is not None and np.all(seen[0] == np.rint(seen[0])):
            bodies.append(_body(*seen))
    bodies = [(c, first) for c, first in bodies if c.size > 8 and c.sum() > 30 * c.size]
    if not bodies:
        return []
    # the widest tells the factor most exactly
    counts, first = max(bodies, key=lambda body: body[0].size)
    gain = _best_gain(counts, first)
    if gain is None:
        return []
    level = clues.measured("mean")
    level = level[np.isfinite(level)]
    offset = _offset(counts, first, gain, round(float(level.min())) if level.size else 0)
    return [effect(bounded(effect, "gain", gain), bounded(effect, "offset", offset), _top(clues))]


def _top(clues: Clues) -> float:
    """The highest code where many pixels share it: saturated ones. Else that of 16 bits."""
    for setting in range(len(clues.points)):
        seen = histogram(clues, "histogram", setting)
        if seen is None:
            continue
        codes, counts = seen
        used = np.flatnonzero(counts > 0)
        if used.size > _DEGREE and counts[used[-1]] > 3 * counts[used[-4:-1]].max() + 5:
            return float(codes[used[-1]])
    return 65535.0


def _body(codes: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, int]:
    """Counts of the central 99 % of a histogram, gaps included, and the first code."""
    full = np.zeros(int(codes.max()) - int(codes.min()) + 1)
    full[np.asarray(codes, int) - int(codes.min())] = counts
    share = np.cumsum(full) / max(full.sum(), 1.0)
    first, last = np.searchsorted(share, [0.005, 0.995])
    middle = int(np.searchsorted(share, 0.5))
    first, last = max(first, middle - _CODES // 2), min(last, middle + _CODES // 2)
    return full[first : last + 1], int(codes.min() + first)


def _best_gain(counts: np.ndarray, first: int) -> float | None:
    """Factor under which a smooth density makes this histogram; None: none does better than 1.

    Which factors come near is seen with the density held; each of the best is then tried with its
    own, and with the plain numbers next to it: under these products fall on halves.
    """
    tried = [_plain(gain, counts.size) for gain in _promising(counts, first)]
    misfit = {gain: _least(counts, first, gain) for gains in tried for gain in gains}
    near = min(misfit, key=lambda gain: misfit[gain])
    fine = 1.0 / near + np.linspace(-0.4, 0.4, 33) / counts.size
    scan = np.array([_least(counts, first, 1.0 / k) for k in fine])
    best = min(float(scan.min()), misfit[near])
    if best > min(0.25, 0.6 * _misfit(counts, first, 1.0, 0.0)):
        return None
    plain = [gain for gains in tried for gain in gains[1:] if misfit[gain] <= best + _TIE]
    if plain:
        return min(plain, key=lambda gain: (_parts(gain), misfit[gain]))
    return float(1.0 / np.mean(fine[scan <= best + _TIE]))


def _parts(gain: float) -> int:
    """Of how plain a factor it is a multiple."""
    return next(i for i, n in enumerate(_PLAIN) if abs(gain * n - round(gain * n)) < 1e-9)


def _promising(counts: np.ndarray, first: int) -> np.ndarray:
    """Factors that lead to these counts best, from the smooth density that lies over them."""
    size = counts.size
    density = np.exp(_log_density(counts, counts > 0.1 * median_filter(counts, 7), counts))
    # the plain ones that are left out are among these
    plain = np.concatenate([np.arange(n // 2, 4 * n) / n for n in _PLAIN[2:]])
    inverse = np.unique(np.r_[np.arange(0.25, 2.0, 0.2 / size), 1.0 / plain])
    inverse = inverse[np.abs(inverse - 1.0) > 0.3 / size]
    misfit = np.empty(inverse.size)
    for n, gain in enumerate(1.0 / inverse):
        ways = _ways(size, first, gain, _phases(first, gain))
        expected = ways * density
        expected *= counts.sum() / np.maximum(expected.sum(axis=1, keepdims=True), 1e-9)
        misfit[n] = np.abs(counts - expected).sum(axis=1).min()
    lowest = (misfit <= np.r_[np.inf, misfit[:-1]]) & (misfit < np.r_[misfit[1:], np.inf])
    equal = np.isin(inverse, 1.0 / plain) & (misfit <= misfit.min() + 2.0 * _TIE * counts.sum())
    chosen = np.flatnonzero(lowest | equal)
    return 1.0 / inverse[chosen[np.argsort(misfit[chosen], kind="stable")[:_CANDIDATES]]]


def _offset(counts: np.ndarray, first: int, gain: float, level: int) -> float:
    """Whole code nearest to ``level`` about which the factor leads to the codes that are used."""

    near = sorted(range(level - _PHASES, level + _PHASES + 1), key=lambda b: abs(b - level))
    misfits = [_misfit(counts, first, gain, (b * (1.0 - gain) - first) % gain) for b in near]
    least = min(misfits)
    return float(next(b for b, m in zip(near, misfits, strict=True) if m <= least + 0.005))


def _plain(gain: float, codes: int) -> list[float]:
    """A factor and the plain ones that so many codes allow."""
    rounded = [round(gain * n) / n for n in _PLAIN]
    near = [r for r in rounded if r > 0 and abs(1.0 / r - 1.0 / gain) < 0.5 / codes]
    return [gain, *(r for r in near if r != 1.0)]


def _least(counts: np.ndarray, first: int, gain: float) -> float:
    """Misfit of a factor at its best phase."""
    return min(_misfit(counts, first, gain, phase) for phase in _phases(first, gain))


def _phases(first: int, gain: float) -> np.ndarray:
    """Of a factor about whole codes, where products fall on halves, and between."""
    whole = (np.arange(40) * (1.0 - gain) - first) % gain
    return np.unique(np.round(np.r_[whole, np.arange(0.0, gain, 0.1)], 6))


def _misfit(counts: np.ndarray, first: int, gain: float, phase: float) -> float:
    """Share of the counts that the best smooth density, sent through the factor, puts elsewhere."""
    ways = _ways(counts.size, first, gain, np.array([phase]))[0]
    used = (ways > 0) & (counts > 0)
    if used.sum() <= _DEGREE + 1:
        return 1.0
    expected = ways * np.exp(_log_density(counts / np.maximum(ways, 1), used, counts))
    return float(0.5 * np.abs(counts - expected).sum() / counts.sum())


def _ways(size: int, first: int, gain: float, phases: np.ndarray) -> np.ndarray:
    """How many codes become each one, (phases, size)."""
    odd = first % 2  # halves are rounded to even codes
    inputs = np.arange(-3, int((size + 3) / gain) + 3)
    codes = rounded_products(inputs * gain + phases[:, None] + odd).astype(int) - odd
    row, here = np.nonzero((codes >= 0) & (codes < size))
    places = row * size + codes[row, here]
    return np.bincount(places, minlength=phases.size * size).reshape(phases.size, size)


def _log_density(density: np.ndarray, used: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Smooth log of a density through the codes that are used, each weighted by its counts."""
    basis = np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, density.size), _DEGREE)
    weight = np.sqrt(counts[used])
    target = np.log(density[used]) * weight
    fit = np.linalg.lstsq(basis[used] * weight[:, None], target, rcond=None)[0]
    return np.clip(basis @ fit, -50.0, 50.0)
