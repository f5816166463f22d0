"""The options that commands share: each is written once, and so are the lists of them."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast, get_type_hints

import typer

if TYPE_CHECKING:
    from dnanalyze.loaders.captures import CaptureSet
    from dnanalyze.model.noise_model import NoiseModel
    from dnanalyze_cli.session import Session

FILES, READING, RUN = "Results", "Reading the captures", "The run"
HDR = "Combined HDR frames"


def option(usage: str, help: str = "", panel: str | None = None, **more: Any) -> Any:
    """An option as its users read it.

    Parameters
    ----------
    usage : str
        Its names, then what stands for its value: ``"-o --output M.yaml"``.
    help : str
    panel : str, optional
        Heading in the help.
    more
        Of `typer.Option`.
    """
    words = usage.split()
    names = [w for w in words if w.startswith("-")]
    value = " ".join(words[len(names) :]) or None
    return typer.Option(*names, metavar=value, rich_help_panel=panel, help=help, **more)


Captures = Annotated[
    str, typer.Argument(metavar="CAPTURES", help="Folder of dark frames.", show_default=False)
]
Json = Annotated[Path | None, option("--json OUT.json", "Results as JSON; - prints them.", FILES)]
Report = Annotated[
    Path | None, option("--report OUT.html", "Report, one HTML file; - prints it.", FILES)
]
Csv = Annotated[Path | None, option("--csv OUT.csv", "Results as a table; - prints it.", FILES)]
Config = Annotated[
    Path | None,
    option(
        "--sidecar --config SIDE.yaml",
        "Sidecar file with what the frames do not state: raw layout, names, metadata.",
        READING,
    ),
]
Tolerance = Annotated[
    float | None,
    option(
        "--tolerance-c C",
        "Frames whose temperatures span at most C share an operating point; default 1.5 °C.",
        READING,
        min=0.0,
    ),
]
Channel = Annotated[
    str | None, option("--channel NAME", "Only this HDR readout channel; default: all.", READING)
]
KeepOutliers = Annotated[
    bool,
    option(
        "--keep-outliers",
        "Keep frames unlike the others of their operating point; default: left out.",
        READING,
    ),
]
Mask = Annotated[
    Path | None,
    option(
        "--mask FILE",
        "Pixels to leave out, those that are not 0: .npy, .fits, .h5, .png or .tif.",
        READING,
    ),
]
SystemGain = Annotated[
    float | None,
    option(
        "--system-gain K",
        "Overall system gain K, DN/e⁻; default: recorded, else photon transfer in the dark.",
        READING,
    ),
]
EffectFiles = Annotated[
    list[Path] | None,
    option("--effects FILE.py", "Python file with user-defined effects (repeatable).", RUN),
]
Seed = Annotated[
    int | None, option("--seed", "Seed of the simulated sensor; default: the model's.", RUN, min=0)
]
Quiet = Annotated[bool, option("--quiet -q", "No progress, no notes.", RUN)]
Scheduler = Annotated[
    str | None,
    option(
        "--scheduler ADDRESS|local",
        "Dask workers do the work. With analyze they read the frames; an interrupted run "
        "continues where it stopped.",
        RUN,
    ),
]
NoCache = Annotated[
    bool, option("--no-cache", "Do not use or store statistics of earlier runs.", RUN)
]
Model = Annotated[
    Path | None, option("--model M.yaml", "Model file; default: the Wang 2025 model.", RUN)
]
ModelOut = Annotated[
    Path | None, option("-o --output M.yaml", "The new model file; - prints it.", FILES)
]

Force = Annotated[
    bool,
    option(
        "--force",
        "Replace what may hold work of yours: frames, effect files, maps, targets. Other "
        "results are replaced in any case.",
        FILES,
    ),
]
Combine = Annotated[
    Path | None,
    option(
        "--combine HDR.yaml",
        "The captures are combined HDR frames: how the channels of --model become one output.",
        HDR,
        show_default=False,
    ),
]
Light = Annotated[
    float, option("--light DN", "Uniform light, DN of the first channel.", HDR, min=0.0)
]
CombinedOut = Annotated[
    Path | None, option("--simulate OUT", "Also write the simulated combined frames, TIFF.", HDR)
]

STEER = "When to stop"
Exclude = Annotated[
    list[str] | None, option("--exclude EFFECT", "Never add this effect (repeatable).", STEER)
]

Budget = Annotated[
    float | None,
    option(
        "--time-limit --budget SECONDS",
        "End after so many seconds, with the best model so far; a report is drawn within them.",
        STEER,
        min=0.0,
    ),
]

NoDescribe = Annotated[
    bool, option("--no-describe", "Do not describe the unexplained residual.", STEER)
]

Options = TypeVar("Options")


@dataclass(frozen=True, kw_only=True)
class Results:
    """Files that a result is written to."""

    json: Json = None
    report: Report = None
    csv: Csv = None


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How captures are read."""

    config: Config = None
    tolerance_c: Tolerance = None
    channel: Channel = None
    keep_outliers: KeepOutliers = False
    mask: Mask = None
    quiet: Quiet = False

    def load(self, session: Session, folder: str | None = None) -> CaptureSet:
        """The captures of a session, or those of another folder."""
        return session.load(
            self.config,
            self.tolerance_c,
            self.channel,
            keep_outliers=self.keep_outliers,
            mask=self.mask,
            folder=folder,
        )


@dataclass(frozen=True, kw_only=True)
class FolderOptions(Reading, Results):
    """What every command takes that reads captures and writes a result."""

    def session_on(self, command: str, captures: str, **more: Any) -> Session:
        """The session of a command on a folder; outputs are checked."""
        from dnanalyze_cli.session import Session

        outputs = self.json, self.report, self.csv
        return Session(command, captures, *outputs, quiet=self.quiet, **more)


@dataclass(frozen=True, kw_only=True)
class ReadOptions(FolderOptions):
    """The same on one folder."""

    captures: Captures

    def session(self, command: str, **more: Any) -> Session:
        """The session of a command; outputs are checked."""
        return self.session_on(command, self.captures, **more)


@dataclass(frozen=True, kw_only=True)
class ModelOptions(ReadOptions):
    """What every command takes that fits a model to captures."""

    model: Model = None
    effects: EffectFiles = None
    seed: Seed = None
    no_cache: NoCache = False

    def session(self, command: str, **more: Any) -> Session:
        """The session of a command; outputs are checked."""
        effects = tuple(self.effects or ())
        return super().session(command, effects=effects, cache=not self.no_cache, **more)

    def begin(self, session: Session) -> tuple[CaptureSet, NoiseModel | None]:
        """The captures, and the model with its seed; None without --model and --seed."""
        own = session.model(self.model)
        found = self.load(session)
        return found, session.seeded(found, own, self.seed)

    def given(self) -> dict[str, Any]:
        """Option to its value, but for those that name the captures, a model or a seed."""
        return {
            "--json": self.json,
            "--report": self.report,
            "--csv": self.csv,
            "--sidecar": self.config,
            "--tolerance-c": self.tolerance_c,
            "--channel": self.channel,
            "--keep-outliers": self.keep_outliers or None,
            "--mask": self.mask,
            "--effects": self.effects,
        }


def takes(kind: type[Options]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The options of ``kind`` with those of a command, which gets them as one object.

    An option that the command has under the same name takes the place of the shared one.

    Parameters
    ----------
    kind : type
        A dataclass whose fields are annotated as Typer wants it.

    Returns
    -------
    callable
        Decorator of a command whose first parameter is a ``kind``.
    """
    hints = get_type_hints(kind, include_extras=True)
    shared = [
        inspect.Parameter(
            f.name,
            inspect.Parameter.POSITIONAL_OR_KEYWORD,
            default=inspect.Parameter.empty if f.default is MISSING else f.default,
            annotation=hints[f.name],
        )
        for f in fields(cast(Any, kind))
    ]

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        own_hints = get_type_hints(command, include_extras=True)
        _, *rest = inspect.signature(command).parameters.values()
        own = {p.name: p.replace(annotation=own_hints[p.name]) for p in rest}
        kept = [p for p in shared if p.name not in own]
        names = {p.name for p in kept}
        first, last = (kept, own.values()) if "captures" in hints else (own.values(), kept)
        every = sorted([*first, *last], key=lambda p: p.default is not inspect.Parameter.empty)

        @wraps(command)
        def run(**given: Any) -> Any:
            common = {name: given.pop(name) for name in names & set(given)}
            return command(kind(**common), **given)

        del run.__wrapped__  # Typer reads the signature below
        run.__signature__ = inspect.Signature(every)  # type: ignore[attr-defined]
        run.__annotations__ = {p.name: p.annotation for p in every}
        return run

    return decorate
