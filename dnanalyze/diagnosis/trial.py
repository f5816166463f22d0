"""Try an effect: put it in, refit everything, and see what the half that no fit saw says."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from dnanalyze.comparator.error import pooled
from dnanalyze.diagnosis.deviance import DEFLATION, TOLERABLE, deviance, dispersion, falls
from dnanalyze.diagnosis.in_its_place import in_its_place
from dnanalyze.diagnosis.refit import FAR, SURE, refitted
from dnanalyze.diagnosis.screening import LEAST, Prospect, much_left, prospects
from dnanalyze.errors import InputError
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import (
    HOPE,
    State,
    derive,
    minimise,
    start,
    with_derivatives_of,
)
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel

MOST_REFITS = 4
WORTH = 0.15  # share of the best promise from which a candidate is refitted
CLOSE = 0.6  # share of the most evidence from which a rival is followed to the end
REACH = 6.0  # times its promise, of the two most telling settings, more than which few refits gain
TIE = 0.05  # share of the loss that a fit may still gain by derivatives taken anew
CLEAR = 50.0  # evidence from which the choice between rivals matters
DOUBT = 6.0, 60.0  # evidence, a unit of the misfit left, where what a fit left undone may decide
STEPS = 6  # of a fit with derivatives taken anew
KIND_GAIN = 4.0  # mean gain of the halves that another kind must bring
UNTRIED = ("bits", "step", "spacing")  # facts of the converter and the mosaic, not kinds


@dataclass(frozen=True)
class Trial:
    """The model with one more effect, refitted.

    Parameters
    ----------
    effect : str
    state : State
        After the refit.
    gain : float
        Fall of the deviance on the judged half; a useless effect gains about nothing.
    fitted_gain : float
        The same on the half that was fitted.
    error : float
        Pooled error on the judged half.
    spread : float
        Misfit per statistic that it leaves, the unit of its gains (see `dispersion`).
    others : tuple of Prospect
        Guesses of the effect that promised nearly as much and were not refitted.
    falls : ndarray
        Fall of the deviance of each statistic, on the judged and on the fitted half.
    """

    effect: str
    state: State
    gain: float
    fitted_gain: float
    error: float
    spread: float = 1.0
    others: tuple[Prospect, ...] = ()
    falls: np.ndarray = field(default_factory=lambda: np.empty(0), repr=False)

    @property
    def evidence(self) -> float:
        """Mean gain of the halves.

        What idle numbers gain by chance on the fitted half they lose on the other, so the mean is
        fair, and it scatters less than the gain on either (Akaike's criterion, measured).
        """
        return (self.gain + self.fitted_gain) / 2.0

    @property
    def tolerable(self) -> bool:
        """Whether the statistics that it changes are left as near as a model called adequate."""
        return self.spread <= TOLERABLE**2

    @property
    def log_odds(self) -> float:
        """Logarithm of the prior odds of the effect."""
        model = self.state.model
        effect = model.get(self.effect)
        return 0.0 if effect is None else math.log(effect.odds(model.names))


def standings(trials: Sequence[Trial]) -> np.ndarray:
    """Evidence and prior odds in units of one overdispersion, by which rivals are ranked.

    The overdispersion is that of the candidate with most evidence, for all of them, as quasi-AIC
    takes it from the model that fits best (Burnham and Anderson 2002, section 2.5): a scale of its
    own for each candidate would rank them otherwise than their deviances do.

    Parameters
    ----------
    trials : sequence of Trial

    Returns
    -------
    ndarray
        (trials,), twice log likelihood ratios but for the correlation of the statistics.
    """
    if not trials:
        return np.empty(0)
    common = max(trials, key=lambda t: t.evidence).spread
    return np.array([t.evidence / common + 2.0 * DEFLATION * t.log_odds for t in trials])


def by_standing(trials: Iterable[Trial]) -> list[Trial]:
    """The likeliest first."""
    trials = list(trials)
    return [trials[i] for i in np.argsort(-standings(trials), kind="stable")]


@dataclass
class SoFar:
    """What a search has found, for an answer when its time is up.

    Parameters
    ----------
    screened : list of str
        Effects in the order of the fall of the error that first-order screening expects.
    trials : list of Trial
        Those refitted.
    """

    screened: list[str] = field(default_factory=list)
    trials: list[Trial] = field(default_factory=list)


def error_of(bench: Bench, state: State) -> float:
    """Pooled error on the judged half."""
    return pooled(state.test, bench.test.families)


def trials(
    bench: Bench,
    state: State,
    known: dict[str, type[Effect]],
    tell: Callable[[str], None] = lambda _: None,
    iterations: int = 3,
    so_far: SoFar | None = None,
) -> list[Trial]:
    """Refit the most promising candidates; the likeliest first.

    ``so_far``: takes what is found, as it is found.
    """
    so_far = so_far or SoFar()
    seen = prospects(bench, state, known, tell)
    so_far.screened[:] = dict.fromkeys(p.effect for p in seen)
    if not seen:
        return []
    least = max(WORTH * seen[0].promise, LEAST)
    best: dict[str, Trial] = {}
    others: dict[str, tuple[Prospect, ...]] = {}
    fell, error = 0.0, error_of(bench, state)
    worth = [p for p in seen if p.promise >= least]
    for p in [p for p in worth if not p.spare][:MOST_REFITS]:
        first = best.get(p.effect)
        if first is not None and first.fitted_gain > SURE and first.error < error:
            others[p.effect] = (*others.get(p.effect, ()), p)
            continue
        if REACH * p.promise < CLOSE * fell:
            continue
        tell(p.effect)
        wanted, again = state.loss - WORTH * fell, HOPE * p.promise > CLOSE * fell
        ended = refitted(bench, p, state, wanted, iterations, again)
        if p.levelled is not None and much_left(ended):
            other = replace(p, model=p.levelled)
            ended = preferred(ended, refitted(bench, other, state, math.inf, iterations))
        made = judged(bench, state, p.effect, ended)
        if p.effect not in best or made.evidence > best[p.effect].evidence:
            best[p.effect] = made
            so_far.trials.append(made)
        fell = max(fell, state.loss - ended.loss)
    for p in [p for p in worth if p.spare and p.effect in best]:
        others[p.effect] = (*others.get(p.effect, ()), p)
    if best:
        _tried_again(bench, state, best, others, CLOSE * seen[0].promise, iterations)
        _from_leader(bench, state, known, best, iterations)
        _polish(bench, state, best)
    complete = (replace(t, others=others.get(t.effect, ())) for t in best.values())
    return by_standing(complete)


def _tried_again(
    bench: Bench,
    state: State,
    best: dict[str, Trial],
    others: dict[str, tuple[Prospect, ...]],
    least: float,
    iterations: int,
) -> None:
    """Rivals from other guesses that promised much, where the leader leaves wrong what it moves."""
    leader = max(best.values(), key=lambda t: t.evidence)
    if leader.tolerable:
        return
    for effect in [e for e in others if e != leader.effect]:
        promising = [p for p in others[effect] if p.promise > least]
        others[effect] = tuple(p for p in others[effect] if p.promise <= least)
        for p in promising:
            made = judged(bench, state, effect, refitted(bench, p, state, state.loss, iterations))
            if made.evidence > best[effect].evidence:
                best[effect] = made


def _from_leader(
    bench: Bench,
    state: State,
    known: dict[str, type[Effect]],
    best: dict[str, Trial],
    iterations: int,
) -> None:
    """Rivals begun with the leader's numbers too: none may lose by where it was begun.

    Of hot pixels that a correction has taken nearly all, counts tell so little that a first guess
    is luck, while another law of the same few pixels may have been fitted well. Only rivals that
    show a sign of their own: of few pixels nearly any law does as well.
    """
    leader = max(best.values(), key=lambda t: t.evidence)
    wanted = state.loss - CLOSE * (state.loss - leader.state.loss)
    rivals = {name: effect for name, effect in known.items() if name in best}
    for name, model in in_its_place(leader.state.model, leader.effect, rivals):
        begun = start(bench, model, knobs_of(model), like=leader.state)
        made = judged(bench, state, name, minimise(bench, begun, iterations, below=wanted))
        if made.evidence > best[name].evidence:
            best[name] = made


def best_guess(bench: Bench, before: State, found: Trial, iterations: int = 3) -> State:
    """The better of a trial and of refits from the effect's other guesses, on both halves."""
    state = found.state
    for other in found.others:
        state = preferred(state, refitted(bench, other, before, FAR * state.loss, iterations))
    return state


def _polish(bench: Bench, state: State, best: dict[str, Trial]) -> None:
    """Go on with rivals that gain much and nearly alike, or that raise the error for all they gain.

    A refit of few steps may mend what is far off at the cost of much that was right, and which of
    two is the better shows once both stand at their best. A rival that lowers the error more than
    the leader, or fits better, with less evidence so far, is one of them. They stand so close that
    the derivatives of what they share are one's as much as the other's. One that is plainly behind
    goes on only while its steps may still bring it near. The leader goes on where what a fit may
    still gain decides: between rivals, or whether there is evidence enough.
    """
    leader = max(best.values(), key=lambda t: t.evidence)
    close = [
        t
        for t in best.values()
        if t is not leader
        and (
            (t.evidence > CLOSE * leader.evidence and t.fitted_gain > 0)
            or (t.error < leader.error and t.state.loss < state.loss)
            or t.fitted_gain > leader.fitted_gain
        )
    ]
    raises = leader.error >= error_of(bench, state)
    doubtful = DOUBT[0] < leader.evidence / leader.spread < DOUBT[1]
    if not doubtful and (leader.evidence < CLEAR or not (close or raises)):
        return

    def gone_on(t: Trial, like: State, below: float = math.inf) -> Trial:
        begun = with_derivatives_of(t.state, like)
        if below < math.inf:  # its own will do to see whether that is within reach
            own = np.isnan(begun.jacobian)
            begun.jacobian[own] = t.state.jacobian[own]
        return judged(bench, state, t.effect, minimise(bench, begun, STEPS, below=below))

    def behind(t: Trial) -> float:
        return leader.evidence - t.evidence - TIE * leader.state.loss

    def leads() -> bool:
        clear = all(behind(best[t.effect]) > 0 for t in close)
        return clear and not (raises or doubtful)

    if leads():
        for t in close:
            if not t.state.at_rest:
                best[t.effect] = gone_on(t, leader.state, t.state.loss - behind(t))
    if not leads():
        like = derive(bench, leader.state, anew=True)
        for t in (leader, *close):
            best[t.effect] = gone_on(best[t.effect], like)


def judged(bench: Bench, before: State, effect: str, after: State) -> Trial:
    """A refit, with what it gained on either half."""
    gains = witnessed(bench, after.model.get(effect), *_gains(before, after))
    halves = (
        (bench.test.names, before.test, after.test),
        (bench.train.names, before.train, after.train),
    )
    fell = np.concatenate([falls(*half) for half in halves])
    return Trial(effect, after, *gains, error_of(bench, after), dispersion(*halves[0]), falls=fell)


def witnessed(
    bench: Bench, effect: Effect | None, gain: float, fitted_gain: float
) -> tuple[float, float]:
    """Gains on the judged and on the fitted half, of an effect that lies in both.

    A half in which none of the effect lies is no witness for it, only against it: for it speaks
    the other, which has all of its places, each far out over all of a line and at many settings.
    """
    if effect is None:
        return gain, fitted_gain
    upper, lower = map(effect.lies_in, bench.plan.windows)
    if upper == lower:
        return gain, fitted_gain
    there, elsewhere = (gain, fitted_gain) if lower else (fitted_gain, gain)
    return (there + min(0.0, elsewhere),) * 2


def _gains(before: State, after: State) -> tuple[float, float]:
    """Fall of the deviance on the judged and on the fitted half."""
    return (
        deviance(before.test) - deviance(after.test),
        deviance(before.train) - deviance(after.train),
    )


def settled(bench: Bench, state: State, name: str, iterations: int = 3) -> State:
    """The best of an effect's kinds: each alternative to its choices, refitted from here."""
    for choice, info in _effect(state.model, name).parameters().items():
        if info.scale != "choice" or choice in (*UNTRIED, *_effect(state.model, name).idle()):
            continue
        for other in info.choices:
            effect = _effect(state.model, name)
            if other != getattr(effect, choice):
                with suppress(InputError):  # a choice that the others rule out
                    kind = replace(effect, **{choice: other})
                    state = _better(bench, state, kind, iterations)
    return state


def related(bench: Bench, state: State, name: str, iterations: int = 6) -> State:
    """The best of an effect and its forms with numbers to match, where the fit stands."""
    for other in _effect(state.model, name).relatives():
        with suppress(InputError):
            state = _better(bench, state, other, iterations, anew=True)
    return state


def _better(bench: Bench, state: State, kind: Effect, iterations: int, anew: bool = False) -> State:
    """The model with another kind of an effect, refitted, if that is clearly better.

    On both halves together: of a shaded sensor one half alone does not tell whether the shading
    scales the dark current of each pixel or adds to it. Given up once no steps would bring it to
    where the state stands.
    ``anew``: its numbers are others, and so are its derivatives.
    """
    model = state.model.with_effect(kind)
    begun = start(bench, model, knobs_of(model), like=state)
    if np.array_equal(begun.train, state.train):
        return state
    if begun.loss > FAR * state.loss:  # the numbers may have made up for the wrong kind
        begun = minimise(bench, begun, 1)
        if begun.loss > FAR * state.loss:
            return state
    if anew:
        begun.jacobian[:, [k.effect == kind.name for k in begun.knobs]] = np.nan
    return preferred(state, minimise(bench, begun, iterations, below=state.loss))


def preferred(state: State, other: State) -> State:
    """The other where it is clearly better."""
    return other if sum(_gains(state, other)) / 2.0 > KIND_GAIN else state


def _effect(model: NoiseModel, name: str) -> Effect:
    found = model.get(name)
    assert found is not None
    return found


def removal(bench: Bench, state: State, name: str, iterations: int = 3) -> State:
    """The model without an effect, refitted."""
    model = state.model.without(name)
    return minimise(bench, start(bench, model, knobs_of(model), like=state), iterations)


def candidates_of(
    state: State, known: dict[str, type[Effect]], exclude: Sequence[str]
) -> dict[str, type[Effect]]:
    """Effects that are neither in the model nor excluded."""
    return {n: e for n, e in known.items() if n not in exclude and state.model.get(n) is None}
