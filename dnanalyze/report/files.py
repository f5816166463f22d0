"""Files appear whole or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
import signal
import threading
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

from dnanalyze.errors import InputError


def write_together(contents: Mapping[Path, str | bytes]) -> None:
    """Several files, all of them or none: each is written whole before the first gets its name.

    Ctrl-C and SIGTERM wait until all have theirs.

    Raises
    ------
    InputError
        One of them cannot be written; then none is.
    """
    from dnanalyze.loaders.writers import atomic

    path = None
    try:
        with _undisturbed(), ExitStack() as stack:
            for path, content in contents.items():
                made = content.encode("utf-8") if isinstance(content, str) else content
                stack.enter_context(atomic(path)).write(made)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Signals that would end the process come when the block is done."""
    if threading.current_thread() is not threading.main_thread():
        yield  # handlers run in the main thread alone
        return
    came: list[int] = []
    before = {
        which: signal.signal(which, lambda number, _: came.append(number))
        for which in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for which, handler in before.items():
            signal.signal(which, handler if handler is not None else signal.SIG_DFL)
        if came:
            signal.raise_signal(came[0])


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """A new folder to fill, which takes its name when the block ends without an error.

    Raises
    ------
    InputError
        ``path`` is a file or a folder with something in it, or its parent cannot be written.
    """
    if path.is_file() or (path.is_dir() and any(path.iterdir())):
        raise InputError(f"{path}: exists already; name a new or empty folder")
    # named before it is made: a signal in between leaves nothing
    temporary = path.parent / f".{path.name}.{secrets.token_hex(4)}"
    try:
        try:
            temporary.mkdir(mode=0o700)
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
        yield temporary
        os.chmod(temporary, 0o777 & ~_umask())
        os.replace(temporary, path)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def check_output(path: Path, captures: str | Path | None = None) -> None:
    """Refuse an output that cannot be written, before the long work begins.

    Captures are only read: an output inside their folder would change them.

    Raises
    ------
    InputError
        ``path`` is a folder, has no folder to stand in, or lies in the capture folder.
    """
    if path.is_dir():
        raise InputError(f"{path}: is a folder; name a file")
    folder = path.absolute().parent
    if not folder.is_dir():
        raise InputError(f"{path}: the folder {folder} does not exist; make it first")
    if not os.access(folder, os.W_OK):
        raise InputError(f"{path}: the folder {folder} cannot be written; name another")
    if captures is None or "://" in str(captures):
        return
    source = Path(captures).resolve()
    if source.is_dir() and source in path.resolve().parents:
        raise InputError(f"{path}: lies inside the captures, which are never changed; name another")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
