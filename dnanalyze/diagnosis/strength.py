"""How strong the effects of a completed model are: its numbers with their standard errors."""

from __future__ import annotations

import math
from dataclasses import replace

from dnanalyze.fitting.fit import Parameter, with_uncertainties
from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench

REPLICATES = 8  # simulated sensors; the errors are good to a quarter, 1 / sqrt(2 (8 - 1))


def parameters_of(held: Bench, state: State, replicates: int = REPLICATES) -> list[Parameter]:
    """The fitted numbers of a model as it stands.

    A refinement keeps the estimate that was made with one simulated sensor, whose luck is as large
    as that of the measured one: the variance is twice that of one sensor, where `fit`, which
    averages over 1 + n simulated sensors, has 1 + 1 / (1 + n) times it.

    Parameters
    ----------
    held : Bench
    state : State
    replicates : int
        Simulated sensors from which the errors are taken; 0: none, and the errors are NaN.
    """
    here = with_uncertainties(held, state, 0).parameters
    if replicates < 2:
        return here
    freed = {p.name: p.se for p in with_uncertainties(held, state, replicates).parameters}
    times = math.sqrt(2.0 / (1.0 + 1.0 / (1.0 + replicates)))
    return [replace(p, se=times * freed[p.name]) for p in here]
