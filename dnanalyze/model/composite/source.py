"""A composite effect as a Python file of the user's own, which draws the same frames."""

from __future__ import annotations

import ast
import inspect
from types import ModuleType
from typing import Any

from dnanalyze.model.composite import effect as composite
from dnanalyze.model.composite import elements, geometry
from dnanalyze.model.composite.effect import CompositeEffect, form_of
from dnanalyze.model.effect import ParameterInfo

_HEAD = '''\
"""{title}

Written by `dnanalyze describe`. Use it with `--effects` and the model file of the same run: the
random numbers are keyed by the name of the effect, so that the frames are the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from dnanalyze import Effect, Site, Stage, Window, choice, parameter
from dnanalyze.model import pink
from dnanalyze.model.streams import Stream

'''
_CLASS = '''\
@dataclass(frozen=True)
class {class_name}(Effect):
    """{title}"""

    name = "{name}"
    stage = Stage.LINE_READ
    varies = "{varies}"
    summary = "{title}"
    physics = "Found by `dnanalyze describe`; the cause is not stated."
    formula = "{formula}"

{fields}
{margin}    def apply(self, signal, site):
        """The signal with the effect, DN."""
        return changed(self, signal, site, {form})
'''


_MARGIN = '''
    def margin(self):
        """Pixels around a window that it reads."""
        return {}

'''


def own_effect(effect: CompositeEffect, title: str) -> str:
    """Source of a file for ``--effects`` with this effect alone, bit by bit the same.

    Parameters
    ----------
    effect : CompositeEffect
    title : str
        What it is, in a sentence.
    """
    form = form_of(effect.where).__name__
    title = " ".join(title.split()).replace('"', "'").replace("\\", "/")
    text = _CLASS.format(
        class_name="".join(part.title() for part in effect.where.split("_")) + "Effect",
        title=title,
        name=effect.name,
        varies="fixed" if effect.when == "fixed" and effect.what != "noise" else "temporal",
        formula=effect.formula,
        fields="\n".join(_field(effect, name) for name in _active(effect)),
        form=form,
        margin=_MARGIN.format(effect.margin()) if effect.margin() else "\n",
    )
    needed = _functions([form, "changed"])
    constants = f"MOST_PAST = {elements.MOST_PAST}  # earlier frames that a value may depend on\n"
    return _HEAD.format(title=title) + constants + "\n\n" + "\n\n".join([*needed, text])


def _active(effect: CompositeEffect) -> list[str]:
    """Its parameters in order, without those that its words do not use."""
    idle = effect.inactive_parameters()
    return [name for name in effect.parameters() if name not in idle]


def _field(effect: CompositeEffect, name: str) -> str:
    """The declaration of one parameter; words have the one that was found as the only choice."""
    info = effect.parameters()[name]
    value = getattr(effect, name)
    if info.scale == "choice":
        given = f", {value!r}" if info.choices else ""
        default = "()" if info.choices == () and isinstance(value, tuple) else repr(value)
        return f"    {name}: {type(value).__name__} = choice({default}, {info.doc!r}{given})"
    return f"    {name}: float = {_parameter(value, info)}"


def _parameter(value: Any, info: ParameterInfo) -> str:
    default = value if isinstance(value, (int, float)) else getattr(value, "value", 1.0)
    return (
        f"parameter(\n        {default!r}, {info.unit!r}, {info.lower!r}, {info.upper!r}, "
        f"{info.doc!r}, {info.scale!r}\n    )"
    )


def _functions(wanted: list[str]) -> list[str]:
    """Sources of functions and of all that they call, those called first."""
    known: dict[str, ModuleType] = {}
    for module in (elements, geometry, composite):
        for name, item in inspect.getmembers(module, inspect.isfunction):
            if item.__module__ == module.__name__:
                known[name] = module
    found: dict[str, str] = {}

    def take(name: str) -> None:
        if name in found:
            return
        source = inspect.getsource(getattr(known[name], name))
        used = [n.id for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Name)]
        for other in used:
            if other in known and other != name:
                take(other)
        found[name] = source

    for name in wanted:
        take(name)
    return [source + "" for source in found.values()]
