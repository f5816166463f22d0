"""What a capture folder is once its headers are read: settings, each with its lazy frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from html import escape
from types import NoneType
from typing import TYPE_CHECKING

import numpy as np

from dnanalyze.digits import number
from dnanalyze.errors import InputError
from dnanalyze.loaders.physical import RANGES, fault

if TYPE_CHECKING:
    from os import PathLike
    from pathlib import Path

    import pandas as pd

    from dnanalyze.loaders.provenance import Taken


@dataclass(frozen=True)
class OperatingPoint:
    """Where the sensor was operated; ``None`` is unknown.

    Raises ``InputError`` for what cannot be (see ``loaders.physical``).

    Parameters
    ----------
    temperature_c : float, optional
        Sensor temperature, C.
    exposure_s : float, optional
        Integration time, s.
    gain : float, optional
        Analogue gain as recorded (a linear factor unless the capture says otherwise).
    channel : str, optional
        HDR readout channel (hcg, lcg, long, short, lofic, ...).
    """

    temperature_c: float | None = None
    exposure_s: float | None = None
    gain: float | None = None
    channel: str | None = None

    def __post_init__(self) -> None:
        for name in RANGES:
            value = getattr(self, name)
            if wrong := fault(name, value):
                raise InputError(wrong)
            if value is not None:  # of equal points the repr is one, by which their noise is drawn
                object.__setattr__(self, name, float(value) + 0.0)
        if not isinstance(self.channel, (str, NoneType)):
            raise InputError(f"channel {str(self.channel)[:40]!r} is no text; quote it")

    def label(self, digits: int = 3) -> str:
        """Return short text for tables and figures.

        Parameters
        ----------
        digits : int
            Significant digits of the numbers.

        Returns
        -------
        str
            Such as ``65 °C, 0.05 s``.

        Examples
        --------
        >>> from dnanalyze import OperatingPoint
        >>> OperatingPoint(65.0, 0.05).label()
        '65 °C, 0.05 s'
        """
        parts = []
        if self.channel is not None:
            parts.append(self.channel)
        if self.temperature_c is not None:
            parts.append(f"{number(self.temperature_c, digits)} °C")
        if self.exposure_s is not None:
            parts.append(f"{number(self.exposure_s, digits)} s")
        if self.gain is not None:
            parts.append(f"gain {number(self.gain, digits)}")
        return ", ".join(parts) or "one operating point"

    def exposure_over(self, reference: OperatingPoint) -> float:
        """Return the exposure over that of another point.

        Parameters
        ----------
        reference : OperatingPoint
            The other point.

        Returns
        -------
        float
            The ratio; 1 where either exposure is unknown.
        """
        here, there = self.exposure_s, reference.exposure_s
        return here / there if here is not None and there else 1.0

    def gain_over(self, reference: OperatingPoint) -> float:
        """Return the analogue gain over that of another point.

        Parameters
        ----------
        reference : OperatingPoint
            The other point.

        Returns
        -------
        float
            The ratio; 1 where either gain is unknown.
        """
        return self.gain / reference.gain if self.gain and reference.gain else 1.0

    def warmer(self, by_c: float) -> OperatingPoint:
        """Return the point so many degrees warmer.

        Parameters
        ----------
        by_c : float
            Difference, C.

        Returns
        -------
        OperatingPoint
            The warmer point; itself where its temperature is unknown.
        """
        if self.temperature_c is None or not by_c:
            return self
        return replace(self, temperature_c=self.temperature_c + by_c)

    def sort_key(self) -> tuple[str, float, float, float]:
        """Return what operating points are sorted by: channel, temperature, exposure, gain.

        Returns
        -------
        tuple
            Unknown values come first.
        """
        low = float("-inf")
        return (
            self.channel or "",
            low if self.temperature_c is None else self.temperature_c,
            low if self.exposure_s is None else self.exposure_s,
            low if self.gain is None else self.gain,
        )


@dataclass(frozen=True)
class Window:
    """A rectangle: rows ``top`` to ``bottom``, columns ``left`` to ``right`` (half open).

    Parameters
    ----------
    top : int
        First row.
    bottom : int
        Row behind the last.
    left : int
        First column.
    right : int
        Column behind the last.
    """

    top: int
    bottom: int
    left: int
    right: int

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.bottom - self.top, self.right - self.left

    @property
    def slices(self) -> tuple[slice, slice]:
        """Index of this rectangle in a full frame."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    def grown(self, reach: int, shape: tuple[int, int]) -> Window:
        """Return this rectangle with more pixels on every side.

        Parameters
        ----------
        reach : int
            Pixels.
        shape : tuple of int
            Full frame, (rows, columns), which it stays inside.

        Returns
        -------
        Window
            The larger rectangle.
        """
        return Window(
            max(0, self.top - reach),
            min(shape[0], self.bottom + reach),
            max(0, self.left - reach),
            min(shape[1], self.right + reach),
        )

    def within(self, outer: Window) -> tuple[slice, slice]:
        """Return the index of this rectangle in an array that covers another.

        Parameters
        ----------
        outer : Window
            What the array covers.

        Returns
        -------
        tuple of slice
            (rows, columns).
        """
        return (
            slice(self.top - outer.top, self.bottom - outer.top),
            slice(self.left - outer.left, self.right - outer.left),
        )

    @classmethod
    def whole(cls, shape: tuple[int, int]) -> Window:
        """Return the full frame.

        Parameters
        ----------
        shape : tuple of int
            (rows, columns).

        Returns
        -------
        Window
            The rectangle of the frame.
        """
        return cls(0, shape[0], 0, shape[1])


@dataclass(frozen=True)
class Frame:
    """One dark frame, read when asked for.

    ``load(window)`` returns the pixels of ``window`` (the whole active area for ``None``) as a
    C-contiguous 2-D array, integer as recorded or float32, in DN. Nothing is kept between calls.
    ``masked()``, where the file knows them, returns the masked (optical black or overscan) pixels
    of the same exposure, 2-D, in DN.
    """

    name: str
    point: OperatingPoint
    load: Callable[[Window | None], np.ndarray]
    masked: Callable[[], np.ndarray] | None = None

    def read(self, window: Window | None = None) -> np.ndarray:
        """Pixels of ``window``, or of the whole active area."""
        return self.load(window)


@dataclass(frozen=True)
class Setting:
    """Frames that share one operating point, in the order in which they were taken.

    ``black_level`` is what their files state, DN.
    """

    point: OperatingPoint
    frames: tuple[Frame, ...]
    black_level: float | None = None


@dataclass(frozen=True)
class Sensor:
    """What the files tell of the sensor itself; ``None`` is unknown.

    Parameters
    ----------
    shape : tuple of int
        Active area, (rows, columns).
    bits : int, optional
        Bits of the converter.
    black_level, white_level : float, optional
        DN; the black level where all operating points have one.
    cfa : tuple of tuple of str, optional
        Colour filter of the top-left block of the active area, such as (("R","G"),("G","B")).
    pixel_pitch_um : float, optional
        Micrometres.
    system_gain_dn_e : float, optional
        Overall system gain K of EMVA 1288, DN/e-, as recorded.
    black_levels : tuple of (OperatingPoint, float)
        Black level of each operating point, DN, where they differ.
    filled : float
        Share of the pixels that a mask leaves out and that repeat others (`loaders.masks`).
    """

    shape: tuple[int, int]
    bits: int | None = None
    black_level: float | None = None
    white_level: float | None = None
    cfa: tuple[tuple[str, ...], ...] | None = None
    pixel_pitch_um: float | None = None
    system_gain_dn_e: float | None = None
    black_levels: tuple[tuple[OperatingPoint, float], ...] = ()
    filled: float = 0.0

    def black_level_at(self, points: Iterable[OperatingPoint]) -> float | None:
        """Return the black level that some operating points share.

        Parameters
        ----------
        points : iterable of OperatingPoint
            The points.

        Returns
        -------
        float or None
            DN; None where it is not known, or not the same for all.
        """
        if not self.black_levels:
            return self.black_level
        known = dict(self.black_levels)
        found = {known.get(point) for point in points}
        return found.pop() if len(found) == 1 else None


@dataclass(frozen=True)
class Source:
    """How a capture set was read; a simulation has none.

    Parameters
    ----------
    formats : tuple of str
        Names of the file formats.
    dtype : str
        Type of the stored pixels, such as "uint16".
    tolerance_c : float
        Span of temperatures within one setting, C.
    region : str
        "active", "masked" or "all" of the readout.
    cache : str, optional
        Folder in which statistics of these frames are kept; not part of what they are.
    taken : tuple of Taken
        Where the metadata were taken from.
    """

    formats: tuple[str, ...]
    dtype: str
    tolerance_c: float
    region: str = "active"
    cache: str | None = field(default=None, compare=False)
    taken: tuple[Taken, ...] = field(default=(), compare=False)


@dataclass(frozen=True, repr=False)
class CaptureSet:
    """Dark frames of one sensor, measured or simulated, grouped by operating point.

    Parameters
    ----------
    name : str
        The folder, or what was simulated.
    sensor : Sensor
        What is common to all frames.
    settings : tuple of Setting
        Sorted by operating point.
    notes : tuple of str
        What the loader had to assume or leave out, one sentence each.
    source : Source, optional
        How it was read from files.
    """

    name: str
    sensor: Sensor
    settings: tuple[Setting, ...]
    notes: tuple[str, ...] = field(default=())
    source: Source | None = None

    @property
    def frame_count(self) -> int:
        """Frames over all settings."""
        return sum(len(s.frames) for s in self.settings)

    def frames(self) -> Iterator[Frame]:
        """Iterate over every frame, operating point by operating point.

        Yields
        ------
        Frame
            The next frame.
        """
        for setting in self.settings:
            yield from setting.frames

    def select(self, keep: Callable[[OperatingPoint], bool]) -> CaptureSet:
        """Return the captures at some operating points.

        Parameters
        ----------
        keep : callable
            Called with an operating point; True keeps it.

        Returns
        -------
        CaptureSet
            The captures that are kept.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> captures = tiny()
        >>> warm = captures.select(lambda point: point.temperature_c > 40.0)
        >>> len(warm.settings)
        2
        """
        return replace(self, settings=tuple(s for s in self.settings if keep(s.point)))

    def to_numpy(self) -> dict[OperatingPoint, np.ndarray]:
        """Read every frame.

        Returns
        -------
        dict
            Operating point to its frames, (frames, rows, columns), DN.

        Examples
        --------
        >>> from dnanalyze.demo import tiny
        >>> [stack.shape for stack in tiny().to_numpy().values()]
        [(3, 64, 64), (3, 64, 64), (3, 64, 64)]
        """
        return {s.point: np.stack([f.read() for f in s.frames]) for s in self.settings}

    def to_dataframe(self) -> pd.DataFrame:
        """List the operating points.

        Returns
        -------
        pandas.DataFrame
            One row an operating point, with its number of frames.

        Examples
        --------
        >>> from dnanalyze.demo import tiny
        >>> tiny().to_dataframe()["frames"].tolist()
        [3, 3, 3]
        """
        import pandas as pd

        return pd.DataFrame([vars(s.point) | {"frames": len(s.frames)} for s in self.settings])

    def save(
        self, folder: str | PathLike[str], format: str = "tif", *, bits: int | None = None
    ) -> Path:
        """Write every frame to a new folder, with a manifest, as `load` reads it.

        Parameters
        ----------
        folder : str or PathLike
            Folder to make.
        format : str
            "tif", "fits", "npy", "h5", "png", "pgm", or "raw10", "raw12-mipi" and the like.
        bits : int, optional
            Bits of a pixel, up to 16, to which values are rounded and clipped; by default those of
            the sensor, or 16.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        InputError
            Unknown format or bits, or a folder that holds a capture already or cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     dnanalyze.load(tiny().save(f"{folder}/darks", "npy")).frame_count
        9
        """
        from dnanalyze.loaders.writers import write_captures

        return write_captures(self, folder, format, bits=bits)

    def __repr__(self) -> str:
        """The captures in a line."""
        (rows, columns), points = self.sensor.shape, len(self.settings)
        return (
            f"<CaptureSet: {self.name}, {self.frame_count} frames of {rows} x {columns} at "
            f"{points} operating point{'' if points == 1 else 's'}>"
        )

    def _repr_html_(self) -> str:
        """The operating points and notes, for a notebook."""
        notes = "".join(f"<li>{escape(note)}</li>" for note in self.notes)
        table = self.to_dataframe().to_html(index=False, na_rep="")
        return f"<p>{escape(repr(self)[1:-1])}</p>{table}<ul>{notes}</ul>"

    @property
    def channels(self) -> list[str]:
        """HDR readout channels, in order; empty where the operating points name none."""
        names = dict.fromkeys(s.point.channel for s in self.settings)
        return [n for n in names if n is not None]

    def channel(self, name: str) -> CaptureSet:
        """Return the captures of one HDR readout channel.

        Parameters
        ----------
        name : str
            Channel.

        Returns
        -------
        CaptureSet
            The frames of that channel.

        Raises
        ------
        InputError
            No frames of that channel; the line gives those that there are.
        """
        if name not in self.channels:
            valid = (
                f"valid: {', '.join(self.channels)}"
                if self.channels
                else ("its frames name none; the column 'channel' of manifest.csv does")
            )
            raise InputError(f"{self.name}: no channel {name!r}; {valid}")
        return self.select(lambda point: point.channel == name)

    def cached(self, folder: str | None) -> CaptureSet:
        """Return the same captures, with a folder in which their statistics are stored.

        Parameters
        ----------
        folder : str or None
            The folder; None stores none.

        Returns
        -------
        CaptureSet
            The same frames.
        """
        if self.source is None:
            return self
        return replace(self, source=replace(self.source, cache=folder))
