"""First guesses of dpc: its parameters as the statistics suggest them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dpc import Dpc
from dnanalyze.model.guesses.evidence import excess, shows, strongest, typical_positive

# Pixels above these multiples of the noise, as the statistics count them
_EXCESS = (("excess_4", 4.0), ("excess_8", 8.0), ("excess_16", 16.0))
HIGH_THRESHOLD = 3.0  # times the usual threshold from which that is looked at too
_LEAST = 1.0, 2.0  # noise: net signal that a multiple of the median may be taken of
_ENOUGH = 5.0  # pixels that should stand out
_TAIL = (  # quantiles of the pattern, and the share of the pixels above them
    ("pattern_q0.9", 0.1), ("pattern_q0.99", 0.01), ("pattern_q0.999", 1e-3),
    ("pattern_q0.9999", 1e-4),
)  # fmt: skip


def guess(effect: type[Dpc], clues: Clues) -> list[Effect]:
    """Threshold from where pixels that stand out begin to be rarer than modelled."""
    rare = [k for name, k in _EXCESS if shows(clues, [name], -1)]
    tied = shows(clues, ["ties_max8"])
    ranks = shows(clues, ["frame_pmax8", "pattern_pmax8", "temporal_pmax8"], -1)
    sparse = shows(clues, ["hot_count_16", "hot_count_32", "hot_count_64"], -1)
    cut = shows(clues, [name for name, _ in _TAIL[-2:]], -1)
    if not (rare or tied or ranks or sparse or cut):
        return []
    noise = typical_positive(clues.measured("temporal_noise_core")) or 1.0
    usual = bounded(effect, "threshold", (rare[0] if rare else 4.0) * noise)
    threshold = bounded(effect, "threshold", _threshold(clues) or usual)
    near = min(threshold, usual)
    guesses: list[Dpc] = []
    standing = bool(rare or ranks or tied)
    if standing:
        guesses.append(effect(threshold, kind="excess"))
        guesses.append(effect(near, kind="median"))
    # the fit without it has made the tail as short as the correction leaves it: then few are
    # missing where it begins
    low, high = (bounded(effect, "threshold", k * noise) for k in _LEAST)
    if rare:
        guesses += [effect(high, kind="multiple"), effect(low, kind="multiple")]
    if standing:
        guesses.append(effect.within(threshold=0.2 * noise, kind="clamp"))
    if sparse or cut:
        guesses.append(effect(kind="static"))
    if standing and threshold > HIGH_THRESHOLD * usual:
        guesses.append(effect(usual, kind="excess"))
    if rare:
        guesses.append(effect(low, kind="ratio"))
    if standing:
        guesses.append(effect(near, kind="excess", sides="both"))
        guesses.append(effect(threshold, kind="clamp"))
    # idle in most kinds, but at hand should it turn out to be another
    share, warmer = bounded(effect, "fraction", _listed(clues)), _hottest(clues)
    black = _darkest(clues)
    return [replace(kind, black=black, fraction=share, warmer=warmer) for kind in guesses]


def _darkest(clues: Clues) -> float:
    """DN of the setting with the least signal."""
    level = clues.measured("median")
    return float(np.nanmin(level)) if np.isfinite(level).any() else 0.0


def _hottest(clues: Clues) -> float:
    """C above the reference of the warmest setting: lists are made where defects show."""
    known = [p.temperature_c for p in clues.points if p.temperature_c is not None]
    origin = clues.reference.temperature_c
    return max(known) - origin if known and origin is not None else 0.0


def _threshold(clues: Clues) -> float:
    """DN above all neighbours from which pixels are gone, over all settings; 0: not to be seen.

    The noise, and with it what so many deviations are in DN, differs from setting to setting, so
    the counts bracket the threshold closer than those of one setting could.
    """
    noise = clues.measured("temporal_noise_core")
    leads, left, weights = [], [], []
    for name, k in _EXCESS:
        expected = clues.simulated(name)
        seen = clues.measured(name)
        usable = np.isfinite(noise * expected * seen) & (expected > _ENOUGH)
        leads += list(k * noise[usable])
        left += list(np.minimum(seen[usable] / expected[usable], 1.0))
        weights += list(np.sqrt(expected[usable]))
    if not leads:
        return 0.0
    order = np.argsort(leads, kind="stable")
    lead, share, weight = (np.array(v)[order] for v in (leads, left, weights))
    # what is missing below a threshold, and what is left above it, speak against it
    below = np.append(0.0, np.cumsum(weight * (1.0 - share)))
    above = np.append(np.cumsum((weight * share)[::-1])[::-1], 0.0)
    at = int(np.argmin(below + above))
    ends = np.concatenate([lead[:1] / 2.0, lead, lead[-1:] * 2.0])
    return float(np.sqrt(ends[at] * ends[at + 1]))


def _listed(clues: Clues) -> float:
    """Share of the pixels that the model has and the measurement lacks above its 99.99 % quantile.

    At the setting where that is farthest off; between quantiles the logarithm of the share goes
    with their value.
    """
    setting = strongest(clues, [_TAIL[-1][0]]) or 0
    top = float(clues.measured(_TAIL[-1][0])[setting])
    modelled = [float(clues.simulated(name)[setting]) for name, _ in _TAIL]
    if not np.all(np.isfinite([top, *modelled])):
        return typical_positive(-excess(clues, "hot_count_16")) / np.prod(clues.shape)
    return math.exp(np.interp(top, modelled, [math.log(share) for _, share in _TAIL]))
