"""Fit a model to a capture set, with uncertainties and correlations of all its parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.fitting.design import design
from dnanalyze.fitting.knobs import Knob, knobs_of, positions
from dnanalyze.fitting.least_squares import State, converge, loss, start, weights
from dnanalyze.fitting.predictor import Bench, bench
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.start import moments, paper_models
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel

REPLICATES = 24
ALIKE = 0.97  # correlation from which two parameters are called indistinguishable
VAGUE = 1.0  # standard error on a log scale from which a parameter is called undetermined


@dataclass(frozen=True)
class Parameter:
    """A fitted number with its standard error, in plain units."""

    name: str
    value: float
    se: float
    unit: str


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    Parameters
    ----------
    model : NoiseModel
    parameters : list of Parameter
    correlations : ndarray
        Between the parameters on their own scales.
    undetermined : list of str
        Sentences on parameters that these captures cannot tell, alone or from one another.
    bench : Bench
    state : State
    """

    model: NoiseModel
    parameters: list[Parameter]
    correlations: np.ndarray
    undetermined: list[str]
    bench: Bench
    state: State


def fit(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    frozen: Sequence[str] = (),
    replicates: int = REPLICATES,
    held: Bench | None = None,
    tell: Callable[[State], None] = lambda _: None,
) -> Fit:
    """Fit a model to dark frames.

    Parameters
    ----------
    captures : CaptureSet
    model : NoiseModel, optional
        Where to begin, and which effects and laws; the paper's model by default.
    frozen : sequence of str
        Parameters to hold, as ``effect.parameter`` or ``pedestal``.
    replicates : int
        Simulated sensors from which the uncertainties are taken; 0 leaves them out (NaN).
    held : Bench, optional
        Statistics taken earlier.
    tell : callable
        Called with every better state.
    """
    held = held or bench(design(captures))
    model = model or paper_start(held)
    state = converge(held, start(held, model, knobs_of(model, frozen)), tell=tell)
    return with_uncertainties(held, state, replicates)


def paper_start(held: Bench) -> NoiseModel:
    """The paper's model by moments of the train half, at the pedestal that suits it best."""
    m = moments(Readings(held.measured[0]), held.plan.captures.sensor.black_level)
    return min(paper_models(m), key=lambda model: loss(held.z(model)[0]))


def with_uncertainties(held: Bench, state: State, replicates: int = REPLICATES) -> Fit:
    """Errors and correlations from how the estimate scatters over simulated sensors of its make.

    The estimate moves by G dz, G = (J'WJ)^-1 J'W. Both the measured and the simulated statistics
    scatter like
    those of a replicate, so the covariance is twice that of G (replicate - mean).
    """
    knobs, here = state.knobs, positions(state.model, state.knobs)
    covariance = np.full((len(knobs), len(knobs)), np.nan)
    seen = np.linalg.norm(state.jacobian, axis=0) > 1e-3 if len(knobs) else np.empty(0, bool)
    if replicates >= 2 and seen.any():
        w = weights(state.train)
        a = state.jacobian[:, seen] * w[:, None]
        gain = np.linalg.pinv(a, rcond=1e-6) * w
        drawn = [held.replicate(state.model, r)[0] for r in range(replicates)]
        scatter = np.nan_to_num((np.array(drawn) - np.nanmean(drawn, axis=0)) / held.train.floor)
        moved = scatter @ gain.T
        covariance[np.ix_(seen, seen)] = 2.0 * moved.T @ moved / (replicates - 1)
    spread = np.sqrt(np.diag(covariance)) if len(knobs) else np.empty(0)
    parameters = [
        Parameter(k.name, k.plain(x), _plain_error(k, x, s), k.unit)
        for k, x, s in zip(knobs, here, spread, strict=True)
    ]
    with np.errstate(invalid="ignore", divide="ignore"):
        correlations = covariance / np.outer(spread, spread)
    doubts = _doubts(knobs, spread, correlations, seen) if replicates >= 2 else []
    return Fit(state.model, parameters, correlations, doubts, held, state)


def _plain_error(knob: Knob, position: float, spread: float) -> float:
    return float(knob.plain(position) * spread if knob.log else spread)


def _doubts(
    knobs: Sequence[Knob], spread: np.ndarray, correlations: np.ndarray, seen: np.ndarray
) -> list[str]:
    sentences = []
    for i, knob in enumerate(knobs):
        if not seen[i]:
            sentences.append(f"{knob.name}: nothing in these captures depends on it")
        elif knob.log and spread[i] > VAGUE:
            sentences.append(
                f"{knob.name}: not determined within a factor of {np.exp(min(spread[i], 50)):.3g}"
            )
    for i in range(len(knobs)):
        for j in range(i):
            if abs(correlations[i, j]) > ALIKE:
                sentences.append(
                    f"{knobs[j].name} and {knobs[i].name}: these captures cannot tell them apart "
                    f"(correlation {correlations[i, j]:+.3f})"
                )
    return sentences
