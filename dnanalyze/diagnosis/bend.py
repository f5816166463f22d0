"""Another strength of an effect with everything that it bends: a step that no derivative finds.

A filter over frames takes noise away, and the fit of the model without it has made the noise small
instead. Strength and noise must then move together, far and along a curve.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from dnanalyze.diagnosis.screening import unbent
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import State, converge, start
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.noise_model import NoiseModel

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
    begun = [start(bench, model, knobs_of(model)) for model in _other_strengths(state.model, name)]
    best = min(begun, key=lambda s: s.loss, default=None)
    return None if best is None else converge(bench, best)


def _other_strengths(model: NoiseModel, name: str) -> Iterator[NoiseModel]:
    effect = model.get(name)
    if effect is None:
        return
    for parameter, info in effect.parameters().items():
        value = getattr(effect, parameter)
        if info.scale in ("choice", "held") or not isinstance(value, (int, float)):
            continue
        for factor in FACTORS:
            other = replace(effect, **{parameter: min(max(value * factor, info.lower), info.upper)})
            rest = unbent(model, other, effect)
            if rest is not None:
                yield rest.with_effect(other)
