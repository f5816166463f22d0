"""First guesses of dark_current_steps: its parameters as the statistics suggest them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dark_current_steps import DarkCurrentSteps
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.counted_steps import counted_steps
from dnanalyze.model.guesses.evidence import histogram, shows
from dnanalyze.model.guesses.hot_counts import USUAL
from dnanalyze.model.guesses.hot_peaks import Peak, hot_peaks
from dnanalyze.significance import SIGN

METALS = 0.35  # activation energy of molybdenum and tungsten, eV
TWICE = 0.2  # tolerance of the ratio 2 of two peaks, each found in bins of 10 %
# Of the fixed pattern: atoms lift a share of the pixels that may be any
QUANTILES = tuple(f"pattern_q{p}" for p in (0.001, 0.01, 0.1, 0.25, 0.75, 0.9, 0.99, 0.999))


def guess(effect: type[DarkCurrentSteps], clues: Clues) -> list[Effect]:
    """The spacing of the peaks, setting by setting; few or many atoms a pixel.

    Of rare atoms one peak may be seen alone, as of hot pixels that are alike.
    """
    guesses = _counted(effect, clues) + _rare(effect, clues)
    if shows(clues, ("pattern_steps",)):
        z = np.nan_to_num(clues.z("pattern_steps"))
        spacing = clues.measured("pattern_step_dn")
        guesses += _grown(effect, clues, np.where(z > SIGN, spacing, np.nan), [0.1, 0.5, 2.0])
    return guesses


def _rare(effect: type[DarkCurrentSteps], clues: Clues) -> list[Effect]:
    """One peak seen by itself, or two of which one is at twice the signal of the other."""
    steps = [_step(found) for found in hot_peaks(clues)]
    spacing = np.array([np.nan if step is None else step[0] for step in steps])
    known = [step for step in steps if step is not None]
    if not known:
        return []
    number, pairs = (float(np.median([step[i] for step in known])) for i in (1, 2))
    return _grown(effect, clues, spacing, [number], pairs)


def _step(peaks: Sequence[Peak]) -> tuple[float, float, float] | None:
    """Signal of one atom, DN, mean number of centres, and their share that has two atoms."""
    if not peaks:
        return None
    for one in peaks:
        for two in peaks:
            if abs(two.amplitude / one.amplitude - 2.0) < TWICE:
                number = one.share + two.share
                return two.amplitude / 2.0, number, two.share / number
    return peaks[0].amplitude, peaks[0].share, 0.0


def _counted(effect: type[DarkCurrentSteps], clues: Clues) -> list[Effect]:
    """Of the ripples in the characteristic functions, where the model's histogram is another."""
    if not shows(clues, QUANTILES, 0):
        return []
    spacing, numbers = np.full(len(clues.points), np.nan), []
    for setting in range(spacing.size):
        seen = histogram(clues, "pattern_hist", setting)
        counted = None if seen is None else counted_steps(*seen)
        if counted is not None:
            spacing[setting] = counted[0]
            numbers.append(counted[1])
    return _grown(effect, clues, spacing, [float(np.median(numbers))]) if numbers else []


def _grown(
    effect: type[DarkCurrentSteps],
    clues: Clues,
    spacing: np.ndarray,
    numbers: list[float],
    pairs: float = 0.0,
) -> list[Effect]:
    """Guesses from a spacing of peaks, DN, one a setting.

    Of a spacing seen at one temperature: the activation energy of these metals, and the usual one.
    """
    amplitude = spacing / hints.exposure_and_gain(clues)
    fits = [hints.thermal_fit(clues, amplitude, ea_ev) for ea_ev in (METALS, USUAL)]
    return [
        effect.within(step=fit[0], mean_number=n, ea_ev=fit[1], pairs=pairs)
        for fit in dict.fromkeys(fits)
        if fit is not None
        for n in numbers
    ]
