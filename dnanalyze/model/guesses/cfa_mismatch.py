"""First guesses of cfa_mismatch: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.cfa_mismatch import CfaMismatch
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import shows, strongest, typical_positive
from dnanalyze.model.guesses.line_profile import line_profile
from dnanalyze.significance import CLEAR

_ALIKE = 0.05  # of the largest: colours whose offsets cancel better in a line are a coincidence
_MODES = (("u", "10"), ("v", "01"), ("uv", "11"))


def guess(effect: type[CfaMismatch], clues: Clues) -> list[Effect]:
    """u and v from the levels of odd and even columns and rows, uv from its line in the spectrum.

    The power of the line is uv^2 times the pixels; either sign of it is tried. Of colours that are
    analysed apart, all from their levels.
    """
    levels = clues.colours("median")
    if len(levels):
        return _of_colours(effect, clues, levels)
    lines = {name: f"pattern_nyquist_{k}" for name, k in _MODES}
    ratios = {n: clues.measured(line) for n, line in lines.items()}
    clear = strongest(clues, list(lines.values())) or 0
    least = _ALIKE**2 * np.nanmax([0.0, *(r[clear] for r in ratios.values())])
    seen = {n: shows(clues, [lines[n]]) and r[clear] > least for n, r in ratios.items()}
    if not (seen["uv"] or (seen["u"] and seen["v"])):
        return []
    floor = clues.measured("pattern_psd_0.35_0.5")
    pixels = clues.shape[0] * clues.shape[1]
    steps = {name: _half_step(clues, axis) for name, axis in (("u", "columns"), ("v", "rows"))}
    sizes = {name: step if seen[name] else 0.0 for name, step in steps.items()}
    if not seen["uv"]:
        return [effect.within(**sizes, uv=0.0)]
    diagonal = math.sqrt(typical_positive(ratios["uv"] * floor) / pixels)
    return [effect.within(**sizes, uv=sign * diagonal) for sign in (1.0, -1.0)]


def _of_colours(effect: type[CfaMismatch], clues: Clues, levels: np.ndarray) -> list[Effect]:
    """Contrasts of the levels of four colours; the settings weighted by their errors."""
    signs = np.array([[1, -1, 1, -1], [1, 1, -1, -1], [1, -1, -1, 1]]) / 4.0
    contrasts = levels[..., 0] @ signs.T / hints.gains(clues)[:, None]
    errors = np.sqrt(np.sum(levels[..., 1] ** 2, axis=1)) / 4.0 / hints.gains(clues)
    weights = np.maximum(errors, 1e-9) ** -2.0
    sizes = weights @ contrasts / weights.sum()
    if not (np.abs(sizes) > CLEAR * weights.sum() ** -0.5).any():
        return []
    return [effect.within(**dict(zip(("u", "v", "uv"), sizes.tolist(), strict=True)))]


def _half_step(clues: Clues, axis: str) -> float:
    """Half of what even lines lie above odd ones, DN."""
    places, offsets = line_profile(clues, axis)
    if offsets.size < 2:
        return 0.0
    even, odd = (float(np.median(offsets[places % 2 == k])) for k in (0, 1))
    return (even - odd) / 2.0
