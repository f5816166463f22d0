"""Evidence kept beside the statistics, so that a second `detect` does not read the frames again."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.analyzers.estimators.saturation import Saturation
from dnanalyze.analyzers.streaming import cache
from dnanalyze.detection.correlation import LagCorrelation
from dnanalyze.detection.evidence import ViewEvidence
from dnanalyze.detection.excess import Excess, StandingOut
from dnanalyze.detection.extremes import Exceedance, RowPhase
from dnanalyze.detection.memory import Autocorrelation
from dnanalyze.detection.replaced import Replaced
from dnanalyze.detection.spectrum import OctaveSpectrum
from dnanalyze.detection.texture import Texture
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint

TYPES: dict[str, Any] = {
    kind.__name__: kind
    for kind in (
        Autocorrelation, Exceedance, Excess, LagCorrelation, OctaveSpectrum, OperatingPoint,
        Replaced, RowPhase, Saturation, StandingOut, Texture, ViewEvidence,
    )
}  # fmt: skip


def entry_of(captures: CaptureSet) -> cache.Entry | None:
    """The entry of these captures' evidence; None where none can be kept."""
    return cache.held(captures, "detect", cache.code(Path(__file__).parent))


def read(entry: cache.Entry) -> list[ViewEvidence] | None:
    """The evidence that was stored; None where there is none."""
    return entry.read(lambda plain, arrays: [_made(item, arrays) for item in plain])


def write(entry: cache.Entry, evidence: list[ViewEvidence]) -> None:
    """Store the evidence."""
    arrays: dict[str, np.ndarray] = {}
    entry.write([_plain(item, arrays) for item in evidence], arrays)


def _plain(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """A tree of dataclasses, tuples, numbers and arrays as JSON; arrays by name."""
    if isinstance(value, np.ndarray):
        name = str(len(arrays))
        arrays[name] = value
        return {"array": name}
    if dataclasses.is_dataclass(value):
        fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        made = {name: _plain(item, arrays) for name, item in fields.items()}
        return {"type": type(value).__name__, "fields": made}
    if isinstance(value, tuple):
        return {"tuple": [_plain(item, arrays) for item in value]}
    if isinstance(value, dict):
        return {"items": [[k, _plain(item, arrays)] for k, item in value.items()]}
    return value.item() if isinstance(value, np.generic) else value


def _made(plain: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    if not isinstance(plain, dict):
        return plain
    if "array" in plain:
        return arrays[plain["array"]]
    if "tuple" in plain:
        return tuple(_made(item, arrays) for item in plain["tuple"])
    if "items" in plain:
        return {k: _made(item, arrays) for k, item in plain["items"]}
    fields = plain["fields"].items()
    return TYPES[plain["type"]](**{name: _made(item, arrays) for name, item in fields})
