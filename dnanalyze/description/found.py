"""What a word finds: an effect, its errors, what it explains; and the law of its size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize
from scipy.stats import chi2

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.significance import UNLIKELY
from dnanalyze.thermal import BOLTZMANN_EV, KELVIN, arrhenius, least_energy

# Sizes of one structure at several points agree to this: cut hot pixels shift them by up to 1.5 %
# (waves and diagonals in log-normal dark current, benchmarks/describe_new_sensors.py).
LAW_SCATTER = 0.02
# By which a further number must lower chi square; the logarithm of four operating points, 1.39,
# would be exceeded by 24 % of chance
SURE = float(chi2.isf(UNLIKELY, 1))


@dataclass(frozen=True)
class Sizes:
    """How large a structure is at each operating point.

    Parameters
    ----------
    values, errors : ndarray
        Of the amplitude, or of its square, in DN.
    squares : bool
        Whether they are squares, as of random elements and of noise.
    """

    values: np.ndarray
    errors: np.ndarray
    squares: bool = False

    @property
    def amplitudes(self) -> tuple[np.ndarray, np.ndarray]:
        """Amplitudes with standard errors, DN."""
        if not self.squares:
            return self.values, self.errors
        size = np.sqrt(np.maximum(self.values, 0.0))
        return size, self.errors / (2.0 * np.maximum(size, np.sqrt(self.errors) / 2.0))


@dataclass(frozen=True)
class Estimate:
    """A structure with its evidence.

    Parameters
    ----------
    effect : CompositeEffect
    errors : dict
        Standard error by parameter.
    explained : float
        Twice the gain of the log likelihood of the layer.
    price : float
        What its numbers cost: ln n each, n the pixels or values that it is estimated from.
    sizes : Sizes
        Over the operating points.
    elements : int
        Fixed elements that drew a value each once, for all operating points; 0 without such.
    """

    effect: CompositeEffect
    errors: dict[str, float]
    explained: float
    price: float
    sizes: Sizes
    chance: float = 0.0
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

    Parameters
    ----------
    values : ndarray
        Of any shape.
    chance : ndarray or float
        Variance of each by chance.

    Returns
    -------
    tuple of float
        A^2, its standard error, twice the gain of the log likelihood over A = 0.
    """
    x2 = np.asarray(values, float).ravel() ** 2
    c = np.broadcast_to(np.asarray(chance, float), np.shape(values)).ravel()
    scale = float(np.mean(c))
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


def random_sizes(
    series: Sequence[np.ndarray], chance: Sequence[float], unit: float = 1.0
) -> tuple[Sizes, float]:
    """Sizes of values that every frame draws anew, and what they explain.

    ``series``: of every operating point, (frames, ...), less the mean of the frames; ``chance``:
    variance of a value by chance. ``unit``: what a value stands for, in amplitudes of the effect.
    """
    found = [random_size(s, c) for s, c in zip(series, chance, strict=True)]
    size, error, gain = np.array(found).T
    frames = np.array([len(s) for s in series])
    spread = error * unit**2 * np.sqrt(frames / (frames - 1.0))
    return Sizes(size * unit**2, spread, squares=True), float(
        np.sum(gain * (frames - 1.0) / frames)
    )


def with_law(
    found: Estimate,
    points: Sequence[OperatingPoint],
    dark: np.ndarray,
    reference: OperatingPoint,
    lost_gain: np.ndarray | float = 1.0,
) -> Estimate:
    """The estimate with the law that its sizes follow over the operating points.

    A constant, a share of the dark signal, or an Arrhenius law of its own: the least chi square
    plus `SURE` for a second number.
    """
    values, errors = found.sizes.values, np.maximum(found.sizes.errors, 1e-12)
    power = 2.0 if found.sizes.squares else 1.0
    weight = 1.0 / errors**2
    apart = 1.0 / (errors**2 + (power * LAW_SCATTER * values) ** 2)  # by which laws are told apart

    def scaled_to(growth: np.ndarray) -> tuple[float, float, float]:
        shape = growth**power
        total = float(np.sum(weight * shape**2))
        size = float(np.sum(weight * shape * values)) / max(total, 1e-300)
        chi = float(np.sum(apart * (values - size * shape) ** 2))
        return size, 1.0 / math.sqrt(max(total, 1e-300)), chi

    laws: list[tuple[float, CompositeEffect, dict[str, float]]] = []

    def take(size: float, error: float, chi: float, numbers: int, **words: object) -> None:
        if size <= 0:
            return
        amplitude = size ** (1.0 / power)
        spread = error / power * amplitude / size
        if found.elements:  # the spread that n values are drawn from, by these values
            spread = math.hypot(spread, amplitude / math.sqrt(2.0 * found.elements))
        gains = words.get("what", found.effect.what) == "gain"
        name, least, most = ("gain", 1e-6, 10.0) if gains else ("amplitude", 1e-4, 1e4)
        new = replace(found.effect, **{name: min(max(amplitude, least), most)}, **words)  # type: ignore[arg-type]
        laws.append((chi + (numbers - 1) * SURE, new, found.errors | {name: spread}))

    ones = np.ones(len(points))
    take(*scaled_to(ones), 1)
    if len(points) > 1 and np.ptp(dark) > 0.1 * max(float(dark.max()), 1e-9):
        if found.effect.what == "level":
            # a fixed pattern of the gain: its sizes are larger by what cut pixels took with them
            fixed = lost_gain if found.effect.when == "fixed" else 1.0
            take(*scaled_to(dark / fixed), 1, what="gain")
        warm = [p.temperature_c for p in points]
        if reference.temperature_c is not None and len({t for t in warm if t is not None}) > 2:
            energy = least_energy(
                lambda e: scaled_to(grown(points, reference, e))[2], np.linspace(-1.0, 2.0, 121)
            )
            growth = grown(points, reference, energy)
            size, _, chi = scaled_to(growth)
            # size and energy together: their errors from the curvature of chi square
            slope = grown(points, reference, energy + 1e-4) ** power - growth**power
            slopes = np.stack([growth**power, size * slope / 1e-4])
            spread = np.sqrt(np.maximum(np.diag(np.linalg.pinv((slopes * weight) @ slopes.T)), 0.0))
            take(size, float(spread[0]), chi, 2, law="thermal", ea_ev=energy)
            if laws and laws[-1][1].law == "thermal":
                laws[-1][2]["ea_ev"] = float(spread[1])
    if not laws:
        return replace(found, explained=0.0)
    _, effect, law_errors = min(laws, key=lambda x: x[0])
    return replace(found, effect=effect, errors=law_errors)


def grown(points: Sequence[OperatingPoint], reference: OperatingPoint, ea_ev: float) -> np.ndarray:
    """Arrhenius growth, with the exposure, from the reference to each point."""
    at = reference.temperature_c
    assert at is not None
    return np.array(
        [arrhenius(p.temperature_c, at, ea_ev) * p.exposure_over(reference) for p in points]
    )


def apparent_energy(points: Sequence[OperatingPoint], dark: np.ndarray) -> float | None:
    """Activation energy of the dark signal between its extremes, eV."""
    known = [(1.0 / (p.temperature_c + KELVIN), d) for p, d in zip(points, dark, strict=True)
             if p.temperature_c is not None and d > 0]  # fmt: skip
    if len(known) < 2:
        return None
    (cold, least), (warm, most) = max(known), min(known)
    if cold == warm:
        return None
    return BOLTZMANN_EV * math.log(most / least) / (cold - warm)
