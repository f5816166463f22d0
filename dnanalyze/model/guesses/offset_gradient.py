"""First guesses of offset_gradient: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.offset_gradient import OffsetGradient
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.surfaces import over_frame, shading, surfaces
from dnanalyze.model.surface import TERMS
from dnanalyze.significance import NOTICEABLE


def guess(effect: type[OffsetGradient], clues: Clues) -> list[Effect]:
    """Least squares on the block means; the mean over the settings in units of the gain, each
    weighted by its standard error, which leaves little of a surface that grows with dark current.
    """
    if shading(clues) is None:
        return []
    raw, errors = surfaces(clues)
    gains = hints.gains(clues)
    known = np.isfinite(raw).all(axis=1) & np.isfinite(errors)
    if not known.any():
        return []
    floor = max(float(errors[known].max()) * 1e-6, 1e-12)
    weight = (gains[known] / np.maximum(errors[known], floor)) ** 2
    mean = weight @ (raw[known] / gains[known, None]) / weight.sum()
    significant = np.abs(mean) >= NOTICEABLE / np.sqrt(weight.sum())
    if not significant.any():
        return []
    terms = over_frame(significant * mean, clues)
    return [effect.within(**dict(zip(TERMS, terms, strict=True)))]
