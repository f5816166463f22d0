"""Models with an effect's rivals in its place, at numbers that mean the same."""

from __future__ import annotations

from collections.abc import Iterator

from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel


def in_its_place(
    model: NoiseModel, name: str, known: dict[str, type[Effect]]
) -> Iterator[tuple[str, NoiseModel]]:
    """Each rival of an effect, with the model that has it instead.

    Parameters
    ----------
    model : NoiseModel
    name : str
        Effect of the model; one that is no extra dark signal of few pixels has no such rivals.
    known : dict
        Effects that may come, by name; those count that are confused with it.
    """
    mine = model.get(name)
    signal = None if mine is None else mine.hot_signal(model.reference)
    if mine is None or signal is None:
        return
    without = model.without(name)
    for rival, effect in known.items():
        if rival != name and alike(mine, effect):
            for guess in effect.of_hot_signal(signal):
                yield rival, without.with_effect(guess)


def alike(mine: Effect, other: type[Effect]) -> bool:
    """Whether one of them names the other among what it is confused with."""
    return mine.name in other.confused_with or other.name in mine.confused_with
