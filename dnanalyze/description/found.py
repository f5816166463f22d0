"""What an estimator finds: an effect, its errors, what it explains; sizes of random values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.significance import TOLERATED

KURTOSIS_SD = math.sqrt(24.0)  # of normal values times the root of their number


@dataclass(frozen=True)
class Sizes:
    """How large a structure is at each operating point."""

    # Of the amplitude, or of its square, in DN.
    values: np.ndarray
    errors: np.ndarray
    squares: bool = False  # whether they are squares, as of random elements and of noise

    @property
    def amplitudes(self) -> tuple[np.ndarray, np.ndarray]:
        """Amplitudes with standard errors, DN."""
        if not self.squares:
            return self.values, self.errors
        size = np.sqrt(np.maximum(self.values, 0.0))
        return size, self.errors / (2.0 * np.maximum(size, np.sqrt(self.errors) / 2.0))


@dataclass(frozen=True)
class Estimate:
    """A structure with its evidence."""

    effect: CompositeEffect
    errors: dict[str, float]  # standard error by parameter
    explained: float  # twice the gain of the log likelihood of the layer
    # What its numbers cost: ln n each, n the pixels or values that it is estimated from.
    price: float
    sizes: Sizes  # over the operating points
    chance: float = 0.0
    # Fixed elements that drew a value each once, for all operating points; 0 without such.
    elements: int = 0

    @property
    def worth(self) -> float:
        """What it explains beyond its price and beyond what chance explains."""
        return self.explained - self.price - self.chance

    @property
    def kind(self) -> tuple[str, str, str]:
        """What, when and where, of geometries of which one is a case of the other the latter.

        Halves are quadrants of which two pairs are alike, a wave is rings about a far centre.
        """
        e = self.effect
        return e.what, e.when, {"halves": "quadrants", "wave": "rings"}.get(e.where, e.where)


def random_size(values: np.ndarray, chance: np.ndarray | float) -> tuple[float, float, float]:
    """Variance A^2 of values x ~ N(0, chance + A^2), its standard error, and what it explains.

    That is twice the gain of the log likelihood over A = 0.
    """
    x2 = np.asarray(values, float).ravel() ** 2
    c = np.broadcast_to(np.asarray(chance, float), np.shape(values)).ravel()
    scale = float(np.mean(c))
    if np.ndim(chance) == 0:
        ratio = max(float(np.mean(x2)) / scale, 1.0)
        size, gain = (ratio - 1.0) * scale, x2.size * (ratio - 1.0 - math.log(ratio))
        return size, (scale + size) * math.sqrt(2.0 / x2.size), gain
    most = 4.0 * float(np.mean(x2)) / scale + 1.0

    def cost(size: float) -> float:
        whole = c + size * scale
        return float(np.sum(np.log(whole) + x2 / whole))

    found = optimize.minimize_scalar(
        cost, bounds=(0.0, most), method="bounded", options={"xatol": 1e-9 * most}
    )
    size, gain = float(found.x) * scale, cost(0.0) - float(found.fun)
    information = 0.5 * float(np.sum(1.0 / (c + size) ** 2))
    return max(size, 0.0), 1.0 / math.sqrt(information), max(gain, 0.0)


def random_sizes(series: Sequence[np.ndarray], chance: Sequence[float]) -> tuple[Sizes, float]:
    """Sizes of values that every frame draws anew, and what they explain.

    ``series``: of every operating point, (frames, ...), less the mean of the frames; ``chance``:
    variance of a value by chance.
    """
    found = [random_size(s, float(c)) for s, c in zip(series, chance, strict=True)]
    size, error, gain = np.array(found).T
    frames = np.array([len(s) for s in series])
    independent = (frames - 1.0) / frames
    return Sizes(size, error / np.sqrt(independent), squares=True), float(gain @ independent)


def distribution(series: Sequence[np.ndarray]) -> str:
    """Two levels or normal, of values less the means of their frames, (frames, ...) a point.

    By their fourth moment over the square of the second, which is 3 of a normal distribution. Of
    two levels with k of n frames up, p = k / n, it is 16 E[p q (1 - 3 p q)] over (4 E[p q])^2: 1.6
    of six frames.
    """
    values = np.concatenate([(s / max(float(s.std()), 1e-300)).ravel() for s in series])
    n = max(int(np.median([len(s) for s in series])), 2)
    p = np.arange(n + 1) / n
    odds = np.array([math.comb(n, k) for k in range(n + 1)]) / 2.0**n
    pq = p * (1.0 - p)
    two = float(odds @ (pq * (1.0 - 3.0 * pq))) / float(odds @ pq) ** 2
    ratio = float(np.mean(values**4) / max(float(np.mean(values**2)) ** 2, 1e-300))
    surely = 3.0 - TOLERATED * KURTOSIS_SD / math.sqrt(values.size)
    return "two_level" if ratio < min((two + 3.0) / 2.0, surely) else "normal"
