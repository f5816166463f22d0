"""What every command does around its one call: check, load, show progress, write."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from dnanalyze.errors import InputError
from dnanalyze.report.output_files import check_output, write_together

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from rich.console import Console

    from dnanalyze.fitting.problem import FitProblem
    from dnanalyze.loaders.captures import CaptureSet
    from dnanalyze.model.effect import Effect
    from dnanalyze.model.noise_model import NoiseModel
    from dnanalyze.report.page import Page, Section
    from dnanalyze.result import Result
    from dnanalyze_cli.progress import Progress

STDOUT = Path("-")


@dataclass
class Session:
    """One run of one command.

    Outputs are checked when the session is made, before any long work, and written at its end,
    each whole or not at all. One of them may be "-", the standard output: what the command says
    then goes to standard error.
    """

    command: str
    captures: str | None = None
    json: Path | None = None
    report: Path | None = None
    csv: Path | None = None
    output: Path | None = None
    effects: tuple[Path, ...] = ()
    quiet: bool = False
    cache: bool = True
    channel: str | None = None
    console: Console = field(init=False)
    _told: bool = field(default=False, init=False)
    _begun: float = field(default_factory=monotonic, init=False)
    _reading: float = field(default=0.0, init=False)  # s
    _active: Progress | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        from rich.console import Console

        printed = self._outputs.count(STDOUT)
        if printed > 1:
            raise InputError("-: named for two outputs; one of them can be printed")
        files = self.files
        for path in files:
            check_output(path, self.captures)
            if [p.resolve() for p in files].count(path.resolve()) > 1:
                raise InputError(f"{path}: named for two outputs; give each its own file")
        self.console = Console(stderr=bool(printed), highlight=False, soft_wrap=False)
        if self.console.width > 110:
            self.console.width = 110

    def load(
        self,
        config: Path | None = None,
        tolerance_c: float | None = None,
        channel: str | None = None,
        keep_outliers: bool = False,
        mask: Path | None = None,
        folder: str | None = None,
    ) -> CaptureSet:
        """The captures, or those of another folder, or one channel of them.

        What had to be assumed is said on stderr.
        """
        from dnanalyze.analyzers.streaming.cache import default_folder
        from dnanalyze.loaders import load

        folder = folder or self.captures
        assert folder is not None
        found = load(
            folder,
            config=config,
            tolerance_c=tolerance_c,
            keep_outliers=keep_outliers,
            mask=mask,
        )
        if channel is not None:
            found, self.channel = found.channel(channel), channel
        if self.cache and (kept := default_folder()):
            found = found.cached(str(kept))
        for note in found.notes:
            self.say(f"note: {note}")
        return found

    def known(self) -> dict[str, type[Effect]]:
        """The catalogue with the user's own effects."""
        from dnanalyze.model.registry import catalogue

        return catalogue(self.effects)

    def model(self, path: Path | None, seed: int | None = None) -> NoiseModel | None:
        """The model file, with this seed where one is given; None where no file is named."""
        from dnanalyze.model.noise_model import load_model

        if path is None:
            return None
        found = load_model(path, self.known())
        return found if seed is None else replace(found, seed=seed)

    def seeded(
        self, captures: CaptureSet, model: NoiseModel | None, seed: int | None
    ) -> NoiseModel | None:
        """The model with this seed; without a model the Wang 2025 model, as a fit begins.

        Raises
        ------
        InputError
            Captures of a channel that the model does not know.
        """
        if model is not None:
            from dnanalyze.model.channel_models import require

            require(model, captures.channels)
        if seed is None:
            return model
        if model is None:
            from dnanalyze.fitting.design import design
            from dnanalyze.fitting.fit import paper_start
            from dnanalyze.fitting.problem import fit_problem

            model = paper_start(fit_problem(design(captures)))
        return replace(model, seed=seed)

    def remaining(self, budget: float | None) -> float | None:
        """What a search has left of so many seconds since the command began; None: no limit.

        A report is drawn within them too, from simulations that take about as long as the frames
        took to be read; a search has half of what is left at the least.
        """
        if budget is None:
            return None
        if not budget > 0:
            raise InputError(f"--budget {budget:g}: valid: seconds above 0")
        page = 0.0 if self.report is None else self._drawing + self._reading
        left = budget - (monotonic() - self._begun)
        return max(left - page, left / 2.0, 1e-3)

    def fit_problem(
        self, progress: Progress, captures: CaptureSet, executor: Executor | None = None
    ) -> FitProblem:
        """The captures read once, frame by frame in sight."""
        begun = monotonic()
        problem = progress.fit_problem(captures, executor)
        self._reading = monotonic() - begun
        return problem

    @cached_property
    def _drawing(self) -> float:
        """Time for the report, s."""
        from dnanalyze.report.drawing_time import drawing_time

        return drawing_time()

    def show(self, result: Result) -> None:
        """Print a result."""
        from dnanalyze.report.terminal import show

        show(self.console, result)

    def print(self, sections: Sequence[Section]) -> None:
        """Print sections below what was shown."""
        from dnanalyze.report.terminal import print_sections

        print_sections(self.console, sections)

    def not_kept(self) -> None:
        """Where no file was named: the model was shown and is in none."""
        if self.output is None:
            text = "The model was not written; -o FILE writes it."
            self.console.print(text, style="dim")

    def say(self, text: str) -> None:
        """A line on stderr, unless --quiet."""
        if not self.quiet:
            print(text, file=sys.stderr)

    @contextmanager
    def progress(self, text: str) -> Iterator[Progress]:
        """A bar on stderr, gone when done; nothing with --quiet or without a terminal.

        Within another it is the next phase of that one's bar.
        """
        if self._active is not None:
            self._active.now(text)
            yield self._active
            return
        with self._told_of_compiling(), self._bar(text) as self._active:
            try:
                yield self._active
            finally:
                self._active = None

    @contextmanager
    def _told_of_compiling(self) -> Iterator[None]:
        """Say so once where loops are compiled: the first run after an install waits for it."""
        from numba.core import event

        class Listener(event.Listener):
            def on_start(self, event: object) -> None:
                tell()

            def on_end(self, event: object) -> None:
                pass

        def tell() -> None:
            if not self._told:
                self._told = True
                self.say("note: compiling for this machine (first run only)")

        with event.install_listener("numba:compile", Listener()):
            yield

    @contextmanager
    def _bar(self, text: str) -> Iterator[Progress]:
        from dnanalyze_cli.progress import Elapsed, Progress, Remaining

        if self.quiet or not sys.stderr.isatty():
            yield Progress()
            return
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn
        from rich.progress import Progress as Bars

        columns = (
            TextColumn("{task.description}"),
            BarColumn(28),
            TextColumn("{task.fields[count]}"),
            Remaining(),
            Elapsed(),
        )
        with Bars(*columns, console=Console(stderr=True), transient=True) as bars:
            yield Progress(bars, bars.add_task(text, total=None, count="", begun=self._begun))

    def finish(
        self,
        result: Result,
        page: Callable[[], Page] | None = None,
        more: Mapping[str, Any] | None = None,
        files: Mapping[Path, str | bytes] | None = None,
        model: Callable[[], str] | None = None,
    ) -> None:
        """Write a result as it was asked for.

        Parameters
        ----------
        result : Result
        page : callable, optional
            Gives the report; by default that of the type of result.
        more : mapping, optional
            Further keys of the document.
        files : mapping, optional
            Further files.
        model : callable, optional
            Gives the model file; by default that of the result's model.
        """
        shown = result._presentation()
        self.write(
            self._document(result, more),
            page or (lambda: shown.page(result)),
            result.to_dataframe,
            model or (lambda: _model_file(result)),
            files,
        )

    def write(
        self,
        content: dict[str, Any],
        page: Callable[[], Page] | None = None,
        table: Callable[[], Any] | None = None,
        model: Callable[[], str] | None = None,
        more: Mapping[Path, str | bytes] | None = None,
    ) -> None:
        """Write what was asked for, and ``more`` files, all made before the first appears."""
        with self.progress("Writing the results"):
            own = self._made(content, page, table, model)
            made: dict[Path, str | bytes] = {**dict(own), **(more or {})}
            write_together({path: text for path, text in made.items() if path != STDOUT})
        for path, text in made.items():
            if path == STDOUT:
                sys.stdout.write(str(text))
            else:
                self.say(f"wrote {path}")

    def keep(self, result: Result, page: Callable[[], Page]) -> None:
        """Write the files as far as a run is, so that it need not begin anew; nothing is said."""
        made = self._made(
            self._document(result),
            page,
            result.to_dataframe,
            lambda: _model_file(result),
        )
        write_together({path: text for path, text in made if path != STDOUT})

    @property
    def files(self) -> list[Path]:
        """Files that were asked for."""
        return [p for p in self._outputs if p != STDOUT]

    @property
    def _outputs(self) -> list[Path]:
        """Files that were asked for; - is the standard output."""
        wanted = (self.output, self.json, self.report, self.csv)
        return [p for p in wanted if p is not None]

    def _document(self, result: Result, more: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """The JSON document: the captures as they were named, the model file where one is made."""
        from dnanalyze.report.plain import plain

        made = {**result.to_dict(), "captures": self.captures}
        if self.output is not None:
            made["model"] = str(self.output)
        return made | plain(more or {})

    def _made(
        self,
        content: dict[str, Any],
        page: Callable[[], Page] | None,
        table: Callable[[], Any] | None,
        model: Callable[[], str] | None,
    ) -> list[tuple[Path, str]]:
        """What was asked for, as text."""
        from dnanalyze.report.page import render
        from dnanalyze.report.plain import to_json

        if self.channel is not None:
            content = {**content, "channel": self.channel}
        made: list[tuple[Path, str]] = []
        if self.output and model:
            made.append((self.output, model()))
        if self.report and page:
            made.append((self.report, render(page())))
        if self.csv and table:
            made.append((self.csv, table().to_csv(index=False)))
        if self.json:
            made.append((self.json, to_json(content)))
        return made


def _model_file(result: Any) -> str:
    from dnanalyze.model.noise_model import dump_model

    return dump_model(result.model)
