"""Add missing effects to a model: stepwise by evidence, or one that the user names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path as FilePath

from dnanalyze.classifier.classify import classify_on
from dnanalyze.comparator.error import TOLERABLE
from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.diagnosis.diagnose import first_answer, judge
from dnanalyze.diagnosis.explain import evidence_for
from dnanalyze.diagnosis.gains import trial_by_prediction, trial_of
from dnanalyze.diagnosis.results import Refinement, Step
from dnanalyze.diagnosis.score_test import score_tests
from dnanalyze.diagnosis.search_path import NO_LIMITS, Path, SearchLimits
from dnanalyze.diagnosis.selection import STANDS_IN, UNFINISHED, confidence_of
from dnanalyze.diagnosis.stepwise import Search, supported
from dnanalyze.errors import InputError
from dnanalyze.fitting.fit import fit_on, starting_model, with_seed
from dnanalyze.fitting.from_part import converge, fitted_in_time
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.measured_parameters import at_measured_parameters
from dnanalyze.fitting.problem import FitProblem, problem_of
from dnanalyze.fitting.state import State, start
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.fitting.yardstick import fitted_by_design
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import find, known_effects
from dnanalyze.progress import Progress, ignored, reporter

__all__ = ["Refinement", "add", "refine"]


def refine(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    exclude: Sequence[str] = (),
    limits: SearchLimits = NO_LIMITS,
    budget: float | None = None,
    effects: Iterable[str | FilePath] | Mapping[str, type[Effect]] = (),
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Refinement:
    """Add the missing effects to a model until no further one is detectable.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames.
    model : NoiseModel, optional
        Starting model; the Wang 2025 model by default.
    exclude : sequence of str
        Effects never to add.
    limits : SearchLimits, optional
        Most effects to add, and the model error that is low enough.
    budget : float, optional
        Seconds after which the search ends with the last complete model.
    effects : sequence of path, or mapping
        The user's own effects: Python files, beside the built-in catalogue; or all effects by name.
    progress : callable, optional
        Called with (steps done, None, what is under way); see `dnanalyze.progress.Progress`.
    executor : concurrent.futures.Executor, optional
        Takes the simulations that do not depend on each other: processes, or those of a Dask client
        (``client.get_executor()``). By default threads of this process. Results are the same to the
        last bit.

    Returns
    -------
    Refinement
        The model error at each step, and the final model.

    Raises
    ------
    InputError
        Captures too small to halve, or of a channel that the model does not know.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> found = dnanalyze.refine(captures, limits=dnanalyze.SearchLimits(max_effects=1))
    >>> found.steps[0].error > found.steps[-1].error
    True
    """
    known = known_effects(effects)
    return refine_on(
        captures, model, exclude=exclude, limits=limits, budget=budget, known=known,
        on_progress=reporter(progress), executor=executor,
    )  # fmt: skip


def refine_on(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    exclude: Sequence[str] = (),
    limits: SearchLimits = NO_LIMITS,
    budget: float | None = None,
    seed: int | None = None,
    known: Mapping[str, type[Effect]] | None = None,
    problem: FitProblem | None = None,
    executor: Executor | None = None,
    on_step: Callable[[Step], None] = ignored,
    on_progress: Callable[[str], None] = ignored,
    on_result: Callable[[Refinement], None] = ignored,
    first: Callable[[list[str]], None] | None = None,
    classifier: bool = True,
) -> Refinement:
    """`refine` on statistics taken earlier, among the effects of ``known``.

    ``on_step`` and ``on_progress`` are called after every step, and with the name of every effect
    that is tried; ``on_result`` after each complete step with the refinement so far, from whose
    model the search can be continued; ``first`` as in `diagnose_on`. ``classifier``: whether one is
    asked to tell the frames of the final model.
    """
    limit = TimeLimit.after(budget)
    unlimited = problem or problem_of(captures, model, executor)
    problem = unlimited.within(limit)
    known = known_effects(() if known is None else known)
    begun = starting_model(unlimited, model, seed, exclude)
    open_to = {n: e for n, e in known.items() if n not in exclude}
    if first is not None:
        with suppress(TimeUp):
            first(first_answer(problem, begun, open_to, exclude))
    state = fitted_in_time(problem, begun)
    so_far: list[Path] = []

    def kept(path: Path) -> None:
        so_far.append(path)
        on_result(_so_far(captures, path))

    search = Search(problem, open_to, tuple(begun.names), limits, on_step, on_progress, kept)
    try:
        path = search.run(state, exclude)
    except TimeUp:
        left = replace(_so_far(captures, so_far[-1]), timed_out=True)
        doubt = left.steps[-1].error > TOLERABLE
        return replace(left, steps=_doubted(left.steps, UNFINISHED)) if doubt else left
    ended = FittedModel.of(unlimited, path.state)
    found = judge(
        captures,
        ended,
        path.tried,
        path.best,
        known,
        elsewhere=not limit.over,
    )
    if found.verdict == "unexplained" and search.near_enough(path):
        found = replace(found, verdict="missing")  # nothing was asked of what is left
    classification = None
    if classifier and not limit.over:
        final = path.state.model
        classification = classify_on(
            captures, final, seed=final.seed, limit=limit, helpers=problem.helpers
        )
        if classification.tells and found.verdict == "adequate":
            found = replace(found, verdict="unexplained")
    steps = list(path.steps)
    if found.verdict == "unexplained":  # what stays unexplained, an effect may stand in for
        steps = _doubted(steps, STANDS_IN)
    return replace(
        _so_far(captures, replace(path, state=ended.state, problem=ended.problem)),
        steps=steps,
        verdict=found.verdict,
        diagnosis=found,
        timed_out=limit.over,
        classification=classification,
    )


def _doubted(steps: Sequence[Step], share: float) -> list[Step]:
    """Steps whose confidence is that share of what it was."""
    return [
        s if s.confidence is None else replace(s, confidence=s.confidence * share) for s in steps
    ]


def _so_far(captures: CaptureSet, path: Path) -> Refinement:
    """A refinement that is not finished."""
    state = path.state
    assert path.problem is not None
    return Refinement(
        captures, list(path.steps), state.model.names, "missing", state.model, None, path.problem,
        state,
    )  # fmt: skip


def add(
    captures: CaptureSet,
    effect: str,
    model: NoiseModel | None = None,
    *,
    effects: Iterable[str | FilePath] | Mapping[str, type[Effect]] = (),
    seed: int | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Refinement:
    """Add one effect to a model, refit everything, and compare the model error before and after.

    Whether these captures support it is decided as in `diagnose`, for this effect alone: the
    confidence is that compared with "nothing is missing"; competing effects are not tested.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames.
    effect : str
        Its name in the catalogue.
    model : NoiseModel, optional
        Without one the Wang 2025 model is fitted first.
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
    Refinement
        Two steps, before and after, and the refitted model.

    Raises
    ------
    InputError
        The model already has the effect, or no effect has that name.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> found = dnanalyze.add(captures, "column_fpn")
    >>> found.effects
    ['convolved_lognormal', 'quantization', 'column_fpn']
    >>> [step.added for step in found.steps]
    [None, 'column_fpn']
    """
    known = known_effects(effects)
    return add_on(
        captures,
        effect,
        model,
        seed=seed,
        known=known,
        on_state=reporter(progress),
        executor=executor,
    )


def add_on(
    captures: CaptureSet,
    effect: str,
    model: NoiseModel | None = None,
    *,
    seed: int | None = None,
    known: Mapping[str, type[Effect]] | None = None,
    problem: FitProblem | None = None,
    executor: Executor | None = None,
    on_state: Callable[[State], None] = ignored,
) -> Refinement:
    """`add` on statistics taken earlier, of an effect of ``known``.

    ``on_state`` is called with every better state of the fit of the Wang 2025 model.
    """
    name, known = effect, known_effects(() if known is None else known)
    kind = find(name, known)
    if model is not None and model.get(name) is not None:
        raise InputError(f"{name}: it is already in the model; `dnanalyze fit --model` refits it")
    problem = problem or problem_of(captures, model, executor)
    model = with_seed(problem, model, seed)
    if model is None:
        model = fit_on(captures, replicates=0, problem=problem, on_state=on_state).model
    model = at_measured_parameters(problem, model)
    begun = start(problem, model)
    null = FittedModel.of(problem, fitted_by_design(problem, begun, minimise))
    seen = score_tests(null.problem, null.state, {name: kind})
    larger = seen[0].model if seen else model.with_effect(kind())
    begun = start(null.problem, larger, like=null.state)
    after = trial_by_prediction(null, trial_of(null, name, converge(null.problem, begun)))
    ended = FittedModel.of(null.problem, after.state)
    yes = supported(null, [after]) is not None
    sure = confidence_of(after, [after]) * (1.0 if yes else STANDS_IN)
    why = evidence_for(null.problem, null.state, after.state, kind)
    steps = [
        Step(None, null.error, model=null.state.model),
        Step(name, ended.error, sure, why, supported=yes, model=after.state.model),
    ]
    found = judge(captures, ended, [], None, known)
    return Refinement(
        captures, steps, after.state.model.names, found.verdict, after.state.model,
        found, ended.problem, ended.state, by_hand=True,
    )  # fmt: skip
