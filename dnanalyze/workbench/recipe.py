"""A node of the history as the commands, or the Python, that design it again from the captures."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from itertools import pairwise

from dnanalyze.model.noise_model import dump_model
from dnanalyze.workbench.history import Node
from dnanalyze.workbench.source import CaptureSource

END = "END_OF_MODEL"


def commands(source: CaptureSource, path: Sequence[Node]) -> str:
    """Shell commands from the captures to the last node of a path.

    Parameters
    ----------
    source : CaptureSource
    path : sequence of Node
        See `History.made`. A model that was set by hand is written as a file.

    Returns
    -------
    str
        A POSIX shell script; its last command prints the node's error.
    """
    captures = shlex.quote(str(source.folder))
    reading = _reading(source)
    lines = []
    before = ""
    for node in path:
        file = f"model-{node.number}.yaml"
        if node.command:
            name, *arguments = node.command
            model = f" --model {before}" if before else ""
            words = "".join(f" {shlex.quote(a)}" for a in arguments)
            lines.append(f"dnanalyze {name} {captures}{words}{model} -o {file}{reading}")
        else:
            lines.append(f"cat > {file} <<'{END}'\n{dump_model(node.model)}{END}")
        before = file
    lines.append(f"dnanalyze compare {captures} --model {before}{reading}")
    return "\n".join(lines) + "\n"


def python(source: CaptureSource, path: Sequence[Node]) -> str:
    """The same as `commands` in Python."""
    more = [
        f"{key}={value!r}"
        for key, value in (
            ("config", source.config and str(source.config)),
            ("tolerance_c", source.tolerance_c),
            ("keep_outliers", source.keep_outliers or None),
            ("mask", source.mask and str(source.mask)),
        )
        if value is not None
    ]
    lines = ["from pathlib import Path", "", "import dnanalyze", ""]
    lines.append(f"captures = dnanalyze.load({', '.join([repr(str(source.folder)), *more])})")
    if source.channel is not None:
        lines.append(f"captures = captures.channel({source.channel!r})")
    known = ""
    if source.effects:
        files = "".join(f"Path({str(p)!r}), " for p in source.effects)
        lines += ["", f"known = dnanalyze.catalogue(({files}))"]
        known = ", known=known"
    model = ""
    for node in path:
        if not node.command:
            file = f'Path("model-{node.number}.yaml")'
            lines.append(f'{file}.write_text("""\\\n{dump_model(node.model)}""")')
            lines.append(f"model = dnanalyze.load_model({file}{known})")
        else:
            lines.append(_call(node.command, model, known))
        model = "model"
    lines += ["print(dnanalyze.compare(captures, model).error)"]
    return "\n".join(lines) + "\n"


def _call(command: Sequence[str], model: str, known: str) -> str:
    name, *arguments = command
    if name == "fit":
        frozen = [b for a, b in pairwise(arguments) if a == "--frozen"]
        options = f", frozen={frozen!r}" if frozen else ""
        given = f", {model}" if model else ""
        return f"model = dnanalyze.fit(captures{given}{options}, replicates=0).model"
    if name == "add":
        return f"model = dnanalyze.add(captures, {arguments[0]!r}, {model}{known}).model"
    given = f", {model}" if model else ""
    return f"model = dnanalyze.{name}(captures{given}{known}).model"


def _reading(source: CaptureSource) -> str:
    """Options of every command."""
    words = ""
    if source.config is not None:
        words += f" --sidecar {shlex.quote(str(source.config))}"
    if source.tolerance_c is not None:
        words += f" --tolerance-c {source.tolerance_c:g}"
    if source.keep_outliers:
        words += " --keep-outliers"
    if source.mask is not None:
        words += f" --mask {shlex.quote(str(source.mask))}"
    if source.channel is not None:
        words += f" --channel {shlex.quote(source.channel)}"
    for path in source.effects:
        words += f" --effects {shlex.quote(str(path))}"
    return words
