"""What an interrupted refinement leaves, and the line that goes on with it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dnanalyze_cli.termination import INTERRUPTED, TERMINATED, Stopped

if TYPE_CHECKING:
    from dnanalyze.diagnosis.refine import Refinement


@contextmanager
def kept_when_stopped(
    files: Sequence[Path], so_far: Sequence[Refinement], go_on: Callable[[], list[str]]
) -> Iterator[None]:
    """Ctrl-C or SIGTERM in the block: one line on what is kept and how to go on.

    Parameters
    ----------
    files : sequence of Path
        What each step writes.
    so_far : sequence of Refinement
        What was kept; the last one stands in the files.
    go_on : callable
        The command to go on with; empty where no model file was named.
    """
    try:
        yield
    except KeyboardInterrupt:
        raise Stopped(_told("interrupted", files, so_far, go_on()), INTERRUPTED) from None
    except SystemExit as leave:
        if leave.code != TERMINATED:
            raise
        raise Stopped(_told("terminated", files, so_far, go_on()), TERMINATED) from None


def _told(
    how: str, files: Sequence[Path], so_far: Sequence[Refinement], go_on: Sequence[str]
) -> str:
    from dnanalyze.report.words import listing, net_additions, number, plural

    if not so_far:
        return f"{how} before the first step; nothing was written"
    if not files:
        return f"{how}; nothing was written; name a file with -o to be able to continue"
    steps = so_far[-1].steps
    count = plural(len(net_additions([s.added for s in steps])), "effect")
    text = (
        f"{how} with {count} added (model error {number(steps[-1].error)}); written to "
        f"{listing(map(str, files))}"
    )
    if not go_on:
        return f"{text}; name a model file with -o to be able to continue"
    return f"{text}; continue with: {shlex.join(go_on)}"


def command_line(
    captures: str,
    output: Path | None,
    options: Mapping[str, Any],
    max_effects: int | None,
    so_far: Refinement | None,
) -> list[str]:
    """The command that goes on from the model that was kept; empty without a model file.

    Parameters
    ----------
    captures : str
    output : Path or None
        The model file.
    options : mapping
        Option to its value, list of values, True for a flag, or None where it was not given.
    max_effects : int or None
        Of the whole run; what was added already is taken off.
    so_far : Refinement or None
    """
    from dnanalyze.model.registry import BASELINE
    from dnanalyze.report.words import net_additions

    if output is None or str(output) == "-" or so_far is None:
        return []
    line = ["dnanalyze", "refine", captures, "--model", str(output), "-o", str(output)]
    for name, value in options.items():
        for one in value if isinstance(value, list) else [value]:
            if one is not None:
                line += [name] if one is True else [name, str(one)]
    if max_effects is not None:
        added = [n for n in net_additions([s.added for s in so_far.steps]) if n not in BASELINE]
        line += ["--max-effects", str(max(max_effects - len(added), 0))]
    return line
