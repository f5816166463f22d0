"""Small text files and YAML, bounded in size, depth and what they may expand to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from dnanalyze.errors import InputError
from dnanalyze.loaders.files import check_regular, unreadable

MAX_BYTES = 8 << 20  # of a table of frames: 100,000 rows of 80 characters
MAX_YAML_BYTES = 2 << 20  # YAML is parsed at about 1 MB/s
# A YAML file of ours nests five deep, and its longest value is a regular expression or a line of
# text. Parsers take time that grows with the square of both.
MAX_DEPTH = 32
MAX_VALUE = 10_000  # characters

# libyaml's parser where PyYAML was built with it: ten times faster, the same data
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_OPENS = (
    yaml.BlockSequenceStartToken, yaml.BlockMappingStartToken,
    yaml.FlowSequenceStartToken, yaml.FlowMappingStartToken,
)  # fmt: skip
_CLOSES = (yaml.BlockEndToken, yaml.FlowSequenceEndToken, yaml.FlowMappingEndToken)


def read_text(path: Path, most: int = MAX_BYTES) -> str:
    """A small text file.

    Parameters
    ----------
    path : Path
    most : int
        Bytes that it may have.

    Raises
    ------
    InputError
        Absent, no regular file, unreadable, no text, or too large.
    """
    try:
        check_regular(path, str(path))
        with path.open("rb") as file:
            data = file.read(most + 1)
    except (FileNotFoundError, NotADirectoryError) as error:
        raise InputError(f"{path}: no such file; give the path of a file") from error
    except OSError as error:
        raise unreadable(str(path), error) from error
    if len(data) > most:
        raise InputError(f"{path}: larger than {most >> 20} MB; split it, or give another file")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text; save it as UTF-8") from error


def read_yaml(path: Path) -> Any:
    """Plain data of a YAML file; tags and aliases that could expand are refused.

    Raises
    ------
    InputError
        Not YAML, with aliases, nested too deep, or too large.
    """
    text = read_text(path, MAX_YAML_BYTES)
    try:
        _check_tokens(path, text)
        return yaml.load(text, _Loader)  # a safe loader
    except InputError:
        raise
    except (yaml.YAMLError, RecursionError, ValueError, OverflowError, TypeError) as error:
        mark = getattr(error, "problem_mark", None)
        place = f" (line {mark.line + 1})" if mark else ""
        problem = getattr(error, "problem", None) or str(error)[:80] or type(error).__name__
        if (
            "maximum nesting depth" in problem
        ):  # the parser looks ahead, and its limit is above ours
            raise _too_deep(path, mark.line if mark else 0) from error
        raise InputError(f"{path}: is not YAML{place}: {' '.join(problem.split())}") from error


def _check_tokens(path: Path, text: str) -> None:
    """Refuse what a parser would take for ever over; stops at the first such token."""
    depth = 0
    for token in yaml.scan(text, _Loader):
        depth += isinstance(token, _OPENS) - isinstance(token, _CLOSES)
        if depth > MAX_DEPTH:
            raise _too_deep(path, token.start_mark.line)
        if isinstance(token, yaml.AliasToken):
            raise InputError(f"{path}: YAML aliases (*name) are not accepted; write the value out")
        if isinstance(token, yaml.ScalarToken) and len(token.value) > MAX_VALUE:
            raise InputError(f"{path}: has a value of more than {MAX_VALUE} characters; shorten it")


def _too_deep(path: Path, line: int) -> InputError:
    return InputError(
        f"{path}: is nested more than {MAX_DEPTH} deep (line {line + 1}); it is damaged"
    )
