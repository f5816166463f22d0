"""Which effect is missing: every candidate tried, ranked by what the unseen half says."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

from dnanalyze.diagnosis.adequacy import (
    FEW,
    WORST,
    adequacy,
    leaves,
    mends,
    on_average,
    sobered,
    unexplained,
)
from dnanalyze.diagnosis.advice import detection_limits, next_capture
from dnanalyze.diagnosis.candidate import Candidate
from dnanalyze.diagnosis.confidence import (
    CERTAIN,
    PLAIN,
    STANDS_IN,
    apart,
    confidence_of,
    confidences,
    lowers,
    rivals,
    significant,
)
from dnanalyze.diagnosis.deviance import DEFLATION
from dnanalyze.diagnosis.everyday import everyday, lacks_everyday
from dnanalyze.diagnosis.evidence import evidence_against, evidence_for
from dnanalyze.diagnosis.first_answer import first_answer
from dnanalyze.diagnosis.leftover import leftover
from dnanalyze.diagnosis.spread_law import spread_law, told
from dnanalyze.diagnosis.trial import (
    STEPS,
    SoFar,
    Trial,
    by_standing,
    candidates_of,
    error_of,
    judged,
    trials,
)
from dnanalyze.digits import number
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start, with_seed
from dnanalyze.fitting.from_part import fitted_in_time
from dnanalyze.fitting.least_squares import State, converge, derive, minimise, start
from dnanalyze.fitting.level import Level
from dnanalyze.fitting.located import located
from dnanalyze.fitting.predictor import Bench, bench
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, EVERYDAY, known_effects
from dnanalyze.result import Result

LITTLE = 0.05  # of the error beyond 1, that what leaves the worst of it must take away
DISAGREE = 0.3  # share of what one half gains that the other has at the most, if they disagree
EVERY_SENSOR = (
    "baseline effect, present in every sensor: added with the other baseline effects, untested"
)
UNDONE = 120.0  # evidence, in units of the misfit left, beyond what last steps of a fit may gain


@dataclass(frozen=True, repr=False)
class Diagnosis(Result):
    """Diagnosis of a model: verdict and candidates.

    Parameters
    ----------
    captures : str
        Name of the captures.
    error : float
        Model error, dimensionless.
    verdict : str
        "adequate", "missing" or "unexplained".
    candidates : list of Candidate
        In the order of confidence, the identified effect first. If the model has no baseline
        effects, these follow an effect that is missing in addition. Empty where the model is
        adequate.
    unexplained : list of str
        Statistics not explained, worst first: by the identified effect, or by the model where the
        captures support no candidate.
    detection_limits : dict
        Effect to a sentence with its detection limit.
    next_capture : list of str
        Recommended captures.
    model : NoiseModel
        The refitted model, to which the candidates were added.
    trials : list of Trial
        The candidates as they were refitted.
    ordinary : list of str
        Baseline effects that the model lacked; they were added before other effects were tested.
    level : Level, optional
        Difference of the mean dark signal, which is within limits for an adequate model.
    law : str
        Sentence on the relative standard deviation of the dark current over temperature, where the
        model includes this dependence; else empty.
    capture_set : CaptureSet, optional
        The measured frames.
    finished : bool
        Whether every candidate was tested; False where the time limit ended the search.
    screened : list of str
        If not finished: effects in the order of the fall of the error that first-order screening
        expects; no refit has confirmed them.
    """

    captures: str
    error: float
    verdict: str
    candidates: list[Candidate]
    unexplained: list[str]
    detection_limits: dict[str, str] = field(default_factory=dict)
    next_capture: list[str] = field(default_factory=list)
    model: NoiseModel | None = None
    trials: list[Trial] = field(default_factory=list)
    ordinary: list[str] = field(default_factory=list)
    level: Level | None = None
    law: str = ""
    capture_set: CaptureSet | None = field(default=None, compare=False)
    finished: bool = True
    screened: list[str] = field(default_factory=list)

    def _brief(self) -> str:
        best = f", {self.candidates[0].effect}" if self.candidates else ""
        return f"{self.captures}, model error {number(self.error)}, {self.verdict}{best}"


def diagnose(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    exclude: Sequence[str] = (),
    budget: float | None = None,
    effects: Iterable[str | Path] | Mapping[str, type[Effect]] = (),
    seed: int | None = None,
    known: Mapping[str, type[Effect]] | None = None,
    held: Bench | None = None,
    tell: Callable[[str], None] = lambda _: None,
    first: Callable[[list[str]], None] | None = None,
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
    known : mapping, optional
        All effects by name: the former name of ``effects``.
    held : Bench, optional
        Statistics taken earlier.
    tell : callable
        Called with a line of progress.
    first : callable, optional
        Called with a first answer before the search: the effects, in the order of the fall of the
        error that first-order screening of a quarter of the field expects; empty
        where the captures are small, or nothing is expected.

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
    limit = TimeLimit.after(budget)
    held = held or bench(design(captures))
    limited = held.within(limit)
    model = located(held, with_seed(held, model, seed) or paper_start(held))
    known = known_effects(effects, known)
    open_to = {name: effect for name, effect in known.items() if name not in exclude}
    so_far = SoFar()
    if first is not None or budget is not None:
        with suppress(TimeUp):
            so_far.screened[:] = first_answer(limited, model, open_to, exclude)
        if first is not None:
            first(so_far.screened)
    asked = fitted_in_time(limited, model)
    stages: list[tuple[str, State]] = []
    try:
        found = _in_full(captures.name, limited, asked, exclude, open_to, stages, so_far, tell)
    except TimeUp:
        state = stages[-1][1] if stages else asked
        found = unfinished(captures.name, held, state, so_far, open_to)
    found = replace(found, capture_set=captures)
    return beside_everyday(held, asked, stages, found) if stages else found


def _in_full(
    name: str,
    held: Bench,
    asked: State,
    exclude: Sequence[str],
    open_to: dict[str, type[Effect]],
    stages: list[tuple[str, State]],
    so_far: SoFar,
    tell: Callable[[str], None],
) -> Diagnosis:
    """The whole of a diagnosis; ``stages`` takes the baseline effects as they are put in."""
    model = asked.model
    if lacks_everyday(model, exclude):
        tell("baseline effects")
        everyday(held, asked, exclude, lambda name, stage: stages.append((name, stage)))
    state = stages[-1][1] if stages else asked
    tried = ranked(held, state, candidates_of(state, open_to, [BASE]), tell, so_far)
    best, law, said = missing(held, state, tried), spread_law(held, state), ""
    if law is not None and (best is None or law.evidence > best.evidence):
        state = converge(held, law.state)
        said = told(held, state.model)
        tried = ranked(held, state, candidates_of(state, open_to, [BASE]), tell)
        best = missing(held, state, tried)
    tell("detection limits")
    return replace(judge(name, held, state, tried, best, open_to), law=said)


def unfinished(
    name: str,
    held: Bench,
    state: State,
    so_far: SoFar,
    known: dict[str, type[Effect]],
) -> Diagnosis:
    """What is known of a model when the time is up: the candidates refitted by then.

    Others may explain as much or more: the confidence is that of one that may stand in for them.
    """
    error = error_of(held, state)
    tried = by_standing({t.effect: t for t in so_far.trials}.values())
    candidates = [
        Candidate(
            t.effect,
            t.error,
            _explained(error, t.error),
            confidence_of(t, tried, error) * STANDS_IN,
            rivals(t, tried),
            evidence_for(held, state, t.state, known[t.effect]),
        )
        for t in tried
        if t.gain > 0 and lowers(t, error)
    ]
    plain = bool(candidates) and significant(tried[0], error)
    return Diagnosis(
        name,
        error,
        "missing" if plain else "unexplained",
        candidates,
        [],
        model=state.model,
        trials=list(tried),
        level=held.level(state.train, state.test),
        finished=False,
        screened=so_far.screened,
    )


def beside_everyday(
    held: Bench, asked: State, stages: Sequence[tuple[str, State]], found: Diagnosis
) -> Diagnosis:
    """A diagnosis of the model with what every sensor has, as one of the model without.

    Parameters
    ----------
    held : Bench
    asked : State
        The model without.
    stages : sequence of (str, State)
        The effects that were put in, with the state then.
    found : Diagnosis
        Of the last of these states.
    """
    error, before = error_of(held, asked), asked
    # only all of them are refitted; beside what is missing, if that was found
    ended = found.trials[0].state if found.verdict == "missing" else stages[-1][1]
    together = judged(held, asked, stages[-1][0], ended)
    chance = float(confidences([together], error)[0])
    ordinary = []
    for name, stage in stages:
        was, now = error_of(held, before), error_of(held, stage)
        effect = stage.model.get(name)
        assert effect is not None
        words = evidence_for(held, before, stage, type(effect))
        words.append(EVERY_SENSOR)
        share = min(1.0, max(0.0, was - now) / max(error - 1.0, 1e-6))
        ordinary.append(Candidate(name, now, share, chance, [], words))
        before = stage
    first = int(found.verdict == "missing")
    others = [  # in shares of the same error
        replace(c, explained=min(1.0, max(0.0, found.error - c.error_after) / max(error - 1, 1e-6)))
        for c in found.candidates
    ]
    return replace(
        found,
        error=error,
        verdict="missing" if found.verdict == "adequate" else found.verdict,
        candidates=[*others[:first], *ordinary, *others[first:]],
        ordinary=[c.effect for c in ordinary],
    )


def ranked(
    held: Bench,
    state: State,
    known: dict[str, type[Effect]],
    tell: Callable[[str], None] = lambda _: None,
    so_far: SoFar | None = None,
) -> list[Trial]:
    """The trials of what may be missing, the likeliest first, and not one that is refuted.

    A count of clusters scatters as these do, and to a model without any it is no great surprise in
    such errors. Its own sensors never show it: where those of the leader refute it, and a rival
    that explains nearly as much puts that right and leaves nothing else, the rival is certain
    beside it.
    """
    tried = trials(held, state, known, tell, so_far=so_far)
    close = rivals(tried[0], tried) if tried else []
    if not close or not tried[0].tolerable:
        return tried
    leader, left = tried[0], adequacy(held, tried[0].state, FEW).left
    near = (t for t in tried[1:] if left and t.effect in close)
    menders = (t for t in near if mends(held, left[:1], leader.state, t.state))
    mender = next((t for t in menders if not leaves(held, t.state)), None)
    if mender is None:
        return tried
    odds = 2.0 * DEFLATION * (leader.log_odds - mender.log_odds)
    less = leader.evidence - mender.evidence + odds + CERTAIN
    refuted = replace(leader, gain=leader.gain - less, fitted_gain=leader.fitted_gain - less)
    return by_standing([refuted, *tried[1:]])


def missing(held: Bench, state: State, tried: Sequence[Trial]) -> Trial | None:
    """The effect to add next: the leader, or None where the data do not support it.

    Where one half speaks for the leader and the other hardly, and where both say so little that the
    luck of the simulated sensors may make it, all are asked once more, of what the models show on
    average: one simulated sensor has its luck of the places of few defects, of its clouds, and of
    noise that the leader draws anew. To take the next in its place would be to choose by luck.
    """
    if not tried:
        return None
    state, leader = _fitted_alike(held, state, tried[0])
    best = _supported(held, state, leader)
    least, most = sorted((leader.gain, leader.fitted_gain))
    disagree = least < DISAGREE * most
    if best is None:
        open_yet = disagree and most > CERTAIN * leader.spread
    else:
        open_yet = leader.evidence < (UNDONE if disagree else CERTAIN) * leader.spread
    return _on_average(held, state, leader, CERTAIN * disagree) if open_yet else best


def _on_average(held: Bench, state: State, leader: Trial, least: float) -> Trial | None:
    """The leader, judged and fitted by averages over sensors, if the evidence is enough then.

    ``least``: what it must be beyond, whatever it puts right.

    A fit bends around the tracks or defects of the one sensor that it is made with.
    """
    bench, before = on_average(held, state)
    its_own, after = on_average(held, leader.state)
    if judged(held, before, leader.effect, after).evidence < 0.0:
        return None
    before, after = minimise(bench, before, STEPS), minimise(its_own, after, STEPS)
    again = judged(held, before, leader.effect, after)
    again = replace(again, spread=leader.spread)  # averages lie nearer to the measurement
    enough = significant(again, error_of(held, before), least)
    if not enough or _supported(held, before, again) is None:
        return None
    ended = start(held, after.model, after.knobs, like=after)
    return replace(again, state=ended, others=leader.others)


def _fitted_alike(held: Bench, state: State, found: Trial) -> tuple[State, Trial]:
    """An effect of little evidence, and the model without it, one fitted as well as the other.

    The refit had derivatives that the model without may have lacked, and may have come upon better
    numbers for what else was added: its last steps are not the effect's. Where the model without
    comes lower by its own or by these, so may the one with it.
    """
    little = found.evidence < UNDONE * found.spread
    if not (little and significant(found, error_of(held, state), least=0.0)):
        return state, found
    begun = [derive(held, state, anew=True)]
    others = _as_with_it(state.model, found)
    if others != state.model:
        begun.append(start(held, others, state.knobs, like=begun[0]))
    without = min((minimise(held, s, STEPS) for s in begun), key=lambda s: s.loss)
    if not without.loss < state.loss:
        return state, found
    within = minimise(held, derive(held, found.state, anew=True), STEPS)
    return without, replace(judged(held, without, found.effect, within), others=found.others)


def _as_with_it(model: NoiseModel, found: Trial) -> NoiseModel:
    """A model with the numbers that a trial gives to what is in both, what every sensor has apart:
    these may have made room for the effect.
    """
    for effect in found.state.model.effects:
        if model.get(effect.name) is not None and effect.name not in (BASE, *EVERYDAY):
            model = model.with_effect(effect)
    return model


def retold(tried: Sequence[Trial], best: Trial | None) -> list[Trial]:
    """The trials, the one to be added as it is told last."""
    return [best if best is not None and t.effect == best.effect else t for t in tried]


def _supported(held: Bench, state: State, leader: Trial) -> Trial | None:
    """The leader, if the evidence is enough.

    Where something is left that no second sensor of the model's make would show, "nothing is
    missing" is refuted already, and less evidence is asked for if it puts that right. One of no
    plain evidence must put the worst of it right, or some of it and the error with it: else it but
    bends around what is really missing.
    """
    error = error_of(held, state)
    left = cache(lambda: adequacy(held, state).left)  # by what the verdict goes

    def puts_right(names: Sequence[str]) -> bool:
        return mends(held, names, state, leader.state)

    if not significant(leader, error) and not (
        significant(leader, error, least=0.0) and puts_right(left()[:WORST])
    ):
        return None
    if leader.evidence > PLAIN * leader.spread:
        return leader
    if left() and not puts_right(left()[:1]):
        little = error - leader.error < LITTLE * (error - 1.0)
        if little or not puts_right(left()):
            return None
    sober = sobered(held, state, leader)
    return leader if significant(sober, error, least=0.0) else None


def judge(
    name: str,
    held: Bench,
    state: State,
    tried: Sequence[Trial],
    best: Trial | None,
    known: dict[str, type[Effect]],
    in_full: bool = True,
) -> Diagnosis:
    """The verdict, with candidates in the order of what they explain; ``best``: see `missing`.

    ``in_full``: with what these captures would not show, and with what the leader leaves over
    followed up.
    """
    error = error_of(held, state)
    over = None
    if best is not None:
        over = leftover(held, state, best, tried, known if in_full else {})
        best = over.found
    tried = retold(tried, best)
    kept = [t for t in tried if t is best or (t.gain > 0 and lowers(t, error))]
    candidates = []
    for t in kept:
        words = evidence_for(held, state, t.state, known[t.effect])
        near = next((o for o in kept[1:] if t is kept[0] and not apart(t, o)), None)
        if near is not None:
            more = evidence_against(held, near.state, t.state, near.effect, t.effect)
            words += [more] if more else []
        candidates.append(
            Candidate(
                t.effect,
                t.error,
                _explained(error, t.error),
                confidence_of(t, tried, error),
                rivals(t, kept),
                words,
            )
        )
    if over is not None:
        verdict, open_yet = "missing", over.left
        candidates = [over.told(candidates[0]), *_by_confidence(candidates[1:])]
    else:
        open_yet = unexplained(held, state)
        verdict = "unexplained" if open_yet else "adequate"
        candidates = _by_confidence(
            _unsupported(held, state, c, t, open_yet)
            for c, t in zip(candidates if open_yet else (), kept, strict=False)
        )
    made = Diagnosis(name, error, verdict, candidates, open_yet, {}, [], state.model, tried)
    return replace(
        made,
        level=held.level(state.train, state.test),
        detection_limits=detection_limits(held, state, known) if in_full else {},
        next_capture=next_capture(held, verdict, candidates),
    )


def _by_confidence(candidates: Iterable[Candidate]) -> list[Candidate]:
    """The most probable first; those alike in the order of the evidence."""
    return sorted(candidates, key=lambda c: -c.confidence)


def _unsupported(
    held: Bench, state: State, candidate: Candidate, found: Trial, left: Sequence[str]
) -> Candidate:
    """A candidate that the data do not support, where something stays unexplained.

    It may bend around what is really missing, as one that leaves what nothing else explains.
    """
    return replace(
        candidate,
        confidence=candidate.confidence * STANDS_IN,
        leaves=[name for name in left if not mends(held, [name], state, found.state)],
    )


def _explained(before: float, after: float) -> float:
    return min(1.0, max(0.0, (before - after) / max(before - 1.0, 1e-6))) if before > after else 0.0
