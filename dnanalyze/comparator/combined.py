"""Measured combined HDR frames against those simulated from the channels' models."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dnanalyze.comparator.compare import table
from dnanalyze.comparator.error import family_errors, pooled
from dnanalyze.comparator.words import failures
from dnanalyze.errors import InputError
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.vectors import prediction
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.hdr import Combination, simulate_combined
from dnanalyze.model.noise_model import NoiseModel


@dataclass(frozen=True)
class CombinedComparison:
    """Measured combined frames against the combination of simulated channels.

    Parameters
    ----------
    error : float
        1 = as close as a second sensor of the same design.
    families : dict
        Error of each family of statistics.
    statistics : list of dict
        One row a statistic and operating point, in the contract's keys.
    failures : list of str
        Where it fails, worst first.
    """

    error: float
    families: dict[str, float]
    statistics: list[dict[str, Any]]
    failures: list[str]


def compare_combined(
    captures: CaptureSet, model: NoiseModel, how: Combination, light: float = 0.0
) -> CombinedComparison:
    """Compare combined frames with the model of the channels.

    Parameters
    ----------
    captures : CaptureSet
        Combined frames, as the sensor puts them out; no channel in their operating points.
    model : NoiseModel
        Tables over channels; see `dnanalyze.model.channel_models.merged`.
    how : Combination
    light : float
        Uniform light on the frames, DN of the first channel.

    Raises
    ------
    InputError
        Frames that carry a channel.
    """
    from dnanalyze.analyzers.analyze import analyze_windows

    channels = sorted({s.point.channel for s in captures.settings if s.point.channel})
    if channels:
        raise InputError(
            f"{captures.name}: frames of channel {channels[0]!r} are no combined frames; "
            "select those without a channel"
        )
    problem = fit_problem(design(captures))
    made = simulate_combined(model, how, problem.plan.shape, problem.plan.settings, light=light)
    simulated = analyze_windows(made, problem.plan.windows)
    z = problem.test.z(prediction(simulated, 1, problem.test))
    rows = table(problem, simulated)
    families = problem.test.families
    return CombinedComparison(pooled(z, families), family_errors(z, families), rows, failures(rows))
