"""All cases, one of each generator in turn: a part of the suite is like the whole."""

from __future__ import annotations

import importlib
import zlib
from itertools import chain, zip_longest

from third_party.case import Case

GENERATORS = {
    "plain": "third_party.generators.plain",
    "getframes": "third_party.generators.getframes_camera",
    "pyxel": "third_party.generators.pyxel_detector",
    "virtual": "third_party.generators.virtual_sensor",
    "filters": "third_party.generators.filters",
    "literature": "third_party.generators.literature",
}


def of_generator(generator: str, series: int = 0) -> list[Case]:
    """Its cases, in an order that is fixed and like a shuffled one."""
    recipes = importlib.import_module(GENERATORS[generator]).RECIPES
    cases = [
        Case(generator, name, strength, recipe, series)
        for name, recipe in recipes.items()
        for strength in range(len(recipe.amounts))
    ]
    return sorted(cases, key=lambda c: zlib.crc32(f"order {c.key}".encode()))


def all_cases(generators: list[str], series: int = 0) -> list[Case]:
    """One of each generator in turn until all are spent."""
    columns = [of_generator(g, series) for g in generators]
    return [c for c in chain.from_iterable(zip_longest(*columns)) if c is not None]
