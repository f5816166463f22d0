"""Numbers kept within the bounds of an effect's parameters."""

from __future__ import annotations


def bounded(effect: type, name: str, number: float) -> float:
    """A number moved within the bounds of an effect's parameter."""
    info = effect.parameters()[name]  # type: ignore[attr-defined]
    return min(max(float(number), info.lower), info.upper)


def clip(cls: type, **values: float) -> dict[str, float]:
    """The values kept inside the bounds of the effect's parameters."""
    known = cls.parameters()  # type: ignore[attr-defined]
    return {
        name: float(min(max(value, known[name].lower), known[name].upper))
        for name, value in values.items()
    }
