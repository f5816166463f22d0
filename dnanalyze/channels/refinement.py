"""Over the readout channels of an HDR sensor: each completed by itself, then one model of all."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import chain
from pathlib import Path

from dnanalyze.comparator.predictive_check import error_of
from dnanalyze.diagnosis.diagnose import Diagnosis, diagnose_on
from dnanalyze.diagnosis.refine import Refinement, add_on, refine_on
from dnanalyze.diagnosis.results import Step
from dnanalyze.diagnosis.search_path import NO_LIMITS, SearchLimits
from dnanalyze.digits import number
from dnanalyze.errors import InputError
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import Parameters, fit_on, uncertain
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.fitting.state import State, start
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.channel_models import channel_model, merged, of_pixel
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, BASELINE, catalogue, known_effects
from dnanalyze.progress import Progress, ignored, reporter
from dnanalyze.result import Result

JOINT_ITERATIONS = 6
WORST = ("unexplained", "missing", "adequate")


@dataclass(frozen=True)
class ChannelStep(Step):
    """A step of one channel's refinement; ``error`` is that over all channels then."""

    channel: str | None = None


@dataclass(frozen=True, repr=False)
class ChannelRefinement(Result):
    """Every channel's completed model, and one model of all.

    Parameters
    ----------
    captures : CaptureSet
        The measured frames.
    channels : dict
        Channel to its refinement.
    shared : list of str
        Effects beyond the everyday ones that belong to all channels: of the pixel, or of a readout
        that all share.
    own : dict
        Channel to the effects of its own readout.
    findings : list of str
        The same in sentences.
    steps : list of ChannelStep
        The first entry is the starting model, the last the one model, refitted; errors over all
        channels.
    model : NoiseModel
        Of all channels; see `dnanalyze.model.channel_models.merged`.
    problem : FitProblem
        The statistics of all channels that were fitted, and the simulations of them.
    state : State
        The last step of the fit of one model.
    """

    captures: CaptureSet = field(compare=False)
    channels: dict[str, Refinement]
    shared: list[str]
    own: dict[str, list[str]]
    findings: list[str]
    steps: list[ChannelStep]
    model: NoiseModel
    problem: FitProblem
    state: State

    def _brief(self) -> str:
        first, last = number(self.steps[0].error), number(self.error)
        return f"{self.captures.name}, {', '.join(self.channels)}, model error {first} to {last}"

    @property
    def effects(self) -> list[str]:
        """In the model of all channels."""
        return self.model.names

    @property
    def verdict(self) -> str:
        """The least good of the channels'."""
        return worst_verdict(r.verdict for r in self.channels.values())

    @property
    def unexplained(self) -> list[str]:
        """Statistics that the model of any channel leaves unexplained."""
        return list(dict.fromkeys(n for r in self.channels.values() for n in r.unexplained))

    @cached_property
    def parameters(self) -> Parameters:
        """The numbers of the model of all channels, with their standard errors."""
        return uncertain(self.problem, self.state).parameters

    @property
    def error(self) -> float:
        """Of the one model, over all channels."""
        return self.steps[-1].error


def worst_verdict(verdicts: Iterable[str]) -> str:
    """The least good of several verdicts."""
    return min(verdicts, key=WORST.index)


def by_channel(captures: CaptureSet) -> dict[str, CaptureSet]:
    """The captures of each readout channel.

    Raises
    ------
    InputError
        Fewer than two channels.
    """
    found = captures.channels
    if len(found) < 2:
        there = "one channel" if found else "no channels"
        raise InputError(
            f"{captures.name}: {there}; two or more are needed, by the column 'channel' of "
            "manifest.csv"
        )
    return {name: captures.channel(name) for name in found}


def refine_channels(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    exclude: Sequence[str] = (),
    limits: SearchLimits = NO_LIMITS,
    budget: float | None = None,
    effects: Iterable[str | Path] | Mapping[str, type[Effect]] = (),
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> ChannelRefinement:
    """Complete a model of each channel, compare what they needed, and fit one model of all.

    Parameters
    ----------
    captures : CaptureSet
        Operating points that carry a channel.
    model : NoiseModel, optional
        Starting model of all channels; the Wang 2025 model by default.
    exclude : sequence of str
        Effects never to add.
    limits : SearchLimits, optional
        Of each channel: most effects to add, and the model error that is low enough.
    budget : float, optional
        Seconds for the searches of all channels, in equal parts.
    effects : sequence of path, or mapping
        The user's own effects: Python files, beside the built-in catalogue; or all effects by name.
    progress : callable, optional
        Called with (steps done, None, what is under way); see `dnanalyze.progress.Progress`.
    executor : concurrent.futures.Executor, optional
        See `refine`.

    Returns
    -------
    ChannelRefinement
        The refinement of each channel, and one model of all.

    Raises
    ------
    InputError
        Fewer than two channels.

    Examples
    --------
    >>> import dnanalyze
    >>> captures = dnanalyze.load("captures/")                # doctest: +SKIP
    >>> dnanalyze.refine_channels(captures).save("m.yaml")    # doctest: +SKIP
    """
    known, on_progress = known_effects(effects), reporter(progress)

    def one(channel: str, part: CaptureSet) -> Refinement:
        return refine_on(
            part,
            channel_model(model, channel) if model is not None else None,
            exclude=exclude,
            limits=limits,
            budget=None if budget is None else budget / len(captures.channels),
            known=known,
            on_progress=partial(_trying, on_progress, channel),
            executor=executor,
        )

    return _over(captures, one, known, on_progress)


def add_channels(
    captures: CaptureSet,
    name: str,
    model: NoiseModel | None = None,
    *,
    known: dict[str, type[Effect]] | None = None,
    progress: Progress | None = None,
) -> ChannelRefinement:
    """Put one effect into the model of every channel; see `refine_channels`."""
    on_progress = reporter(progress)

    def one(channel: str, part: CaptureSet) -> Refinement:
        problem = fit_problem(design(part))
        if model is None:
            begun = fit_on(part, problem=problem, replicates=0).model
        else:
            begun = channel_model(model, channel)
        return add_on(part, name, begun, known=known, problem=problem)

    return _over(captures, one, known, on_progress)


def diagnose_channels(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    budget: float | None = None,
    known: dict[str, type[Effect]] | None = None,
    on_progress: Callable[[str], None] = ignored,
) -> dict[str, Diagnosis]:
    """What is missing in the model of each channel; see `diagnose`."""
    made = {}
    for channel, part in by_channel(captures).items():
        own = channel_model(model, channel) if model is not None else None
        on_progress(f"{channel}: reading")
        share = None if budget is None else budget / len(captures.channels)
        trying = partial(_trying, on_progress, channel)
        made[channel] = diagnose_on(part, own, budget=share, known=known, on_progress=trying)
    return made


def _trying(on_progress: Callable[[str], None], channel: str, effect: str) -> None:
    on_progress(f"{channel}: trying {effect}")


def _over(
    captures: CaptureSet,
    one: Callable[[str, CaptureSet], Refinement],
    known: dict[str, type[Effect]] | None,
    on_progress: Callable[[str], None],
) -> ChannelRefinement:
    """Each channel by itself, then all together."""
    made: dict[str, Refinement] = {}
    for channel, part in by_channel(captures).items():
        on_progress(f"{channel}: reading")
        made[channel] = one(channel, part)
    shared, own, findings = belonging(
        {c: r.model for c, r in made.items()}, catalogue() if known is None else known
    )
    on_progress("All channels together")
    problem = fit_problem(design(captures, most_settings=len(captures.settings)))
    state = _joint(problem, {c: r.model for c, r in made.items()})
    steps = [*_steps(made), ChannelStep(None, error_of(problem, state))]
    return ChannelRefinement(
        captures, made, shared, own, findings, steps, state.model, problem, state
    )


def _joint(problem: FitProblem, models: Mapping[str, NoiseModel]) -> State:
    """One model of all channels, refitted: what is shared moves with all of them."""
    points = [p for p, _ in problem.plan.settings]
    celsius = sorted({p.temperature_c for p in points if p.temperature_c is not None})
    model = merged(models, celsius)
    return minimise(problem, start(problem, model), JOINT_ITERATIONS)


def _steps(made: Mapping[str, Refinement]) -> list[ChannelStep]:
    """Channel after channel; the error over all is the root mean square of theirs."""
    errors = {c: r.steps[0].error for c, r in made.items()}

    def over_all() -> float:
        return math.sqrt(sum(e * e for e in errors.values()) / len(errors))

    steps = [ChannelStep(None, over_all())]
    for channel, result in made.items():
        for step in result.steps[1:]:
            errors[channel] = step.error
            steps.append(ChannelStep(**vars(step) | {"error": over_all()}, channel=channel))
    return steps


def belonging(
    models: Mapping[str, NoiseModel], known: Mapping[str, type[Effect]]
) -> tuple[list[str], dict[str, list[str]], list[str]]:
    """Which effects belong to all channels and which to one readout, and the same in sentences.

    Parameters
    ----------
    models : mapping
        Channel to its completed model.
    known : mapping
        Effects by name.

    Returns
    -------
    shared, own, findings
        See `ChannelRefinement`.
    """
    added = {c: [n for n in m.names if n not in (BASE, *BASELINE)] for c, m in models.items()}
    every = list(dict.fromkeys(chain(*added.values())))
    seen = {name: [c for c, names in added.items() if name in names] for name in every}
    pixel = [n for n in every if of_pixel(known[n])]
    everywhere = [n for n in every if n not in pixel and len(seen[n]) == len(models)]
    said = []
    for name in pixel:
        where = "every channel" if len(seen[name]) == len(models) else ", ".join(seen[name])
        said.append(
            f"{name}: an effect of the pixel, shared by all channels; identified in {where}"
        )
    if everywhere:
        said.append(
            f"identified in every channel, so shared by all readouts: {', '.join(everywhere)}"
        )
    shared = [*pixel, *everywhere]
    for name in (n for n in every if n not in shared):
        only = f"{seen[name][0]} only" if len(seen[name]) == 1 else ", ".join(seen[name])
        said.append(f"{name}: identified in {only}, so an effect of that readout")
    own = {c: [n for n in names if n not in shared] for c, names in added.items()}
    return shared, own, said or ["no channel needs more than the baseline effects"]
