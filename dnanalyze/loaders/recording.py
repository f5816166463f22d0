"""What the header of one file says, and how its frames become ``Frame.load``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_pixels, check_range, worth_a_look
from dnanalyze.loaders.masks import Mask
from dnanalyze.loaders.physical import fault

Cfa = tuple[tuple[str, ...], ...]


QUANTITIES = ("temperature_c", "exposure_s", "gain", "channel", "frame", "offset")


@dataclass(frozen=True)
class Doubt:
    """What is doubtful about a value that a source states.

    Parameters
    ----------
    about : str
        One of ``QUANTITIES``.
    kind : str
        Doubts of one kind are told once, with the first text and the number of frames.
    text : str
        A clause that begins with where the value stands, without a full stop.
    """

    about: str
    kind: str
    text: str


@dataclass(frozen=True)
class Metadata:
    """What one source says of one frame; ``None`` is not said.

    Units as in ``OperatingPoint``; ``frame`` orders the frames of a setting; ``offset`` is the
    black level as the camera was set, in its own units. A source may say what
    cannot be (a gain of 0); `plausible` drops it. ``taken`` gives for each quantity the place that
    states it and how, as ("header CCD-TEMP", "'-9,8'").
    """

    temperature_c: float | None = None
    exposure_s: float | None = None
    gain: float | None = None
    channel: str | None = None
    frame: float | None = None
    offset: float | None = field(default=None, compare=False, repr=False)
    taken: Mapping[str, tuple[str, str]] = field(default_factory=dict, compare=False, repr=False)
    doubts: tuple[Doubt, ...] = field(default=(), compare=False, repr=False)

    def or_else(self, other: Metadata) -> Metadata:
        """Field by field, this source's word, or else the other's."""
        mine = {name for name in QUANTITIES if getattr(self, name) is not None}
        values = {n: getattr(self if n in mine else other, n) for n in QUANTITIES}
        taken = {k: v for k, v in other.taken.items() if k not in mine} | dict(self.taken)
        doubts = self.doubts + tuple(d for d in other.doubts if d.about not in mine)
        return Metadata(**values, taken=taken, doubts=doubts)

    def of(self, source: str) -> Metadata:
        """The same, with its source where none is stated yet."""
        known = (name for name in QUANTITIES if getattr(self, name) is not None)
        return replace(self, taken=dict.fromkeys(known, (source, "")) | dict(self.taken))

    def said_by(self, source: str) -> Metadata:
        """The same, "header" in the names of its sources replaced."""
        taken = {k: (where.replace("header", source, 1), how) for k, (where, how)
                 in self.taken.items()}  # fmt: skip
        return replace(self, taken=taken)

    def in_channel(self, channel: str, source: str) -> Metadata:
        """The same frame in a channel, unless it names one itself."""
        return self.or_else(Metadata(channel=channel).of(source))

    def plausible(self) -> tuple[Metadata, tuple[str, ...]]:
        """What of it can be, and what is wrong with the rest.

        Cameras write a gain of 0 for the lowest of their settings: no measurement, and no reason
        to refuse the frame.
        """
        wrong = {name: fault(name, getattr(self, name)) for name in QUANTITIES if name != "channel"}
        bad: dict[str, Any] = {name: None for name, text in wrong.items() if text}
        return (replace(self, **bad) if bad else self), tuple(filter(None, wrong.values()))


@dataclass(frozen=True)
class Area:
    """What part of a readout makes a frame.

    Parameters
    ----------
    active : Window, optional
        Where light falls; None is everywhere.
    masked : Window, optional
        Optical black or overscan.
    again : bool
        Whether another frame has the same readout: one of several amplifiers.
    """

    active: Window | None = None
    masked: Window | None = None
    again: bool = False


@dataclass(frozen=True)
class Recording:
    """One file: its header, and a way to its pixels.

    Parameters
    ----------
    format : str
        Name for people, such as "TIFF".
    shape : tuple of int
        (rows, columns) of the whole readout, masked pixels included.
    dtype : numpy.dtype
        Of the pixels as stored.
    read : callable
        ``read(index, window)``: pixels of frame ``index``, DN; picklable. Its attribute
        ``partial`` is true where it reads a window without decoding the rest.
    frames : tuple of Metadata
        One for each frame in the file.
    active : Window, optional
        Where light falls; None is everywhere.
    masked : Window, optional
        Optical black or overscan.
    areas : tuple of Area
        One for each frame, where they differ; instead of ``active`` and ``masked``.
    cfa : tuple of tuple of str, optional
        Colour filter at the top left of the whole readout.
    bits, black_level, white_level, pixel_pitch_um, system_gain_dn_e
        As in ``Sensor``.
    notes : tuple of str
        What was assumed, one sentence each.
    mask : ndarray of bool, optional
        Pixels of the whole readout that the file leaves out.
    lit : bool
        Whether light fell on the active area, seen against the masked one.
    left_out : str
        Why the file is no dark frame, or "".
    """

    format: str
    shape: tuple[int, int]
    dtype: np.dtype
    read: Callable[[int, Window], np.ndarray]
    frames: tuple[Metadata, ...] = (Metadata(),)
    active: Window | None = None
    masked: Window | None = None
    cfa: Cfa | None = None
    bits: int | None = None
    black_level: float | None = None
    white_level: float | None = None
    pixel_pitch_um: float | None = None
    system_gain_dn_e: float | None = None
    notes: tuple[str, ...] = ()
    mask: np.ndarray | None = None
    lit: bool = False
    left_out: str = ""
    areas: tuple[Area, ...] = ()

    def area(self, index: int) -> Area:
        """The area of frame ``index``."""
        return self.areas[index] if self.areas else Area(self.active, self.masked)


@dataclass(frozen=True)
class FrameReader:
    """``Frame.load`` of one frame of a file: a region of its readout, checked, nothing kept.

    Parameters
    ----------
    name : str
        For messages.
    read : callable
        ``Recording.read``.
    index : int
        Frame in the file.
    region : Window
        Rectangle of the readout that is the frame.
    checked : bool
        Whether ``check_pixels`` applies; a masked strip may well be clipped to one value.
    mask : Mask, optional
        What is left of the region; then the whole region is read whatever the window.
    """

    name: str
    read: Callable[[int, Window], np.ndarray]
    index: int
    region: Window
    checked: bool = True
    mask: Mask | None = None

    @property
    def partial(self) -> bool:
        """Whether a window is read without the rest of the frame; readers say so themselves."""
        return self.mask is None and bool(getattr(self.read, "partial", False))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the frame."""
        return self.region.shape if self.mask is None else self.mask.shape

    def __call__(self, window: Window | None = None) -> np.ndarray:
        """Pixels of ``window`` (None is all), DN: native byte order, C-contiguous, 2-D.

        Raises
        ------
        InputError
            The file cannot be read any more, or ``check_pixels`` refuses it.
        """
        whole = Window.whole(self.shape)
        window = window or whole
        array = self._pixels(window)
        if not self.checked:
            check_range(self.name, array)
            return array
        if window == whole:
            check_pixels(self.name, array)
        else:
            check_range(self.name, array)
            if worth_a_look(array):  # a clipped corner, or an empty frame: the whole decides
                check_pixels(self.name, self._pixels(whole))
        return array

    def _pixels(self, window: Window) -> np.ndarray:
        if self.mask is None:
            return self._stored(window)
        left = self.mask.apply(self._stored(Window.whole(self.region.shape)))
        return np.ascontiguousarray(left[window.slices])

    def _stored(self, window: Window) -> np.ndarray:
        region = self.region
        place = Window(
            region.top + window.top,
            region.top + window.bottom,
            region.left + window.left,
            region.left + window.right,
        )
        try:
            with np.errstate(all="ignore"):  # what overflows is refused when it is checked
                array = self.read(self.index, place)
                if array.dtype.kind == "f" and array.dtype != np.float32:
                    array = array.astype(np.float32)
        except InputError:
            raise
        except MemoryError as error:
            raise InputError(
                f"{self.name}: more to decode than there is free memory; cut it into smaller frames"
            ) from error
        except Exception as error:  # decoders raise anything; the user needs one line
            raise InputError(
                f"{self.name}: cannot be decoded ({one_line(error)}); "
                "copy the file again or leave it out"
            ) from error
        if array.shape != window.shape:
            raise InputError(
                f"{self.name}: decodes to {array.shape} pixels and declares {window.shape}; "
                "copy the file again or leave it out"
            )
        return np.ascontiguousarray(array, array.dtype.newbyteorder("="))


def one_line(error: BaseException) -> str:
    """An exception's text on one line, shortened."""
    parts = [a.decode("utf-8", "replace") if isinstance(a, bytes) else str(a) for a in error.args]
    text = " ".join(" ".join(parts).split()) or type(error).__name__
    return text if len(text) <= 160 else text[:157] + "..."


def shifted_cfa(cfa: Cfa | None, top: int, left: int) -> Cfa | None:
    """The colour filter seen from row ``top``, column ``left`` of where it was stated."""
    if cfa is None:
        return None
    rows, columns = len(cfa), len(cfa[0])
    return tuple(
        tuple(cfa[(top + r) % rows][(left + c) % columns] for c in range(columns))
        for r in range(rows)
    )
