"""First guesses of noisy_pixels: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.noisy_pixels import NoisyPixels
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import curve, quietest, shows

LEVELS = (0.5, 0.9, 0.99, 0.999)  # quantiles of the variance, as the statistics have them
# Shares and variance ratios that are compared; a fit follows from the nearest
FRACTIONS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.2)
RATIOS = np.geomspace(1.5, 8.0, 12) ** 2
REPEATS = 0.02  # correlation of the variances in two halves; heavy tails alone have 0


def guess(effect: type[NoisyPixels], clues: Clues) -> list[Effect]:
    """The two populations whose quantiles of the temporal variance are nearest to the measured
    ones, at the quietest setting, where shot noise differs least from pixel to pixel.
    """
    names = [f"temporal_variance_q{p:g}" for p in LEVELS]
    if not shows(clues, (*names, "temporal_kurtosis", "blink_repeat"), 0):
        return []
    noise = clues.measured("temporal_noise")
    if not (np.isfinite(noise) & (noise > 0)).any():
        return []
    quiet = quietest(noise)
    seen = np.array([clues.measured(n)[quiet] for n in names])
    repeat = float(clues.measured("blink_repeat")[quiet])
    means = curve(clues, "frame_means", quiet)
    if not (np.isfinite(seen).all() and (seen > 0).all()) or means is None or repeat < REPEATS:
        return []
    freedom = max(means.size - 1, 1)
    fits = [
        (float(np.sum(np.log(populations(f, float(r), freedom) / seen) ** 2)), f, float(r))
        for f in FRACTIONS
        for r in RATIOS
    ]
    best = [min(fit for fit in fits if fit[1] == f) for f in FRACTIONS]
    guesses: list[Effect] = []
    for _, fraction, ratio in sorted(best)[:2]:
        usual = noise[quiet] ** 2 / (1.0 + fraction * (ratio - 1.0))
        sigma = math.sqrt((ratio - 1.0) * usual) / hints.gains(clues)[quiet]
        guesses.append(effect.within(fraction=fraction, sigma=sigma))
    return guesses


def populations(fraction: float, ratio: float, freedom: int) -> np.ndarray:
    """Quantiles ``LEVELS`` of the variances over pixels, over their mean, of two populations.

    ``ratio``: variance of the noisier ones over that of the others; chi-squared of ``freedom``.
    """
    from scipy.special import chdtr

    x = np.geomspace(1e-3, 60.0, 2000)
    usual = chdtr(freedom, freedom * x)
    noisy = chdtr(freedom, freedom * x / ratio)
    share = (1.0 - fraction) * usual + fraction * noisy
    found: np.ndarray = np.interp(LEVELS, share, x)
    return found / (1.0 + fraction * (ratio - 1.0))
