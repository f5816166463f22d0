"""Diagnose and add until nothing more is missing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path as FilePath

from dnanalyze.diagnosis.confidence import STANDS_IN, confidence_of
from dnanalyze.diagnosis.diagnose import EVERY_SENSOR, Diagnosis, judge, missing
from dnanalyze.diagnosis.everyday import everyday, lacks_everyday
from dnanalyze.diagnosis.evidence import evidence_for
from dnanalyze.diagnosis.first_answer import first_answer
from dnanalyze.diagnosis.other_way import by_another_way
from dnanalyze.diagnosis.path import Path, Step
from dnanalyze.diagnosis.screening import prospects
from dnanalyze.diagnosis.strength import parameters_of
from dnanalyze.diagnosis.trial import error_of, judged
from dnanalyze.diagnosis.walk import Walk
from dnanalyze.digits import number
from dnanalyze.errors import InputError
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import Parameter, fit, paper_start, with_seed
from dnanalyze.fitting.from_part import fitted_in_time
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import State, minimise, start
from dnanalyze.fitting.level import Level
from dnanalyze.fitting.located import located
from dnanalyze.fitting.predictor import Bench, bench
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import find, known_effects
from dnanalyze.result import Result


@dataclass(frozen=True, repr=False)
class Refinement(Result):
    """Result of a stepwise refinement.

    Parameters
    ----------
    captures : str
        Name of the captures.
    steps : list of Step
        The first entry is the starting model.
    effects : list of str
        In the final model.
    verdict : str
        "adequate", "missing" (stopped early) or "unexplained".
    model : NoiseModel
        The final model.
    diagnosis : Diagnosis or None
        Of the final model; None where the refinement is not finished.
    bench : Bench
        The statistics that were fitted, and the simulations of it.
    state : State
        The last step of the fit.
    by_hand : bool
        Of `add`: the user chose the effect.
    timed_out : bool
        Whether the time limit ended the search, or the computation of the standard errors.
    capture_set : CaptureSet, optional
        The measured frames.
    """

    captures: str
    steps: list[Step]
    effects: list[str]
    verdict: str
    model: NoiseModel
    diagnosis: Diagnosis | None
    bench: Bench
    state: State
    by_hand: bool = False
    timed_out: bool = False
    capture_set: CaptureSet | None = field(default=None, compare=False)

    def _brief(self) -> str:
        first, last = (number(self.steps[i].error) for i in (0, -1))
        return f"{self.captures}, model error {first} to {last}, {', '.join(self.effects)}"

    @property
    def finished(self) -> bool:
        """Whether it came to its end."""
        return self.diagnosis is not None

    @property
    def unexplained(self) -> list[str]:
        """Statistics that the final model leaves unexplained, worst first."""
        return [] if self.diagnosis is None else self.diagnosis.unexplained

    @cached_property
    def parameters(self) -> list[Parameter]:
        """The numbers of the final model with their standard errors; simulates when first asked.

        Of a refinement that is not finished, or whose time was up, without the errors (NaN), which
        would take long.
        """
        if self.finished and not self.timed_out:
            return parameters_of(self.bench, self.state)
        return parameters_of(self.bench, self.state, 0)

    @property
    def level(self) -> Level | None:
        """The mean dark level of the final model, which an adequate one keeps."""
        return None if self.diagnosis is None else self.diagnosis.level


def refine(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    exclude: Sequence[str] = (),
    max_effects: int | None = None,
    until_error: float | None = None,
    budget: float | None = None,
    effects: Iterable[str | FilePath] | Mapping[str, type[Effect]] = (),
    seed: int | None = None,
    most_effects: int | None = None,
    known: Mapping[str, type[Effect]] | None = None,
    held: Bench | None = None,
    tell: Callable[[Step], None] = lambda _: None,
    trying: Callable[[str], None] = lambda _: None,
    keep: Callable[[Refinement], None] = lambda _: None,
    first: Callable[[list[str]], None] | None = None,
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
    max_effects : int, optional
        Stop once this many effects were added.
    until_error : float, optional
        Stop once the model error is at or below this.
    budget : float, optional
        Seconds after which the search ends with the last complete model.
    effects : sequence of path, or mapping
        The user's own effects: Python files, beside the built-in catalogue; or all effects by name.
    seed : int, optional
        Seed of the simulated sensor; by default the model's.
    most_effects : int, optional
        The former name of ``max_effects``.
    known : mapping, optional
        All effects by name: the former name of ``effects``.
    held : Bench, optional
        Statistics taken earlier.
    tell, trying : callable
        Called after every step, and with the name of every effect that is tried.
    keep : callable
        Called with the refinement after each complete step; the search can be continued from any of
        these models.
    first : callable, optional
        Called with a first answer before the search, as in `diagnose`.

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
    >>> found = dnanalyze.refine(captures, max_effects=1)
    >>> found.steps[0].error > found.steps[-1].error
    True
    """
    limit = TimeLimit.after(budget)
    unlimited = held or bench(design(captures))
    held = unlimited.within(limit)
    known = known_effects(effects, known)
    most = most_effects if max_effects is None else max_effects
    begun = located(unlimited, with_seed(unlimited, model, seed) or paper_start(unlimited))
    open_to = {n: e for n, e in known.items() if n not in exclude}
    if first is not None:
        with suppress(TimeUp):
            first(first_answer(held, begun, open_to, exclude))
    state = fitted_in_time(held, begun)
    so_far: list[Path] = []

    def kept(path: Path) -> None:
        so_far.append(path)
        keep(_so_far(captures, unlimited, path))

    walk = Walk(held, open_to, tuple(begun.names), most, until_error, tell, trying, kept)
    path = walk.note(Path(state, ()), state, None)
    kept(path)
    try:
        path = _to_its_end(walk, path, exclude)
    except TimeUp:
        return replace(_so_far(captures, unlimited, so_far[-1]), timed_out=True)
    held = unlimited
    found = judge(captures.name, held, path.state, path.tried, path.best, known, in_full=False)
    found = replace(found, capture_set=captures)
    steps = list(path.steps)
    if found.verdict == "unexplained" and walk.near_enough(path):
        found = replace(found, verdict="missing")  # nothing was asked of what is left
    if found.verdict == "unexplained":
        steps = [doubted(s) for s in steps]
    state = path.state
    return Refinement(
        captures.name, steps, state.model.names, found.verdict, state.model, found, held, state,
        timed_out=limit.over, capture_set=captures,
    )  # fmt: skip


def _to_its_end(walk: Walk, path: Path, exclude: Sequence[str]) -> Path:
    """What every sensor has, then what else is missing."""
    if lacks_everyday(path.state.model, exclude):
        stages: list[tuple[str, State]] = []
        everyday(walk.held, path.state, exclude, lambda name, s: stages.append((name, s)))
        for name, stage in stages:
            path = walk.note(path, stage, name, why=[EVERY_SENSOR])
        walk.keep(path)
    path = walk.to_end(path)
    try:
        return by_another_way(walk, path)
    except TimeUp:
        return path


def _so_far(captures: CaptureSet, held: Bench, path: Path) -> Refinement:
    """A refinement that is not finished."""
    state = path.state
    return Refinement(
        captures.name, list(path.steps), state.model.names, "missing", state.model, None, held,
        state, capture_set=captures,
    )  # fmt: skip


def doubted(step: Step) -> Step:
    """The step with half its confidence: what stays unexplained, the effect may stand in for."""
    if step.confidence is None:
        return step
    return replace(step, confidence=step.confidence * STANDS_IN)


def add(
    captures: CaptureSet,
    effect: str,
    model: NoiseModel | None = None,
    *,
    effects: Iterable[str | FilePath] | Mapping[str, type[Effect]] = (),
    seed: int | None = None,
    known: Mapping[str, type[Effect]] | None = None,
    held: Bench | None = None,
    tell: Callable[[State], None] = lambda _: None,
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
    known : mapping, optional
        All effects by name: the former name of ``effects``.
    held : Bench, optional
        Statistics taken earlier.
    tell : callable
        Called with every better state of the fit of the Wang 2025 model.

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
    ['convolved_lognormal', 'column_fpn']
    >>> [step.added for step in found.steps]
    [None, 'column_fpn']
    """
    name, known = effect, known_effects(effects, known)
    kind = find(name, known)
    if model is not None and model.get(name) is not None:
        raise InputError(f"{name}: it is already in the model; `dnanalyze fit --model` refits it")
    held = held or bench(design(captures))
    model = with_seed(held, model, seed)
    if model is None:
        model = fit(captures, replicates=0, held=held, tell=tell).model
    model = located(held, model)
    before = minimise(held, start(held, model, knobs_of(model)))
    seen = prospects(held, before, {name: kind})
    larger = seen[0].model if seen else before.model.with_effect(kind())
    begun = start(held, larger, knobs_of(larger), like=before)
    after = judged(held, before, name, minimise(held, begun, 8))
    why = evidence_for(held, before, after.state, kind)
    error = error_of(held, before)
    supported = missing(held, before, [after]) is not None
    sure = confidence_of(after, [after], error) * (1.0 if supported else STANDS_IN)
    steps = [Step(None, error), Step(name, after.error, sure, why, supported=supported)]
    found = judge(captures.name, held, after.state, [], None, known, in_full=False)
    found = replace(found, capture_set=captures)
    state = after.state
    return Refinement(
        captures.name, steps, state.model.names, found.verdict, state.model, found, held, state,
        by_hand=True, capture_set=captures,
    )  # fmt: skip
