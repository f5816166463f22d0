"""First guesses of amp_glow: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.amp_glow import PLACES, AmpGlow, glow
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import curve
from dnanalyze.significance import SIGN

# Of the field, in steps of a factor of 1.3 to 2: a fit follows from there
LENGTHS = (0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.5, 0.8, 1.2)


def guess(effect: type[AmpGlow], clues: Clues) -> list[Effect]:
    """The three places and lengths that follow the most shaded block means best."""
    names = [f"shading_{i}_{j}" for i in range(4) for j in range(4) if i or j]
    seen = np.array([np.abs(np.nan_to_num(clues.z(name))) for name in names])
    if not (seen > SIGN).any():
        return []
    setting = int(np.argmax((seen**2).sum(0)))
    blocks = curve(clues, "block_means", setting)
    if blocks is None or min(blocks.shape) < 3:
        return []
    fitted_places = []
    for place in PLACES:
        fits = [(*_fit(place, length, blocks, clues), length) for length in LENGTHS]
        error, height, length = min(f for f in fits)
        if height > 0:
            fitted_places.append((error, place, length))
    fitted_places.sort()
    guesses: list[Effect] = []
    for _, place, length in fitted_places[:3]:
        heights = np.full(len(clues.points), np.nan)
        for j in range(heights.size):
            each = curve(clues, "block_means", j)
            if each is not None:
                heights[j] = _fit(place, length, each, clues)[1]
        found = _over_settings(clues, heights)
        if found is not None:
            exposure, height, ea = found
            guesses.append(
                effect.within(
                    amplitude=height, length=length, ea_ev=ea, location=place, exposure=exposure
                )
            )
    return guesses


def _over_settings(clues: Clues, heights: np.ndarray) -> tuple[str, float, float] | None:
    """The law over exposure, amplitude and activation energy that fit the heights best.

    Exposure none only where exposures differ: those of one exposure go by it.
    """
    best, least = None, math.inf
    laws = [("proportional", hints.exposure_and_gain(clues)), ("none", hints.gains(clues))]
    several = len({point.exposure_s for point in clues.points}) > 1
    for exposure, growth in laws if several else laws[:1]:
        fitted = hints.thermal_fit(clues, heights / growth, 0.0)
        if fitted is None:
            continue
        height, ea = fitted
        growth = np.nan_to_num(growth) * hints.thermal_growth(clues, np.array([ea]))[0]
        rest = float(np.nansum((heights - height * growth) ** 2))
        if rest < least:
            best, least = (exposure, height, ea), rest
    return best


def _fit(place: str, length: float, blocks: np.ndarray, clues: Clues) -> tuple[float, float]:
    """(residual mean square, amplitude) of c + a e^(-r/l) on the block means."""
    area = clues.area
    rows, columns = (
        begin + (np.arange(count) + 0.5) * length_here / count
        for begin, count, length_here in zip(
            (area.top, area.left), blocks.shape, area.shape, strict=True
        )
    )
    light = glow(place, length, rows, columns, clues.field)
    light -= light.mean()
    y = blocks - blocks.mean()
    height = float((light * y).sum() / max((light * light).sum(), 1e-30))
    return float(np.mean((y - height * light) ** 2)), height
