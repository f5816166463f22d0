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

_FILES, _READING, _RUN = "Results", "Reading the captures", "The run"
_HDR = "Combined HDR frames"

Captures = Annotated[
    str, typer.Argument(metavar="CAPTURES", help="Folder of dark frames.", show_default=False)
]
Json = Annotated[
    Path | None,
    typer.Option(
        "--json", metavar="OUT.json", rich_help_panel=_FILES, help="Results as JSON; - prints them."
    ),
]
Report = Annotated[
    Path | None,
    typer.Option(
        "--report",
        metavar="OUT.html",
        rich_help_panel=_FILES,
        help="Report, one HTML file; - prints it.",
    ),
]
Csv = Annotated[
    Path | None,
    typer.Option(
        "--csv", metavar="OUT.csv", rich_help_panel=_FILES, help="Results as a table; - prints it."
    ),
]
Config = Annotated[
    Path | None,
    typer.Option(
        "--sidecar",
        "--config",
        metavar="SIDE.yaml",
        rich_help_panel=_READING,
        help="Sidecar file with what the frames do not state: raw layout, names, metadata.",
    ),
]
Tolerance = Annotated[
    float | None,
    typer.Option(
        "--tolerance-c",
        metavar="C",
        min=0.0,
        rich_help_panel=_READING,
        help="Frames whose temperatures span at most C share an operating point; default 1.5 °C.",
    ),
]
Channel = Annotated[
    str | None,
    typer.Option(
        "--channel",
        metavar="NAME",
        rich_help_panel=_READING,
        help="Only this HDR readout channel; default: all.",
    ),
]
KeepOutliers = Annotated[
    bool,
    typer.Option(
        "--keep-outliers",
        rich_help_panel=_READING,
        help="Keep frames unlike the others of their operating point; default: left out.",
    ),
]
Mask = Annotated[
    Path | None,
    typer.Option(
        "--mask",
        metavar="FILE",
        rich_help_panel=_READING,
        help="Pixels to leave out, those that are not 0: .npy, .fits, .h5, .png or .tif.",
    ),
]
SystemGain = Annotated[
    float | None,
    typer.Option(
        "--system-gain",
        metavar="K",
        rich_help_panel=_READING,
        help="Overall system gain K, DN/e⁻; default: recorded, else photon transfer in the dark.",
    ),
]
EffectFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--effects",
        metavar="FILE.py",
        rich_help_panel=_RUN,
        help="Python file with user-defined effects (repeatable).",
    ),
]
Seed = Annotated[
    int | None,
    typer.Option(
        "--seed",
        min=0,
        rich_help_panel=_RUN,
        help="Seed of the simulated sensor; default: the model's.",
    ),
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", rich_help_panel=_RUN, help="No progress, no notes.")
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS|local",
        rich_help_panel=_RUN,
        help="Dask workers do the work: of analyze they read the frames, and an interrupted run "
        "continues where it stopped.",
    ),
]
NoCache = Annotated[
    bool,
    typer.Option(
        "--no-cache", rich_help_panel=_RUN, help="Do not use or store statistics of earlier runs."
    ),
]
Model = Annotated[
    Path | None,
    typer.Option(
        "--model",
        metavar="M.yaml",
        rich_help_panel=_RUN,
        help="Model file; default: the Wang 2025 model.",
    ),
]
ModelOut = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="M.yaml",
        rich_help_panel=_FILES,
        help="The new model file; - prints it.",
    ),
]

Force = Annotated[
    bool,
    typer.Option(
        "--force",
        rich_help_panel=_FILES,
        help="Replace what may hold work of yours: frames, effect files, maps, targets. Other "
        "results are replaced in any case.",
    ),
]
Combine = Annotated[
    Path | None,
    typer.Option(
        "--combine",
        metavar="HDR.yaml",
        rich_help_panel=_HDR,
        help="The captures are combined HDR frames: how the channels of --model become one output.",
        show_default=False,
    ),
]
Light = Annotated[
    float,
    typer.Option(
        "--light",
        metavar="DN",
        min=0.0,
        rich_help_panel=_HDR,
        help="Uniform light, DN of the first channel.",
    ),
]
CombinedOut = Annotated[
    Path | None,
    typer.Option(
        "--simulate",
        metavar="OUT",
        rich_help_panel=_HDR,
        help="Also write the simulated combined frames, TIFF.",
    ),
]

FILES = _FILES
STEER = "When to stop"
Exclude = Annotated[
    list[str] | None,
    typer.Option(
        "--exclude",
        metavar="EFFECT",
        rich_help_panel=STEER,
        help="Never add this effect (repeatable).",
    ),
]

Budget = Annotated[
    float | None,
    typer.Option(
        "--time-limit",
        "--budget",
        metavar="SECONDS",
        min=0.0,
        rich_help_panel=STEER,
        help="End the search after so many seconds, with the best model so far.",
    ),
]

NoDescribe = Annotated[
    bool,
    typer.Option(
        "--no-describe",
        rich_help_panel=STEER,
        help="Do not describe the unexplained residual.",
    ),
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

    def load(self, session: Session) -> CaptureSet:
        """The captures of a session."""
        return session.load(
            self.config,
            self.tolerance_c,
            self.channel,
            keep_outliers=self.keep_outliers,
            mask=self.mask,
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
