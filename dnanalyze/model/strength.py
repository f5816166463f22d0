"""How strong an effect is: the parameters in proportion to which it changes the frames."""

from __future__ import annotations

from dataclasses import replace

from dnanalyze.model.bounds import bounded
from dnanalyze.model.effect import Effect

STRENGTHS = (
    "sigma", "rms", "amplitude", "fraction", "density", "rate", "mean_number", "alpha", "step",
    "strength", "loss",
)  # fmt: skip


def strength_of(effect: type[Effect]) -> str | None:
    """The positive parameter that says how strong an effect is; None of one without."""
    known = effect.parameters()
    return next((n for n, i in known.items() if i.scale == "log" and n in STRENGTHS), None)


def at_factor(effect: Effect, factor: float) -> Effect | None:
    """An effect at so many times its strength; None where that is no other effect.

    That is its positive strength, or of a surface or a pattern of signs each of its terms in DN.
    Parameters that follow a law over temperature are left as they are.
    """
    name = strength_of(type(effect))
    known, unused = effect.parameters(), effect.inactive_parameters()
    linear = [n for n, i in known.items() if i.scale in ("linear", "signed") and i.unit == "DN"]
    changed = {}
    for term in [name] if name else linear:
        value = getattr(effect, term)
        if term not in unused and isinstance(value, (int, float)):
            changed[term] = bounded(type(effect), term, factor * value)
    other = replace(effect, **changed)
    return None if other == effect else other
