"""One file a format: the header of a file to a ``Recording``.

Each module has ``SUFFIXES`` and ``read(path, name, config, previous)``, which reads the header
alone. ``previous`` is the recording of the file before, whose facts of the sensor may be reused.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from dnanalyze.errors import InputError
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.files import check_regular, unreadable
from dnanalyze.loaders.formats.envi_header import header_beside
from dnanalyze.loaders.formats.unread import instead
from dnanalyze.loaders.recording import Recording, one_line

# Without a handler tifffile's complaints about damaged files would stand on stderr beside the
# one line that the user gets; a program that configures logging still sees them.
logging.getLogger("tifffile").addHandler(logging.NullHandler())

Reader = Callable[[Path, str, Config, Recording | None], Recording]

# Suffix to module; a module is imported when a file asks for it.
MODULES = {
    **dict.fromkeys((".tif", ".tiff"), "tiff"),
    **dict.fromkeys(
        (".fits", ".fit", ".fts", ".fits.gz", ".fit.gz", ".fts.gz", ".fz"), "fits"
    ),
    **dict.fromkeys((".npy",), "numpy_files"),
    **dict.fromkeys((".npz",), "npz"),
    **dict.fromkeys((".h5", ".hdf5", ".hdf", ".nxs"), "hdf5"),
    **dict.fromkeys((".png",), "png"),
    **dict.fromkeys((".pgm",), "pgm"),
    **dict.fromkeys((".ser",), "ser"),
    **dict.fromkeys(
        (".raw", ".bin", ".raw8", ".raw10", ".raw12", ".raw14", ".raw16"), "headerless"
    ),
    **dict.fromkeys(
        (
            ".dng", ".cr2", ".cr3", ".crw", ".nef", ".nrw", ".arw", ".srf", ".sr2", ".raf", ".orf",
            ".rw2", ".pef", ".srw", ".3fr", ".iiq", ".kdc", ".dcr", ".mrw", ".x3f", ".erf", ".mos",
        ),
        "camera_raw",
    ),
}  # fmt: skip


def suffix_of(path: Path) -> str:
    """The suffix that says the format, in lower case: ``.tif``, ``.fits.gz``."""
    double = "".join(path.suffixes[-2:]).lower()
    return double if double in MODULES else path.suffix.lower()


def module_of(path: Path) -> str | None:
    """The module that reads this file; None where it is no frame."""
    if header_beside(path) is not None:
        return "envi"
    return MODULES.get(suffix_of(path))


def read_header(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The header of one file of any format.

    Parameters
    ----------
    path : Path
    name : str
        How the file is named to the user.
    config : Config
        The sidecar.
    previous : Recording, optional
        Of the file before.

    Raises
    ------
    InputError
        Unknown format, damaged, truncated, unreadable; one line with the remedy.
    """
    module = module_of(path)
    if module is None:
        if found := instead([path]):
            raise InputError(f"{name}: is not read: {found}")
        raise InputError(f"{name}: unknown format; valid: {', '.join(sorted(MODULES))}")
    read: Reader = import_module(f"{__name__}.{module}").read
    try:
        check_regular(path, name)
    except OSError as error:  # a link to itself, no permission
        raise unreadable(name, error) from error
    try:
        with path.open("rb") as file:
            empty = not file.read(1)
        if empty:
            raise InputError(f"{name}: is empty; copy the file again or leave it out")
        return read(path, name, config, previous)
    except InputError:
        raise
    except (PermissionError, FileNotFoundError) as error:
        raise unreadable(name, error) from error
    except MemoryError as error:
        raise InputError(f"{name}: its header asks for more memory than there is") from error
    except Exception as error:  # libraries raise anything on damaged files
        raise InputError(
            f"{name}: damaged or not the format its name says ({one_line(error)}); "
            "copy the file again or leave it out"
        ) from error
