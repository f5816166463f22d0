"""First guesses of dark_gradient: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dark_gradient import DarkGradient
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import over_signal, shows, straight
from dnanalyze.model.guesses.surfaces import over_frame, shading, surfaces
from dnanalyze.model.surface import TERMS
from dnanalyze.significance import NOTICEABLE

SHORT = 0.1  # share of the longest exposure up to which a ramp is not that of the dark current
LEAST_SLOPE = 8.0  # standard errors of a slope


def guess(effect: type[DarkGradient], clues: Clues) -> list[Effect]:
    """Least squares on the block means; their growth gives the activation energy, or their
    slope over the mean level the share. Rows that wait from the slope of the row means at the
    shortest exposures.
    """
    waits = _waits(clues) if shows(clues, ("shading_0_1", "pattern_rows_0_0.02")) else None
    return [*_surfaces(effect, clues), *([effect.within(**waits)] if waits else [])]


def _surfaces(effect: type[DarkGradient], clues: Clues) -> list[DarkGradient]:
    seen = shading(clues)
    if seen is None:
        return []
    growth = hints.exposure_and_gain(clues)
    raw, errors = surfaces(clues)
    fits = raw / growth[:, None]
    size = np.sqrt((fits**2).sum(1))
    fitted = hints.thermal_fit(clues, size, 0.63)
    if fitted is None:
        return []
    height, ea = fitted
    best = int(np.nanargmax(np.where(np.isfinite(size), (seen**2).sum(0), -1)))
    significant = np.abs(raw[best]) >= min(NOTICEABLE * errors[best], np.abs(raw[best]).max())
    terms = over_frame(significant * fits[best] / size[best] * height, clues)
    values = dict(zip(TERMS, terms, strict=True))
    added = effect.within(**values, ea_ev=ea)
    shares = _slopes(clues, raw)
    if shares is None:
        return [added]
    share = dict(zip(TERMS, over_frame(significant * shares, clues), strict=True))
    return [added, effect.within(**share, form="scaled")]


def _slopes(clues: Clues, fits: np.ndarray) -> np.ndarray | None:
    """Slope of each coefficient over the mean level, DN a DN; None: the level hardly moves."""
    both = over_signal(clues, fits.T)
    if both is None:
        return None
    away = both[0] - both[0].mean()
    return np.asarray(np.clip(both[1] @ away / (away @ away), -0.5, 0.5))


def _waits(clues: Clues) -> dict[str, float] | None:
    """Height of the ramp (DN at the reference) and activation energy; None: none stands out."""
    known = [p.exposure_s for p in clues.points if p.exposure_s is not None]
    limit = SHORT * max(known) if known else math.inf
    if known and min(known) > limit:
        limit = min(known)
    heights = np.full(len(clues.points), np.nan)
    for i, point in enumerate(clues.points):
        places, means = clues.lines("rows", i)
        if means.size < 16 or (point.exposure_s or 0.0) > limit:
            continue
        slope, error = straight(places, means)
        if abs(slope) > LEAST_SLOPE * error:
            heights[i] = slope * clues.field[0]
    if not np.isfinite(heights).any():
        return None
    sign = math.copysign(1.0, float(np.nansum(heights)))
    fitted = hints.thermal_fit(clues, sign * heights / hints.gains(clues), 0.63)
    if fitted is None:
        return None
    return {"wait": sign * fitted[0], "ea_ev": fitted[1]}
