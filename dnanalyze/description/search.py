"""Every estimator on every layer, less what it finds in a simulated sensor of the model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from dnanalyze.description.coarse import coarse_patterns
from dnanalyze.description.elements import changing_elements, fixed_elements
from dnanalyze.description.found import Estimate
from dnanalyze.description.law import with_law
from dnanalyze.description.layers import Layers
from dnanalyze.description.lines import few_lines, row_before
from dnanalyze.description.waves import waves
from dnanalyze.loaders.captures import OperatingPoint

Kind = tuple[str, str, str]  # what, when and where
LEAST_GAIN = 12.0  # twice a gain in log likelihood of 6: odds of 400 to 1, of some hundred tries
CHANCE = 2.0  # what a word finds in one simulated sensor, another may exceed: an exponential's tail


def searched(seen: Layers, chance: dict[Kind, float], reference: OperatingPoint) -> list[Estimate]:
    """The best of each geometry over the frames that explains more than its price and chance do.

    ``chance``: see `by_chance`.
    """
    found: dict[tuple[str, str], Estimate] = {}
    for tried in _estimates(seen):
        e = replace(with_law(tried, seen, reference), chance=CHANCE * chance.get(tried.kind, 0.0))
        form = e.effect.where, e.effect.when
        if e.worth > max(LEAST_GAIN, found[form].worth if form in found else 0.0):
            found[form] = e
    return sorted(found.values(), key=lambda e: -e.worth)


def by_chance(simulated: Layers) -> dict[Kind, float]:
    """What every kind of structure explains in a simulated sensor that has none."""
    found: dict[Kind, float] = {}
    for e in _estimates(simulated):
        found[e.kind] = max(found.get(e.kind, 0.0), e.explained)
    return found


def _estimates(seen: Layers) -> Iterator[Estimate]:
    """What all estimators find."""
    even = np.ones(len(seen.taken))
    growths = [even]
    if seen.grows:
        growths.append(np.maximum(seen.dark, 1e-3 * float(seen.dark.max())))
    fixed = [t.fixed for t in seen.taken]
    for growth in growths:
        yield from waves(seen, fixed, growth, "level")
        yield from fixed_elements(seen, fixed, growth)
    if seen.several:
        yield from waves(seen, [t.variance for t in seen.taken], even, "noise")
        yield from few_lines(seen)
        yield from row_before(seen)
        yield from changing_elements(seen)
        yield from coarse_patterns(seen)
