"""Folder of dark frames to a ``CaptureSet``: one file a format."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dnanalyze.loaders.folder import load as load
    from dnanalyze.loaders.inspection import inspect as inspect
    from dnanalyze.loaders.mosaic import planes as planes
    from dnanalyze.loaders.writers import write_captures as write_captures

_HOME = {"load": "folder", "inspect": "inspection", "planes": "mosaic", "write_captures": "writers"}
__all__ = ["inspect", "load", "planes", "write_captures"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
