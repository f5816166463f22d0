"""First guesses of defect_lines: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.defect_lines import DefectLines
from dnanalyze.model.guesses.evidence import excess, shows, typical_positive


def guess(effect: type[DefectLines], clues: Clues) -> list[Effect]:
    """The lines that stand out, as measured over the whole field: they have one place in it.

    Where no profile is at hand, their share from the count of outlying lines, and their offset
    from the farthest one.
    """
    guesses: list[Effect] = []
    for axis, line, across in (("columns", "column", 1), ("rows", "row", 0)):
        named = _measured(clues, axis)
        if named is not None:
            guesses.append(named)
            continue
        if not shows(clues, [f"{line}_{k}" for k in ("outliers", "extreme", "kurtosis")]):
            continue
        lines, length = clues.shape[across], clues.shape[1 - across]
        count = max(1.0, typical_positive(excess(clues, f"{line}_outliers")))
        farthest = typical_positive(clues.measured(f"{line}_extreme"))
        power = clues.simulated(f"pattern_{axis}_0.3_0.5")
        spread = math.sqrt(typical_positive(power) / length) or 1.0
        beyond = math.sqrt(1.0 + 2.0 * math.log(count))  # of the largest of so many Gaussians
        sigma = bounded(effect, "sigma", farthest * spread / beyond)
        guesses.append(effect(bounded(effect, "fraction", count / lines), sigma, axis))
    return guesses


def _measured(clues: Clues, axis: str) -> DefectLines | None:
    seen = clues.defects(axis)
    if not np.any(seen[:, 1]):  # in frames that are nearly all alike lines stand out by nothing
        return None
    across, along = (1, 0) if axis == "columns" else (0, 1)
    places, offsets, begins, ends = seen.T
    rms = float(np.sqrt(np.mean(offsets**2)))
    parts = bool((begins > 0).any() or (ends < clues.field[along]).any())
    return DefectLines(
        bounded(DefectLines, "fraction", len(seen) / clues.field[across]),
        bounded(DefectLines, "sigma", rms),
        axis,
        tuple(int(p) for p in places),
        tuple(round(float(o), 4) for o in offsets / rms),
        tuple(float(round(b)) for b in begins) if parts else (),
        tuple(float(round(e)) for e in ends) if parts else (),
    )
