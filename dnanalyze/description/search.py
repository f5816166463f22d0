"""Every word on every layer, less what it finds in a simulated sensor of the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dnanalyze.description.fixed_elements import fixed_elements
from dnanalyze.description.found import Estimate, with_law
from dnanalyze.description.layers import Layers
from dnanalyze.description.lines import variance_lines
from dnanalyze.description.temporal import temporal
from dnanalyze.description.waves import waves
from dnanalyze.loaders.captures import OperatingPoint

Kind = tuple[str, str, str]  # what, when and where
LEAST_GAIN = 12.0  # twice a gain in log likelihood of 6: odds of 400 to 1, of some hundred tries
CHANCE = 2.0  # what a word finds in one simulated sensor, another may exceed: an exponential's tail


def searched(seen: Layers, chance: dict[Kind, float], reference: OperatingPoint) -> list[Estimate]:
    """Structures that explain more than their price and than chance does, the best first.

    ``chance``: see `by_chance`.
    """
    found = []
    for e in _words(seen):
        lawful = with_law(e, seen.points, seen.dark, reference, seen.lost_gain)
        found.append(replace(lawful, chance=CHANCE * chance.get(e.kind, 0.0)))
    return _best(sorted((e for e in found if e.worth > LEAST_GAIN), key=lambda e: -e.worth))


def by_chance(simulated: Layers) -> dict[Kind, float]:
    """What every kind of structure explains in a simulated sensor that has none."""
    found: dict[Kind, float] = {}
    for e in _words(simulated):
        found[e.kind] = max(found.get(e.kind, 0.0), e.explained)
    return found


def _words(seen: Layers) -> list[Estimate]:
    """What all words find."""
    even = np.ones(len(seen.taken))
    growths = [even]
    if np.ptp(seen.dark) > 0.1 * max(float(seen.dark.max()), 1e-9):
        growths.append(np.maximum(seen.dark, 1e-3 * float(seen.dark.max())))
    fixed = [t.fixed for t in seen.taken]
    found: list[Estimate] = []
    for growth in growths:
        found += waves(seen, fixed, growth, "level")
        found += fixed_elements(seen, fixed, growth)
    if seen.several:
        found += waves(seen, [t.variance for t in seen.taken], even, "noise")
        found += variance_lines(seen)
    return found + temporal(seen)


def _best(found: list[Estimate]) -> list[Estimate]:
    """The best of each geometry over the frames."""
    made: dict[tuple[str, str], Estimate] = {}
    for e in found:
        made.setdefault((e.effect.where, e.effect.when), e)
    return list(made.values())
