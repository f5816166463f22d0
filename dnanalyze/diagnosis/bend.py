"""What a fit without an effect bends to make up for it, put right; along it, other strengths.

A filter over frames takes noise away, and the fit of the model without it has made the noise small
instead. Strength and noise must then move together, far and along a curve. Of codes that so little
noise leaves the fit may have moved the level too, which the means of the frames tell still.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np

from dnanalyze.fitting.fit import ordinary_start
from dnanalyze.fitting.knobs import Knob, knobs_of, positions, turned
from dnanalyze.fitting.least_squares import State, converge, start
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect, Stage
from dnanalyze.model.guesses.evidence import quietest
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, EVERYDAY

UNBENT = (1.0, 0.0)
FACTORS = (0.5, 0.65, 0.8, 1.25, 1.5, 2.0)


def along_bend(bench: Bench, state: State, name: str) -> State | None:
    """The best of an effect's other strengths, with what each bends, refitted.

    Parameters
    ----------
    bench : Bench
    state : State
        Fitted model with the effect.
    name : str

    Returns
    -------
    State or None
        None where the effect bends nothing.
    """
    return _best(bench, _other_strengths(state.model, name, least_noise(bench)))


def begun_again(bench: Bench, state: State, name: str) -> State | None:
    """The effect as it is, refitted with what it bends begun again.

    The level as the means of the frames tell it, and numbers of which it leaves no trace as they
    are guessed with the effect: at a wrong strength these may have gone where no step leads back.
    Parameters and what is returned are those of `along_bend`.
    """
    effect, noise = state.model.get(name), least_noise(bench)
    if effect is None or unbent(state.model, effect, noise) is None:
        return None
    return _best(bench, [_afresh(bench, state.model, effect, noise)])


def begun_elsewhere(bench: Bench, state: State, name: str) -> State | None:
    """The effect at the best of its strengths that no bend leads to, begun again as `begun_again`.

    Parameters and what is returned are those of `along_bend`.
    """
    effect, noise = state.model.get(name), least_noise(bench)
    if effect is None or unbent(state.model, effect, noise) is None:
        return None
    others = [o for o in _strengths(effect) if unbent(state.model, o, noise, effect) is None]
    return _best(bench, [_afresh(bench, state.model, other, noise) for other in others])


def _afresh(bench: Bench, model: NoiseModel, effect: Effect, noise: float) -> NoiseModel:
    begun, model = ordinary_start(bench), model.with_effect(effect)
    level = relevelled(model, unbent(begun, effect, noise) or begun) or model
    return _turned(level, lambda k, x: _guessed(x, k, level, effect, noise)) or level


def _best(bench: Bench, models: Iterable[NoiseModel]) -> State | None:
    """The one that begins best, at its end; None of none."""
    begun = [start(bench, model, knobs_of(model)) for model in models]
    best = min(begun, key=lambda s: s.loss, default=None)
    return None if best is None else converge(bench, best)


def _other_strengths(model: NoiseModel, name: str, noise: float) -> Iterator[NoiseModel]:
    effect = model.get(name)
    for other in _strengths(effect) if effect is not None else ():
        rest = unbent(model, other, noise, effect)
        if rest is not None:
            yield rest.with_effect(other)


def _strengths(effect: Effect) -> Iterator[Effect]:
    """The effect with each of its numbers at other values."""
    for parameter, info in effect.parameters().items():
        value = getattr(effect, parameter)
        free = info.scale not in ("choice", "held") and parameter not in effect.idle()
        if not (free and isinstance(value, (int, float))):
            continue
        for factor in FACTORS:
            other = min(max(value * factor, info.lower), info.upper)
            if other != value:
                yield replace(effect, **{parameter: other})


def least_noise(bench: Bench) -> float:
    """Temporal noise of the quietest frames that tell it, DN; infinite where there is none."""
    train = bench.train
    values = train.values[train.names == "temporal_noise"]
    return float(values[quietest(values)]) if values.size else math.inf


def unbent(
    model: NoiseModel, effect: Effect, noise: float = math.inf, other: Effect | None = None
) -> NoiseModel | None:
    """A model whose numbers are right with an effect in it; None where it bends none of them.

    The numbers are those of a fit without it, or with it as ``other`` says, to frames of which the
    quietest have so much noise, DN.
    """
    return _turned(model, lambda k, x: _right(x, k, model, effect, noise, other))


def _turned(model: NoiseModel, right: Callable[[Knob, float], float]) -> NoiseModel | None:
    """A model with other numbers; None where they are the same."""
    knobs = knobs_of(model)
    plain = [k.plain(x) for k, x in zip(knobs, positions(model, knobs), strict=True)]
    other = [right(k, x) for k, x in zip(knobs, plain, strict=True)]
    if other == plain:
        return None
    where = [k.inside(k.position(x)) for k, x in zip(knobs, other, strict=True)]
    return turned(model, knobs, np.array(where))


def beside(bench: Bench, model: NoiseModel, effect: Effect) -> NoiseModel | None:
    """The model with what every sensor has begun again, by the moments less what an effect adds.

    None where it does not tell.
    """
    if any(effect.adds(p, model.reference) is None for p, _ in bench.plan.settings):
        return None
    begun = ordinary_start(bench, effect)
    for name in (BASE, *EVERYDAY):
        other = begun.get(name)
        if other is not None and model.get(name) is not None:
            model = model.with_effect(other)
    return replace(model, pedestal=begun.pedestal)


def relevelled(model: NoiseModel, begun: NoiseModel) -> NoiseModel | None:
    """A model with the black level and the seed of another; None where other numbers are free."""
    seed = begun.get(BASE)
    if seed is None or model.get(BASE) is None:
        return None
    made = replace(model, pedestal=begun.pedestal).with_effect(seed)
    return made if knobs_of(made) == knobs_of(model) else None


def _right(
    x: float, knob: Knob, model: NoiseModel, effect: Effect, noise: float, other: Effect | None
) -> float:
    factor, shift = bending(effect, knob, model, noise)
    was, moved = UNBENT if other is None else bending(other, knob, model, noise)
    if (factor, shift) == (was, moved) or not was:
        return x
    return factor * (x - moved) / was + shift


def _guessed(x: float, knob: Knob, model: NoiseModel, effect: Effect, noise: float) -> float:
    """A number as it is, or, where the effect leaves no trace of it, as it is guessed with it."""
    factor, shift = bending(effect, knob, model, noise)
    return x if factor else shift


def bending(effect: Effect, knob: Knob, model: NoiseModel, noise: float) -> tuple[float, float]:
    """Factor and shift of a number of a model that does without an effect.

    Numbers of what works on codes are as they were found on these.
    """
    bearer = model.get(knob.effect)
    if knob.effect == effect.name or (bearer is not None and bearer.stage > Stage.CONVERTER):
        return UNBENT
    return effect.bent(knob.name, knob.unit, noise)
