"""Progress of a command: a bar, the time of its phase, frames that tell when they are read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.progress import ProgressColumn, Task
from rich.text import Text

from dnanalyze.loaders.captures import CaptureSet, Window

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from dnanalyze.fitting.problem import FitProblem
    from dnanalyze.fitting.state import State

LEAST_S, LEAST_SHARE = 3.0, 0.1  # of a phase, before which no estimate is fair


class Elapsed(ProgressColumn):
    """Time since the phase began, and since the command did where that is longer."""

    def render(self, task: Task) -> Text:
        """Such as ``0:12 (total 1:40)``."""
        now, whole = task.get_time(), task.fields.get("begun")
        phase = task.elapsed or 0.0
        text = clock(phase)
        if whole is not None and now - whole > phase + 1.0:
            text += f" (total {clock(now - whole)})"
        return Text(text)


class Remaining(ProgressColumn):
    """What is left of a phase whose steps are counted, by its mean pace; else nothing."""

    def render(self, task: Task) -> Text:
        """Such as ``about 0:30 left``."""
        left = remaining(task.completed, task.total, task.elapsed)
        return Text("" if left is None else f"about {clock(left)} left")


def remaining(done: float, total: float | None, elapsed: float | None) -> float | None:
    """Seconds left at the mean pace so far; None before there is one.

    Parameters
    ----------
    done, total : float
        Steps; a total of None is not known.
    elapsed : float or None
        Seconds.
    """
    if not total or elapsed is None or elapsed < LEAST_S or done < LEAST_SHARE * total:
        return None
    return max(0.0, elapsed * (total - done) / done)


def clock(seconds: float) -> str:
    """``1:05``, ``1:02:03``."""
    whole = int(seconds)
    minutes, rest = divmod(whole, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


@dataclass(frozen=True)
class Progress:
    """A progress bar that library calls can feed, or one that stays silent."""

    bars: Any = None
    task: Any = None

    def __call__(self, done: float = 0, total: float | None = None, what: str = "") -> None:
        """So much of the total is done; or what is under way."""
        if what:
            self.now(what)
        elif self.bars:
            count = "" if total is None else f"{done:.0f} of {total:.0f}"
            self.bars.update(self.task, completed=done, total=total, count=count)

    def now(self, text: str) -> None:
        """The phase, beside the bar; what was counted before is no part of it."""
        if self.bars:
            self.bars.reset(self.task, description=text, total=None, count="")

    def doing(self, text: str) -> None:
        """The same phase, in other words: its time goes on."""
        if self.bars:
            self.bars.update(self.task, description=text)

    def trying(self, what: str) -> None:
        """What a search is at: an effect that is tried or refitted, or another step of it."""
        steps = {"baseline effects": "Fitting", "detection limits": "Estimating"}
        self.doing(f"{steps.get(what, 'Trying')} {what}")

    def note(self, text: str) -> None:
        """A line that stays, above the bar."""
        if self.bars:
            self.bars.console.print(text, highlight=False)

    @property
    def first(self) -> Callable[[list[str]], None] | None:
        """What a search calls with its first answer; None where nobody is watching."""
        if not self.bars:
            return None
        from dnanalyze.report.words import first_answer

        return lambda effects: self.note(first_answer(effects)) if effects else None

    def fit_problem(self, captures: CaptureSet, executor: Executor | None = None) -> FitProblem:
        """The captures read once, frame by frame in sight."""
        from dnanalyze.fitting.design import design
        from dnanalyze.fitting.problem import fit_problem
        from dnanalyze.fitting.processes import helpers_for, helpers_of

        plan = design(captures)
        # they start while the frames are read
        helpers = helpers_for(plan.pixels) if executor is None else helpers_of(executor)
        if self.bars:
            self.now("Reading frames")
            plan = replace(plan, captures=watched(plan.captures, self))
        problem = fit_problem(plan, helpers)
        self.now("Fitting")
        return problem

    def fitting(self, problem: FitProblem) -> Callable[[State], None]:
        """What a fit calls with every better state: the model error on the fitted data."""
        from dnanalyze.comparator.error import pooled
        from dnanalyze.digits import number

        def tell(state: State) -> None:
            error = pooled(state.train, problem.train.families)
            self.doing(f"Fitting, model error {number(error)}")

        return tell


Reader = Callable[[Window | None], np.ndarray]


@dataclass(frozen=True, repr=False)
class WatchedReader:
    """``Frame.load`` that tells its name; to the cache it is the reader that it wraps."""

    reader: Reader
    tell: Callable[[], None]

    def __call__(self, window: Window | None = None) -> np.ndarray:
        """Pixels of ``window``."""
        pixels = self.reader(window)
        self.tell()
        return pixels

    def __repr__(self) -> str:
        """That of the reader: the cache keeps statistics by it."""
        return repr(self.reader)


def watched(captures: CaptureSet, tick: Callable[[int, int], None]) -> CaptureSet:
    """The same captures; ``tick(done, total)`` after the first reading of each frame.

    Parameters
    ----------
    captures : CaptureSet
    tick : callable
    """
    seen: set[tuple[int, int]] = set()
    total = captures.frame_count

    def told(key: tuple[int, int]) -> Callable[[], None]:
        def tell() -> None:
            if key not in seen:
                seen.add(key)
                tick(len(seen), total)

        return tell

    settings = tuple(
        replace(
            s,
            frames=tuple(
                replace(f, load=WatchedReader(f.load, told((i, k)))) for k, f in enumerate(s.frames)
            ),
        )
        for i, s in enumerate(captures.settings)
    )
    return replace(captures, settings=settings)
