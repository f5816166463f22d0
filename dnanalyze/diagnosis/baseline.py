"""The baseline effects, which every sensor has, put in together and stated one by one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from dnanalyze.fitting.fit import at_a_glance, ordinary_start
from dnanalyze.fitting.from_part import converge, fitted
from dnanalyze.fitting.least_squares import State, given
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.start import partly_named
from dnanalyze.model.laws import Law
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import EVERYDAY

EVERY_SENSOR = (
    "baseline effect, present in every sensor: added with the other baseline effects, untested"
)
FAR_OFF = 5.0  # loss per statistic beyond which the next effect moves all that is fitted here


def far_off(state: State) -> bool:
    """Whether so much is left that the next effect moves all parameters."""
    return state.loss > FAR_OFF * len(state.train)


def lacks_baseline(model: NoiseModel, exclude: Sequence[str] = ()) -> bool:
    """Whether a model has none of the baseline effects that are not excluded."""
    wanted = any(name not in exclude for name in EVERYDAY)
    return wanted and all(model.get(name) is None for name in EVERYDAY)


def baseline_start(bench: Bench, exclude: Sequence[str] = (), seed: int = 0) -> NoiseModel:
    """The model with the baseline effects that are not excluded, from moments of the frames."""
    begun = ordinary_start(bench)
    for name in exclude:
        begun = begun.without(name)
    return replace(begun, seed=seed)


def baseline_fitted(bench: Bench, begun: NoiseModel) -> State:
    """All baseline effects fitted together."""
    return fitted(bench, begun, partial(converge, hopeless=FAR_OFF))


def with_baseline(
    bench: Bench, paper: State, exclude: Sequence[str], note: Callable[[str, State], None]
) -> State:
    """Add the baseline effects; all are fitted together, beside a seed of constant spread.

    The models on the way take the effects named so far from that fit, and the rest from the tables
    of the Wang 2025 model.

    ``paper``: the Wang 2025 model, fitted. ``note``: called with each effect and the state then.
    """
    found = at_a_glance(bench)
    full = baseline_fitted(bench, baseline_start(bench, exclude, paper.model.seed))
    names = [n for n in EVERYDAY if n not in exclude]

    def stage(named: Sequence[str], pedestal: Law) -> State:
        model = partly_named(found, paper.model, full.model, named, pedestal)
        train, test = bench.coordinates(model)
        blank = np.empty((len(train), 0))
        return State(model, [], bench.train.z(train), given(bench.test.z(test)), blank)

    before = paper
    for count in range(1, len(names)):
        state = stage(names[:count], full.model.pedestal)
        if state.loss > before.loss:  # its pedestal may still be that of the paper's model
            state = min(state, stage(names[:count], paper.model.pedestal), key=lambda s: s.loss)
        note(names[count - 1], state)
        before = state
    note(names[-1], full)
    return full
