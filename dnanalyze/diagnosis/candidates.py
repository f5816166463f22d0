"""Refits of candidates; competing effects reach their optima before either is named."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.diagnosis.classifier_tests import without_distinguished
from dnanalyze.diagnosis.filter_tests import DENIED, FILTERS, denied, without_denied
from dnanalyze.diagnosis.forms import in_best_form
from dnanalyze.diagnosis.gains import trial_by_prediction, trial_of
from dnanalyze.diagnosis.nuisance import without_biased
from dnanalyze.diagnosis.score_test import Guess, along, much_left, score_tests
from dnanalyze.diagnosis.selection import (
    COMPETING_SHARE,
    EVIDENCE_DECISIVE,
    EVIDENCE_NULL,
    EVIDENCE_ODDS_10,
    LEAST_GAIN,
    REFITS,
    Trial,
    competitors,
    contenders,
    significant,
    standings,
)
from dnanalyze.fitting.changes import part_for, screening_part
from dnanalyze.fitting.derivatives import GROWTH, derive
from dnanalyze.fitting.from_part import FIT_STEPS
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State, carried, deviance, start, with_derivatives_of
from dnanalyze.model.effect import Effect, Placing
from dnanalyze.model.strength import at_factor
from dnanalyze.progress import ignored

# Times its promise, which is that of two operating points, that a refit may gain; or as many times
# as another of these refits has gained.
GAIN_OVER_PROMISE = 6.0
# Weaker starts at most, down to 1/512 of a guess. Without them the refits of a glow and a gradient
# of a real CCD (st7_2013) end 4,000 and 10,000 above the loss of the model without, with them 1,500
# and 3,300 below.
STARTS = 3
# Least share of a strength from one start to the next: farther, the logarithms of the statistics
# are no straight line. From 27 times their size, column offsets began at 0.08 of it, where the
# statistics hardly move, and stayed there.
WEAKER = 1.0 / GROWTH
# Times the distance of two sensors of a design that the captures may be from one of them. Codes of
# random widths are at 0.8 to 1.9; of 15 guesses of effects that are not there the least is at 3.1.
AS_SENSORS = 2.0


@dataclass(frozen=True)
class SoFar:
    """What a search has found at a time: effects, the largest score test first, and trials."""

    screened: Sequence[str] = ()
    trials: Sequence[Trial] = ()


def candidates_of(
    state: State, known: dict[str, type[Effect]], exclude: Sequence[str]
) -> dict[str, type[Effect]]:
    """Effects that are neither in the model nor excluded."""
    return {n: e for n, e in known.items() if n not in exclude and state.model.get(n) is None}


def by_standing(trials: Sequence[Trial]) -> list[Trial]:
    """The most probable first."""
    return [trials[i] for i in np.argsort(-standings(trials), kind="stable")]


def trials(
    null: FittedModel,
    known: dict[str, type[Effect]],
    on_progress: Callable[[str], None] = ignored,
    on_trial: Callable[[SoFar], None] = ignored,
) -> list[Trial]:
    """Refit the candidates with the largest promise; the most probable first.

    ``null``: the model without them. ``on_progress``: called with each name. ``on_trial``: called
    with what is found so far, after the score tests and after each refit.
    """
    guesses = _screened(null, known, on_progress)
    on_trial(SoFar(list(guesses)))
    found = _refits(null, guesses, on_progress, on_trial)
    promises = {name: own[0].promise for name, own in guesses.items()}
    made = [
        t for t in _at_their_optima(null, found, promises) if shown(null.problem, t.state, t.effect)
    ]
    tested = by_standing([_tested(null.problem, t, made) for t in made])
    return by_standing(without_distinguished(null.problem, tested))


def refitted_once(
    null: FittedModel,
    known: dict[str, type[Effect]],
    on_progress: Callable[[str], None] = ignored,
    on_part: bool = False,
) -> tuple[list[str], list[Trial]]:
    """The effects of the largest promise, and one refit of each, that of most evidence first.

    On a part of the field, none is refitted where the first of them has a place or few pixels: it
    does not show that as the whole does. Arguments are those of `trials`.
    """
    guesses = _screened(null, known, on_progress)
    names = list(guesses)[:REFITS]
    if not names or (on_part and known[names[0]].placing is not Placing.EVERYWHERE):
        return names, []
    found = [
        t for t in _refits(null, guesses, on_progress) if shown(null.problem, t.state, t.effect)
    ]
    tested = [_tested(null.problem, t, found) for t in found]
    return names, sorted(tested, key=lambda t: -t.evidence)


def _screened(
    null: FittedModel, known: dict[str, type[Effect]], on_progress: Callable[[str], None]
) -> dict[str, list[Guess]]:
    """Guesses of each effect, the largest promise first."""
    guesses: dict[str, list[Guess]] = {}
    for guess in score_tests(null.problem, null.state, known, on_progress):
        guesses.setdefault(guess.effect, []).append(guess)
    return guesses


def _refits(
    null: FittedModel,
    guesses: dict[str, list[Guess]],
    on_progress: Callable[[str], None],
    on_trial: Callable[[SoFar], None] = ignored,
) -> list[Trial]:
    """The first effects, each refitted from its best guess while it may reach the best of them.

    The first one must gain what is asked for: more where nothing is left to be corrected.
    """
    found: list[Trial] = []
    least = EVIDENCE_NULL if null.left else EVIDENCE_ODDS_10
    wanted, reach = null.state.loss - least, GAIN_OVER_PROMISE
    for name, own in list(guesses.items())[:REFITS]:
        if own[0].promise < LEAST_GAIN or reach * own[0].promise < null.state.loss - wanted:
            break
        on_progress(name)
        ended = _refitted_from(null, own, wanted)
        gained = null.state.loss - ended.loss
        reach = max(reach, gained / own[0].promise)
        made = trial_of(null, name, ended)
        if much_left(ended):
            made = as_sensors(null, own, made)
        if significant(made, EVIDENCE_NULL):  # one that cannot be named leaves others their chance
            wanted = min(wanted, null.state.loss - COMPETING_SHARE * gained)
        found.append(replace(made, others=_of_other_kinds(own)))
        on_trial(SoFar(list(guesses), list(found)))
    return found


def _refitted_from(null: FittedModel, guesses: Sequence[Guess], wanted: float) -> State:
    """The refit of the best guess of an effect.

    Where it ends above the loss of the model without the effect, the other from the guess beside
    that model as fitted: the best may come with a baseline made anew, from where six steps do not
    always lead back.
    """
    ended = refitted(null.problem, guesses[0], null.state, wanted)
    plain = next((g for g in guesses if g.model.without(g.effect) == null.state.model), None)
    if ended.loss <= null.state.loss or plain is None or plain is guesses[0]:
        return ended
    other = refitted(null.problem, plain, null.state, wanted)
    return min(ended, other, key=lambda state: state.loss)


def as_sensors(null: FittedModel, guesses: Sequence[Guess], found: Trial) -> Trial:
    """A trial, or that of a guess if sensors of its design differ as much; both by prediction.

    Where each sensor has its own few draws, as codes of random widths, no parameter brings the
    simulated sensor to the measured one, and a refit leaves the right values for it.
    """
    problem, made = null.problem, []
    for guess in (guesses[0], *_of_other_kinds(guesses)):
        part = screening_part(problem, guess.model)
        if part is not None and not _differ_as_much(part, start(part, guess.model)):
            continue
        begun = start(problem, guess.model, like=null.state)
        if _differ_as_much(problem, begun):
            trial = trial_by_prediction(null, trial_of(null, guess.effect, begun))
            made.append(replace(trial, by_design=True))
    if not made:
        return found
    return max(trial_by_prediction(null, found), *made, key=lambda t: t.evidence)


def _differ_as_much(problem: FitProblem, begun: State) -> bool:
    """Whether two sensors of a design differ about as much as the captures from one of them."""
    other = problem.fitted_z(replace(begun.model, seed=begun.model.seed + 1))
    return begun.loss <= AS_SENSORS * float(np.sum(deviance(begun.train - other)))


def _tested(problem: FitProblem, found: Trial, trials: Sequence[Trial]) -> Trial:
    """A candidate filter with the result of the tests for filters.

    Where another kind of effect explains as much, or much is left with the filter too, its evidence
    says little by itself: then these tests must find it.
    """
    if found.effect not in FILTERS or not significant(found, EVIDENCE_NULL):
        return found
    rivals = [t for t in trials if t.effect in competitors(found, trials)]
    other = any(t.effect not in FILTERS and significant(t) for t in rivals)
    against = denied(problem, found.state.model, other or much_left(found.state))
    return replace(found, denied=DENIED if against else "")


def shown(problem: FitProblem, state: State, name: str) -> bool:
    """Whether these captures tell an effect of a model, as fitted, from a simpler one."""
    effect, plan = state.model.get(name), problem.plan
    assert effect is not None
    pixels = sum(math.prod(window.shape) for window in plan.windows)
    return effect.shows_in(max(n for _, n in plan.settings), pixels)


def _of_other_kinds(guesses: Sequence[Guess]) -> tuple[Guess, ...]:
    """The next guess, and the first of each other kind."""
    first = {g.kind: g for g in reversed(guesses)}
    return tuple(g for g in guesses[1:] if g is guesses[1] or first[g.kind] is g)


def _at_their_optima(
    null: FittedModel, found: list[Trial], promises: dict[str, float]
) -> list[Trial]:
    """The leader and its contenders at their optima, where the choice is open.

    Contenders are in their best forms, and take the derivatives of what they share from the leader.
    All of these are compared by what sensors of their design show.
    """
    able = [t for t in found if t.fitted_gain >= LEAST_GAIN]
    if not able:
        return found
    leader = max(able, key=lambda t: t.evidence)
    near = without_denied(null.problem, leader, found, contenders(leader, found, promises))
    if significant(leader, EVIDENCE_DECISIVE) and len(near) == 1:
        return found
    like = derive(null.problem, leader.state, anew=True)
    made = []
    for t in found:
        if t.effect in near and not t.by_design:
            begun = best = like if t is leader else with_derivatives_of(t.state, like)
            if len(near) > 1:
                best = in_best_form(null.problem, replace(t, state=begun))
            ended = trial_of(null, t.effect, minimise(null.problem, best, FIT_STEPS))
            formed = len(near) > 1 and best is begun
            t = trial_by_prediction(null, replace(ended, others=t.others, formed=formed))
        made.append(t)
    return made


def refitted(problem: FitProblem, guess: Guess, like: State, wanted: float = math.inf) -> State:
    """A guess refitted, on a part of the field first where that may be.

    ``like``: the model without the effect. ``wanted``: loss that must come within reach; else the
    refit is given up.
    """
    part = part_for(problem, guess.model)
    if part is None:
        return _from_guess(problem, guess, like, wanted)
    there = carried(like, problem, part)
    near = _from_guess(part, guess, there, wanted * there.loss / like.loss)
    return minimise(problem, carried(near, part, problem), FIT_STEPS, below=wanted)


def refitted_beside(here: FittedModel, tried: Sequence[Trial]) -> list[Trial]:
    """Trials of a model refitted in the model with one more effect; most evidence first.

    Of these, the ones that have decisive evidence there. Filters are left to the tests for filters,
    which `trials` makes.
    """
    least = here.state.loss - EVIDENCE_DECISIVE
    made = [
        trial_of(here, t.effect, _refitted_in(here.problem, here.state, t, least))
        for t in tried
        if t.effect not in FILTERS and here.state.model.get(t.effect) is None
    ]
    found = [t for t in made if significant(t, EVIDENCE_DECISIVE)]
    return sorted(found, key=lambda t: -t.evidence)


def _refitted_in(problem: FitProblem, state: State, found: Trial, least: float) -> State:
    """The effect of a trial in another model, with the derivatives that either knows."""
    effect = found.state.model.get(found.effect)
    assert effect is not None
    model = state.model.with_effect(effect)
    begun = start(problem, model, like=state)
    own = with_derivatives_of(begun, found.state).jacobian
    known = np.where(np.isnan(begun.jacobian), own, begun.jacobian)
    return minimise(problem, replace(begun, jacobian=known), FIT_STEPS, below=least)


def _from_guess(problem: FitProblem, guess: Guess, like: State, wanted: float) -> State:
    """A refit on one field, with the derivatives of the model without where these carry over.

    They do not for the parameters that the effect has biased.
    """
    begun = _begun(problem, guess, like)
    return minimise(problem, without_biased(problem, begun, guess.effect), FIT_STEPS, below=wanted)


def _begun(problem: FitProblem, guess: Guess, like: State) -> State:
    """A guess simulated, at a lower strength where the statistics want less than half of it.

    A refit that begins far beyond does not come back. Nor does one that begins where the effect
    hardly shows: a strength along whose change the least loss is no lower is not taken. A guess
    that comes with corrected nuisance parameters begins as it is, since these go with its strength.
    """
    begun = start(problem, guess.model, like=like)
    if guess.model.without(guess.effect) != like.model:
        return begun
    least = along(like, like.train - begun.train)
    for _ in range(STARTS):
        effect = begun.model.get(guess.effect)
        if effect is None or least.share >= 0.5:  # half and twice a strength are forms (`forms`)
            break
        weaker = at_factor(effect, max(least.share, WEAKER))
        if weaker is None:
            break
        lower = start(problem, begun.model.with_effect(weaker), like=like)
        found = along(like, like.train - lower.train)
        if found.loss >= least.loss:
            break
        begun, least = lower, found
    return begun
