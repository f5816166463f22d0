"""First guesses of dark_current_steps: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.bounds import clip
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dark_current_steps import DarkCurrentSteps
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.counted_steps import counted_steps
from dnanalyze.model.guesses.evidence import SIGN, curve, shows

FAR = 5.0  # robust standard deviations of the pattern from which a pixel counts as hot
FEWEST = 20  # hot pixels that show how they are spread
NARROW = 0.4  # quartile distance over median; 1.6 where amplitudes are exponential


def guess(effect: type[DarkCurrentSteps], clues: Clues) -> list[Effect]:
    """The spacing of the peaks, setting by setting; few or many atoms a pixel."""
    guesses = _counted(effect, clues)
    rare = _single_peak(clues)
    if rare is not None:
        guesses += _grown(effect, clues, rare[0], [rare[1]])
    if shows(clues, ("pattern_steps",)):
        z = np.nan_to_num(clues.z("pattern_steps"))
        spacing = np.asarray(clues.measured("pattern_step_dn"), float)
        guesses += _grown(effect, clues, np.where(z > SIGN, spacing, np.nan), [0.1, 0.5, 2.0])
    return guesses


def _counted(effect: type[DarkCurrentSteps], clues: Clues) -> list[Effect]:
    """Of the ripples in the characteristic functions of all settings."""
    if not shows(clues, effect.fingerprint):
        return []
    spacing, numbers = np.full(len(clues.points), np.nan), []
    for setting in range(spacing.size):
        x, n = (curve(clues, f"pattern_hist_{axis}", setting) for axis in "xn")
        counted = None if x is None or n is None else counted_steps(x, n)
        if counted is not None:
            spacing[setting] = counted[0]
            numbers.append(counted[1])
    return _grown(effect, clues, spacing, [float(np.median(numbers))]) if numbers else []


def _grown(
    effect: type[DarkCurrentSteps], clues: Clues, spacing: np.ndarray, numbers: list[float]
) -> list[Effect]:
    """Guesses from a spacing of peaks, DN, one a setting."""
    fitted = hints.thermal_fit(clues, spacing / hints.exposure_and_gain(clues), 0.35)
    if fitted is None:
        return []
    step, ea = fitted
    return [effect(**clip(effect, step=step, mean_number=n, ea_ev=ea)) for n in numbers]


def _single_peak(clues: Clues) -> tuple[np.ndarray, float] | None:
    """Amplitude, DN, one a setting, and share of hot pixels that are all about equally hot.

    Where atoms are rare nearly all such pixels hold one: a single peak far above the core, and no
    spacing to be seen. Hot pixels of other origin spread over a decade.
    """
    if not shows(clues, [f"hot_count_{k}" for k in (5, 8, 16)]):
        return None
    sigma = np.asarray(clues.measured("pattern_noise_core"), float)
    amplitude, shares = np.full(sigma.size, np.nan), []
    for setting in range(sigma.size):
        x, n = (curve(clues, f"pattern_hist_{axis}", setting) for axis in "xn")
        if x is None or n is None or not np.isfinite(sigma[setting]):
            continue
        summed = np.cumsum(n)
        x = x - np.interp(0.5 * summed[-1], summed, x)
        hot = x > FAR * sigma[setting]
        count = np.cumsum(n[hot])
        if not hot.any() or count[-1] < FEWEST:
            continue
        low, middle, high = np.interp(np.array([0.25, 0.5, 0.75]) * count[-1], count, x[hot])
        if high - low < NARROW * middle:
            amplitude[setting] = middle
            shares.append(float(count[-1] / summed[-1]))
    return (amplitude, max(shares)) if shares else None
