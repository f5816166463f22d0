"""Rows or columns whose noise exceeds that of the others."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.description.found import Estimate, Sizes
from dnanalyze.description.layers import Layers
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.robust import robust_deviation

LINE_ERRORS = 5.0  # standard errors by which a line stands out


def variance_lines(seen: Layers) -> list[Estimate]:
    """A share of the rows, or of the columns, with an additional noise."""
    if not seen.several:
        return []
    found = []
    for where, axis in (("row", 1), ("column", 0)):
        lines = [t.line_variances(axis) / t.noise**2 for t in seen.taken]
        mean = np.mean(lines, axis=0)
        middle = float(np.median(mean))
        error = robust_deviation(mean, middle)
        chosen = mean > middle + LINE_ERRORS * max(error, 1e-9)
        share = float(chosen.mean())
        if not 0 < share < 0.5:
            continue
        excess = [x[chosen] - np.median(x[~chosen]) for x in lines]
        size = np.array([float(x.mean()) for x in excess]) * [t.noise**2 for t in seen.taken]
        scatter = np.array([robust_deviation(x) for x in lines]) / math.sqrt(chosen.sum())
        sizes = Sizes(size, scatter * [t.noise**2 for t in seen.taken], squares=True)
        gain = float(np.sum(((mean[chosen] - middle) / error) ** 2))
        first = seen.window.top if where == "row" else seen.window.left
        effect = CompositeEffect(
            what="noise", where=where, distribution="two_level", share=share,
            lines=groups(chosen, first),
        )  # fmt: skip
        spread = math.sqrt(share * (1 - share) / chosen.size)
        price = (float(chosen.sum()) + 2.0) * math.log(chosen.size)
        found.append(Estimate(effect, {"share": spread}, gain, price, sizes))
    return found


def groups(chosen: np.ndarray, first: int) -> tuple[float, ...]:
    """First and last line of each run of chosen ones, one pair after the other."""
    edges = np.diff(np.concatenate([[0], chosen.astype(int), [0]]))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    return tuple(float(n + first) for pair in zip(starts, ends, strict=True) for n in pair)
