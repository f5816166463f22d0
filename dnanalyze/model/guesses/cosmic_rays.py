"""First guesses of cosmic_rays: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.bounds import clip
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.cosmic_rays import CosmicRays
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import curve, excess, shows

LIMIT, CUT = 8.0, 6.0  # noises that a transient stands out by, and a difference of two frames
REACH, MUCH = 60.0, 0.1  # noises up to which differences are counted, nearly; share beyond
FEWEST, PLAIN = 4, 30.0  # differences that tell a charge; noises where they do not


def guess(effect: type[CosmicRays], clues: Clues) -> list[Effect]:
    """Rate from the pixels that stand out once; how many of them touch tells the length.

    The charge comes from how far frames differ, where those differ that do by far.
    """
    if not shows(clues, ("transient_high", "transient_adjacent")):
        return []
    hits = np.maximum(excess(clues, "transient_high"), 0)
    touching = np.maximum(excess(clues, "transient_adjacent"), 0)
    noise = np.asarray(clues.measured("temporal_noise_core"), float)
    good = (hits > 0) & (noise > 0)
    if not good.any():
        return []
    share = float(np.nansum(touching[good]) / np.sum(hits[good]))
    length = 0.5 if share < 0.3 else 1.0 + 4.0 * share
    pixels_a_hit = 1.5 + length
    place = int(np.nanargmin(np.where(good, noise, np.nan)))  # hot pixels flicker less there
    a_pixel, reached = _charge(clues, place, noise[place])
    seen = hits[good] / np.exp(-np.minimum(LIMIT * noise[good] / a_pixel, 3.0))
    seconds = np.array([1.0 if p.exposure_s is None else p.exposure_s for p in clues.points])
    # transients are counted over all frames of a setting; take eight, within a factor of a few
    rate = np.sum(seen) / pixels_a_hit / (8 * np.sum(seconds[good]))
    rate /= np.prod(clues.shape) * 1e-6
    energy = a_pixel / hints.gains(clues)[place] * pixels_a_hit
    more = (1, 10) if reached else (1,)
    numbers = [clip(effect, rate=rate, energy=energy * f, length=length) for f in more]
    return [effect(**n, charge=kind) for kind in ("track", "path") for n in numbers]


def _charge(clues: Clues, setting: int, noise: float) -> tuple[float, bool]:
    """Mean charge of a pixel that is hit, DN, and whether hits go beyond what is counted.

    An exponential charge is as large beyond any cut as beyond nothing. Both frames of a difference,
    which is over sqrt 2, may be hit.
    """
    x, n = (curve(clues, f"difference_hist_{axis}", setting) for axis in "xn")
    if x is None or n is None:
        return PLAIN * noise, True
    far = np.abs(x) / noise
    beyond, ends = n[far > CUT].sum(), n[far > REACH].sum()
    if beyond < FEWEST:
        return PLAIN * noise, True
    charge = math.sqrt(2.0) * noise * float(np.sum(n * np.maximum(far - CUT, 0.0)) / beyond)
    return charge, bool(ends > MUCH * beyond)
