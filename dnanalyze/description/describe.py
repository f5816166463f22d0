"""Describe what no effect of the catalogue explains, add it, and judge the model with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from dnanalyze.classifier.classify import classify_on
from dnanalyze.classifier.result import Classification
from dnanalyze.comparator.predictive_check import FittedModel, error_of
from dnanalyze.description.advice import more_captures
from dnanalyze.description.found import Estimate
from dnanalyze.description.layers import layers, simulated_layers
from dnanalyze.description.look import Look, look
from dnanalyze.description.nearest import Nearest, as_good, nearest
from dnanalyze.description.search import by_chance, searched
from dnanalyze.description.words import sentence
from dnanalyze.diagnosis.explain import evidence_for
from dnanalyze.diagnosis.gains import trial_of
from dnanalyze.diagnosis.selection import STANDS_IN, Trial, confidence_of
from dnanalyze.diagnosis.stepwise import reduced, supported
from dnanalyze.digits import number
from dnanalyze.errors import InputError
from dnanalyze.fitting.fit import baseline_model, starting_model
from dnanalyze.fitting.from_part import FIT_STEPS, fitted_in_time
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem, problem_of
from dnanalyze.fitting.state import State, start
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.fitting.whole_field import departures
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.model.composite.source import own_effect
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, BASELINE, known_effects
from dnanalyze.progress import Progress, ignored, reporter
from dnanalyze.result import Result

MAX_LAYERS = 2  # layers whose best structure is put into the model and refitted


@dataclass(frozen=True)
class Number:
    """A number of a structure: estimated from its residual layer, and after the refit."""

    name: str
    value: float
    se: float
    unit: str
    in_model: float


@dataclass(frozen=True, repr=False)
class Description(Result):
    """Structure of the residual that no effect of the catalogue explains, in words and numbers.

    Parameters
    ----------
    captures : CaptureSet
        The measured frames.
    verdict : str
        "described", "possible" (the error does not fall, or the data do not support it), "nothing"
        (no structure beyond chance) or "adequate" (no residual exceeds chance).
    text : str
        The sentence.
    error_before, error_after : float
        Model error without and with the structure; NaN where none was added.
    confidence : float
        As for an effect of the catalogue; NaN where no structure was added.
    after : str
        "adequate" or "unexplained": the model with it.
    effect : CompositeEffect or None
        The structure, as estimated from its residual layer.
    numbers : list of Number
        Its numbers.
    evidence : list of str
        Statistics that it corrects.
    nearest : list of Nearest
        The nearest effects of the catalogue and what they do not explain.
    removed : list of str
        Effects that are no longer supported with the structure in the model.
    next_capture : list of str
        Recommended captures.
    others : list of str
        Sentences on structures in other residual layers.
    model : NoiseModel
        With the structure, refitted; as it was where none is supported.
    look : Look or None
        What the figure shows.
    finished : bool
        False where the time limit ended the refits.
    classification : Classification, optional
        Whether a classifier tells the frames of `model` from the measured ones: a model whose
        frames it tells is not adequate. None where the time limit came first.
    """

    captures: CaptureSet = field(compare=False)
    verdict: str
    text: str
    error_before: float
    error_after: float
    confidence: float
    after: str
    effect: CompositeEffect | None
    numbers: list[Number]
    evidence: list[str]
    nearest: list[Nearest]
    removed: list[str]
    next_capture: list[str]
    others: list[str]
    model: NoiseModel
    look: Look | None = None
    finished: bool = True
    classification: Classification | None = None

    def _brief(self) -> str:
        return f"{self.captures.name}, {self.verdict}, model error {number(self.error_before)}"

    def source(self) -> str:
        """Python source of the structure as a user's own effect, with the numbers of the model.

        Returns
        -------
        str
            A file for ``--effects``, which draws the frames of the model to the last bit.

        Raises
        ------
        InputError
            Nothing was found.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> found = dnanalyze.describe(tiny(), budget=60)  # doctest: +SKIP
        >>> print(found.source())  # doctest: +SKIP
        """
        made = self.model.get(CompositeEffect.name) or self.effect
        if not isinstance(made, CompositeEffect):
            raise InputError("describe: there is no structure to write as an effect")
        return own_effect(made, self.text.split(":")[0])


def describe(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    budget: float | None = None,
    effects: Iterable[str | Path] | Mapping[str, type[Effect]] = (),
    seed: int | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Description:
    """Describe the residual that no effect of the catalogue explains; add it to a model.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames.
    model : NoiseModel, optional
        The model that `refine` ends with; by default the baseline model.
    budget : float, optional
        Seconds after which the refits end; the best result so far is returned.
    effects : sequence of path, or mapping
        The user's own effects: Python files, beside the built-in catalogue; or all effects by name.
    seed : int, optional
        Seed of the simulated sensor; by default the model's.
    progress : callable, optional
        Called with (steps done, None, what is under way); see `dnanalyze.progress.Progress`.
    executor : concurrent.futures.Executor, optional
        Takes the simulations that do not depend on each other: processes, or those of a Dask client
        (``client.get_executor()``). By default threads of this process. Results are the same to the
        last bit.

    Returns
    -------
    Description
        The structure in words and numbers, and the model with it.

    Raises
    ------
    InputError
        The model has a composite effect already, or the captures are too small to halve.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> found = dnanalyze.describe(tiny(), budget=60)
    >>> found.captures.name
    'virtual sensor'
    """
    known = known_effects(effects)
    return describe_on(
        captures,
        model,
        budget=budget,
        known=known,
        seed=seed,
        on_progress=reporter(progress),
        executor=executor,
    )


def describe_on(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    budget: float | None = None,
    seed: int | None = None,
    known: Mapping[str, type[Effect]] | None = None,
    problem: FitProblem | None = None,
    executor: Executor | None = None,
    on_progress: Callable[[str], None] = ignored,
) -> Description:
    """`describe` on statistics taken earlier, beside the effects of ``known``."""
    limit = TimeLimit.after(budget)
    if model is not None and model.get(CompositeEffect.name) is not None:
        raise InputError(
            "model: it already has the effect 'composite'; describe requires a model without it"
        )
    problem = problem or problem_of(captures, model, executor)
    begun = starting_model(problem, model or baseline_model(problem), seed)
    on_progress("fitting the model")
    state = fitted_in_time(problem.within(limit), begun)
    found = described(
        captures, problem, state, known_effects(() if known is None else known), limit, on_progress
    )
    if limit.over:
        return found
    on_progress("training a classifier")
    final = found.model
    classification = classify_on(
        captures, final, seed=final.seed, limit=limit, helpers=problem.helpers
    )
    found = replace(found, classification=classification)
    if found.effect is not None:
        return replace(found, after="unexplained") if classification.tells else found
    if (
        classification.tells
        or not FittedModel.of(problem, state).adequate
        or departures(problem.plan, state.model)
    ):
        return found
    text = "Nothing to describe: no residual of the model exceeds chance in these captures."
    return replace(found, verdict="adequate", text=text, after="adequate")


def described(
    captures: CaptureSet,
    problem: FitProblem,
    state: State,
    known: Mapping[str, type[Effect]],
    limit: TimeLimit,
    on_progress: Callable[[str], None] = ignored,
    rivals: bool = True,
) -> Description:
    """The description of what a fitted model leaves.

    ``rivals``: whether the nearest effects of the catalogue are refitted instead.
    """
    on_progress("residual layers")
    seen = layers(problem.plan, state.model)
    base = tuple(e for e in state.model.effects if e.name in (BASE, *BASELINE))
    simulated = simulated_layers(problem.plan, replace(state.model, effects=base))
    on_progress("structures in the layers")
    found = searched(seen, by_chance(simulated), state.model.reference)
    if not found:
        text = (
            "No structure in the residual layers exceeds chance: the statistics not explained "
            "have none of the geometries that describe tests."
        )
        return _without(captures, problem, state, "nothing", text)
    null = FittedModel.of(problem, state)
    tried = _refitted(null, found, limit, on_progress)
    told = {id(e): sentence(e, seen, state.model.reference) for e in found}
    if not tried:
        open_ = _without(captures, null.problem, null.state, "possible", told[id(found[0])])
        return replace(open_, effect=found[0].effect, look=look(found[0], seen), finished=False)
    best, trial = max(tried, key=lambda pair: pair[1].evidence)
    near = known if rivals else {}
    judged = _judged(captures, null, best, trial, near, limit, on_progress, told[id(best)])
    return replace(
        judged,
        next_capture=more_captures(best.effect, seen),
        others=[told[id(e)] for e in found if _layer(e) != _layer(best)][:2],
        look=look(best, seen),
        finished=len(tried) == len(_best_of_layers(found)),
    )


def _refitted(
    null: FittedModel, found: list[Estimate], limit: TimeLimit, on_progress: Callable[[str], None]
) -> list[tuple[Estimate, Trial]]:
    """The model with each of the best structures, as many as the time allows."""
    limited = null.problem.within(limit)
    tried: list[tuple[Estimate, Trial]] = []
    with suppress(TimeUp):
        for one in _best_of_layers(found):
            on_progress(f"refitting with {one.effect.where}")
            begun = start(limited, null.state.model.with_effect(one.effect), like=null.state)
            ended = minimise(limited, begun, FIT_STEPS)
            tried.append((one, trial_of(null, CompositeEffect.name, ended)))
    return tried


def _judged(
    captures: CaptureSet,
    null: FittedModel,
    best: Estimate,
    trial: Trial,
    known: Mapping[str, type[Effect]],
    limit: TimeLimit,
    on_progress: Callable[[str], None],
    text: str,
) -> Description:
    """Whether the model needs the structure: its evidence, and what the catalogue does instead."""
    problem, state, ended = null.problem, null.state, trial.state
    certain = supported(null, [trial]) is not None
    sure = confidence_of(trial, [trial]) * (1.0 if certain else STANDS_IN)
    removed: list[str] = []
    if certain and not limit.over:
        on_progress("testing which effects are still needed")
        smaller, gone = reduced(problem, ended)
        if smaller.model.get(CompositeEffect.name) is not None:
            ended, removed = smaller, gone
    near: list[Nearest] = []
    if not limit.over:
        on_progress("nearest effects of the catalogue")
        near = nearest(problem, state, ended, best.effect, known)
    rival = as_good(near, error_of(problem, ended))
    if rival is not None:
        certain, sure = False, min(sure, STANDS_IN)
        text = f"{text[:-1]}; the catalogue effect {rival} explains as much: add it first."
    left = FittedModel.of(problem, ended)
    return Description(
        captures,
        verdict="described" if certain else "possible",
        text=text,
        error_before=null.error,
        error_after=left.error,
        confidence=sure,
        after="adequate" if left.adequate else "unexplained",
        effect=best.effect,
        numbers=_numbers(best, ended.model),
        evidence=evidence_for(problem, state, ended, CompositeEffect),
        nearest=near,
        removed=removed,
        next_capture=[],
        others=[],
        model=ended.model if certain else state.model,
    )


def _layer(found: Estimate) -> tuple[bool, bool]:
    """The residual layer that shows it: of the noise, of the fixed pattern or of single frames."""
    return found.effect.what == "noise", found.effect.when == "fixed"


def _best_of_layers(found: list[Estimate]) -> list[Estimate]:
    """The best of every layer: the layer tells geometries apart, the statistics do not."""
    made: dict[tuple[bool, bool], Estimate] = {}
    for one in found:
        made.setdefault(_layer(one), one)
    return list(made.values())[:MAX_LAYERS]


def _numbers(found: Estimate, model: NoiseModel) -> list[Number]:
    """The numbers of a structure that have an error."""
    made = model.get(CompositeEffect.name) or found.effect
    infos = CompositeEffect.parameters()
    return [
        Number(
            name,
            float(getattr(found.effect, name)),
            float(error),
            infos[name].unit,
            made.value(name, model.reference),
        )
        for name, error in found.errors.items()
        if name in infos and np.isfinite(error)
    ]


def _without(
    captures: CaptureSet, problem: FitProblem, state: State, verdict: str, text: str
) -> Description:
    """A description without a structure in the model."""
    error, nan = error_of(problem, state), float("nan")
    return Description(
        captures, verdict, text, error, nan, nan, "unexplained", None, [], [], [], [], [], [],
        state.model,
    )  # fmt: skip
