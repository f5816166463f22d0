"""Stepwise search: add the best candidate, drop superfluous effects, swap confounded ones.

Read from `Search.run` down: each step is `choose` (score tests, refits, significance), `completed`
(form and strength of the effect, everything at its optimum) and `reduced` (backward step). Where
nothing more is significant and the model is not adequate, `swapped` tries confounded effects in
the place of one that was added. Of large captures the search begins on a part of the field, takes
the steps there that this leaves no doubt of, and goes on with the whole field.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from dnanalyze.comparator.error import ERROR_SCATTER, way
from dnanalyze.comparator.predictive_check import FittedModel, error_of
from dnanalyze.diagnosis.baseline import (
    baseline_fitted,
    baseline_start,
    far_off,
    lacks_baseline,
    new_in,
    reasons,
)
from dnanalyze.diagnosis.candidates import (
    SoFar,
    candidates_of,
    refitted_beside,
    refitted_once,
    shown,
    trials,
)
from dnanalyze.diagnosis.explain import evidence_for
from dnanalyze.diagnosis.forms import completed
from dnanalyze.diagnosis.gains import trial_by_prediction, trial_of
from dnanalyze.diagnosis.results import Step
from dnanalyze.diagnosis.search_path import (
    NO_LIMITS,
    Addition,
    Path,
    SearchLimits,
    descending,
    falling,
    last_change,
)
from dnanalyze.diagnosis.selection import (
    DEFLATION,
    EVIDENCE_DECISIVE,
    EVIDENCE_NULL,
    EVIDENCE_ODDS_10,
    Trial,
    apart,
    beyond_doubt,
    competitors,
    confidence_of,
    on_both_halves,
    significant,
)
from dnanalyze.diagnosis.spread_law import in_words, spread_law
from dnanalyze.fitting.from_part import FIT_STEPS, converge
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State, carried, start
from dnanalyze.fitting.time_limit import TimeLimit
from dnanalyze.fitting.yardstick import by_design, expressed, fitted_by_design, fitted_in
from dnanalyze.model.effect import Effect
from dnanalyze.model.registry import BASE, BASELINE
from dnanalyze.progress import ignored


def choose(
    null: FittedModel,
    known: dict[str, type[Effect]],
    on_progress: Callable[[str], None] = ignored,
    on_trial: Callable[[SoFar], None] = ignored,
    spread: bool = True,
) -> tuple[list[Trial], Trial | None]:
    """The candidates refitted, the most probable first, and the one to add next.

    That is the first of them, or the slope of the spread of the dark current (named as the base),
    if it is significant and has more evidence. ``spread``: whether that is open. Other arguments
    are those of `trials`.
    """
    tried = trials(null, known, on_progress, on_trial)
    best = supported(null, tried)
    law = spread_law(null, math.inf if best is None else best.state.loss) if spread else None
    if law is not None and (best is None or law.evidence > best.evidence):
        return tried, law
    return tried, best


def supported(null: FittedModel, tried: Sequence[Trial]) -> Trial | None:
    """The first of the trials whose evidence is enough.

    A trial is passed over where one before it explains the same statistics without evidence enough:
    it may stand in for that one. Trials that gain on one half alone do not count there.
    """
    before: list[Trial] = []
    for found in tried:
        if all(apart(found, other) for other in before) and _enough(null, found):
            return found
        if on_both_halves(found):
            before.append(found)
    return None


def _enough(null: FittedModel, found: Trial) -> bool:
    """Whether the evidence of a candidate is enough.

    One that corrects one of the largest residuals needs less evidence, since replicates have
    rejected the model without it; one that corrects none of the residuals needs more, since it may
    adapt to what is really missing.
    """
    if not significant(found, EVIDENCE_NULL):
        return False
    if null.corrects(null.left[:3], found.state):
        return True
    corrects = not null.left or null.corrects(null.left, found.state)
    return significant(found, EVIDENCE_ODDS_10 if corrects else EVIDENCE_DECISIVE)


def lower_without(null: FittedModel, best: Trial) -> State | None:
    """The model without a candidate, from where the refit with it ended, if that is nearly as good.

    The loss may have several minima, and a refit may end in a lower one without need of the
    candidate, whose evidence is then that of the minimum. None where the candidate is decisive
    there too, or where it is not a lower one.
    """
    if best.effect == BASE:
        return None
    begun = start(null.problem, best.state.model.without(best.effect))
    fall, left = null.state.loss - begun.loss, begun.loss - best.state.loss
    if fall < EVIDENCE_NULL * best.overdispersion or left > EVIDENCE_DECISIVE * best.overdispersion:
        return None
    return minimise(null.problem, begun, FIT_STEPS)


def removal(problem: FitProblem, state: State, name: str) -> State:
    """The model without an effect, refitted."""
    model = state.model.without(name)
    return minimise(problem, start(problem, model, like=state), FIT_STEPS)


def reduced(problem: FitProblem, state: State) -> tuple[State, list[str]]:
    """Backward step: the model without effects that are no longer significant, and their names.

    By the yardstick of the model that has them.
    """
    gone = []
    whole = FittedModel.of(problem, state)
    for name in [n for n in state.model.names if n not in (*BASELINE, BASE)]:
        without = FittedModel(whole.problem, removal(whole.problem, whole.state, name))
        found = trial_of(without, name, whole.state)
        if found.evidence < EVIDENCE_NULL and found.error_fall <= ERROR_SCATTER * without.error:
            whole = FittedModel.of(whole.problem, without.state)
            gone.append(name)
    return (expressed(whole.state, whole.problem, problem) if gone else state), gone


def swapped(
    problem: FitProblem,
    state: State,
    added: Sequence[str],
    known: dict[str, type[Effect]],
    on_progress: Callable[[str], None],
) -> tuple[str, FittedModel, Trial] | None:
    """The best exchange of one added effect for one that it is confounded with.

    While much was missing, two such effects explained nearly as much; which of them it is shows
    once the rest is in the model. The effect itself is among them, from new first guesses.

    ``added`` may go, ``known`` may come. Returned are the effect that goes, the model without it,
    and the one that comes; None where no exchange is significant.
    """
    null, found = FittedModel.of(problem, state), []
    for name in added:
        mine = state.model.get(name)
        assert mine is not None
        others = {
            n: e for n, e in known.items() if n in mine.confused_with or name in e.confused_with
        }
        others[name] = type(mine)
        without = FittedModel(null.problem, removal(null.problem, null.state, name))
        for trial in trials(without, others, on_progress):
            made = trial_by_prediction(null, trial)
            if significant(made):
                found.append((name, without, made))
    return max(found, key=lambda f: f[2].evidence, default=None)


@dataclass(frozen=True)
class Search:
    """A stepwise search and its limits.

    ``known``: effects that may be added. ``begun``: those of the starting model, which do not count
    as added. ``limits``: of the user. ``on_step``, ``on_progress``: called with every step, and
    with the name of every candidate. ``on_path``: called whenever the model is complete.
    ``whole``: the whole field where ``problem`` is a part of it; model errors, and what is kept,
    are of it.
    """

    problem: FitProblem
    known: dict[str, type[Effect]]
    begun: tuple[str, ...] = ()
    limits: SearchLimits = NO_LIMITS
    on_step: Callable[[Step], None] = ignored
    on_progress: Callable[[str], None] = ignored
    on_path: Callable[[Path], None] = ignored
    whole: FitProblem | None = None

    def run(self, state: State, exclude: Sequence[str] = ()) -> Path:
        """From a fitted model to one in which nothing more is significant, or to a limit."""
        begun, path = self._on_part(state, exclude)
        path = self._searched(path)
        steps = descending(path.steps)
        if len(steps) < len(path.steps):
            return replace(begun, state=state)
        return replace(path, steps=tuple(steps))

    def _on_part(self, state: State, exclude: Sequence[str]) -> tuple[Path, Path]:
        """The starting model, and that with baseline effects and steps that a part decides.

        Both are stated for the part, where there is one, with their errors on the whole field; the
        second is then fitted to that, unless it is far off.
        """
        part = self.problem.part
        if part is None:
            begun = self._begun(state)
            return begun, self._with_baseline(begun, exclude)
        coarse = replace(self, problem=replace(part, even=False), whole=self.problem)
        untimed = coarse.problem.within(TimeLimit())
        begun = coarse._begun(carried(state, self.problem, untimed))
        found = coarse._while_plain(coarse._with_baseline(begun, exclude))
        if found.state is begun.state:
            return begun, replace(found, state=state)
        there = carried(found.state, coarse.problem, self.problem)
        found = replace(found, state=there, converged=False)
        return begun, found if far_off(there) else self._converged(found)

    def _begun(self, state: State) -> Path:
        """The starting model, noted and kept; whatever the time, since it is the least answer."""
        whole = None if self.whole is None else self.whole.within(TimeLimit())
        untimed = replace(self, problem=self.problem.within(TimeLimit()), whole=whole)
        path = untimed._noted(Path(state), state, None)
        self._kept(path)
        return path

    def _with_baseline(self, path: Path, exclude: Sequence[str]) -> Path:
        """The baseline effects in the model, one step each, with the error of all of them."""
        if not lacks_baseline(path.state.model, exclude):
            return path
        begun = baseline_start(self.problem, exclude, path.state.model.seed)
        state = baseline_fitted(self.problem, begun)
        error = self._error(state)
        for name in new_in(state.model, path.state.model):
            effect = state.model.get(name)
            assert effect is not None
            path = self._noted(path, state, name, why=reasons(effect), error=error)
        self._kept(path)
        return path

    def _while_plain(self, path: Path) -> Path:
        """Forward steps on a part of the field, while that decides them.

        Of a model that is far off it leaves as little as the whole, and of an effect that is
        everywhere and has no rival. The candidates of which it leaves some are the first to be
        tested on the whole field.
        """
        while not self.near_enough(path):
            null = FittedModel.of(self.problem, path.state)
            if null.adequate:
                break
            path = self._tested(path, null) if far_off(path.state) else self._plain(path, null)
            if path.best is None or self._full(path):
                return replace(path, open=tuple(t.effect for t in path.tried) or path.open)
            path = self._with(path, null, path.best, path.error)
        return path

    def _searched(self, path: Path) -> Path:
        """Forward, backward and swap steps until none is significant."""
        while not self.near_enough(path):
            null = FittedModel.of(self.problem, path.state)
            undecided = not path.converged and not far_off(path.state)
            path = self._plain(path, null) if undecided else self._tested(path, null)
            best = path.best
            lower = None if best is None else lower_without(null, best)
            if lower is not None:
                lower = self._at_home(lower, null)
                path = self._at_its_optimum(replace(path, state=lower, converged=False))
                continue
            if best is None and not path.converged:
                path = self._at_its_optimum(path)
                if not FittedModel.of(self.problem, path.state).adequate:
                    continue  # what is left may be another effect
                return replace(path, tried=(), best=None)
            if best is None and not null.adequate:
                added = self._added(path.state)
                found = swapped(self.problem, path.state, added, self._open(path), self.on_progress)
                other = None
                if found is not None and not self._full(path, found[0]):
                    other = self._exchanged(path, *found)
                if other is not None:
                    path = other
                    continue
            if best is None or self._full(path):
                return self._converged(path)
            path = self._with(path, null, best, path.error)
        return self._converged(replace(path, tried=(), best=None))

    def _at_its_optimum(self, path: Path) -> Path:
        """`_converged`; the candidates so far are the first to be tested beside it.

        A refit with a candidate moves all parameters, and gains by it what the model without the
        candidate had left to gain.
        """
        first = tuple(t.effect for t in path.tried) or path.open
        return self._converged(replace(path, open=first))

    def _exchanged(self, path: Path, gone: str, null: FittedModel, best: Trial) -> Path | None:
        """One effect in the place of another; None where the model error would rise.

        ``null``: the model without either. Both steps have the error of the exchange: the model
        between them is none that the search arrives at.
        """
        made = self._made(null, best, [best])
        if made[-1].error > path.error:
            return None
        path = replace(path, tried=(best,))
        path = self._without(path, self._at_home(null.state, null), [gone], made[-1].error)
        return self._taken(path, made)

    def _tested(self, path: Path, null: FittedModel) -> Path:
        """The candidates tested: those first that were significant beside the last one."""
        known = self._first(path) or self._open(path)
        tried, best = choose(null, known, self.on_progress, spread=BASE not in path.refused)
        if best is None and self._first(path):
            return self._tested(replace(path, open=()), null)
        return replace(path, tried=tuple(tried), best=best)

    def _plain(self, path: Path, null: FittedModel) -> Path:
        """The candidate that one refit decides; without one the first are left open.

        Of a model that is not at its optimum, the others wait for that.
        """
        known = self._first(path) or self._open(path)
        names, tried = refitted_once(null, known, self.on_progress, self.whole is not None)
        best = supported(null, tried)
        if best is None or not beyond_doubt(best, tried):
            return replace(path, tried=(), best=None, open=tuple(names))
        return replace(path, tried=tuple(tried), best=best)

    def _first(self, path: Path) -> dict[str, type[Effect]]:
        """Candidates that are tested before all others."""
        return {name: e for name, e in self._open(path).items() if name in path.open}

    def _open(self, path: Path) -> dict[str, type[Effect]]:
        return candidates_of(path.state, self.known, [BASE, *path.dropped, *path.refused])

    def _full(self, path: Path, gone: str | None = None) -> bool:
        """Whether the user wants no more effects; ``gone``: the one that another replaces."""
        law = path.best is not None and path.best.effect == BASE
        added = len(self._added(path.state)) - (gone is not None)
        most = self.limits.max_effects
        return most is not None and not law and added >= most

    def near_enough(self, path: Path) -> bool:
        """Whether the model error is as low as the user asked."""
        enough = self.limits.until_error
        return enough is not None and path.error <= enough

    def _added(self, state: State) -> list[str]:
        return [n for n in state.model.names if n not in (*self.begun, *BASELINE)]

    def _with(self, path: Path, null: FittedModel, best: Trial, most: float) -> Path:
        """The best candidate in the model, and others that stay decisive beside it.

        An effect with which the model error, each model by its own yardstick, would exceed
        ``most`` is not taken: it fits the residual of what else is missing. Nor is one that has
        become, at its optimum, what the captures do not tell from a simpler effect.
        """
        if best.effect == BASE:
            return self._with_law(path, null, best, most)
        made = self._made(null, best, path.tried, self._room(path))
        if len(made) > 1 and not falling([most, *(m.error for m in made)]):
            made = self._made(null, best, path.tried)
        visible = shown(null.problem, made[0].state, best.effect)
        if made[-1].error > most or not visible:
            return replace(path, refused=(*path.refused, best.effect))
        return self._taken(path, made)

    def _room(self, path: Path) -> float:
        """How many effects more the user wants at most."""
        most = self.limits.max_effects
        return math.inf if most is None else most - len(self._added(path.state))

    def _made(
        self, null: FittedModel, best: Trial, tried: Sequence[Trial], room: float = 1
    ) -> list[Addition]:
        """The best candidate in the model, then each that stays decisive beside those before it.

        Each is completed; in the last model all is at its optimum. Errors are by the yardstick of
        that.
        """
        problem, rest = null.problem, tried
        found, states = [(best, tried)], [completed(problem, best)]
        while len(found) < room:
            rest = refitted_beside(FittedModel(problem, states[-1]), rest)
            if not rest or not beyond_doubt(rest[0], rest):
                break
            found.append((rest[0], rest))
            states.append(completed(problem, rest[0]))
        if self.whole is None:  # that of a part is only where the fit of the whole field begins
            fit = partial(converge, rounds=1, settled=DEFLATION, last=False)
            if any(trial.by_design for trial, _ in found):
                fit = partial(fitted_by_design, fit=fit)
            states[-1] = fit(problem, states[-1])
        errors = self._errors([self._at_home(s, null) for s in states])
        made, before = [], null.state
        for (trial, among), state, error in zip(found, states, errors, strict=True):
            effect = type(state.model.get(trial.effect))
            why = evidence_for(problem, before, state, effect)  # type: ignore[arg-type]
            made.append(Addition(trial, among, self._at_home(state, null), error, why))
            before = state
        return made

    def _taken(self, path: Path, made: Sequence[Addition]) -> Path:
        """The steps of effects that are taken."""
        first, names = made[0], [m.trial.effect for m in made]
        for one in made:
            found = one.trial
            sure, near = confidence_of(found, one.tried), competitors(found, one.tried)
            path = self._noted(path, one.state, found.effect, sure, near, one.evidence, one.error)
        later = [
            t.effect
            for t in first.tried
            if significant(t) and t.effect not in names and apart(first.trial, t)
        ]
        path = replace(path, refused=(), converged=False, open=tuple(later))
        self._kept(path)
        return path

    def _reduced(self, path: Path) -> Path:
        """Without the effects that are no longer significant, unless the model error would rise.

        By the yardstick of the model that is left: that of the one with them may be wider.
        """
        state, gone = reduced(self.problem, path.state)
        if not gone or way(path.error, error := self._error(state)) == "rises":
            return path
        path = self._without(path, state, gone, error)
        self._kept(path)
        return path

    def _converged(self, path: Path) -> Path:
        """Everything at its optimum, and what is then superfluous gone.

        The error of the last step, which the baseline effects and the other step of an exchange
        share, is that of the new state; an effect that raises it, from the step before that change,
        is taken out (`_undone`). A fit with which the error rises is not taken: the loss of one
        simulated sensor has several minima along parameters of which the fitted half shows little,
        such as those of a glow in a corner of the other half.
        """
        if path.converged:
            return path
        there = by_design(self.problem, path.state.model)
        state = fitted_in(there, self.problem, path.state, converge)
        error, last = self._error(state), path.steps[-1]
        if way(path.error, error) == "rises":
            state, error = path.state, path.error
        count = last_change(path.steps)
        steps = [
            replace(s, error=error, model=state.model)
            if s is last or (s.added in BASELINE and s.model is last.model)
            else s
            for s in path.steps
        ]
        steps[-count] = replace(steps[-count], error=error)
        refused = path.refused if state is path.state else ()
        path = replace(path, state=state, steps=tuple(steps), converged=True, refused=refused)
        last = steps[-1]
        if last.added in self._added(state) and last.error > steps[-1 - count].error:
            return self._converged(self._undone(path))
        self._kept(path)
        return self._reduced(path)

    def _undone(self, path: Path) -> Path:
        """The model before the last effect, whose step, or exchange, is none."""
        count = last_change(path.steps)
        before, name = path.steps[-1 - count], path.steps[-1].added
        model = before.model
        assert model is not None
        assert name is not None
        gone = [] if count == 1 else [str(path.steps[-2].added).removeprefix("-")]
        for undone in (f"-{name}", *gone):
            self.on_step(Step(undone, before.error, model=model))
        return replace(
            path,
            state=start(self.problem, model),
            steps=path.steps[:-count],
            dropped=(*path.dropped, name),
            converged=False,
        )

    def _with_law(self, path: Path, null: FittedModel, law: Trial, most: float) -> Path:
        """The spread of the dark current free to change with temperature: no effect more."""
        state = self._at_home(converge(null.problem, law.state), null)
        error = self._error(state)
        if error > most:
            return replace(path, refused=(*path.refused, BASE))
        why = [in_words(self.problem, state.model)]
        path = self._noted(path, state, None, why=why, error=error)
        self._kept(path)
        return path

    def _without(
        self, path: Path, state: State, gone: Sequence[str], error: float | None = None
    ) -> Path:
        for name in gone:
            path = self._noted(path, state, f"-{name}", error=error)
        return replace(path, state=state, dropped=(*path.dropped, *gone))

    def _noted(
        self,
        path: Path,
        state: State,
        name: str | None,
        sure: float | None = None,
        near: Sequence[str] = (),
        why: Sequence[str] = (),
        error: float | None = None,
    ) -> Path:
        error = self._error(state) if error is None else error
        steps = (*path.steps, Step(name, error, sure, list(why), list(near), model=state.model))
        for step in descending(steps)[len(descending(path.steps)) :]:
            self.on_step(step)
        return replace(path, state=state, steps=steps)

    def _error(self, state: State) -> float:
        """Model error by the yardstick of the model itself."""
        return self._errors([state])[0]

    def _errors(self, states: Sequence[State]) -> list[float]:
        """Model errors by the yardstick of the last of the models."""
        if self.whole is None:
            own = FittedModel.of(self.problem, states[-1])
            rest = [expressed(s, self.problem, own.problem) for s in states[:-1]]
            return [*(error_of(own.problem, s) for s in rest), own.error]
        there = by_design(self.whole, states[-1].model)
        return [error_of(there, carried(s, self.problem, there)) for s in states]

    def _at_home(self, state: State, null: FittedModel) -> State:
        """A state that was fitted by the yardstick of ``null``, in that of the frames."""
        return expressed(state, null.problem, self.problem)

    def _kept(self, path: Path) -> None:
        steps = descending(path.steps)
        if len(steps) == len(path.steps):
            there, state = self._as_stated(path.state)
            self.on_path(replace(path, state=state, steps=tuple(steps), problem=there))

    def _as_stated(self, state: State) -> tuple[FitProblem, State]:
        """The whole field and a state by the yardstick of its error, whatever the time."""
        untimed = self.problem.within(TimeLimit())
        if self.whole is None:
            own = FittedModel.of(untimed, state)
            return own.problem, own.state
        there = by_design(self.whole.within(TimeLimit()), state.model)
        return there, carried(state, untimed, there)
