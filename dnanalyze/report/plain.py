"""Results as plain data that JSON can hold: every number finite or null."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.estimate import NORMAL_95


def plain(value: Any) -> Any:
    """Dictionaries, lists, text, finite numbers, booleans, None; NaN and infinity become None."""
    if isinstance(value, Enum):
        return plain(value.value)
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, (np.generic, np.ndarray)):
        return plain(value.tolist())
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if hasattr(value, "to_plain"):
        return plain(value.to_plain())
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(v) for v in value]
    raise TypeError(f"{type(value).__name__} has no plain form")


def estimate(value: float | None, se: float | None) -> dict[str, float | None]:
    """A number with its standard error and its interval of 95 %, in one unit."""
    if value is None or se is None:
        return {"value": value, "se": se, "low": None, "high": None}
    half = NORMAL_95 * se
    return {"value": value, "se": se, "low": value - half, "high": value + half}


def document(command: str, captures: str | None, **body: Any) -> dict[str, Any]:
    """What every JSON file begins with, then ``body``."""
    import dnanalyze

    head = {
        "schema": f"dnanalyze/{command}/1",
        "captures": captures,
        "version": dnanalyze.__version__,
    }
    return plain(head | body)


def to_json(content: Mapping[str, Any]) -> str:
    """JSON text with a newline at its end."""
    return json.dumps(plain(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
