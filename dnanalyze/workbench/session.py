"""A session on one capture folder: captures, model, history and the task under way."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from threading import Condition, RLock, Thread
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.loaders.code_unit import code_unit, in_codes
from dnanalyze.model.effect import Effect
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel, model_from_plain
from dnanalyze.model.registry import WANG, find
from dnanalyze.report.words import plural
from dnanalyze.workbench import recipe
from dnanalyze.workbench.evaluation import Evaluation, Preview
from dnanalyze.workbench.fit_errors import refused, rises, with_errors_before
from dnanalyze.workbench.history import History, Node
from dnanalyze.workbench.jobs import Job, Worker
from dnanalyze.workbench.measuring import Measurements, Superseded
from dnanalyze.workbench.pictures import Pictures
from dnanalyze.workbench.sliders import Slider, sliders, with_value
from dnanalyze.workbench.source import CaptureSource
from dnanalyze.workbench.worker import Task

Event = Callable[[str], None]
FIELD_BYTES = 256 << 20  # of fields kept between full evaluations
CHARGE_BYTES = 64 << 20
FADES_S = 5.0  # of a message that a task was cancelled
MOVED = "set "  # begins the action of a node that a slider or a number field made
REPLACED = ("fit", "add")  # tasks that set another model: the present one's yardstick can wait


@dataclass
class WorkbenchSession:
    """Everything the workbench knows, without any widget.

    Parameters
    ----------
    source : CaptureSource
    model : NoiseModel, optional
        Starting model; by default the Wang 2025 model is fitted first.
    loaded : CaptureSet, optional
        The captures of the source; read from it by default.

    Notes
    -----
    Methods may be called from several threads. Every listener is called with "statistics",
    "history", "evaluation", "yardstick", "earlier", "draft", "diagnosis", "answer",
    "detection" or "message" after each change, from the thread that made it.

    The error of a new model is first stated by the yardstick of the model before; the model's
    own follows in the background ("yardstick"), then those of models before it that have none
    yet ("earlier"). Only then is it `Node.exact`.

    Examples
    --------
    >>> from pathlib import Path
    >>> from dnanalyze.workbench.session import WorkbenchSession
    >>> from dnanalyze.workbench.source import CaptureSource
    >>> session = WorkbenchSession(CaptureSource(Path("captures")))   # doctest: +SKIP
    >>> session.prepare()                                             # doctest: +SKIP
    >>> session.add("column_fpn").over.wait()                         # doctest: +SKIP
    >>> session.settle()                                              # doctest: +SKIP
    >>> session.history.present.error                                 # doctest: +SKIP
    """

    source: CaptureSource
    model: NoiseModel | None = None
    loaded: CaptureSet | None = None
    captures: CaptureSet = field(init=False)
    known: dict[str, type[Effect]] = field(init=False)
    problem: FitProblem | None = field(init=False, default=None)
    history: History | None = field(init=False, default=None)
    evaluation: Evaluation | None = field(init=False, default=None)
    baseline: Evaluation | None = field(init=False, default=None)
    draft: Evaluation | None = field(init=False, default=None)
    diagnosis: dict[str, Any] | None = field(init=False, default=None)
    detection: dict[str, Any] | None = field(init=False, default=None)
    message: str = field(init=False, default="")
    fades_s: float | None = field(init=False, default=None)
    answers: dict[int, dict[str, Any]] = field(init=False, default_factory=dict)
    stage: str = field(init=False, default="reading the frames")
    pinned: frozenset[str] = field(init=False, default=frozenset())

    def __post_init__(self) -> None:
        self.captures = self.loaded or self.source.captures()
        self.known = self.source.known()
        self.worker = Worker(self.source)
        self._lock = RLock()
        self._evaluating = RLock()
        self._previewing = RLock()
        self._preview: Preview | None = None
        self._begun = False
        self.listeners: list[Event] = []
        self._removed: dict[str, Effect] = {}
        self._measurements = Measurements(
            self._exact, lambda e: self.tell(f"{type(e).__name__}: {e}"), self._replaced_soon
        )
        self._settled = Condition(self._lock)
        self._took: dict[str, float] = {}

    def changed(self, what: str) -> None:
        """Tell every listener what has changed."""
        for listener in list(self.listeners):
            listener(what)

    # Statistics and the starting model

    def begin(self) -> None:
        """`prepare` in a thread, once unless it fails; what is wrong becomes a message."""
        with self._lock:
            begun, self._begun = self._begun, True
        if not begun:
            Thread(target=self._prepare_or_tell, daemon=True).start()

    def _prepare_or_tell(self) -> None:
        try:
            self.prepare()
        except InputError as error:
            self.tell(str(error))
        except Exception as error:  # an effect of the user's may raise anything
            self.tell(f"internal error: {type(error).__name__}: {error}")
        self._begun = self.problem is not None  # or else the next page tries again

    @cached_property
    def pictured(self) -> CaptureSet:
        """The captures in codes, in which models simulate frames."""
        return in_codes(self.captures, code_unit(self.captures))

    @cached_property
    def pictures(self) -> Pictures:
        """Images of the captures and of models, for the screen."""
        return Pictures(self.pictured)

    def left(self) -> None:
        """No page shows the session any more: its worker ends when its task has."""
        self.worker.rest()
        self.pictures.clear()

    def prepare(self) -> None:
        """Take the statistics, in the worker, and set the starting model; takes seconds.

        Raises
        ------
        InputError
            The frames cannot be read, the worker ended, or another task is under way.
        """
        self.stage = f"statistics of {plural(self.captures.frame_count, 'frame')}"
        answer: dict[str, Any] = {}
        failed: list[str] = []
        opening = Task("open", None if self.model is None else self.model.to_plain())
        self._idle()
        self.worker.start(opening, answer.update, failed.append).over.wait()
        if failed:
            raise InputError(failed[0])
        if not answer:  # the server ends
            return
        room = Memo(FIELD_BYTES, charge=Memo(CHARGE_BYTES))
        found: FitProblem = answer["problem"].with_memo(room)
        first = self.model or model_from_plain(answer["model"], "model", self.known)
        self._measurements.begin(found)
        self._measurements.now(first, answer["simulated"])
        with self._lock:
            self.problem, self.stage = found, "error of the first model"
        self.changed("statistics")
        action = "Wang 2025 model, initial values" if self.model is None else "model as given"
        with self._lock:
            self.history = History.begun(first, action, ())
        self.changed("history")
        self._measure()
        if self.model is None:
            self.fit()

    # The model

    @property
    def present(self) -> Node:
        """The node shown.

        Raises
        ------
        InputError
            The statistics are not taken yet.
        """
        if self.history is None:
            raise InputError("the statistics of the captures are still being taken")
        return self.history.present

    def sliders(self) -> list[Slider]:
        """Every number of the present model that can be moved, in the model's order."""
        return sliders(self.present.model, self.present.standard_errors, self.pinned)

    def with_value(self, name: str, value: float, model: NoiseModel | None = None) -> NoiseModel:
        """The present model, or another, with one number changed; see `sliders.with_value`."""
        return with_value(self.present.model if model is None else model, name, value)

    def adopt(self, model: NoiseModel, action: str) -> None:
        """A model that was set by hand as a new node."""
        self._put(model, action)
        if not action.startswith(MOVED):
            self.changed("history")
            self._measure()
            return
        try:
            self._measure()
        finally:  # a slider shows its model already: drawing the history would delay the error
            self.changed("history")

    def _put(self, model: NoiseModel, action: str) -> None:
        """A new node whose error is not known yet; the last one, where a slider moves on."""
        with self._lock:
            history = self._history()
            before = history.present.action
            if action.startswith(MOVED) and before.startswith(MOVED) and history.open:
                names = dict.fromkeys([*before[len(MOVED) :].split(", "), action[len(MOVED) :]])
                self.history = history.revised(model, MOVED + ", ".join(names))
            else:
                self.history = history.grown(action, model)

    def remove(self, effect: str) -> None:
        """The model without an effect; `restore` puts it back with the same numbers.

        Raises
        ------
        InputError
            The model has no such effect.
        """
        model = self.present.model
        found = model.get(effect)
        if found is None:
            raise InputError(f"no effect {effect!r} in the model; valid: {', '.join(model.names)}")
        self._removed[effect] = found
        self.adopt(model.without(effect), f"without {effect}")

    @property
    def removed(self) -> list[str]:
        """Effects that were taken out and can be restored."""
        return list(self._removed)

    def restore(self, effect: str) -> None:
        """The model with an effect at the numbers it had, or at its defaults."""
        kind = find(effect, self.known)
        found = self._removed.get(effect) or kind()
        self.adopt(self.present.model.with_effect(found), f"with {effect}")

    def pin(self, parameter: str, pinned: bool) -> None:
        """Keep a parameter ("effect.parameter") in fits, or free it."""
        self.pinned = self.pinned | {parameter} if pinned else self.pinned - {parameter}
        self.changed("history")

    def preview(self, model: NoiseModel) -> Evaluation:
        """A quick estimate of a model's error with its curves, by the change from the present.

        Raises
        ------
        InputError
            The present model has no error yet.
        """
        return self._prepared().evaluate(model)

    def moved(self) -> None:
        """A slider moves: previews go before whole fields, until it rests."""
        self._measurements.moved()

    @property
    def moving(self) -> bool:
        """Whether a slider moves."""
        return self._measurements.moving

    def _prepared(self) -> Preview:
        """Previews by the change from the last model with a full error; none waits for another."""
        with self._previewing:
            with self._lock:
                problem, known, made = self.problem, self.evaluation, self._preview
            if problem is None or known is None:
                raise InputError("the error of the present model is still being computed")
            if made is None:
                made = Preview(problem, known)
            elif made.known is not known:
                made = made.rebased(known)
            self._preview = made
            return made

    def _measure(self) -> None:
        """The full error of the present node: at once, and by its own yardstick later.

        It does not wait for a slider: what one began ends where another model is present.
        """
        self._measurements.rested()
        with self._evaluating:
            while True:
                node = self.present
                try:
                    found = self._measurements.now(node.model)
                    break
                except Superseded:
                    if not self._measurements.rest():
                        return
            with self._lock:
                self.history = self._stated(node.number, found)
                if set(node.model.names) <= WANG and (self.baseline is None or node.command):
                    self.baseline = found
                if self.history.at == node.number:
                    self.evaluation, self.draft = found, None
                self._settled.notify_all()
        self.changed("evaluation")
        self._prepared()  # before it is asked for
        self._measurements.refine(found)

    def _exact(self, found: Evaluation) -> None:
        """An evaluation has become that by the model's own yardstick."""
        with self._lock:
            for node in self._history().nodes:
                if node.model == found.model:
                    self.history = self._stated(node.number, found)
            if self.baseline is not None and self.baseline.model == found.model:
                self.baseline = found
            present = self.present.model == found.model
            if present:
                self.evaluation = found
            kept = self._measurements.kept
            self.history = with_errors_before(self._history(), found, kept)
            fit = self.present if present and rises(self.present, found.error) else None
            self._settled.notify_all()
        self.changed("yardstick" if present else "earlier")
        self._prepared()
        if fit is not None:
            self._refuse(fit)

    def _refuse(self, fit: Node) -> None:
        """Back to the model with which a fit began, unless something is under way with the fit."""
        job = self.worker.job
        if self.present.number == fit.number and (job is None or job.background):
            self.undo()
            self.tell(refused(fit))

    def _stated(self, number: int, found: Evaluation) -> History:
        return self._history().measured(number, found.error, found.families, found.exact)

    def _replaced_soon(self) -> bool:
        job = self.worker.job
        return job is not None and not job.background and job.task.kind in REPLACED

    def settle(self, limit_s: float = 300.0) -> bool:
        """Wait until the present model's error is exact; whether it is."""
        with self._settled:
            return self._settled.wait_for(
                lambda: self.history is not None and self.history.present.exact, limit_s
            )

    # History

    def undo(self) -> None:
        """Back to the parent of the present node."""
        self._go(lambda h: h.undo())

    def redo(self) -> None:
        """Forward to where the last undo came from."""
        self._go(lambda h: h.redo())

    def go(self, number: int) -> None:
        """To any node; what is done there begins a branch."""
        self._go(lambda h: h.moved(number))

    def name(self, number: int, name: str) -> None:
        """Give a node a name."""
        with self._lock:
            self.history = self._history().named(number, name)
        self.changed("history")

    def _go(self, move: Callable[[History], History]) -> None:
        with self._lock:
            self.history = move(self._history())
        self.changed("history")
        self._measure()

    def _history(self) -> History:
        if self.history is None:
            raise InputError("the statistics of the captures are still being taken")
        return self.history

    # Long work

    def fit(self) -> Job:
        """Refit the present model but for its pinned parameters."""
        frozen = tuple(sorted(self.pinned))
        command = ("fit", "--replicates", "0", *(w for n in frozen for w in ("--frozen", n)))
        base = self.present
        first = base.parent is None and set(base.model.names) <= WANG and self.model is None

        def step(found: dict[str, Any]) -> None:
            self._drafted(base, model_from_plain(found["model"], "model", self.known))

        def done(found: dict[str, Any]) -> None:
            action = "Wang 2025 model, fitted" if first else "fit"
            self._grow(base, action, found["model"], command)

        return self._run(Task("fit", base.model.to_plain(), frozen=frozen), done, step)

    def _drafted(self, base: Node, model: NoiseModel) -> None:
        """Show where a fit stands, as a preview."""
        found = self._prepared().evaluate(model)
        with self._lock:
            if self.present.number != base.number:
                return
            self.draft = found
        self.changed("draft")

    def add(self, effect: str) -> Job:
        """Add an effect and refit.

        A diagnosis of the present node may have put the baseline effects in; they are then added
        first, as a node of their own.

        Raises
        ------
        InputError
            No effect of that name, or the model holds it already.
        """
        find(effect, self.known)
        base = self.present
        if base.model.get(effect) is not None:
            raise InputError(f"{effect}: it is already in the model")
        self._idle()
        completed = self._completed()
        between = completed is not None and effect not in completed.names
        if completed is not None and between:
            new = [name for name in completed.names if base.model.get(name) is None]
            self._put(completed, f"add baseline effects {', '.join(new)}")
            base = self.present

        def step(found: dict[str, Any]) -> None:
            answer = found | {"effect": effect}
            self._grow(base, f"add {effect}", found["model"], ("add", effect), answer=answer)

        def done(found: dict[str, Any]) -> None:
            with self._lock:
                here = self.answers.get(self._history().at, {})
                if found and here.get("effect") == effect:
                    self.answers[self._history().at] = here | found
            self.changed("answer")

        job = self._run(Task("add", base.model.to_plain(), effect=effect), done, step)
        if between:  # once the task is under way: it shows at once, its error is not the last one
            self.changed("history")
            self._measure()
        return job

    def complete(self) -> None:
        """The baseline effects that the diagnosis of the present node put in, as a new node.

        Raises
        ------
        InputError
            No diagnosis of this node put any in.
        """
        model = self._completed()
        if model is None:
            raise InputError("no diagnosis of this step has put baseline effects in; diagnose it")
        new = [name for name in model.names if self.present.model.get(name) is None]
        self.adopt(model, f"add baseline effects {', '.join(new)}")

    def standard_errors(self) -> Job:
        """Standard errors of the present model's parameters, from simulated replicates."""
        base = self.present

        def done(found: dict[str, Any]) -> None:
            with self._lock:
                self.history = self._history().known(base.number, found["standard_errors"])
            self.changed("history")

        return self._run(Task("standard errors", base.model.to_plain()), done)

    def diagnose(self) -> Job:
        """Rank the effects that may be missing in the present model."""
        base = self.present

        def told(found: dict[str, Any]) -> None:
            with self._lock:
                self.diagnosis = found | {"node": base.number}
            self.changed("diagnosis")

        return self._run(Task("diagnose", base.model.to_plain()), told, told)

    def refine(self) -> Job:
        """Diagnose and add until nothing more is missing; each step becomes a node."""
        base = self.present

        def step(found: dict[str, Any]) -> None:
            if len(found["steps"]) > 1:
                self._grow(None, _last(found["steps"]), found["model"], ())

        def done(found: dict[str, Any]) -> None:
            self._grow(None, "refine", found["model"], ("refine",), base.number, found)

        return self._run(Task("refine", base.model.to_plain()), done, step)

    def detect(self) -> Job:
        """Look for hidden defect-pixel correction and denoise in the captures."""

        def done(found: dict[str, Any]) -> None:
            with self._lock:
                self.detection = found
            self.changed("detection")

        return self._run(Task("detect"), done)

    def cancel(self) -> None:
        """End the task under way but for the opening; nodes that it made stay."""
        job = self.worker.job
        if job is not None and not job.cancellable:
            return
        self.worker.cancel()
        if self.draft is not None:
            self.draft = None
            self.changed("evaluation")
        if job is not None:
            self.tell(f"{job.task.kind}: cancelled after {job.elapsed_s:.0f} s", FADES_S)

    def tell(self, message: str, seconds: float | None = None) -> None:
        """A message for the user, which fades after some seconds, or stays."""
        with self._lock:
            self.message = message
            self.fades_s = None if seconds is None else time.monotonic() + seconds
        self.changed("message")

    def fade(self) -> None:
        """Take back a message whose time has passed."""
        if self.fades_s is not None and time.monotonic() > self.fades_s:
            self.tell("")

    def remaining_s(self, job: Job) -> float | None:
        """Estimated seconds until a task ends, from the last one of its kind; None at first."""
        took = self._took.get(job.task.kind)
        return None if took is None else max(0.0, took - job.elapsed_s)

    def close(self) -> None:
        """End the work in the background and the worker process."""
        self._measurements.close()
        self.worker.close()

    def _idle(self) -> None:
        job = self.worker.job
        if job is not None and not job.background:
            raise InputError(f"{job.task.kind} is under way; cancel it first")

    def _completed(self) -> NoiseModel | None:
        """The present model with the baseline effects that its diagnosis put in, if any."""
        found = self.diagnosis
        if found is None or found["node"] != self.present.number or found["model"] is None:
            return None
        model = model_from_plain(found["model"], "model", self.known)
        return model if set(model.names) > set(self.present.model.names) else None

    def _run(
        self,
        task: Task,
        done: Callable[[dict[str, Any]], None],
        step: Callable[[dict[str, Any]], None] = lambda _: None,
    ) -> Job:
        self._idle()
        if self.message:
            self.tell("")
        began = time.monotonic()

        def timed(found: dict[str, Any]) -> None:
            self._took[task.kind] = time.monotonic() - began
            done(found)

        return self.worker.start(task, timed, self.tell, step)

    def _grow(
        self,
        base: Node | None,
        action: str,
        plain: dict[str, Any],
        command: tuple[str, ...],
        origin: int | None = None,
        answer: dict[str, Any] | None = None,
    ) -> None:
        """A new node below ``base``, or below the present one, with what a task says of it."""
        model = model_from_plain(plain, "model", self.known)
        with self._lock:
            history = self._history()
            if base is not None and history.at != base.number:
                history = history.moved(base.number)
            self.history = history.grown(action, model, command, origin)
            if answer is not None:
                self.answers[self.history.at] = answer
        self.changed("history")
        self._measure()

    def commands(self) -> str:
        """Shell commands that design the present node from the captures."""
        return recipe.commands(self.source, self._history().made())

    def python(self) -> str:
        """Python code that makes the present node from the captures."""
        return recipe.python(self.source, self._history().made())


def _last(steps: Sequence[dict[str, Any]]) -> str:
    added = steps[-1]["added"]
    return f"without {added[1:]}" if added and added.startswith("-") else f"add {added}"
