"""Hold a sensor's dark frames against a noise model, see where it fails, name what is missing.

>>> import dnanalyze
>>> captures = dnanalyze.load("captures/")          # doctest: +SKIP
>>> dnanalyze.compare(captures).error               # doctest: +SKIP
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

# Name to the module that holds it. They are imported when first asked for, so that
# `import dnanalyze` costs nothing.
_HOME = {
    "InputError": "dnanalyze.errors",
    "load": "dnanalyze.loaders",
    "CaptureSet": "dnanalyze.loaders.captures",
    "OperatingPoint": "dnanalyze.loaders.captures",
    "Window": "dnanalyze.loaders.captures",
    "analyze": "dnanalyze.analyzers.analyze",
    "Statistics": "dnanalyze.analyzers.statistics",
    "NoiseModel": "dnanalyze.model.noise_model",
    "load_model": "dnanalyze.model.noise_model",
    "dump_model": "dnanalyze.model.noise_model",
    "simulate": "dnanalyze.model.simulate",
    "catalogue": "dnanalyze.model.registry",
    "Effect": "dnanalyze.model.effect",
    "Site": "dnanalyze.model.effect",
    "Stage": "dnanalyze.model.effect",
    "parameter": "dnanalyze.model.effect",
    "choice": "dnanalyze.model.effect",
    "fit": "dnanalyze.fitting.fit",
    "compare": "dnanalyze.comparator.compare",
    "diagnose": "dnanalyze.diagnosis.diagnose",
    "add": "dnanalyze.diagnosis.refine",
    "refine": "dnanalyze.diagnosis.refine",
    "detect": "dnanalyze.detection.detect",
}

__all__ = sorted([*_HOME, "__version__"])


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("dnanalyze")
    if name not in _HOME:
        raise AttributeError(f"module 'dnanalyze' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
