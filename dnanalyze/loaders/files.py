"""Which files a capture path means: a folder, one file, a manifest, or a remote URL."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from dnanalyze.errors import InputError
from dnanalyze.loaders.archives import is_archive, unpacked
from dnanalyze.loaders.remote import Origin, fetched

MAX_FILES = 100_000
MANIFESTS = ("manifest.csv", "manifest.yaml", "manifest.yml")
SIDECARS = ("dnanalyze.yaml", "dnanalyze.yml")


@dataclass(frozen=True)
class Place:
    """Where the captures lie.

    Parameters
    ----------
    name : str
        As the user gave it.
    root : Path
        The folder, local.
    files : tuple of Path
        All files below it in natural order, or the one file that was named.
    single : bool
        Whether one file was named.
    origin : Origin, optional
        Where the files were copied from.
    """

    name: str
    root: Path
    files: tuple[Path, ...]
    single: bool = False
    origin: Origin | None = None

    def relative(self, path: Path) -> str:
        """The file as it is named to the user, below the root."""
        return path.relative_to(self.root).as_posix()


def find(path: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> Place:
    """The files that ``path`` means.

    Parameters
    ----------
    path : str or path, or several
        A folder, one file, a manifest in a folder, an archive of a folder (.zip, .tar.gz), or an
        fsspec URL ("s3://bucket/darks"); or several files.

    Raises
    ------
    InputError
        Nothing there, unreadable, a link that leaves the folder, too many files.
    """
    if not isinstance(path, (str, os.PathLike)):
        return _several(path)
    text = os.fspath(path)
    if "://" in text:
        return _fetched(text)
    given = Path(text)
    try:
        if given.is_dir():
            return Place(text, given, _below(given))
        if given.is_file():
            if given.name.lower() in MANIFESTS:
                return Place(text, given.parent, _below(given.parent))
            if is_archive(given):
                check_regular(given, text)
                root = unpacked(given, text, MAX_FILES)
                return Place(text, root, _below(root))
            return Place(text, given.parent, (given,), single=True)
    except OSError as error:
        raise unreadable(text, error) from error
    if os.path.lexists(text):
        raise InputError(
            f"{text}: is a pipe, socket, device or a link that leads nowhere; give a folder of "
            "dark frames or one file"
        )
    raise InputError(f"{text}: no such file or folder; give a folder of dark frames or one file")


def _several(paths: Iterable[str | os.PathLike[str]]) -> Place:
    """Files that are named one by one, in that order."""
    files = []
    for path in paths:
        file = Path(path)
        try:
            check_regular(file, str(file))
        except FileNotFoundError:
            raise InputError(f"{file}: no such file") from None
        except OSError as error:
            raise unreadable(str(file), error) from error
        files.append(file.absolute())
        if len(files) > MAX_FILES:
            raise InputError(f"{file}: more than {MAX_FILES} files; give those of one capture")
    if not files:
        raise InputError("no files: give a folder of dark frames, or one file at the least")
    root = Path(os.path.commonpath([file.parent for file in files]))
    return Place(str(root), root, tuple(files))


def unreadable(name: str, error: OSError) -> InputError:
    """What to say of a file that the system does not let us read."""
    reason = error.strerror or type(error).__name__
    return InputError(f"{name}: cannot be read ({reason}); check its permissions")


def check_regular(path: Path, name: str) -> None:
    """Refuse a folder, pipe, socket or device: to read one may wait for ever.

    Raises
    ------
    InputError
        No regular file.
    OSError
        Absent, a link to itself, or not to be looked at.
    """
    kind = path.stat().st_mode
    if stat.S_ISDIR(kind):
        raise InputError(f"{name}: is a folder; give a file")
    if not stat.S_ISREG(kind):
        raise InputError(f"{name}: is a pipe, socket or device; give a regular file")


def natural_key(name: str) -> list[tuple[int, int, str]]:
    """Sort key under which dark_2 comes before dark_10."""
    return [
        (0, int(part), "") if part.isdigit() else (1, 0, part)
        for part in re.split(r"([0-9]+)", name.casefold())
    ]


def inside(root: Path, path: Path, name: str) -> Path:
    """``path``, when it lies below ``root`` after every link is followed.

    Raises
    ------
    InputError
        It leaves the folder.
    """
    # realpath, unlike Path.resolve, follows a link to itself no further than once
    if not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(root)):
        raise InputError(
            f"{name}: leads outside the capture folder {root}; copy the file into the folder"
        )
    return path


def _below(root: Path) -> tuple[Path, ...]:
    def refuse(error: OSError) -> None:
        raise unreadable(str(error.filename), error)

    paths: list[Path] = []
    for folder, folders, names in os.walk(root, onerror=refuse):
        folders[:] = [f for f in folders if not f.startswith(".")]
        for name in [*names, *(f for f in folders if Path(folder, f).is_symlink())]:
            path = Path(folder, name)
            if name.startswith("."):
                continue
            if path.is_symlink():
                inside(root, path, str(path))
            if not path.is_dir():
                paths.append(path)
        if len(paths) > MAX_FILES:
            raise InputError(f"{root}: more than {MAX_FILES} files; give the folder of one capture")
    return tuple(sorted(paths, key=lambda p: natural_key(p.relative_to(root).as_posix())))


def _fetched(url: str) -> Place:
    origin, single = fetched(url, MAX_FILES, inside)
    return Place(url, origin.root, _below(origin.root), single, origin)
