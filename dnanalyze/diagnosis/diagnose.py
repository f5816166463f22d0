"""Which effect is missing in a model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.diagnosis.baseline import (
    baseline_fitted,
    baseline_start,
    lacks_baseline,
    new_in,
    reasons,
)
from dnanalyze.diagnosis.candidates import SoFar, by_standing, candidates_of, trials
from dnanalyze.diagnosis.detectability import detection_limits
from dnanalyze.diagnosis.explain import evidence_against, evidence_for, next_capture
from dnanalyze.diagnosis.forms import completed
from dnanalyze.diagnosis.gains import trial_of
from dnanalyze.diagnosis.results import Candidate, Diagnosis
from dnanalyze.diagnosis.score_test import score_tests
from dnanalyze.diagnosis.selection import (
    DEFLATION,
    STANDS_IN,
    Trial,
    apart,
    competitors,
    confidence_of,
    confidences,
    significant,
)
from dnanalyze.diagnosis.spread_law import in_words
from dnanalyze.diagnosis.stepwise import choose, lower_without, supported
from dnanalyze.fitting.agreement import agreements
from dnanalyze.fitting.fit import starting_model
from dnanalyze.fitting.from_part import converge, fitted, fitted_in_time
from dnanalyze.fitting.problem import FitProblem, problem_of
from dnanalyze.fitting.state import State, start
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.fitting.whole_field import coverage
from dnanalyze.fitting.yardstick import expressed
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, known_effects
from dnanalyze.progress import Progress, ignored, reporter

__all__ = ["Diagnosis", "diagnose"]


def diagnose(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    exclude: Sequence[str] = (),
    budget: float | None = None,
    effects: Iterable[str | Path] | Mapping[str, type[Effect]] = (),
    seed: int | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Diagnosis:
    """Identify the effect that is missing in a model.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames.
    model : NoiseModel, optional
        The Wang 2025 model by default. It is refitted first, so that only what no parameter can
        reproduce counts as residual. If it has no baseline effects, these are added before other
        effects are tested.
    exclude : sequence of str
        Effects that are not tested.
    budget : float, optional
        Seconds after which the search ends; the best result so far is returned.
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
    Diagnosis
        The verdict and the candidates, best first, with their evidence.

    Raises
    ------
    InputError
        Captures too small to halve, or of a channel that the model does not know.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> found = dnanalyze.diagnose(captures)
    >>> found.verdict, found.candidates[0].effect
    ('missing', 'column_fpn')
    """
    known = known_effects(effects)
    return diagnose_on(
        captures, model, exclude=exclude, budget=budget, known=known, seed=seed,
        on_progress=reporter(progress), executor=executor,
    )  # fmt: skip


def diagnose_on(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    exclude: Sequence[str] = (),
    budget: float | None = None,
    seed: int | None = None,
    known: Mapping[str, type[Effect]] | None = None,
    problem: FitProblem | None = None,
    executor: Executor | None = None,
    on_progress: Callable[[str], None] = ignored,
    first: Callable[[list[str]], None] | None = None,
    on_result: Callable[[Diagnosis], None] = ignored,
    afterwards: TimeLimit | None = None,
) -> Diagnosis:
    """`diagnose` on statistics taken earlier, among the effects of ``known``.

    ``on_progress`` is called with the name of every candidate; ``first``, before the search, with a
    first answer: the effects in the order of the fall of the error that first-order screening of a
    quarter of the field expects, none where the captures are small or nothing is expected.
    ``on_result`` is called after each candidate with what is known so far, and with the whole
    diagnosis before the detection limits; ``afterwards`` limits their time, they are then left out.
    """
    limit = TimeLimit.after(budget)
    problem = problem or problem_of(captures, model, executor)
    limited = problem.within(limit)
    model = starting_model(problem, model, seed, exclude)
    known = known_effects(() if known is None else known)
    open_to = {name: effect for name, effect in known.items() if name not in exclude}
    so_far = SoFar()

    def found_so_far(now: SoFar) -> None:
        nonlocal so_far
        so_far = now

    if first is not None or budget is not None:
        with suppress(TimeUp):
            so_far = SoFar(first_answer(limited, model, open_to, exclude))
        if first is not None:
            first(list(so_far.screened))
    asked = fitted_in_time(limited, model)
    baseline: State | None = None

    def whole(found: Diagnosis) -> Diagnosis:
        found = replace(found, begun=asked.model)
        return found if baseline is None else _with_baseline_listed(problem, asked, baseline, found)

    def kept(found: Diagnosis) -> None:
        on_result(whole(found) if found.finished else found)

    try:
        if lacks_baseline(asked.model, exclude):
            on_progress("baseline effects")
            baseline = baseline_fitted(limited, baseline_start(limited, exclude, asked.model.seed))
        found = _in_full(
            captures,
            limited,
            baseline or asked,
            open_to,
            on_progress,
            found_so_far,
            kept,
            afterwards,
        )
    except TimeUp:
        found = unfinished(captures, FittedModel.of(problem, baseline or asked), so_far, open_to)
    return whole(found)


def first_answer(
    problem: FitProblem,
    model: NoiseModel,
    known: dict[str, type[Effect]],
    exclude: Sequence[str] = (),
) -> list[str]:
    """Effects in the order of their score tests on the middle quarter of the field.

    No refit has confirmed them. Empty where nothing is expected, or where the captures are so small
    that the whole field takes no longer.
    """
    part = problem.part
    if part is None:
        return []
    baseline = lacks_baseline(model, exclude)
    # the fits of the whole field begin with these, and do not simulate them again
    state = (
        baseline_fitted(part, baseline_start(problem, exclude, model.seed))
        if baseline
        else fitted(part, model)
    )
    found = score_tests(part, state, candidates_of(state, known, [BASE]))
    return list(dict.fromkeys(g.effect for g in found if g.promise > 0.0))


def _in_full(
    captures: CaptureSet,
    problem: FitProblem,
    state: State,
    open_to: dict[str, type[Effect]],
    on_progress: Callable[[str], None],
    on_trial: Callable[[SoFar], None],
    on_result: Callable[[Diagnosis], None],
    afterwards: TimeLimit | None,
) -> Diagnosis:
    """The whole of a diagnosis of a fitted model that has its baseline effects."""
    null, law = FittedModel.of(problem, state), ""

    def tell(so_far: SoFar) -> None:
        on_trial(so_far)
        if so_far.trials:
            on_result(unfinished(captures, null, so_far, open_to))

    tried, best = choose(null, candidates_of(null.state, open_to, [BASE]), on_progress, tell)
    other = None
    if best is not None:
        other = best.state if best.effect == BASE else lower_without(null, best)
    if best is not None and other is not None:
        null = FittedModel.of(null.problem, converge(null.problem, other))
        law = in_words(problem, null.state.model) if best.effect == BASE else ""
        tried, best = choose(null, candidates_of(null.state, open_to, [BASE]), on_progress)
    on_progress("what the leading candidate leaves")
    found = replace(judge(captures, null, tried, best, open_to, follow_up=True), law=law)
    on_result(found)
    on_progress("detection limits")
    if afterwards is None:
        return replace(found, detection_limits=detection_limits(null.problem, null.state, open_to))
    with suppress(TimeUp):
        limits = detection_limits(null.problem.within(afterwards), null.state, open_to)
        found = replace(found, detection_limits=limits)
    return found


def judge(
    captures: CaptureSet,
    null: FittedModel,
    tried: Sequence[Trial],
    best: Trial | None,
    known: dict[str, type[Effect]],
    follow_up: bool = False,
    elsewhere: bool = True,
) -> Diagnosis:
    """The verdict on a model, with its candidates; ``best``: the one that is significant.

    ``follow_up``: whether what it leaves is tested for further effects, which takes simulations.
    ``elsewhere``: whether a model fitted to a window is compared with the rest of the field.
    """
    problem, state, error = null.problem, null.state, null.error
    open_yet = null.unexplained
    if best is not None:
        first, open_yet = _leader(null, best, tried, known, follow_up)
        rest = [t for t in tried if t is not best and t.gain > 0.0 and t.error_fall > 0.0]
        candidates = [first, *_by_confidence(_candidate(null, t, tried, known) for t in rest)]
    elif open_yet:
        candidates = _by_confidence(
            replace(
                c := _candidate(null, t, tried, known),
                confidence=c.confidence * STANDS_IN,
                leaves=[n for n in open_yet if not null.corrects([n], t.state)],
            )
            for t in tried
            if t.gain > 0.0 and t.error_fall > 0.0
        )
    else:
        candidates = []
    direct = agreements(problem, state)
    seen = coverage(problem.plan, state.model if elsewhere and best is None else None)
    right = not open_yet and all(a.kept for a in direct) and not seen.departs
    verdict = "missing" if best is not None else "adequate" if right else "unexplained"
    return Diagnosis(
        captures,
        error,
        verdict,
        candidates,
        open_yet,
        next_capture=next_capture(problem, verdict, candidates),
        model=state.model,
        trials=[best, *(t for t in tried if t is not best)] if best is not None else list(tried),
        level=problem.level(state.train, state.test),
        direct=direct,
        coverage=seen,
    )


def _candidate(
    null: FittedModel, found: Trial, tried: Sequence[Trial], known: dict[str, type[Effect]]
) -> Candidate:
    why = evidence_for(null.problem, null.state, found.state, known[found.effect])
    return Candidate(
        found.effect,
        found.error,
        _share(null.error, null.error - found.error),
        confidence_of(found, tried),
        competitors(found, tried),
        [*why, found.denied] if found.denied else why,
    )


def _leader(
    null: FittedModel,
    best: Trial,
    tried: Sequence[Trial],
    known: dict[str, type[Effect]],
    follow_up: bool,
) -> tuple[Candidate, list[str]]:
    """The identified effect, with what it leaves: another candidate may correct that, or none.

    Where none does, the effect may stand in for one that is in no catalogue.
    """
    leader, problem = _candidate(null, best, tried, known), null.problem
    rival = next((t for t in tried if t is not best and not apart(best, t)), None)
    if rival is not None:
        against = evidence_against(problem, rival.state, best.state, rival.effect, best.effect)
        leader.evidence.extend([against] if against else [])
    with_it = FittedModel.of(problem, best.state)
    leader, left = _ends_at(leader, null, with_it), with_it.unexplained
    others = [t for t in tried if t is not best and significant(t)]
    second = next((t for t in others if null.corrects(left[:1], t.state)), None)
    if left and second is None and follow_up:
        ended = converge(problem, completed(problem, best), rounds=1, settled=DEFLATION, last=False)
        after = FittedModel.of(problem, ended)
        leader, left = _ends_at(leader, null, after), after.unexplained
        open_to = candidates_of(after.state, known, [BASE])
        further = supported(after, trials(after, open_to)) if left else None
        if further is not None and after.corrects(left[:3], further.state):
            second = further
    if not left:
        return leader, left
    worst = "; ".join(infos()[name].title for name in left[:3])
    if second is not None:
        words = f"it does not explain {worst}, which {second.effect} in addition would correct"
        return replace(leader, evidence=[*leader.evidence, words], leaves=left), left
    words = (
        f"it does not explain {worst}, and no other candidate does: it may replace an effect that "
        "is not in the catalogue"
    )
    sure = leader.confidence * STANDS_IN
    return replace(leader, confidence=sure, evidence=[*leader.evidence, words], leaves=left), left


def _ends_at(found: Candidate, null: FittedModel, after: FittedModel) -> Candidate:
    """The candidate with the model error of the model with it, by that model's own yardstick."""
    explained = _share(null.error, null.error - after.error)
    return replace(found, error_after=after.error, explained=explained)


def unfinished(
    captures: CaptureSet, null: FittedModel, so_far: SoFar, known: dict[str, type[Effect]]
) -> Diagnosis:
    """What is known of a model when the time is up: the candidates refitted by then.

    Others may explain as much or more: the confidence is that of one that may stand in for them.
    """
    error = null.error
    tried = by_standing(list(so_far.trials))
    candidates = [
        _candidate(null, t, tried, known) for t in tried if t.gain > 0 and t.error_fall > 0
    ]
    return Diagnosis(
        captures,
        error,
        "missing" if tried and significant(tried[0]) else "unexplained",
        [replace(c, confidence=c.confidence * STANDS_IN) for c in candidates],
        [],
        model=null.state.model,
        trials=tried,
        level=null.problem.level(null.state.train, null.state.test),
        finished=False,
        screened=list(so_far.screened),
    )


def _with_baseline_listed(
    problem: FitProblem, asked: State, baseline: State, found: Diagnosis
) -> Diagnosis:
    """A diagnosis of the model with the baseline effects, as one of the model without (``asked``).

    The effects are fitted together, so each is stated with the error and the confidence of all.
    """
    null = FittedModel.of(problem, baseline)
    before, ended = FittedModel(null.problem, expressed(asked, problem, null.problem)), null.state
    if found.verdict == "missing":  # beside what is missing too
        ended = start(null.problem, found.trials[0].state.model, [])
    new = new_in(baseline.model, asked.model)
    chance = float(confidences([trial_of(before, new[0], ended)])[0])
    error = FittedModel.of(problem, asked).error
    share = _share(error, error - null.error)
    listed = [
        Candidate(
            effect.name, null.error, share, chance, [],
            [*evidence_for(null.problem, before.state, null.state, type(effect)), *reasons(effect)],
        )
        for name in new
        if (effect := baseline.model.get(name)) is not None
    ]  # fmt: skip
    others = [  # in shares of the same error
        replace(c, explained=_share(error, found.error - c.error_after)) for c in found.candidates
    ]
    first = int(found.verdict == "missing")
    return replace(
        found,
        error=error,
        verdict="missing" if found.verdict == "adequate" else found.verdict,
        candidates=[*others[:first], *listed, *others[first:]],
        ordinary=[c.effect for c in listed],
    )


def _by_confidence(candidates: Iterable[Candidate]) -> list[Candidate]:
    return sorted(candidates, key=lambda c: -c.confidence)


def _share(error: float, fall: float) -> float:
    """A fall as a share of the error above 1, within 0 and 1."""
    return min(1.0, max(0.0, fall) / max(error - 1.0, 1e-6))
