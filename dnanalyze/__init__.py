"""Compare a noise model with a sensor's dark frames, and identify the missing physical effect.

The units are DN (digital numbers), e- (electrons), C (degrees Celsius) and s. A session::

    import dnanalyze

    captures = dnanalyze.load("captures/")
    comparison = dnanalyze.compare(captures)
    comparison.plot()
    diagnosis = dnanalyze.diagnose(captures, comparison.model)
    better = dnanalyze.add(captures, diagnosis.candidates[0].effect, comparison.model)
    better.plot()
    better.save("model.yaml")

Every result prints (``summary``), tabulates (``to_dataframe``), saves (``save``), plots (``plot``)
and shows itself in a notebook.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dnanalyze.analyzers.analyze import analyze
    from dnanalyze.analyzers.statistics import Statistics
    from dnanalyze.benchmarking.run import BenchmarkResult, benchmark
    from dnanalyze.channels.refinement import ChannelRefinement, refine_channels
    from dnanalyze.checking.check import CheckResult, check
    from dnanalyze.checking.targets import load_targets
    from dnanalyze.classifier.classify import classify
    from dnanalyze.classifier.result import Classification
    from dnanalyze.comparator.compare import Comparison, compare
    from dnanalyze.description.describe import Description, describe
    from dnanalyze.description.pattern import LearnedPattern, learn_pattern
    from dnanalyze.detection.detect import detect
    from dnanalyze.detection.results import Detection
    from dnanalyze.diagnosis.diagnose import Diagnosis, diagnose
    from dnanalyze.diagnosis.refine import Refinement, add, refine
    from dnanalyze.diagnosis.search_path import SearchLimits
    from dnanalyze.errors import InputError
    from dnanalyze.estimate import Estimate
    from dnanalyze.fitting.fit import Fit, fit
    from dnanalyze.loaders.arrays import from_arrays
    from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Window
    from dnanalyze.loaders.folder import load
    from dnanalyze.loaders.inspection import inspect
    from dnanalyze.model.add_noise import add_dark_noise
    from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
    from dnanalyze.model.export.export import export
    from dnanalyze.model.noise_model import NoiseModel, dump_model, load_model
    from dnanalyze.model.registry import catalogue
    from dnanalyze.model.simulate import simulate

    __version__: str

__all__ = [
    "BenchmarkResult",
    "CaptureSet",
    "ChannelRefinement",
    "CheckResult",
    "Classification",
    "Comparison",
    "Description",
    "Detection",
    "Diagnosis",
    "Effect",
    "Estimate",
    "Fit",
    "InputError",
    "LearnedPattern",
    "NoiseModel",
    "OperatingPoint",
    "Refinement",
    "SearchLimits",
    "Site",
    "Stage",
    "Statistics",
    "Window",
    "__version__",
    "add",
    "add_dark_noise",
    "analyze",
    "benchmark",
    "catalogue",
    "check",
    "choice",
    "classify",
    "compare",
    "describe",
    "detect",
    "diagnose",
    "dump_model",
    "export",
    "fit",
    "from_arrays",
    "inspect",
    "learn_pattern",
    "load",
    "load_model",
    "load_targets",
    "parameter",
    "refine",
    "refine_channels",
    "simulate",
]

# Where each name lives. They are imported when first asked for, so that `import dnanalyze` costs
# nothing; a type checker reads the imports above instead.
_HOME = {
    "dnanalyze.analyzers.analyze": ("analyze",),
    "dnanalyze.analyzers.statistics": ("Statistics",),
    "dnanalyze.benchmarking.run": ("BenchmarkResult", "benchmark"),
    "dnanalyze.channels.refinement": ("ChannelRefinement", "refine_channels"),
    "dnanalyze.checking.check": ("CheckResult", "check"),
    "dnanalyze.comparator.compare": ("Comparison", "compare"),
    "dnanalyze.checking.targets": ("load_targets",),
    "dnanalyze.classifier.classify": ("classify",),
    "dnanalyze.classifier.result": ("Classification",),
    "dnanalyze.description.describe": ("Description", "describe"),
    "dnanalyze.description.pattern": ("LearnedPattern", "learn_pattern"),
    "dnanalyze.detection.detect": ("detect",),
    "dnanalyze.detection.results": ("Detection",),
    "dnanalyze.diagnosis.diagnose": ("Diagnosis", "diagnose"),
    "dnanalyze.diagnosis.refine": ("Refinement", "add", "refine"),
    "dnanalyze.diagnosis.search_path": ("SearchLimits",),
    "dnanalyze.errors": ("InputError",),
    "dnanalyze.estimate": ("Estimate",),
    "dnanalyze.fitting.fit": ("Fit", "fit"),
    "dnanalyze.loaders.arrays": ("from_arrays",),
    "dnanalyze.loaders.captures": ("CaptureSet", "OperatingPoint", "Window"),
    "dnanalyze.loaders.folder": ("load",),
    "dnanalyze.loaders.inspection": ("inspect",),
    "dnanalyze.model.add_noise": ("add_dark_noise",),
    "dnanalyze.model.effect": ("Effect", "Site", "Stage", "choice", "parameter"),
    "dnanalyze.model.export.export": ("export",),
    "dnanalyze.model.noise_model": ("NoiseModel", "dump_model", "load_model"),
    "dnanalyze.model.registry": ("catalogue",),
    "dnanalyze.model.simulate": ("simulate",),
}

if not TYPE_CHECKING:

    def __getattr__(name):
        if name == "__version__":
            from importlib.metadata import version

            return version("dnanalyze")
        for module, names in _HOME.items():
            if name in names:
                value = getattr(import_module(module), name)
                globals()[name] = value
                return value
        raise AttributeError(f"module 'dnanalyze' has no attribute {name!r}")

    def __dir__():
        return __all__
