"""First guesses of storage_dark_current: its parameters as the statistics suggest them."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.storage_dark_current import StorageDarkCurrent
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import curve, shows, straight
from dnanalyze.model.laws import Law, TableLaw
from dnanalyze.significance import NOTICEABLE

SPREAD = 0.8  # of ln(dark current) over the pixels of common sensors
BEFORE = 0.0, 2.0  # the first row is read at once, or after two readouts of the field


def guess(effect: type[StorageDarkCurrent], clues: Clues) -> list[Effect]:
    """From the growth of the scatter over the rows, by an Arrhenius law, or by a table.

    Charge of the mean w (b + u) at the row u has the variance w^2 (b + u)^2 (e^(s^2) - 1): from the
    first row to the last it grows by (2 b + 1) w^2 (e^(s^2) - 1). A table serves operating points
    that do not follow the law, since they were read by another clock.
    """
    if not shows(clues, ("scatter_shading_0_1",), 0):
        return []
    grown, errors = np.array([_growth(clues, i) for i in range(len(clues.points))]).T
    seen = np.abs(grown) > NOTICEABLE * errors
    sign = math.copysign(1.0, float(grown[seen].sum()))
    size = np.sqrt(np.where(seen, np.maximum(sign * grown, 0.0), 0.0))
    fitted = hints.thermal_fit(clues, size / hints.gains(clues), 0.63)
    if fitted is None:
        return []
    height, energy = fitted
    growth = hints.gains(clues) * hints.thermal_growth(clues, np.array([energy]))[0]
    laws: list[tuple[float | TableLaw, float]] = [(height, energy)]
    off = np.abs(sign * grown - (height * growth) ** 2) > NOTICEABLE * errors
    if (off & seen).any():
        own = np.where(seen, size, height * growth) / hints.gains(clues)
        laws.append((TableLaw(tuple(clues.points), tuple(map(float, own))), 0.0))
    return [_made(effect, law, ea, b, sign) for law, ea in laws for b in BEFORE]


def _made(
    effect: type[StorageDarkCurrent],
    law: float | TableLaw,
    energy: float,
    before: float,
    sign: float,
) -> Effect:
    share = 1.0 / math.sqrt((2.0 * before + 1.0) * math.expm1(SPREAD**2))
    inside = partial(bounded, effect, "amplitude")
    if isinstance(law, TableLaw):
        amplitude: Law = replace(law, values=tuple(inside(share * v) for v in law.values))
    else:
        amplitude = inside(share * law)
    return effect(
        amplitude=amplitude,  # type: ignore[arg-type]
        spread=SPREAD,
        before=before,
        ea_ev=energy,
        first="top" if sign > 0 else "bottom",
    )


def _growth(clues: Clues, setting: int) -> tuple[float, float]:
    """Growth of the variance between neighbours from the first row of the frame to the last, and
    its standard error, DN^2; (0, infinity): not known.
    """
    blocks = curve(clues, "scatter_blocks", setting)
    if blocks is None or len(blocks) < 4:
        return 0.0, math.inf
    scatter = np.median(blocks, axis=1)
    slope, error = straight(np.arange(len(scatter)), scatter)
    whole = len(scatter) * clues.field[0] / clues.area.shape[0]
    return slope * whole, error * whole
