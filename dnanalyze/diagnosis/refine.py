"""Diagnose and add until nothing more is missing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from dnanalyze.diagnosis.adequacy import averaged
from dnanalyze.diagnosis.background import along_background
from dnanalyze.diagnosis.bend import along_bend
from dnanalyze.diagnosis.confidence import CERTAIN, LUCK, NOTHING, STANDS_IN, confidences
from dnanalyze.diagnosis.diagnose import Diagnosis, judge, missing, retold
from dnanalyze.diagnosis.everyday import everyday, lacks_everyday
from dnanalyze.diagnosis.exchange import exchange
from dnanalyze.diagnosis.screening import prospects
from dnanalyze.diagnosis.trial import (
    best_guess,
    candidates_of,
    error_of,
    judged,
    preferred,
    removal,
    settled,
    trials,
)
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import State, converge, derive, minimise, start
from dnanalyze.fitting.predictor import Bench, bench
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, EVERYDAY, catalogue, find

POOR = 1.3  # error above which an early choice is reconsidered where nothing more can be added


@dataclass(frozen=True)
class Step:
    """What was added (None: the starting model; "-name": taken out again), and the error then."""

    added: str | None
    error: float
    confidence: float | None = None
    evidence: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Refinement:
    """A model completed step by step.

    Parameters
    ----------
    captures : str
    steps : list of Step
        The first entry is the starting model.
    effects : list of str
        In the final model.
    verdict : str
        "adequate", "missing" (stopped early) or "unexplained".
    model : NoiseModel
    diagnosis : Diagnosis
        Of the final model.
    bench : Bench
    state : State
    """

    captures: str
    steps: list[Step]
    effects: list[str]
    verdict: str
    model: NoiseModel
    diagnosis: Diagnosis
    bench: Bench
    state: State


def refine(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    exclude: Sequence[str] = (),
    most_effects: int | None = None,
    until_error: float | None = None,
    known: dict[str, type[Effect]] | None = None,
    held: Bench | None = None,
    tell: Callable[[Step], None] = lambda _: None,
    trying: Callable[[str], None] = lambda _: None,
    keep: Callable[[NoiseModel], None] = lambda _: None,
) -> Refinement:
    """Complete a model.

    Parameters
    ----------
    captures : CaptureSet
    model : NoiseModel, optional
        Where to begin; the paper's model by default.
    exclude : sequence of str
        Effects never to add.
    most_effects : int, optional
        Stop once this many effects were added.
    until_error : float, optional
        Stop once the error is at or below this.
    known : dict, optional
        Effects by name; the built-in catalogue by default.
    held : Bench, optional
        Statistics taken earlier.
    tell, trying : callable
        Called after every step, and with the name of every effect that is tried.
    keep : callable
        Called with the model whenever it stands complete; from any of these one may go on.
    """
    held = held or bench(design(captures))
    known = catalogue() if known is None else known
    steps: list[Step] = []

    def note(step: Step) -> None:
        steps.append(step)
        tell(step)

    begun = model or paper_start(held)
    state = minimise(held, start(held, begun, knobs_of(begun)))
    note(Step(None, error_of(held, state)))
    if lacks_everyday(begun, exclude):
        state = everyday(
            held, state.model, exclude, lambda name, s: note(Step(name, error_of(held, s)))
        )
        keep(state.model)
    dropped: set[str] = set()
    fresh = False
    while True:
        if until_error is not None and steps[-1].error <= until_error:
            tried = []
            break
        open_to = candidates_of(state, known, [BASE, *exclude, *dropped])
        tried = trials(held, state, open_to, trying)
        error = error_of(held, state)
        added = [n for n in state.model.names if n not in (*begun.names, *EVERYDAY)]
        best, before = missing(held, state, tried), state
        if best is None and error > POOR and not fresh:
            # derivatives that many steps kept up may hide from the refits what true ones show
            state, fresh = minimise(held, derive(held, state, anew=True)), True
            continue
        among = retold(tried, best)
        other = exchange(held, state, added, open_to, trying) if not best and error > POOR else None
        if other is not None:
            best, before, among = other.found, other.without, [other.found]
            added.remove(other.gone)
        if best is None or (most_effects is not None and len(added) >= most_effects):
            break
        if other is not None:
            dropped.add(other.gone)
            note(Step(f"-{other.gone}", error_of(held, before)))
        state, fresh = _completed(held, best_guess(held, before, best), best.effect), False
        sure = float(confidences(among, error)[0])
        note(Step(best.effect, error_of(held, state), sure))
        state, gone = _needless(held, state)
        for name in gone:
            dropped.add(name)
            note(Step(f"-{name}", error_of(held, state)))
        keep(state.model)
    found = judge(captures.name, held, state, tried, known, limits=False)
    if found.verdict == "unexplained":
        steps = [_doubted(s) for s in steps]
    return Refinement(
        captures.name, steps, state.model.names, found.verdict, state.model, found, held, state
    )


def _doubted(step: Step) -> Step:
    """Something stays unexplained at the end, for which the effect may stand in."""
    if step.confidence is None:
        return step
    return replace(step, confidence=step.confidence * STANDS_IN)


def _completed(held: Bench, state: State, name: str) -> State:
    """The effect in its best kind and everything at its best place; each may change the other."""
    state = converge(held, settled(held, state, name, relatives=False))
    state = preferred(state, along_bend(held, state, name) or state)
    if error_of(held, state) > POOR:
        state = along_background(held, state)
    again = settled(held, state, name)
    return state if again is state else converge(held, again)


def _needless(held: Bench, state: State) -> tuple[State, list[str]]:
    """Drop effects whose removal, after a refit, costs nothing on the unseen half.

    The latest too: it may have led others to a place from which they do without it.
    """
    gone = []
    for name in list(state.model.names):
        if name in (*EVERYDAY, BASE):
            continue
        without = removal(held, state, name)
        if _idle(held, without, state, name):
            state = without
            gone.append(name)
    return state, gone


def _idle(held: Bench, without: State, state: State, name: str) -> bool:
    """Whether an effect gains nothing on the unseen half, and the error stays without it; where
    the fitted half gains much, on average over simulated sensors.
    """
    found = judged(held, without, name, state)
    if error_of(held, without) > (1.0 + LUCK) * found.error:
        return False
    if found.gain < NOTHING / 2 and found.fitted_gain > CERTAIN:
        found = judged(held, averaged(held, without), name, averaged(held, state))
    return found.gain < NOTHING / 2


def add(
    captures: CaptureSet,
    name: str,
    model: NoiseModel,
    *,
    known: dict[str, type[Effect]] | None = None,
    held: Bench | None = None,
) -> Refinement:
    """Put one effect in, refit everything together, and report the error before and after."""
    known = catalogue() if known is None else known
    effect = find(name, known)
    held = held or bench(design(captures))
    before = minimise(held, start(held, model, knobs_of(model)))
    seen = prospects(held, before, {name: effect})
    larger = seen[0].model if seen else before.model.with_effect(effect())
    begun = start(held, larger, knobs_of(larger), like=before)
    after = judged(held, before, name, minimise(held, begun, 8))
    steps = [Step(None, error_of(held, before)), Step(name, after.error)]
    found = judge(captures.name, held, after.state, [], known, limits=False)
    state = after.state
    return Refinement(
        captures.name, steps, state.model.names, found.verdict, state.model, found, held, state
    )
