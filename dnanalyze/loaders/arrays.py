"""Arrays in memory to a ``CaptureSet``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Source, Window
from dnanalyze.loaders.checks import check_count, check_shape
from dnanalyze.loaders.grouping import group
from dnanalyze.loaders.headers import as_bias, from_header, image_type
from dnanalyze.loaders.health import examined
from dnanalyze.loaders.recording import FrameReader


def from_arrays(
    frames: Mapping[OperatingPoint, Any] | Iterable[Any],
    *,
    name: str = "arrays",
    bits: int | None = None,
    black_level: float | None = None,
    cfa: Sequence[Sequence[str]] | None = None,
    system_gain: float | None = None,
    keep_outliers: bool = False,
) -> CaptureSet:
    """Take dark frames from arrays in memory.

    Identical frames of an operating point count once, and a frame unlike the others of its
    operating point is left out, as in `load`; the notes tell them.

    Parameters
    ----------
    frames : mapping, or iterable
        Operating point to its frames, DN: an array (frames, rows, columns), one frame (rows,
        columns), or several frames. A frame is whatever NumPy makes an array of: an ndarray, an
        xarray.DataArray, an astropy CCDData. Without a mapping, frames whose ``header`` states
        temperature and exposure, such as CCDData.
    name : str
        Name of the captures.
    bits : int, optional
        Bits of the converter.
    black_level : float, optional
        DN.
    cfa : sequence of sequence of str, optional
        Colour filter of the top-left block, such as ("RG", "GB").
    system_gain : float, optional
        Overall system gain K, DN/e-, where it is known.
    keep_outliers : bool
        Keep frames that are unlike the others of their operating point.

    Returns
    -------
    CaptureSet
        The frames. The arrays are not copied; they must not be changed while it is in use.

    Raises
    ------
    InputError
        No frames; frames of different shapes, too small, or no numbers; a frame without a header
        and without an operating point.

    Examples
    --------
    >>> import numpy as np
    >>> import dnanalyze
    >>> from dnanalyze import OperatingPoint
    >>> stack = np.random.default_rng(1).normal(64.0, 2.0, (4, 64, 64)).round()
    >>> dnanalyze.from_arrays({OperatingPoint(25.0, 0.05): stack}, bits=12).frame_count
    4
    """
    pairs = _pairs(frames)
    check_count(name, len(pairs))
    arrays = [_pixels(f"{name}[{n}]", frame) for n, (_, frame) in enumerate(pairs)]
    shape = arrays[0].shape
    for number, array in enumerate(arrays):
        if array.shape != shape:
            raise InputError(
                f"{name}[{number}]: has {array.shape} pixels, the first frame {shape}; all frames "
                "need one shape"
            )
    filters = None if cfa is None else tuple(tuple(row) for row in cfa)
    check_shape(name, shape, mosaic=filters is not None)
    read, whole = _Arrays(arrays), Window.whole(shape)
    made = [
        Frame(label := f"{name}[{n}]", point, FrameReader(label, read, n, whole))
        for n, (point, _) in enumerate(pairs)
    ]
    settings, notes = examined(
        group([(frame, None) for frame in made]), keep_outliers, black_level is not None
    )
    sensor = Sensor(shape, bits, black_level, None, filters, None, system_gain)
    return CaptureSet(name, sensor, settings, notes, Source(("array",), str(arrays[0].dtype), 0.0))


@dataclass(frozen=True)
class _Arrays:
    """Reads arrays as the files of one folder are read: (number, window) to pixels."""

    arrays: Sequence[np.ndarray]
    partial: bool = True

    def __call__(self, index: int, window: Window) -> np.ndarray:
        part = self.arrays[index][window.slices]
        return np.array(part, part.dtype if part.dtype.kind in "ui" else np.float32, order="C")


def _pixels(name: str, frame: Any) -> np.ndarray:
    mask = getattr(frame, "mask", None)
    if mask is not None and np.any(mask):
        raise InputError(f"{name}: has masked pixels; give whole frames without a mask")
    array = np.asarray(frame.data if hasattr(frame, "header") else frame)
    if array.ndim != 2 or array.dtype.kind not in "uif":
        raise InputError(
            f"{name}: has {array.ndim} axes of {array.dtype}; a frame has rows and columns of "
            "integers or floats"
        )
    return array.astype(array.dtype.newbyteorder("="), copy=False)


def _pairs(
    frames: Mapping[OperatingPoint, Any] | Iterable[Any],
) -> list[tuple[OperatingPoint, Any]]:
    """Each frame with its operating point."""
    if not isinstance(frames, Mapping):
        return [(_stated(f, n), f) for n, f in enumerate(frames)]
    made = []
    for point, several in frames.items():
        if not isinstance(point, OperatingPoint):
            raise InputError(f"{str(point)[:40]!r}: is no OperatingPoint, such as (25.0, 0.05)")
        single = getattr(several, "ndim", 3) == 2
        made += [(point, frame) for frame in ([several] if single else several)]
    return made


def _stated(frame: Any, number: int) -> OperatingPoint:
    """The operating point of a frame's own header."""
    header = getattr(frame, "header", None)
    if header is None or not hasattr(header, "items"):
        raise InputError(
            f"frame {number}: has no header; give a mapping of operating points to frames"
        )
    values = dict(header.items())
    comments = getattr(header, "comments", None)
    said = from_header(values, {k: str(comments[k]) for k in values} if comments else {})
    said = as_bias(said) if image_type(values) == "bias" else said
    return OperatingPoint(said.temperature_c, said.exposure_s, said.gain, said.channel)
