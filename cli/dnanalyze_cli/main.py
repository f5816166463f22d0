"""The entry point: commands to exit codes.

0 done, 1 a check failed, 2 bad input, 3 an internal error; 130 interrupted, 141 the reader of the
output is gone, 143 terminated.
"""

from __future__ import annotations

import os
import sys
import traceback
import warnings
from collections.abc import Sequence
from io import TextIOWrapper
from pathlib import Path

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.commands import (
    add,
    analyze,
    benchmark,
    check,
    compare,
    demo,
    describe,
    detect,
    diagnose,
    effects,
    export,
    fit,
    inspect,
    refine,
    simulate,
    workbench,
)
from dnanalyze_cli.short_warnings import ShortWarnings
from dnanalyze_cli.termination import INTERRUPTED, TERMINATED, Stopped, end_on_sigterm

app = typer.Typer(
    name="dnanalyze",
    help="Compare a noise model with dark frames and identify the missing physical effect.",
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode="rich",
    epilog="Start with [bold]dnanalyze demo[/bold], or with your own frames: "
    "[bold]dnanalyze refine FOLDER -o model.yaml --report page.html[/bold].",
)
for panel, commands in {
    "A first hour": (
        demo.demo,
        inspect.inspect,
        analyze.analyze,
        compare.compare,
        diagnose.diagnose,
        refine.refine,
        detect.detect,
        simulate.simulate,
        check.check,
    ),
    "Further": (workbench.workbench, effects.effects, benchmark.benchmark, export.export),
    "Step by step": (fit.fit, add.add, describe.describe),
}.items():
    for command in commands:
        app.command(rich_help_panel=panel, no_args_is_help=False)(command)
for command in (refine.channels, compare.hdr):  # earlier names of `refine` and `compare --combine`
    app.command(hidden=True)(command)

# The base of every usage error; Typer carries its own copy of Click, so it is found through Typer.
_UsageError: type[Exception] = typer.BadParameter.__mro__[1]
BAD_INPUT, INTERNAL, BROKEN_PIPE = 2, 3, 141
COMPLETION = "_DNANALYZE_COMPLETE"  # by which a shell asks how a word goes on
NOTHING_HALF = "nothing was left half-written"


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
    """Run one command; return its exit code. Whatever goes wrong is one line on stderr.

    ``DNANALYZE_DEBUG=1`` shows the traceback of an internal error, which is never exit code 1: that
    says that a check failed.
    """
    command = typer.main.get_command(app)
    try:
        result = command.main(arguments, prog_name="dnanalyze", standalone_mode=False)
        if result == INTERRUPTED:  # some versions of Typer give the code, others raise
            raise KeyboardInterrupt
    except (KeyboardInterrupt, typer.Abort):
        return _fail(f"interrupted; {NOTHING_HALF}", INTERRUPTED)
    except Stopped as stop:
        return _fail(str(stop), stop.code)
    except InputError as error:
        return _fail(str(error))
    except _UsageError as error:
        return _fail(str(getattr(error, "format_message", error.__str__)()))
    except typer.Exit as leave:
        return leave.exit_code
    except MemoryError:
        return _fail("out of memory; use fewer or smaller frames")
    except BrokenPipeError:
        return _reader_gone()
    except SystemExit as leave:
        if leave.code == 0 and COMPLETION in os.environ:  # the shell has its answer
            return 0
        if leave.code == TERMINATED:
            return _fail(f"terminated; {NOTHING_HALF}", TERMINATED)
        if isinstance(leave.__context__, BrokenPipeError):  # Typer's answer to it is exit code 1
            return _reader_gone()
        return _internal(leave)
    except Exception as error:
        return _internal(error)
    return result if isinstance(result, int) else 0


def run() -> None:
    """The ``dnanalyze`` command."""
    end_on_sigterm()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # its encoding may lack ° or σ
            stream.reconfigure(errors="replace")
    warnings.showwarning = ShortWarnings()
    code = main()
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        code = _reader_gone()
    sys.exit(code)


def _fail(text: str, code: int = BAD_INPUT) -> int:
    print("dnanalyze: " + " ".join(text.split()), file=sys.stderr)
    return code


def _internal(error: BaseException) -> int:
    """One line on what failed and where, and how to report it."""
    debug = os.environ.get("DNANALYZE_DEBUG", "") not in ("", "0")
    if debug:
        traceback.print_exception(error)
    frames = traceback.extract_tb(error.__traceback__)
    at = f" at {Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""
    more = "the traceback above" if debug else "the traceback that DNANALYZE_DEBUG=1 shows"
    return _fail(
        f"internal error: {type(error).__name__}: {_short(error)}{at}; please report it with the "
        f"command, `dnanalyze --version` and {more}",
        INTERNAL,
    )


def _short(error: BaseException, most: int = 200) -> str:
    """The message of an error, which may be a page long."""
    text = " ".join(str(error).split())
    return text if len(text) <= most else text[:most] + " ..."


def _reader_gone() -> int:
    """What reads the output has ended, as ``head`` does: no error, and nothing more to say."""
    sys.stdout = open(os.devnull, "w")  # noqa: SIM115 (what is buffered yet goes there at the end)
    return BROKEN_PIPE
