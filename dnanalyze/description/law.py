"""The law that sizes of a structure follow over the operating points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from dnanalyze.description.found import Estimate
from dnanalyze.description.layers import Layers
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
ENERGIES = np.linspace(-1.0, 2.0, 121)  # eV


def with_law(found: Estimate, seen: Layers, reference: OperatingPoint) -> Estimate:
    """The estimate with the law that its sizes follow over the operating points.

    A constant, a share of the dark signal, or an Arrhenius law of its own: the least chi square
    plus `SURE` for a second number. Standard errors hold the scatter of the sizes about the law
    (Birge ratio).
    """
    values, errors = found.sizes.values, np.maximum(found.sizes.errors, 1e-12)
    power = 2.0 if found.sizes.squares else 1.0
    weight = 1.0 / errors**2
    apart = 1.0 / (errors**2 + (power * LAW_SCATTER * values) ** 2)  # by which laws are told apart
    points, dark = seen.points, seen.dark
    laws: list[tuple[float, Estimate]] = []

    def scaled_to(growth: np.ndarray) -> tuple[float, float, float]:
        shape = growth**power
        total = max(float(np.sum(weight * shape**2)), 1e-300)
        size = float(np.sum(weight * shape * values)) / total
        off = (values - size * shape) ** 2
        return size, birge(off, 1) / math.sqrt(total), float(np.sum(apart * off))

    def birge(off: np.ndarray, numbers: int) -> float:
        """By which sizes scatter about a law of so many numbers beyond their errors."""
        return math.sqrt(max(1.0, float(np.sum(weight * off)) / max(off.size - numbers, 1)))

    def take(size: float, error: float, chi: float, own: dict[str, float], **words: object) -> None:
        if size <= 0:
            return
        amplitude = size ** (1.0 / power)
        spread = error / power * amplitude / size
        if found.elements:  # the spread that n values are drawn from, by these values
            spread = math.hypot(spread, amplitude / math.sqrt(2.0 * found.elements))
        name = "gain" if words.get("what", found.effect.what) == "gain" else "amplitude"
        info = CompositeEffect.parameters()[name]
        amplitude = min(max(amplitude, info.lower), info.upper)
        effect = replace(found.effect, **{name: amplitude}, **words)  # type: ignore[arg-type]
        of_law = replace(found, effect=effect, errors=found.errors | {name: spread} | own)
        laws.append((chi + len(own) * SURE, of_law))

    take(*scaled_to(np.ones(len(points))), {})
    if not seen.grows:
        return laws[0][1] if laws else replace(found, explained=0.0)
    if found.effect.what == "level":
        # a fixed pattern of the gain: its sizes are larger by what cut pixels took with them
        fixed = seen.lost_gain if found.effect.when == "fixed" else 1.0
        take(*scaled_to(dark / fixed), {}, what="gain")
    warm = {p.temperature_c for p in points} - {None}
    if reference.temperature_c is not None and len(warm) > 2:

        def growth(energy: float) -> np.ndarray:
            return grown(points, reference, energy)

        energy = least_energy(lambda e: scaled_to(growth(e))[2], ENERGIES)
        size, _, chi = scaled_to(growth(energy))
        # size and energy together: their errors from the curvature of chi square
        slope = (growth(energy + 1e-4) ** power - growth(energy) ** power) / 1e-4
        slopes = np.stack([growth(energy) ** power, size * slope])
        variance = np.diag(np.linalg.pinv((slopes * weight) @ slopes.T))
        beyond = birge((values - size * growth(energy) ** power) ** 2, 2)
        error, of_energy = (beyond * math.sqrt(v) for v in np.maximum(variance, 0.0))
        take(size, error, chi, {"ea_ev": of_energy}, law="thermal", ea_ev=energy)
    return min(laws, key=lambda x: x[0])[1] if laws else replace(found, explained=0.0)


def follows(found: Estimate) -> bool:
    """Whether the amplitude is the same at all operating points, but for what may shift it."""
    sizes, errors = found.sizes.amplitudes
    off = (sizes - found.effect.amplitude) / np.hypot(errors, LAW_SCATTER * sizes)
    return float(np.sum(off**2)) <= float(chi2.isf(UNLIKELY, max(off.size - 1, 1)))


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
