"""First guesses: what the statistics suggest for the parameters of each effect of the catalogue.

One file an effect, of the effect's name, with ``guess(effect, clues)``, or one of several effects
with the same estimate; and what several use.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
from functools import cache
from typing import Any

EFFECTS = "dnanalyze.model.effects"
SHARED = dict.fromkeys(("row_fpn", "column_noise"), "white_lines")


def guess_of(effect: type) -> Callable[..., list[Any]] | None:
    """The function ``guess(effect, clues)`` for an effect of the catalogue, or one derived from it.

    None for an effect from elsewhere.
    """
    for base in effect.__mro__:
        package, _, name = base.__module__.rpartition(".")
        name = SHARED.get(name, name)
        if package == EFFECTS and name in _files():
            made: Callable[..., list[Any]] = importlib.import_module(f"{__name__}.{name}").guess
            return made
    return None


@cache
def _files() -> frozenset[str]:
    return frozenset(module.name for module in pkgutil.iter_modules(__path__))
