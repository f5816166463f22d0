"""Captures at a URL: copied here to be read; a Dask worker elsewhere copies what it reads."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window


@dataclass(frozen=True)
class Origin:
    """Where the copies came from.

    Parameters
    ----------
    url : str
        As the user gave it.
    system : fsspec file system
        Travels to Dask workers.
    base : str
        The folder there.
    root : Path
        The folder here, in a temporary folder of its own.
    """

    url: str
    system: Any
    base: str
    root: Path

    def local(self, name: str) -> Path:
        """Where the copy of a remote file belongs."""
        return self.root / name.removeprefix(self.base).lstrip("/")

    def fetch(self, path: Path) -> None:
        """Copy the file that belongs at ``path``, on a machine that lacks it."""
        made(self.root.parent)
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, part = tempfile.mkstemp(dir=path.parent, suffix=".part")
        os.close(handle)
        try:
            self.system.get_file(f"{self.base}/{path.relative_to(self.root).as_posix()}", part)
            os.replace(part, path)
        except Exception as error:
            raise _unfetched(self.url, error) from error
        finally:
            Path(part).unlink(missing_ok=True)


@dataclass(frozen=True)
class Fetched:
    """``Recording.read`` of a copied file, which is copied again where it is not.

    Parameters
    ----------
    read : callable
        Reads the copy.
    path : Path
        The copy.
    origin : Origin
    """

    read: Callable[[int, Window], np.ndarray]
    path: Path
    origin: Origin

    @property
    def partial(self) -> bool:
        """As of the reader of the copy."""
        return bool(getattr(self.read, "partial", False))

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``."""
        if not self.path.exists():
            self.origin.fetch(self.path)
        return self.read(index, window)


def fetched(
    url: str, most: int, refuse: Callable[[Path, Path, str], object]
) -> tuple[Origin, bool]:
    """A local copy of a remote folder or file, removed when the program ends.

    Parameters
    ----------
    url : str
        An fsspec URL.
    most : int
        Files at most.
    refuse : callable
        Called with (root, path, name); raises where a path leaves the folder.

    Returns
    -------
    origin : Origin
    single : bool
        Whether the URL names one file.

    Raises
    ------
    InputError
        No fsspec, nothing there, too many files, too large, no access.
    """
    try:
        fsspec: Any = import_module("fsspec")
    except ImportError as error:
        raise InputError(f"{url}: remote captures need fsspec; pip install fsspec") from error
    local = made(Path(tempfile.mkdtemp(prefix="dnanalyze-")))
    try:
        system, remote = fsspec.core.url_to_fs(url)
        sizes = {name: info["size"] or 0 for name, info in system.find(remote, detail=True).items()}
        if not sizes:
            raise InputError(f"{url}: no such file or folder; check the address")
        if len(sizes) > most:
            raise InputError(f"{url}: more than {most} files; give the folder of one capture")
        if sum(sizes.values()) > shutil.disk_usage(local).free:
            raise InputError(f"{url}: larger than the free space of {local.parent}")
        single = remote in sizes
        base = remote.rpartition("/")[0] if single else remote.rstrip("/")
        origin = Origin(url, system, base, local / (base.rpartition("/")[2] or "captures"))
        for name in sizes:
            target = origin.local(name)
            refuse(local, target, f"{url}: {name}")
            target.parent.mkdir(parents=True, exist_ok=True)
            system.get_file(name, str(target))
    except InputError:
        raise
    except Exception as error:  # every protocol has its own errors
        raise _unfetched(url, error) from error
    return origin, single


@cache
def made(folder: Path) -> Path:
    """The temporary folder, there, private, and removed when this process ends."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _unfetched(url: str, error: Exception) -> InputError:
    text = " ".join(str(error).split())[:160] or type(error).__name__
    return InputError(f"{url}: cannot be fetched ({text}); check address and access")
