"""A map of the whole frame that a model holds: in a NumPy file, named with its checksum."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.errors import InputError

MOST_PIXELS = 1 << 28  # 1 GiB of float32; the largest sensors have half of that
MOST_VALUE = 1e6  # DN


@dataclass(frozen=True, eq=False)
class FieldMap:
    """Values of every pixel of a frame.

    Equal maps have the same checksum; a map is hashed by it.

    Parameters
    ----------
    array : ndarray
        (rows, columns), float32.
    file : str
        NumPy file that holds it; empty for a map in memory alone.

    Raises
    ------
    InputError
        No two-dimensional array of finite numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from dnanalyze.model.learned.field_map import FieldMap
    >>> FieldMap(np.zeros((4, 6), np.float32)).shape
    (4, 6)
    """

    array: np.ndarray
    file: str = ""

    def __post_init__(self) -> None:
        made = self.array
        if made.ndim != 2 or made.dtype.kind != "f" or not 0 < made.size <= MOST_PIXELS:
            raise InputError(
                f"map {self.file}: {made.dtype} of shape {made.shape}; valid: (rows, columns) of "
                f"floating-point numbers, up to {MOST_PIXELS:,} pixels"
            )
        if not np.isfinite(made).all() or np.abs(made).max() > MOST_VALUE:
            raise InputError(f"map {self.file}: valid: finite numbers up to {MOST_VALUE:g} DN")
        own = np.ascontiguousarray(made, np.float32)
        own.setflags(write=False)
        object.__setattr__(self, "array", own)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.array.shape[0], self.array.shape[1]

    @cached_property
    def checksum(self) -> str:
        """SHA-256 of shape and values."""
        made = hashlib.sha256(repr(self.shape).encode())
        made.update(self.array.astype("<f4", copy=False).tobytes())
        return made.hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FieldMap) and self.checksum == other.checksum

    def __hash__(self) -> int:
        return hash(self.checksum)

    def to_plain(self) -> dict[str, str]:
        """As written in YAML: file and checksum."""
        return {"file": self.file, "sha256": self.checksum}

    @classmethod
    def from_plain(cls, raw: Any) -> FieldMap:
        """Read the map that YAML names.

        Raises
        ------
        InputError
            No such file, no map, or another map than the one that was written.
        """
        if not isinstance(raw, dict) or not isinstance(raw.get("file"), str) or not raw["file"]:
            raise InputError("map: valid: a mapping with 'file', a NumPy file (.npy), and 'sha256'")
        if extra := set(raw) - {"file", "sha256"}:
            raise InputError(f"map: unknown key {min(map(str, extra))!r}; valid: file, sha256")
        found = read_map(Path(raw["file"]))
        if raw.get("sha256") not in (None, found.checksum):
            raise InputError(f"map {raw['file']}: not the map that the model was written with")
        return found


def read_map(path: Path) -> FieldMap:
    """Read a map from a NumPy file.

    Raises
    ------
    InputError
        No NumPy file, or one without a map.
    """
    try:
        with path.open("rb") as stream:
            if stream.read(6) != b"\x93NUMPY":
                raise ValueError
        if path.stat().st_size > 8 * MOST_PIXELS + 4096:
            raise ValueError
        array = np.load(path, allow_pickle=False, mmap_mode="r")
        return FieldMap(np.asarray(array), str(path))
    except OSError as error:
        raise InputError(f"map {path}: {error.strerror or 'cannot be read'}") from None
    except (ValueError, EOFError, SyntaxError, TypeError, MemoryError):
        raise InputError(f"map {path}: no NumPy file (.npy) of (rows, columns)") from None


def map_bytes(found: FieldMap) -> bytes:
    """The map as a NumPy file."""
    import io

    out = io.BytesIO()
    np.save(out, found.array, allow_pickle=False)
    return out.getvalue()
