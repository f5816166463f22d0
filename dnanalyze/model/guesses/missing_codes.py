"""First guesses of missing_codes: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.missing_codes import PERIODS, MissingCodes
from dnanalyze.model.guesses.code_widths import code_widths
from dnanalyze.model.guesses.evidence import histogram, shows, typical_positive

_MOST_CODES = 1 << 14  # of a histogram that is looked at
WIDTH_SCATTER = 0.1  # of a width: histograms tell no better
FEWEST = 4  # codes of a period; in shorter ones too few others are alike


def guess(effect: type[MissingCodes], clues: Clues) -> list[Effect]:
    """Sigma from the roughness of the histogram; periods near a power of two are tried too."""
    if not shows(clues, effect.fingerprint):
        return []
    rough = clues.measured("code_roughness")
    base = np.nan_to_num(clues.simulated("code_roughness"))
    sigma = math.sqrt(typical_positive(rough**2 - base**2))
    sigma = bounded(effect, "sigma", sigma or 0.1)
    guesses: list[Effect] = [effect(sigma)]
    if shows(clues, ["code_comb"]):
        guesses = [*_periodic(clues, sigma), *guesses]
    return guesses


def _periodic(clues: Clues, sigma: float) -> list[Effect]:
    """With the widths of the codes that the histograms tell; else with the period of the comb.

    Where every code is as wide as the others but for one of twice the width, or of none, a
    digital gain did it: that a converter's error should be just one step is a coincidence.
    """
    widths = code_widths(_histograms(clues), PERIODS)
    if not widths:
        period = typical_positive(clues.measured("code_comb_period"))
        turns = {p: p / period for p in PERIODS} if period else {}  # a harmonic may be strongest
        fits = [p for p, n in turns.items() if n > 0.9 and abs(n - round(n)) < 0.08]
        return [MissingCodes(sigma, "periodic", p) for p in fits[:2]]
    if any(_by_a_gain(d) for d in widths):
        return []
    return [_with_widths(d) for d in widths if d.any()]


def _by_a_gain(d: np.ndarray) -> bool:
    if d.size < FEWEST:
        return False
    odd = int(np.argmax(np.abs(d - np.median(d))))
    others = 1.0 + np.delete(d, odd)
    times = (1.0 + d[odd]) / others.mean()
    alike = bool(np.ptp(others) < WIDTH_SCATTER * others.mean())
    return alike and bool(min(abs(times - 2.0), times) < WIDTH_SCATTER)


def _with_widths(d: np.ndarray) -> MissingCodes:
    relative = tuple(round(float(v), 4) for v in d / np.std(d))
    return MissingCodes(
        bounded(MissingCodes, "sigma", float(np.std(d))), "periodic", d.size, relative
    )


def _histograms(clues: Clues) -> list[tuple[np.ndarray, np.ndarray]]:
    """Codes and counts of the settings that have whole codes, and not too many."""
    seen = [histogram(clues, "histogram", setting) for setting in range(len(clues.points))]
    return [
        h for h in seen if h is not None and not np.any(h[0] % 1) and np.ptp(h[0]) <= _MOST_CODES
    ]
