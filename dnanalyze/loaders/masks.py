"""Masked pixels: what a mask leaves of a frame.

Rows and columns that are masked for the most part are taken out, as the gaps between the modules
of a detector are, so that nothing counts them. Single masked pixels take the values of another
pixel of their row and colour, the same in every frame: levels, noise, quantiles, tails and counts
of pixels are those of the pixels that are left, in expectation exactly. What depends on the place
of a pixel (neighbours, lines, spectra) meets there a pixel without relation to its surroundings;
where that is more than ``LEAST_PLACED``, the analysis leaves it out (`Sensor.filled`).
"""

from __future__ import annotations

import hashlib
import os
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.checks import MAX_PIXELS, MIN_COLUMNS, MIN_ROWS

GONE = 0.5  # share of a row or column, from which it is taken out
FILLED_SHARE = 0.2  # share of the pixels that may be filled
# A correlation between two pixels, one of which may be filled, is too small by twice this share;
# of a correlation of .1 that is 2e-4, a standard error of 25 million pixels.
LEAST_PLACED = 1e-3
BLOCK = 4  # lines at the largest code side by side: a gap, and no defect
_SEED = 0
MASK_SUFFIXES = (".npy", ".fits", ".fit", ".fts", ".h5", ".hdf5", ".hdf", ".nxs", ".tif", ".tiff",
                 ".png")  # fmt: skip
_NAMED = re.compile(
    r"(?:^|[_. -])(?:bpm|(?:bad|dead|defect)[_ -]?(?:pix(?:el)?s?)?[_ -]?(?:map|mask)?"
    r"|(?:pix(?:el)?[_ -]?)?mask)$",
    re.IGNORECASE,
)


@dataclass(frozen=True, eq=False)
class Mask:
    """What is left of frames of one shape.

    Parameters
    ----------
    rows, columns : ndarray of int
        Rows and columns that are left.
    targets, sources : ndarray of int
        Flat indices, in the frame that is left, of filled pixels and of those they repeat.
    digest : str
        Of all that, by which stored statistics are known.
    """

    rows: np.ndarray = field(repr=False)
    columns: np.ndarray = field(repr=False)
    targets: np.ndarray = field(repr=False)
    sources: np.ndarray = field(repr=False)
    digest: str

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns that are left."""
        return self.rows.size, self.columns.size

    @property
    def filled(self) -> float:
        """Share of the pixels that are filled."""
        return self.targets.size / (self.rows.size * self.columns.size)

    def apply(self, frame: np.ndarray) -> np.ndarray:
        """What is left of a frame of the whole region."""
        out = np.ascontiguousarray(frame[np.ix_(self.rows, self.columns)])
        flat = out.reshape(-1)
        flat[self.targets] = flat[self.sources]
        return out

    def words(self, shape: tuple[int, int], source: str) -> str:
        """A note on what the mask leaves out of frames of a shape."""
        rows, columns = shape[0] - self.rows.size, shape[1] - self.columns.size
        parts = [f"{n} {what}" for n, what in ((rows, "rows"), (columns, "columns")) if n]
        if self.targets.size:
            parts.append(f"{self.targets.size} single pixels ({100 * self.filled:.2g} %)")
        text = f"Masked by {source}: {', '.join(parts) or 'nothing'}."
        if rows or columns:
            text += " Rows and columns that are masked are taken out."
        if self.filled > LEAST_PLACED:
            text += " Neighbours, lines, spectra and shading are not measured."
        return text


def make_mask(masked: np.ndarray, name: str, period: int = 1) -> Mask:
    """The mask of a region.

    Parameters
    ----------
    masked : ndarray of bool
        (rows, columns); True is left out.
    name : str
        For messages.
    period : int
        Of the colour filter: rows and columns are taken out in blocks of it.

    Raises
    ------
    InputError
        Too little is left.
    """
    rows, columns, rest = _whole_lines(masked, period)
    if not _enough(rest):
        raise InputError(
            f"{name}: the mask leaves {int((~masked).sum())} of {masked.size} pixels, too few in "
            f"too few rows and columns; mask less than {100 * FILLED_SHARE:g} % of the pixels, or "
            "choose a part with active_rows and active_columns in the sidecar"
        )
    targets = np.flatnonzero(rest)
    parts = rows, columns, targets, _sources(rest, targets, period, name)
    digest = hashlib.blake2b(digest_size=16)
    for part in parts:
        digest.update(str(part.size).encode() + part.astype(np.int64).tobytes())
    return Mask(*parts, digest.hexdigest())


def leaves_enough(masked: np.ndarray) -> bool:
    """Whether `make_mask` takes this mask of a monochrome region."""
    return _enough(_whole_lines(masked, 1)[2])


def _whole_lines(masked: np.ndarray, period: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows and columns that are left, and the mask on these."""
    rows = _left(masked.mean(axis=1) < GONE, period)
    columns = _left(masked[rows].mean(axis=0) < GONE if rows.size else rows > 0, period)
    return rows, columns, masked[np.ix_(rows, columns)]


def _enough(rest: np.ndarray) -> bool:
    return (
        rest.shape[0] >= MIN_ROWS and rest.shape[1] >= MIN_COLUMNS and rest.mean() <= FILLED_SHARE
    )


def _left(kept: np.ndarray, period: int) -> np.ndarray:
    whole = kept[: kept.size // period * period].reshape(-1, period).all(axis=1)
    return np.flatnonzero(np.repeat(whole, period))


def _sources(rest: np.ndarray, targets: np.ndarray, period: int, name: str) -> np.ndarray:
    """An unmasked pixel of the row and colour of each target, drawn once for all frames."""
    rng = np.random.default_rng(_SEED)
    columns = rest.shape[1]
    out = np.empty_like(targets)
    rows, places = np.divmod(targets, columns)
    for row in np.unique(rows):
        free = np.flatnonzero(~rest[row])
        for phase in range(period):
            own = (rows == row) & (places % period == phase)
            choice = free[free % period == phase]
            if own.any() and not choice.size:
                raise InputError(f"{name}: the mask leaves no pixel of one colour in row {row}")
            if own.any():
                out[own] = row * columns + rng.choice(choice, int(own.sum()))
    return out


def gaps_of(frame: np.ndarray) -> np.ndarray | None:
    """Pixels of a frame that hold a code for "no pixel"; None where there are none.

    The largest and second largest value of 32 bits, -1 and -2 where nothing else is negative (both
    as photon counters write them), and the largest of 8 or 16 bits in whole blocks of rows or
    columns.
    """
    kind, size = frame.dtype.kind, frame.dtype.itemsize
    most = np.iinfo(frame.dtype).max
    if kind == "u" and size >= 4:
        found = frame >= most - 1
    elif kind == "i" and frame.min() in (-1, -2):
        found = frame < 0
    elif kind == "u":
        full = frame == most
        rows, columns = (_block(full.all(axis=1 - axis)) for axis in (0, 1))
        found = rows[:, None] | columns[None, :]
    else:
        return None
    return found if found.any() else None


def _block(lines: np.ndarray) -> np.ndarray:
    """Lines that stand with neighbours in a block of ``BLOCK`` or more."""
    window = np.convolve(lines, np.ones(BLOCK), "valid") >= BLOCK
    out = np.zeros(lines.size, bool)
    for start in np.flatnonzero(window):
        out[start : start + BLOCK] = True
    return out


def is_mask_file(path: Path) -> bool:
    """Whether a file is a mask by its name ("bpm.fits", "darks_bad_pixels.png") and content."""
    if not _NAMED.search(path.stem) or path.suffix.lower() not in MASK_SUFFIXES:
        return False
    try:
        return bool(read_mask(path).mean() < GONE)
    except InputError:
        return False


def read_mask(path: str | os.PathLike[str]) -> np.ndarray:
    """A mask from a file: NumPy, FITS, HDF5, PNG or TIFF; pixels that are not 0 are left out.

    Returns
    -------
    ndarray of bool
        (rows, columns).

    Raises
    ------
    InputError
        No mask of two dimensions.
    """
    file = Path(path)
    kind = file.suffix.lower()
    try:
        if kind == ".npy":
            values = np.load(file, allow_pickle=False, mmap_mode="r")
        elif kind in (".fits", ".fit", ".fts"):
            from astropy.io import fits

            with fits.open(file, memmap=False) as units:
                values = next(u.data for u in units if getattr(u, "data", None) is not None)
        elif kind in (".h5", ".hdf5", ".hdf", ".nxs"):
            values = _of_hdf5(file)
        elif kind in (".tif", ".tiff"):
            import tifffile

            values = tifffile.imread(file)
        elif kind == ".png":
            from PIL import Image

            with Image.open(file) as image:
                values = np.asarray(image)
        else:
            raise InputError(f"{file}: no mask; valid: .npy, .fits, .h5, .png, .tif")
        if values.ndim != 2 or not 0 < values.size <= MAX_PIXELS or values.dtype.kind not in "buif":
            raise InputError(f"{file}: has shape {values.shape}; a mask is (rows, columns) numbers")
        return np.asarray(values) != 0
    except InputError:
        raise
    except Exception as error:  # decoders raise anything; the user needs one line
        text = " ".join(str(error).split())[:120]
        raise InputError(f"{file}: cannot be read as a mask ({text}); store it as .npy") from error


def _of_hdf5(file: Path) -> np.ndarray:
    import h5py

    from dnanalyze.loaders.formats.dataset_names import is_mask

    with h5py.File(file, "r") as content:
        found: list[str] = []
        content.visititems(
            lambda name, item: (
                found.append(name) if isinstance(item, h5py.Dataset) and item.ndim == 2 else None
            )
        )
        named = [n for n in found if is_mask(n)] or found
        if len(named) != 1:
            raise InputError(f"{file}: holds {len(named)} masks; name one pixel_mask, or give .npy")
        return np.asarray(content[named[0]][()])
