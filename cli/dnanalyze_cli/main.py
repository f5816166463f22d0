"""The entry point: commands to exit codes (0 done, 1 a check failed, 2 bad input)."""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.commands import (
    add,
    analyze,
    benchmark,
    channels,
    check,
    compare,
    demo,
    detect,
    diagnose,
    effects,
    export,
    fit,
    hdr,
    inspect,
    refine,
    simulate,
)

app = typer.Typer(
    name="dnanalyze",
    help="Hold dark frames against a noise model, see where it fails, name what is missing.",
    add_completion=False,
    rich_markup_mode="rich",
    epilog="Start with [bold]dnanalyze demo[/bold] or [bold]dnanalyze compare FOLDER[/bold].",
)
for panel, commands in {
    "Look": (inspect.inspect, analyze.analyze),
    "Model": (fit.fit, simulate.simulate, compare.compare, hdr.hdr),
    "Find what is missing": (
        diagnose.diagnose,
        add.add,
        refine.refine,
        channels.channels,
        detect.detect,
    ),
    "Hold and share": (benchmark.benchmark, check.check, export.export),
    "Learn": (effects.effects, demo.demo),
}.items():
    for command in commands:
        app.command(rich_help_panel=panel, no_args_is_help=False)(command)

# The base of every usage error; Typer carries its own copy of Click, so it is found through Typer.
_UsageError: type[Exception] = typer.BadParameter.__mro__[1]
INTERRUPTED, TERMINATED = 130, 143


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: bool = typer.Option(False, "--version", help="Show the version."),
) -> None:
    if version:
        import dnanalyze

        typer.echo(f"dnanalyze {dnanalyze.__version__}")
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code. What the user can mend is one line on stderr."""
    command = typer.main.get_command(app)
    try:
        result = command.main(arguments, prog_name="dnanalyze", standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):
        result = INTERRUPTED
    except InputError as error:
        return _fail(str(error))
    except _UsageError as error:
        return _fail(str(getattr(error, "format_message", error.__str__)()))
    except typer.Exit as leave:
        return leave.exit_code
    except MemoryError:
        return _fail("out of memory; use fewer or smaller frames")
    if result == INTERRUPTED:  # some versions of Typer give the code, others raise
        return _fail("interrupted; nothing was left half-written", INTERRUPTED)
    return result if isinstance(result, int) else 0


def run() -> None:
    """The ``dnanalyze`` command."""
    signal.signal(
        signal.SIGTERM, lambda *_: sys.exit(TERMINATED)
    )  # so that temporaries are removed
    sys.exit(main())


def _fail(text: str, code: int = 2) -> int:
    print("dnanalyze: " + " ".join(text.split()), file=sys.stderr)
    return code
