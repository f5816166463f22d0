"""Add, drop and exchange effects until nothing more is missing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from dnanalyze.diagnosis.completion import POOR, completed
from dnanalyze.diagnosis.confidence import confidence_of, rivals, significant
from dnanalyze.diagnosis.diagnose import missing, ranked, retold
from dnanalyze.diagnosis.evidence import evidence_for
from dnanalyze.diagnosis.exchange import exchange
from dnanalyze.diagnosis.needless import needless
from dnanalyze.diagnosis.path import Fork, Path, Step
from dnanalyze.diagnosis.spread_law import spread_law, told
from dnanalyze.diagnosis.trial import Trial, best_guess, candidates_of, error_of
from dnanalyze.fitting.least_squares import State, converge, derive, minimise
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect
from dnanalyze.model.registry import BASE, EVERYDAY


@dataclass(frozen=True)
class Walk:
    """Where paths may go, where they stop, and who is told.

    Parameters
    ----------
    held : Bench
    known : dict
        Effects that may be added, by name.
    begun : tuple of str
        Effects of the model to begin with, which are not counted as added.
    most_effects, until_error, tell, trying
        As in `refine`.
    keep : callable
        Called with the path whenever its model stands complete.
    """

    held: Bench
    known: dict[str, type[Effect]]
    begun: tuple[str, ...] = ()
    most_effects: int | None = None
    until_error: float | None = None
    tell: Callable[[Step], None] = lambda _: None
    trying: Callable[[str], None] = lambda _: None
    keep: Callable[[Path], None] = lambda _: None

    def note(
        self,
        path: Path,
        state: State,
        name: str | None,
        sure: float | None = None,
        near: Sequence[str] = (),
        why: Sequence[str] = (),
    ) -> Path:
        """The path, gone on to a state; why, where the data had to speak for what was added.

        ``near``: what it may be confused with. ``why``: the reason where they had not.
        """
        effect = None if name is None or sure is None else state.model.get(name)
        if effect is not None:
            why = evidence_for(self.held, path.state, state, type(effect))
        step = Step(name, error_of(self.held, state), sure, list(why), list(near))
        self.tell(step)
        return replace(path, state=state, steps=(*path.steps, step))

    def to_end(self, path: Path) -> Path:
        """Go on until nothing more is missing, or it is enough."""
        held, fresh = self.held, False
        while not self.near_enough(path):
            state, error = path.state, error_of(held, path.state)
            open_to = candidates_of(state, self.known, [BASE, *path.dropped])
            tried = ranked(held, state, open_to, self.trying)
            added = self.added(state)
            best, among, gone = missing(held, state, tried), tried, []
            path = replace(path, tried=tuple(tried), best=best)
            law = spread_law(held, state)
            if law is not None and (best is None or law.evidence > best.evidence):
                path, fresh = self._with_law(path, law), False
                continue
            if best is None and error > POOR and not fresh:
                # derivatives that many steps kept up may hide from the refits what true ones show
                state, fresh = minimise(held, derive(held, state, anew=True)), True
                path = replace(path, state=state)
                continue
            if best is not None:
                among = retold(tried, best)
            elif error > POOR:
                other = exchange(held, state, added, open_to, self.trying)
                if other is not None:
                    best, among = other.found, [other.found]
                    state, gone = other.without, [other.gone]
            if best is None or self._full(len(added) - len(gone)):
                return path
            path = self._without(_forked(path, best, among, error), state, gone)
            sure, near = confidence_of(best, among, error), rivals(best, among)
            path, fresh = self.add(path, best, sure, near), False
        return replace(path, tried=(), best=None)

    def added(self, state: State) -> list[str]:
        """Effects of a model that were added to what it began with and every sensor has."""
        return [n for n in state.model.names if n not in (*self.begun, *EVERYDAY)]

    def stops(self, path: Path) -> bool:
        """Whether it was told to go no further."""
        return self.near_enough(path) or self._full(len(self.added(path.state)))

    def add(self, path: Path, found: Trial, sure: float, near: Sequence[str] = ()) -> Path:
        """One more effect, everything at its best place, and what is needless with it gone."""
        begun = best_guess(self.held, path.state, found)
        path = self.note(path, completed(self.held, begun, found.effect), found.effect, sure, near)
        path = self._without(path, *needless(self.held, path.state))
        self.keep(path)
        return path

    def _with_law(self, path: Path, law: Trial) -> Path:
        """The path with a spread of dark current that changes with temperature: no effect more."""
        state = converge(self.held, law.state)
        step = Step(None, error_of(self.held, state), None, [told(self.held, state.model)])
        self.tell(step)
        path = replace(path, state=state, steps=(*path.steps, step))
        self.keep(path)
        return path

    def _without(self, path: Path, state: State, gone: Sequence[str]) -> Path:
        """The path at the state that does without some effects."""
        for name in gone:
            path = self.note(path, state, f"-{name}")
        return replace(path, state=state, dropped=(*path.dropped, *gone))

    def near_enough(self, path: Path) -> bool:
        """Whether the error is as low as was asked."""
        return self.until_error is not None and path.error <= self.until_error

    def _full(self, count: int) -> bool:
        return self.most_effects is not None and count >= self.most_effects


def _forked(path: Path, best: Trial, among: Sequence[Trial], error: float) -> Path:
    """The path with a fork, where a rival explains nearly as much and would do for itself."""
    close = rivals(best, [t for t in among if significant(t, error)])
    other = next((t for t in among if t.effect in close[:1]), None)
    return path if other is None else replace(path, forks=(*path.forks, Fork(path, best, other)))
