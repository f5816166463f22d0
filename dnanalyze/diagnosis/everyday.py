"""What every sensor has, put in together, and told one by one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from dnanalyze.fitting.fit import at_a_glance, ordinary_start
from dnanalyze.fitting.from_part import fitted
from dnanalyze.fitting.least_squares import State, converge, given, start
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.start import partly_named
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.laws import Law
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import EVERYDAY

FAR_GAIN = 4.0  # times the conversion gain that the moments give
FAR_OFF = 5.0  # loss a number from which what is missing will move all that is fitted here
HARDLY, SPREAD = 0.05, 0.2  # of read noise over the pixels: no derivative tells; tried then
NO_WORSE = 0.03  # share of the loss by which a fit may lie higher or lower and be as good


def everyday(
    bench: Bench, paper: State, exclude: Sequence[str], note: Callable[[str, State], None]
) -> State:
    """Put in what every sensor has, and let what the paper's tables absorbed get its name.

    All four are fitted together, beside a seed of constant spread and kernel. The models on the
    way there take the effects named so far from that fit and leave the rest to the paper's tables.

    Parameters
    ----------
    bench : Bench
    paper : State
        The paper's model, fitted.
    exclude : sequence of str
        Effects to leave out.
    note : callable
        Called with the name of each effect and the state with it.
    """
    found, begun = at_a_glance(bench), ordinary_start(bench)
    for name in exclude:
        begun = begun.without(name)
    ended = partial(converge, own=True, hopeless=FAR_OFF)
    full = spread_out(bench, told_gain(bench, fitted(bench, begun, ended), begun))
    names = [n for n in EVERYDAY if n not in exclude]

    def stage(named: Sequence[str], pedestal: Law) -> State:
        model = partly_named(found, paper.model, full.model, named, pedestal)
        train, test = bench.coordinates(model)  # at once: both are asked for
        blank = np.empty((len(train), 0))
        return State(model, [], bench.train.z(train), given(bench.test.z(test)), blank)

    before = paper
    for count in range(1, len(names)):
        state = stage(names[:count], full.model.pedestal)
        if state.loss > before.loss:  # it may lie at the paper's still
            state = min(state, stage(names[:count], paper.model.pedestal), key=lambda s: s.loss)
        note(names[count - 1], state)
        before = state
    note(names[-1], full)
    return full


def lacks_everyday(model: NoiseModel, exclude: Sequence[str] = ()) -> bool:
    """Whether a model has none of what every sensor has; what else it lacks cannot be told yet.

    ``exclude``: not where all of it is excluded.
    """
    wanted = any(name not in exclude for name in EVERYDAY)
    return wanted and all(model.get(name) is None for name in EVERYDAY)


def spread_out(bench: Bench, fitted: State) -> State:
    """The fit, or one whose read noise differs from pixel to pixel, where that lies lower.

    At no spread at all no derivative tells of any.
    """
    read = fitted.model.get("read_noise")
    if not (isinstance(read, ReadNoise) and isinstance(read.spread, float)):
        return fitted
    if read.spread > HARDLY:
        return fitted
    model = fitted.model.with_effect(replace(read, spread=SPREAD))
    begun = start(bench, model, fitted.knobs, like=fitted)
    begun.jacobian[:, [k.name == "read_noise.spread" for k in fitted.knobs]] = np.nan
    if begun.loss > (1.0 - NO_WORSE) * fitted.loss:
        return fitted
    return converge(bench, begun, own=True, hopeless=FAR_OFF)


def told_gain(bench: Bench, fitted: State, begun: NoiseModel) -> State:
    """The fit with the conversion gain of its beginning, where next to no charge tells another.

    Without charge a fit may wander to electrons of hundreds of DN, for a few spikes, and whatever
    brings charge later would start with their noise.
    """
    found, first = (m.get("dark_shot_noise") for m in (fitted.model, begun))
    if not isinstance(found, DarkShotNoise) or not isinstance(first, DarkShotNoise):
        return fitted
    point = fitted.model.reference
    ratio = found.value("dn_per_e", point) / first.value("dn_per_e", point)
    if 1 / FAR_GAIN < ratio < FAR_GAIN:
        return fitted
    plain = start(bench, fitted.model.with_effect(first), fitted.knobs, like=fitted)
    return plain if plain.loss < fitted.loss * (1.0 + NO_WORSE) else fitted
