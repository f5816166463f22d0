"""First guesses of rts: its parameters as the statistics suggest them."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from dnanalyze.model.bounds import clip
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.rts import Rts
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import curve, shows
from dnanalyze.model.guesses.hot_counts import hot_signals

FRACTION_RATIO = 3.0  # times: two fractions nearer than this are one guess
SLOW = 2.0  # frames: a pixel that hardly changes in the series shows in the pattern too


def guess(effect: type[Rts], clues: Clues) -> list[Effect]:
    """From the noisiest pixels; and from the hot ones, where these are noisier than the model's."""
    guesses: list[Effect] = _of_noise(effect, clues)
    if shows(clues, ("noise_at_99", "noise_at_999")):
        guesses += [e for hot in hot_signals(clues)[:2] for e in effect.of_hot_signal(hot)]
    return guesses


def _of_noise(effect: type[Rts], clues: Clues) -> list[Effect]:
    """Step from the noisiest pixels' variance beyond Gaussian noise, fraction from the frame's.

    And from how far down the pixels are noisier than Gaussian noise has them: the frame's
    variance tells few blinking pixels badly.
    """
    if not shows(clues, effect.fingerprint[:6]):
        return []
    total = np.asarray(clues.measured("temporal_noise"), float) ** 2
    core = np.asarray(clues.measured("temporal_noise_core"), float) ** 2
    top = np.asarray(clues.measured("temporal_variance_q0.999"), float) * total
    gaussian = _gaussian_quantile(clues, 0.999)
    usual = np.asarray(clues.simulated("temporal_variance_q0.999"), float)
    step2 = 4.0 * (top - np.minimum(usual, gaussian) * core)
    if not (np.isfinite(step2) & (step2 > 0)).any():
        return []
    lost = np.where(step2 > 0, 4.0 * (total - core) / step2, np.nan)
    lost = lost[np.isfinite(lost) & (lost > 0)]
    fractions = [float(np.median(lost)) if lost.size else 0.01]
    few = _noisier(clues)
    if not 1 / FRACTION_RATIO < few / fractions[0] < FRACTION_RATIO:
        fractions.append(few)
    step = np.sqrt(np.where(step2 > 0, step2, np.nan))
    thermal = hints.thermal_fit(clues, step / hints.exposure_and_gain(clues), 0.6)
    fixed = float(np.nanmedian(step / hints.gains(clues)))
    kinds: list[tuple[float, float, str]] = [(fixed, 0.0, "none")]
    if thermal is not None and thermal[1] > 0.2:
        kinds.insert(0, (*thermal, "proportional"))
    # the noisiest pixels of few frames overstate the step; p E[A^2] o (1 - o) is kept
    shares = {"exponential": (0.35, 2.0), "fixed": (0.6, 1.0)}
    guesses: list[Effect] = []
    centred = {"polarity": "centred", "occupancies": "spread"}
    shapes: list[dict[str, Any]] = [{}, {"dwell_frames": SLOW}, centred]
    for law, shape in itertools.product(shares, shapes):
        share, square = shares[law]
        for fraction, (size, ea, exposure) in itertools.product(fractions, kinds):
            p = fraction / (share**2 * square)
            values = clip(effect, fraction=p, amplitude=size * share, ea_ev=ea)
            chosen = {**values, "amplitudes": law, "exposure": exposure, **shape}
            guesses.append(effect.from_plain(chosen))
    return guesses


def _gaussian_quantile(clues: Clues, level: float) -> float:
    """Quantile of the variances over pixels of equal Gaussian noise, over their mean."""
    from scipy.special import chdtri

    means = [curve(clues, "frame_means", i) for i in range(len(clues.points))]
    freedom = max((m.size for m in means if m is not None), default=8) - 1
    return float(chdtri(freedom, 1.0 - level)) / max(freedom, 1)


def _noisier(clues: Clues) -> float:
    """Share of the pixels that are noisier than the rest, from where their variance leaps.

    Over the quantile that Gaussian noise has, so that rounding, which widens all alike, is no leap;
    at the quietest setting, where shot noise differs least from pixel to pixel.
    """
    levels = (0.5, 0.9, 0.99, 0.999)
    core = np.asarray(clues.measured("temporal_noise_core"), float)
    quiet = int(np.nanargmin(core))
    seen = [
        np.asarray(clues.measured(f"temporal_variance_q{p:g}"), float)[quiet]
        / _gaussian_quantile(clues, p)
        for p in levels
    ]
    leaps = np.diff(np.log(np.nan_to_num(seen, nan=1.0)))
    return 3.0 * (1.0 - levels[1 + int(np.argmax(leaps))])
