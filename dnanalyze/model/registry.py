"""All effects by name: the built-in files, entry points, and a user's own file."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
import sys
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path

from dnanalyze.errors import InputError
from dnanalyze.model.effect import Effect
from dnanalyze.model.own_effects import guarded, own_error

BASELINE = ("read_noise", "pixel_fpn", "dark_shot_noise", "quantization")
BASE = "convolved_lognormal"
WANG = frozenset({BASE, "quantization"})  # the model of Wang 2025, and the converter
MEANT = 3  # names that a wrong one may stand for


@cache
def built_in() -> dict[str, type[Effect]]:
    """The catalogue: every file in ``effects`` and every ``dnanalyze.effects`` entry point."""
    from dnanalyze.model import effects

    effects_by_name: dict[str, type[Effect]] = {}
    for module in pkgutil.iter_modules(effects.__path__):
        effects_by_name |= _effects_of(importlib.import_module(f"{effects.__name__}.{module.name}"))
    for entry in entry_points(group="dnanalyze.effects"):
        effect = entry.load()
        effects_by_name[effect.name] = effect
    return effects_by_name


def catalogue(files: tuple[Path, ...] = ()) -> dict[str, type[Effect]]:
    """Return all effects by name: the built-in catalogue and the user's own files.

    Parameters
    ----------
    files : tuple of path
        Python files with classes derived from ``dnanalyze.Effect``.

    Returns
    -------
    dict
        Name to class.

    Raises
    ------
    InputError
        A file that is no Python file or holds no effect.

    Examples
    --------
    >>> import dnanalyze
    >>> "column_fpn" in dnanalyze.catalogue()
    True
    """
    effects_by_name = dict(built_in())
    for path in files:
        effects_by_name |= _load_file(path)
    return effects_by_name


def described() -> dict[str, type[Effect]]:
    """Effects that a model may hold but no diagnosis tries: `dnanalyze describe` makes them."""
    from dnanalyze.model.composite.effect import CompositeEffect
    from dnanalyze.model.learned.pattern_map import PatternMap

    return {kind.name: kind for kind in (CompositeEffect, PatternMap)}


def known_effects(
    effects: Iterable[str | Path] | Mapping[str, type[Effect]] = (),
) -> dict[str, type[Effect]]:
    """The effects that a model may be given.

    Parameters
    ----------
    effects : sequence of path, or mapping
        The user's own Python files, beside the built-in catalogue; or all effects by name.
    """
    if isinstance(effects, Mapping):
        return dict(effects)
    return catalogue(tuple(Path(path) for path in effects))


def find(name: str, known: dict[str, type[Effect]]) -> type[Effect]:
    """The effect of that name.

    Raises
    ------
    InputError
        Unknown; the message lists the valid names, those like it first.
    """
    if name not in known:
        like = [n for n in sorted(known) if name and name in n]
        like = like or get_close_matches(name, known, 1)
        meant = f"did you mean {' or '.join(like)}? " if 0 < len(like) <= MEANT else ""
        raise InputError(f"unknown effect {name!r}; {meant}valid names: {', '.join(sorted(known))}")
    return known[name]


def _load_file(path: Path) -> dict[str, type[Effect]]:
    spec = importlib.util.spec_from_file_location(f"dnanalyze_user_{path.stem}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise InputError(f"--effects {path}: not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look up annotations that are text there
    try:
        spec.loader.exec_module(module)
    except (KeyboardInterrupt, MemoryError):
        raise
    except BaseException as error:  # whatever the user's code raises, SystemExit too
        raise own_error(f"--effects {path}", error) from error
    effects_of_file = _effects_of(module)
    if not effects_of_file:
        raise InputError(f"--effects {path}: no class derived from dnanalyze.Effect with a name")
    return {name: guarded(kind, path) for name, kind in effects_of_file.items()}


def _effects_of(module: object) -> dict[str, type[Effect]]:
    return {
        item.name: item
        for _, item in inspect.getmembers(module, inspect.isclass)
        if issubclass(item, Effect)
        and isinstance(item.name, str)
        and item.name
        and item.__module__ == getattr(module, "__name__", "")
    }
