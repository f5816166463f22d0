"""What a part of the field says first, within seconds, before the whole confirms or corrects it."""

from __future__ import annotations

from collections.abc import Sequence

from dnanalyze.diagnosis.everyday import everyday, lacks_everyday
from dnanalyze.diagnosis.screening import prospects
from dnanalyze.diagnosis.trial import candidates_of
from dnanalyze.fitting.from_part import fitted
from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE


def first_answer(
    held: Bench,
    model: NoiseModel,
    known: dict[str, type[Effect]],
    exclude: Sequence[str] = (),
) -> list[str]:
    """Effects in the order of the fall of the error that first-order screening expects.

    No refit has confirmed them. The middle quarter of the field is screened, with the baseline
    effects put in where the model has none.

    Parameters
    ----------
    held : Bench
        Statistics of the captures.
    model : NoiseModel
        Where to begin.
    known : dict
        Effects to consider, by name.
    exclude : sequence of str
        Baseline effects to leave out.

    Returns
    -------
    list of str
        Empty where nothing is expected, or where the captures are so small that the whole answers
        as soon.
    """
    part = held.part
    if part is None:
        return []
    state = fitted(part, model)
    if lacks_everyday(model, exclude):
        stages: list[State] = [state]
        everyday(part, state, exclude, lambda _, stage: stages.append(stage))
        state = stages[-1]
    found = prospects(part, state, candidates_of(state, known, [BASE]))
    return list(dict.fromkeys(p.effect for p in found))
