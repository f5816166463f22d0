"""What the models tell of a sensor: errors, effects, gain, hidden filters; kept on disk."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from dnanalyze.analyzers.streaming import cache
from dnanalyze.benchmarking.benchmark_value import ABSENT, BenchmarkValue
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel

PACKAGE = Path(__file__).parents[1]
REPLICATES = 8  # simulated sensors that tell the error of the gain


@dataclass(frozen=True)
class Strength:
    """An effect of the refined model and how strong it is.

    Parameters
    ----------
    effect : str
    rms_dn : float or None
        Where its variance has a closed form: its share of a pixel's noise at the model's reference.
    parameters : dict
        Value (at the reference) and unit of each number.
    """

    effect: str
    rms_dn: float | None
    parameters: dict[str, tuple[float, str]]


@dataclass(frozen=True)
class ModelFindings:
    """What comparison, refinement and detection found of one sensor.

    Parameters
    ----------
    errors : dict
        "gaussian", "paper", "refined".
    gain : BenchmarkValue
        Conversion gain by the shot noise of the refined model.
    effects : list of Strength
    verdict : str
    reference : str
        Operating point at which the strengths are told.
    filtered : bool or None
    filter_kind : str
    notes : list of str
        What could not be done, and why.
    """

    errors: dict[str, float] = field(default_factory=dict)
    gain: BenchmarkValue = ABSENT
    effects: list[Strength] = field(default_factory=list)
    verdict: str = ""
    reference: str = ""
    filtered: bool | None = None
    filter_kind: str = ""
    notes: list[str] = field(default_factory=list)


KEPT = TypeAdapter(ModelFindings)  # reads what was kept on disk


def model_findings(
    captures: CaptureSet, quick: bool, on_progress: Callable[[str], None], processes: bool = True
) -> ModelFindings:
    """Compare, refine and detect; what was found before of the same files is read again.

    Parameters
    ----------
    captures : CaptureSet
    quick : bool
        Leave the refinement out.
    on_progress : callable
        Called with what is under way.
    processes : bool
        Whether other processes may be started.
    """
    entry = cache.held(captures, "benchmark", quick, cache.code(PACKAGE))
    known = None if entry is None else entry.read(lambda plain, _: KEPT.validate_python(plain))
    if known is not None:
        return known
    made = _model_findings(captures, quick, on_progress, processes)
    if entry is not None:
        entry.write(asdict(made), {})
    return made


def _model_findings(
    captures: CaptureSet, quick: bool, on_progress: Callable[[str], None], processes: bool
) -> ModelFindings:
    notes: list[str] = []
    errors, result = _refined(captures, quick, on_progress, processes, notes)
    filtered, kind = _filtered(captures, on_progress, notes)
    if result is None:
        return ModelFindings(errors, filtered=filtered, filter_kind=kind, notes=notes)
    on_progress("standard error of the gain")
    return ModelFindings(
        errors, _gain(result), strengths(result.model), result.verdict,
        result.model.reference.label(), filtered, kind, notes,
    )  # fmt: skip


def _refined(
    captures: CaptureSet,
    quick: bool,
    on_progress: Callable[[str], None],
    processes: bool,
    notes: list[str],
) -> tuple[dict[str, float], Any]:
    """Errors of the Gaussian, the paper's and the refined model; the refinement, or None.

    The search begins with the Wang 2025 model as the comparison has fitted it.
    """
    from dnanalyze.comparator.compare import compare_on
    from dnanalyze.diagnosis.refine import refine_on
    from dnanalyze.fitting.design import design
    from dnanalyze.fitting.problem import fit_problem
    from dnanalyze.fitting.processes import helpers_for

    on_progress("Wang 2025 model")
    try:
        plan = design(captures)
        problem = fit_problem(plan, helpers_for(plan.pixels) if processes else None)
        comparison = compare_on(captures, problem=problem)
    except InputError as error:
        notes.append(f"no model could be compared with it: {error}")
        return {}, None
    errors = {k: comparison.baselines[k] for k in ("gaussian", "paper")}
    if quick:
        return errors, None
    result = refine_on(
        captures,
        comparison.model,
        problem=problem,
        on_progress=lambda effect: on_progress(f"trying {effect}"),
        classifier=False,  # a seventh of the time, for the verdict alone
    )
    return errors | {"refined": result.steps[-1].error}, result


def strengths(model: NoiseModel) -> list[Strength]:
    """Each effect of a model with its numbers at the model's reference."""
    made = []
    for effect in model.effects:
        variance = effect.variance(model.reference)
        numbers = {
            key: (np.asarray(effect.value(key, model.reference)).item(), info.unit)
            for key, info in effect.parameters().items()
            if info.scale != "choice"
        }
        rms = math.sqrt(variance) if variance is not None and variance >= 0 else None
        made.append(Strength(effect.name, rms, numbers))
    return made


def _gain(result: Any) -> BenchmarkValue:
    if result.model.get("dark_shot_noise") is None:
        return ABSENT
    from dnanalyze.fitting.fit import with_uncertainties

    fitted = with_uncertainties(result.problem, result.state, REPLICATES)
    estimates = {p.name: p for p in fitted.parameters}
    gain = estimates.get("dark_shot_noise.dn_per_e")
    if gain is None or not (math.isfinite(gain.se) and gain.se < 0.5 * gain.value):
        return ABSENT
    return BenchmarkValue(gain.value, gain.se, "shot noise of the refined model")


def _filtered(
    captures: CaptureSet, on_progress: Callable[[str], None], notes: list[str]
) -> tuple[bool | None, str]:
    from dnanalyze.detection import detect

    on_progress("hidden filters")
    try:
        detection = detect(captures)
    except InputError as error:
        notes.append(f"it could not be tested for hidden filters: {error}")
        return None, ""
    return detection.filtered, detection.kind
