"""The virtual sensor of `dnanalyze.demo`: it shares no code with the model either.

Its own tests (tests/demo) hold what it draws against closed forms.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from dnanalyze.demo import EFFECTS, OUTSIDE, draw_sensor, generate, resolve
from third_party.case import FRAMES, SHAPE, Drawn, Point, Recipe

LEVELS = ("middling", "strong")
PAIRS = (
    ("column_fpn", "hot_pixels"),
    ("row_noise", "crosstalk"),
    ("amp_glow", "flicker_noise"),
    ("periodic_pattern", "missing_codes"),
)
ORDINARY = 5


def drawn(names: tuple[str, ...], level: str, seed: int) -> Drawn:
    """A sensor at random with these effects hidden."""
    sensor = draw_sensor(np.random.default_rng(seed))
    hidden = {name: {"level": level} for name in names}
    captures = generate(sensor, hidden, SHAPE, frames=FRAMES, seed=seed)
    stacks = {
        Point(float(s.point.temperature_c or 0.0), float(s.point.exposure_s or 0.0)): np.stack(
            [f.read() for f in s.frames]
        )
        for s in captures.settings
    }
    parameters: dict[str, Any] = {"sensor": asdict(sensor), "hidden": resolve(sensor, hidden, seed)}
    return Drawn(stacks, (), parameters)


def _single(name: str) -> Recipe:
    kinds = (f"outside:{name}",) if name in OUTSIDE else (name,)
    return Recipe(kinds, lambda a, seed: drawn((name,), LEVELS[int(a)], seed), (0, 1))


def _pair(names: tuple[str, str]) -> Recipe:
    return Recipe(names, lambda a, seed: drawn(names, "strong", seed))


RECIPES: dict[str, Recipe] = {
    **{name: _single(name) for name in EFFECTS},
    **{"+".join(names): _pair(names) for names in PAIRS},
    **{
        f"ordinary_{n}": Recipe((), lambda a, seed: drawn((), "strong", seed))
        for n in range(1, ORDINARY + 1)
    },
}
