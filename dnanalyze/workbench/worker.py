"""What a session's worker process does: fits, diagnoses and refinements, told step by step."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from multiprocessing.connection import Connection
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.fitting.processes import warm
from dnanalyze.fitting.time_limit import BATCH, TimeLimit
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.effect import Effect
from dnanalyze.model.noise_model import NoiseModel, model_from_plain
from dnanalyze.workbench.source import CaptureSource

Tell = Callable[[str, Any], None]
DRAFT_S = 1.5  # between two drafts of a fit: each costs the page a preview
REPLICATES = 8  # simulated sensors for standard errors: 27 % of an error, 1 / sqrt(2 * 7)


@dataclass(frozen=True)
class Task:
    """Long work on a model.

    Parameters
    ----------
    kind : {"open", "fit", "standard errors", "add", "diagnose", "refine", "detect"}
    model : mapping or None
        As in YAML; None: the starting model of the captures.
    effect : str
        For "add".
    frozen : tuple of str
        For "fit": parameters that keep their values, as "effect.parameter".
    """

    kind: str
    model: dict[str, Any] | None = None
    effect: str = ""
    frozen: tuple[str, ...] = ()


@dataclass(frozen=True)
class UntilAsked(TimeLimit):
    """Work in the background ends when something else is asked for.

    Parameters
    ----------
    asked : callable
        Whether it is.
    """

    asked: Callable[[], bool] = lambda: False

    @property
    def batch(self) -> int:
        """Simulations between two looks."""
        return BATCH

    @property
    def over(self) -> bool:
        """Whether something else is asked for."""
        return self.asked()

    def __reduce__(self) -> tuple[type[TimeLimit], tuple[()]]:
        """Another process has no limit."""
        return TimeLimit, ()


class Bed:
    """Captures, effects and statistics of a worker, read when first needed.

    Parameters
    ----------
    source : CaptureSource
    asked : callable
        Whether work in the background is to end.
    """

    def __init__(self, source: CaptureSource, asked: Callable[[], bool] = lambda: False) -> None:
        self.source = source
        self.background = UntilAsked(asked=asked)

    @cached_property
    def captures(self) -> CaptureSet:
        """The frames."""
        return self.source.captures()

    @cached_property
    def known(self) -> dict[str, type[Effect]]:
        """The catalogue with the user's own effects."""
        return self.source.known()

    @cached_property
    def problem(self) -> FitProblem:
        """Statistics of both halves of the field."""
        return fit_problem(design(self.captures))

    def warm(self) -> None:
        """Read what every task needs, and load the compiled loops, before a task asks for it."""
        _ = self.known, self.captures
        warm()

    def model(self, task: Task) -> NoiseModel | None:
        """The model of a task."""
        if task.model is None:
            return None
        return model_from_plain(task.model, "model", self.known)


def carried_out(bed: Bed, task: Task, tell: Tell) -> dict[str, Any]:
    """The result of a task: models as in YAML, the rest as in JSON.

    That of "open" holds the fit problem and the simulated statistics as they are.
    """
    return _TASKS[task.kind](bed, task, tell)


def _open(bed: Bed, task: Task, tell: Tell) -> dict[str, Any]:
    from dnanalyze.fitting.fit import paper_start

    tell("progress", "statistics")
    model, problem = bed.model(task), bed.problem
    tell("progress", "error of the first model")
    model = model or paper_start(problem)
    return {
        "problem": problem,
        "model": model.to_plain(),
        "simulated": problem.statistics(model, half=1),
    }


def _fit(bed: Bed, task: Task, tell: Tell) -> dict[str, Any]:
    from dnanalyze.fitting.fit import fit_on
    from dnanalyze.fitting.state import State

    told_s = time.monotonic()

    def better(state: State) -> None:
        nonlocal told_s
        if time.monotonic() - told_s > DRAFT_S:
            tell("step", {"model": state.model.to_plain()})
            told_s = time.monotonic()

    problem = bed.problem
    tell("progress", "the model's parameters")
    found = fit_on(
        bed.captures,
        bed.model(task),
        frozen=task.frozen,
        replicates=0,
        problem=problem,
        on_state=better,
    )
    return {"model": found.model.to_plain(), "undetermined": found.undetermined}


def _standard_errors(bed: Bed, task: Task, tell: Tell) -> dict[str, Any]:
    from dnanalyze.fitting.fit import with_uncertainties
    from dnanalyze.fitting.state import start

    model = bed.model(task)
    assert model is not None
    tell("progress", f"simulating {REPLICATES} sensors of the model")
    found = with_uncertainties(bed.problem, start(bed.problem, model), REPLICATES)
    return {"standard_errors": {p.name: p.se for p in found.parameters if p.se == p.se}}


def _add(bed: Bed, task: Task, tell: Tell) -> dict[str, Any]:
    from dnanalyze.diagnosis.refine import add_on
    from dnanalyze.report.words import add_headline

    tell("progress", f"adding {task.effect}")
    model = bed.model(task)
    assert model is not None
    found = add_on(bed.captures, task.effect, model, known=bed.known, problem=bed.problem)
    step = found.steps[-1]
    tell(
        "step",
        {
            "model": found.model.to_plain(),
            "headline": add_headline(found),
            "verdict": found.verdict,
            "supported": step.supported,
            "confidence": step.confidence,
        },
    )
    return _classified(bed, found.model, tell) if found.verdict == "adequate" else {}


def _classified(bed: Bed, model: NoiseModel, tell: Tell) -> dict[str, Any]:
    """What a classifier says of a model that is adequate otherwise; in the background."""
    from dnanalyze.classifier.classify import classify_on
    from dnanalyze.classifier.words import sentence

    tell("background", "asking a classifier")
    found = classify_on(
        bed.captures, model, seed=model.seed, limit=bed.background, helpers=bed.problem.helpers
    )
    if not found.finished:
        return {}
    return {"classifier": sentence(found), "tells": found.tells}


def _diagnose(bed: Bed, task: Task, tell: Tell) -> dict[str, Any]:
    from dnanalyze.diagnosis.diagnose import Diagnosis, diagnose_on
    from dnanalyze.report.words import diagnose_headline, first_answer

    def plain(found: Diagnosis) -> dict[str, Any]:
        models = {t.effect: t.state.model.to_plain() for t in found.trials}
        return {
            "error": found.error,
            "headline": diagnose_headline(found) if found.finished else "",
            "verdict": found.verdict,
            "finished": found.finished,
            "ordinary": found.ordinary,
            "candidates": [vars(c) | {"model": models.get(c.effect)} for c in found.candidates],
            "unexplained": found.unexplained,
            "detection_limits": {n: str(v) for n, v in found.detection_limits.items()},
            "next_capture": found.next_capture,
            "model": None if found.model is None else found.model.to_plain(),
        }

    told: dict[str, Any] = {}

    def keep(found: Diagnosis) -> None:
        tell("step", plain(found))
        if found.finished:
            if found.verdict == "adequate" and found.model is not None:
                told.update(_classified(bed, found.model, tell))
            tell("background", "detection limits")

    found = diagnose_on(
        bed.captures,
        bed.model(task),
        known=bed.known,
        problem=bed.problem,
        on_progress=lambda text: tell("progress", f"trying {text}"),
        first=lambda effects: tell("first", first_answer(effects) if effects else ""),
        on_result=keep,
        afterwards=bed.background,
    )
    return plain(found) | told


def _refine(bed: Bed, task: Task, tell: Tell) -> dict[str, Any]:
    from dnanalyze.classifier.words import sentence
    from dnanalyze.diagnosis.refine import Refinement, refine_on
    from dnanalyze.report.words import first_answer, refine_headline

    def keep(now: Refinement) -> None:
        tell("step", {"model": now.model.to_plain(), "steps": _steps(now.steps)})

    found = refine_on(
        bed.captures,
        bed.model(task),
        known=bed.known,
        problem=bed.problem,
        on_progress=lambda name: tell("progress", f"trying {name}"),
        first=lambda effects: tell("first", first_answer(effects) if effects else ""),
        on_result=keep,
    )
    told = found.classification
    return {
        "model": found.model.to_plain(),
        "steps": _steps(found.steps),
        "headline": refine_headline(found),
        "verdict": found.verdict,
        "classifier": "" if told is None or not told.cells else sentence(told),
    }


def _detect(bed: Bed, task: Task, tell: Tell) -> dict[str, Any]:
    from dnanalyze.detection import detect

    def progress(done: int, total: int | None, what: str = "", /) -> None:
        tell("progress", what or f"frame {done} of {total}")

    found = detect(bed.captures, progress=progress)
    return found.to_dict() | {"captures": str(bed.source.folder)}


def _steps(steps: Any) -> list[dict[str, Any]]:
    return [vars(step) for step in steps]


_TASKS: dict[str, Callable[[Bed, Task, Tell], dict[str, Any]]] = {
    "open": _open,
    "fit": _fit,
    "standard errors": _standard_errors,
    "add": _add,
    "diagnose": _diagnose,
    "refine": _refine,
    "detect": _detect,
}


def serve(pipe: Connection, source: CaptureSource) -> None:
    """Carry out tasks from a pipe until its other end is closed.

    Messages are pairs: ("progress", text), ("first", text), ("step", mapping), ("background", text)
    from where another task may end this one, and at the end ("done", mapping) or ("failed", text).
    None in place of a task ends the work in the background.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the server decides
    bed = Bed(source, pipe.poll)
    with suppress(Exception):  # met again, and told, by the first task
        bed.warm()

    def tell(kind: str, content: Any) -> None:
        pipe.send((kind, content))

    with suppress(EOFError, OSError):
        while True:
            task = pipe.recv()
            if task is None:
                continue
            try:
                answer: tuple[str, Any] = "done", carried_out(bed, task, tell)
            except InputError as error:
                answer = "failed", str(error)
            except (EOFError, OSError):
                raise
            except Exception as error:  # told to the user; the process serves on
                answer = "failed", f"internal error: {type(error).__name__}: {error}"
            pipe.send(answer)
