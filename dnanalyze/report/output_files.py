"""Files appear whole or not at all; what happens where an output exists.

A file of results is replaced. What may hold work of the user (a folder of frames, an effect file, a
map, targets) is replaced with ``force`` only, and a folder only if it holds nothing but frames.
"""

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


def check_kept(path: Path, force: bool, option: str = "") -> None:
    """Refuse to replace a file that may hold work of the user, unless ``force`` is given.

    Raises
    ------
    InputError
        The file exists.
    """
    if path.exists() and not force:
        raise InputError(
            f"{option} {path}: exists; name another file, or give --force to replace it".strip()
        )


def check_folder(path: Path, force: bool = False) -> None:
    """Refuse a folder that exists and holds something, unless ``force`` may replace it.

    Raises
    ------
    InputError
        ``path`` is a file, or a folder with something in it: any without ``force``; with it, one
        without ``manifest.csv``, which every folder of simulated frames has.
    """
    if path.is_file():
        raise InputError(f"{path}: is a file; name a new or empty folder")
    if not path.is_dir() or not any(path.iterdir()):
        return
    if not force:
        raise InputError(
            f"{path}: exists already; name a new or empty folder, or give --force to replace it"
        )
    if not (path / "manifest.csv").is_file():
        raise InputError(
            f"{path}: has no manifest.csv, so it is no folder of simulated frames, which --force "
            "replaces; name another"
        )


@contextmanager
def atomic_folder(path: Path, force: bool = False) -> Iterator[Path]:
    """A new folder to fill, which takes its name when the block ends without an error.

    Raises
    ------
    InputError
        See `check_folder`; or its parent cannot be written.
    """
    check_folder(path, force)
    # named before it is made: a signal in between leaves nothing
    temporary = path.parent / f".{path.name}.{secrets.token_hex(4)}"
    former = temporary.with_name(f"{temporary.name}.former")
    try:
        try:
            temporary.mkdir(mode=0o700)
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
        yield temporary
        os.chmod(temporary, 0o777 & ~_umask())
        with _undisturbed():
            if path.is_dir():
                os.replace(path, former)
            os.replace(temporary, path)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        shutil.rmtree(former, ignore_errors=True)


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
