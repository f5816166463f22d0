"""A .zip or .tar.gz as a folder: unpacked to a temporary one within limits, removed at exit."""

from __future__ import annotations

import bz2
import gzip
import lzma
import shutil
import tarfile
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path, PurePosixPath
from typing import IO, Any

from dnanalyze.errors import InputError
from dnanalyze.loaders.checks import MIN_BITS
from dnanalyze.loaders.recording import one_line
from dnanalyze.loaders.remote import made

TARS: dict[str, Callable[[Path], Any]] = {
    ".tar": lambda path: path.open("rb"),
    ".tar.gz": gzip.open, ".tgz": gzip.open, ".tar.bz2": bz2.open, ".tar.xz": lzma.open,
}  # fmt: skip
SUFFIXES = (".zip", *TARS)
FREE_BYTES = 64 << 20  # bytes that may be unpacked of whatever is in the archive
_BLOCK = 1 << 20
_LONGEST = 240  # characters of a name; systems take 255


def is_archive(path: Path) -> bool:
    """Whether the name is that of an archive that is read."""
    return path.name.lower().endswith(SUFFIXES)


def unpacked(path: Path, name: str, most: int) -> Path:
    """The folder with the files of an archive, or its only folder; removed when the program ends.

    Parameters
    ----------
    path : Path
    name : str
        For messages.
    most : int
        Files at most.

    Raises
    ------
    InputError
        Damaged, encrypted, too many or too large files, more than noise can be packed, a link, or
        a name that leads elsewhere.
    """
    state = path.stat()
    return _unpacked(path, name, most, state.st_mtime_ns, state.st_size)


@cache  # as long as the file does not change
def _unpacked(path: Path, name: str, most: int, changed: int, size: int) -> Path:
    local = made(Path(tempfile.mkdtemp(prefix="dnanalyze-")))
    root = local / (path.name.split(".")[0] or "captures")
    root.mkdir()
    # a byte of frames holds MIN_BITS at least, as in `checks.check_stored`
    room = _Room(
        name, min(max(FREE_BYTES, int(8 * size / MIN_BITS)), shutil.disk_usage(local).free)
    )
    zipped = path.name.lower().endswith(".zip")
    try:
        for count, (member, file) in enumerate((_zip if zipped else _tar)(path, name, room)):
            if count >= most:
                raise InputError(f"{name}: holds more than {most} files; give that of one capture")
            target = root / _safe(member, name)
            target.parent.mkdir(parents=True, exist_ok=True)
            with target.open("xb") as out:
                while block := file.read(_BLOCK):
                    room.take(len(block))
                    out.write(block)
    except InputError:
        shutil.rmtree(local, ignore_errors=True)
        raise
    except FileExistsError as error:
        raise InputError(f"{name}: holds a file twice; unpack it and give the folder") from error
    except Exception as error:  # libraries raise anything on damaged archives
        raise InputError(
            f"{name}: cannot be unpacked ({one_line(error)}); copy it again, or unpack it and give "
            "the folder"
        ) from error
    inside = list(root.iterdir())
    return inside[0] if len(inside) == 1 and inside[0].is_dir() else root


class _Room:
    """Bytes that may still be unpacked."""

    def __init__(self, name: str, left: int) -> None:
        self.name, self.left = name, left

    def take(self, count: int) -> None:
        """Count bytes.

        Raises
        ------
        InputError
            More than there may be.
        """
        self.left -= count
        if self.left < 0:
            raise InputError(
                f"{self.name}: unpacks to more than frames can be packed by, or than there is free "
                "space; unpack it and give the folder"
            )


class _Bounded:
    """A stream whose bytes are counted, so that a header cannot ask for all that it unpacks to."""

    def __init__(self, stream: IO[bytes], room: _Room) -> None:
        self.stream, self.room = stream, room

    def read(self, size: int = _BLOCK) -> bytes:
        """So many bytes, or what is left."""
        data = self.stream.read(min(size, FREE_BYTES))
        self.room.take(len(data))
        return data


def _zip(path: Path, name: str, room: _Room) -> Iterator[tuple[str, IO[bytes]]]:
    with zipfile.ZipFile(path) as archive:
        for info in archive.infolist():
            if info.is_dir() or _beside(info.filename):
                continue
            kind = info.external_attr >> 16 & 0o170000
            if kind not in (0, 0o100000):
                raise _link(name, info.filename)
            if info.flag_bits & 1:
                raise InputError(f"{name}: is encrypted; unpack it and give the folder")
            with archive.open(info) as file:
                yield info.filename, file


def _tar(path: Path, name: str, room: _Room) -> Iterator[tuple[str, IO[bytes]]]:
    suffix = next(s for s in sorted(TARS, key=len) if path.name.lower().endswith(s))
    with TARS[suffix](path) as stream:
        source: Any = _Bounded(stream, _Room(name, room.left))  # headers as well
        with tarfile.open(fileobj=source, mode="r|") as archive:
            for member in archive:
                if member.isdir() or _beside(member.name):
                    continue
                if not member.isreg():
                    raise _link(name, member.name)
                file = archive.extractfile(member)
                if file is not None:
                    yield member.name, file


def _beside(member: str) -> bool:
    """Whether it is what systems put beside the files of the user."""
    return any((p.startswith(".") and p not in (".", "..")) or p == "__MACOSX"
               for p in member.replace("\\", "/").split("/"))  # fmt: skip


def _safe(member: str, name: str) -> PurePosixPath:
    plain = member.replace("\\", "/")
    parts = PurePosixPath(plain).parts
    if (
        not parts or plain.startswith("/") or ".." in parts or ":" in parts[0] or "\0" in plain
        or len(plain) > _LONGEST
    ):  # fmt: skip
        raise InputError(
            f"{name}: holds a file named {member[:60]!r}, which leads elsewhere; unpack it and "
            "give the folder"
        )
    return PurePosixPath(*parts)


def _link(name: str, member: str) -> InputError:
    return InputError(
        f"{name}: {member[:60]} is a link or no plain file; unpack it and give the folder"
    )
