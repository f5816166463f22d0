"""Effects from the user's own Python file: checked when read, and their errors told in one line."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.model.effect import Effect, Stage


def guarded(kind: type[Effect], path: Path) -> type[Effect]:
    """The same class; whatever its methods raise names the file and the effect.

    ``SystemExit`` too: a file of the user's must not end the program as if it were done.

    Raises
    ------
    InputError
        A class that cannot be an effect.
    """
    where = f"--effects {path}: {kind.name}"
    if not dataclasses.is_dataclass(kind):
        raise InputError(f"{where}: is no dataclass; write @dataclass(frozen=True) above it")
    for field in dataclasses.fields(kind):
        if "info" not in field.metadata:
            raise InputError(f"{where}.{field.name}: declare it with parameter(...) or choice(...)")
    if not isinstance(kind.stage, Stage):
        raise InputError(f"{where}: stage {kind.stage!r} is none of dnanalyze's Stage")
    for name, item in list(vars(kind).items()):
        if name not in vars(Effect) or name.startswith("__"):
            continue
        if isinstance(item, classmethod):
            setattr(kind, name, classmethod(_told(item.__func__, f"{where}.{name}")))
        elif callable(item):
            setattr(kind, name, _told(item, f"{where}.{name}", checked=name == "apply"))
    return kind


def own_error(where: str, error: BaseException) -> InputError:
    """What the user's code raised, in one line."""
    text = " ".join(str(error).split())[:160]
    return InputError(f"{where}: raises {type(error).__name__}{f' ({text})' if text else ''}")


def _told(function: Callable[..., Any], where: str, checked: bool = False) -> Callable[..., Any]:
    @functools.wraps(function)
    def call(*args: Any, **options: Any) -> Any:
        try:
            result = function(*args, **options)
        except (InputError, KeyboardInterrupt, MemoryError):
            raise
        except BaseException as error:  # whatever the user's code raises
            raise own_error(where, error) from error
        if checked:
            _check_signal(result, args[1].shape[-2:], where)
        return result

    return call


def _check_signal(result: Any, shape: tuple[int, ...], where: str) -> None:
    if not isinstance(result, np.ndarray) or result.dtype.kind not in "iuf":
        kind = f"{result.dtype} pixels" if isinstance(result, np.ndarray) else type(result).__name__
        raise InputError(f"{where}: returns {kind}; return the signal, an array of float32")
    if result.shape != shape:
        raise InputError(f"{where}: returns shape {result.shape}; return the signal's, {shape}")
    if not np.isfinite(result).all():
        raise InputError(f"{where}: returns pixels that are NaN or infinite; return finite ones")
