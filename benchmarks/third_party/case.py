"""What a case of the suite is: who draws it, what is in it, and what its frames must show."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

SHAPE = (256, 256)
FRAMES = 6
STRENGTHS = ("moderate", "strong")


@dataclass(frozen=True, order=True)
class Point:
    """An operating point: temperature (C) and exposure (s)."""

    temperature_c: float
    exposure_s: float


@dataclass(frozen=True)
class Claim:
    """A statistic of `measures.STATISTICS` lies between two values at a point of the case.

    ``point`` counts the operating points from cold to hot, -1 the hottest.
    """

    statistic: str
    low: float
    high: float
    point: int = -1
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Drawn:
    """Frames (frames, rows, columns) in DN by operating point, and the claims on them."""

    stacks: Mapping[Point, np.ndarray]
    claims: tuple[Claim, ...] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Recipe:
    """How a generator makes a case.

    Parameters
    ----------
    hides : tuple of str
        Kinds of `answers.ANSWERS`; empty: what every sensor has and nothing more.
    draw : callable
        ``draw(amount, seed)``.
    amounts : tuple of float
        One for each of the strengths; a recipe with one has that only.
    """

    hides: tuple[str, ...]
    draw: Callable[[float, int], Drawn]
    amounts: tuple[float, ...] = (0.0,)


@dataclass(frozen=True)
class Case:
    """One folder: a recipe of a generator at a strength, drawn for the ``series``-th time.

    Series 0 is the frozen suite; others are the same cases on seeds never seen before.
    """

    generator: str
    name: str
    strength: int
    recipe: Recipe
    series: int = 0

    @property
    def key(self) -> str:
        """Name of the case, and of its folder."""
        strength = f"-{STRENGTHS[self.strength]}" if len(self.recipe.amounts) > 1 else ""
        return f"{self.generator}/{self.name}{strength}" + (
            f"-series{self.series}" if self.series else ""
        )

    @property
    def seed(self) -> int:
        """Of the case alone: others may come and go beside it."""
        return zlib.crc32(self.key.encode())

    def drawn(self) -> Drawn:
        """The frames."""
        return self.recipe.draw(self.recipe.amounts[self.strength], self.seed)


def near(statistic: str, value: float, share: float = 0.2, **more: Any) -> Claim:
    """A claim of a value, give or take a share of it."""
    low, high = sorted((value * (1 - share), value * (1 + share)))
    return Claim(statistic, float(low), float(high), **more)


def both(first: Recipe, second: Recipe) -> tuple[str, ...]:
    """What two recipes hide together."""
    return first.hides + second.hides
