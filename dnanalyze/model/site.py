"""Where and when an effect acts: place, operating point, frame, and its random numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.streams import Stream
from dnanalyze.thermal import arrhenius


def _not_kept(name: str, make: Callable[[], Any]) -> Any:
    return make()


def _no_calibration(number: int, warmer: float = 0.0) -> np.ndarray:
    raise NotImplementedError("this site has no frames before the effect")


@dataclass(frozen=True)
class Site:
    """Where and when an effect acts, and its random numbers.

    Parameters
    ----------
    shape : tuple of int
        Full frame, (rows, columns).
    window : Window
        The part of it that the signal covers.
    point, reference : OperatingPoint
        Here, and where the model's numbers are stated.
    frame : int
        Number of the frame in its setting, from 0.
    fixed_stream, frame_stream : Stream
        Random numbers of this effect: the same in every frame of every setting, and new in each
        frame.
    keep : callable
        ``keep(name, make)`` returns ``make()`` and caches it for the frames of this operating
        point.
    field : callable
        ``field(stream, kind)`` draws "normal" or "uniform" over ``window``.
    calibration : callable
        ``calibration(n, warmer)`` is frame n, whole, so many C warmer than the reference point,
        before this effect: a calibration frame of the same sensor. Negative n are frames of no
        capture.
    share : callable
        As ``keep``, for what does not depend on the window: all parts of the frame get the same.
    dn_per_e : float, optional
        Conversion gain of the model's `dark_shot_noise` here, DN/e-; None where it counts none.
    shared : tuple of int
        Rows and columns of the pixels that share an amplifier, by the model's `read_noise`.
    """

    shape: tuple[int, int]
    window: Window
    point: OperatingPoint
    reference: OperatingPoint
    frame: int
    fixed_stream: Stream
    frame_stream: Stream
    keep: Callable[[str, Callable[[], Any]], Any]
    field: Callable[[Stream, str], np.ndarray]
    calibration: Callable[[int, float], np.ndarray] = _no_calibration
    share: Callable[[str, Callable[[], Any]], Any] = _not_kept
    dn_per_e: float | None = None
    shared: tuple[int, int] = (1, 1)

    @property
    def silicon(self) -> Stream:
        """`fixed_stream`, by the name of effects written before."""
        return self.fixed_stream

    @property
    def moment(self) -> Stream:
        """`frame_stream`, by the name of effects written before."""
        return self.frame_stream

    def fixed_normal(self, name: str = "") -> np.ndarray:
        """Standard normal field of the silicon over the window, float32.

        Parameters
        ----------
        name : str
            Another name is another field.

        Returns
        -------
        ndarray
            (rows, columns), float32.
        """
        return self.field(self.fixed_stream.child(name), "normal")

    def fixed_uniform(self, name: str = "") -> np.ndarray:
        """Uniform field of the silicon over the window, float32.

        Parameters
        ----------
        name : str
            Another name is another field.

        Returns
        -------
        ndarray
            (rows, columns), float32.
        """
        return self.field(self.fixed_stream.child(name), "uniform")

    def amplifiers(self, kind: str, name: str = "") -> np.ndarray:
        """Field of the silicon with a number for each amplifier, float32.

        Parameters
        ----------
        kind : str
            "normal" or "uniform".
        name : str
            Another name is another field.

        Returns
        -------
        ndarray
            (rows, columns), float32; the same for pixels that share an amplifier.
        """
        stream, window = self.fixed_stream.child(name), self.window
        if self.shared == (1, 1):
            return self.field(stream, kind)
        down, across = self.shared
        top, left = window.top // down, window.left // across
        few = Window(top, -(-window.bottom // down), left, -(-window.right // across))
        each: np.ndarray = getattr(stream, kind)(few, self._amplifiers_across)
        every = each.repeat(down, axis=0).repeat(across, axis=1)
        return every[
            window.top - top * down : window.bottom - top * down,
            window.left - left * across : window.right - left * across,
        ]

    def amplifier_at(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Index of the amplifier of pixels; that of the pixel itself where none is shared.

        Parameters
        ----------
        rows : ndarray of int
            Of the pixels in the full frame.
        columns : ndarray of int
            As many.

        Returns
        -------
        ndarray of int
            Row x width + column, both in units of the groups that share an amplifier.
        """
        down, across = self.shared
        return rows // down * self._amplifiers_across + columns // across

    @property
    def _amplifiers_across(self) -> int:
        return -(-self.shape[1] // self.shared[1])

    def normal(self, name: str = "") -> np.ndarray:
        """Standard normal field of this frame over the window, float32.

        Parameters
        ----------
        name : str
            Another name is another field.

        Returns
        -------
        ndarray
            (rows, columns), float32.
        """
        return self.field(self.frame_stream.child(name), "normal")

    def uniform(self, name: str = "") -> np.ndarray:
        """Uniform field of this frame over the window, float32.

        Parameters
        ----------
        name : str
            Another name is another field.

        Returns
        -------
        ndarray
            (rows, columns), float32.
        """
        return self.field(self.frame_stream.child(name), "uniform")

    def columns(self, stream: Stream) -> np.ndarray:
        """One standard normal a column of the window, float32.

        Parameters
        ----------
        stream : Stream
            Random numbers of the silicon or of the frame.

        Returns
        -------
        ndarray
            (columns,), float32.
        """
        line = Window(0, 1, self.window.left, self.window.right)
        return stream.normal(line, self.shape[1])[0]

    def rows(self, stream: Stream) -> np.ndarray:
        """One standard normal a row of the window, float32.

        Parameters
        ----------
        stream : Stream
            Random numbers of the silicon or of the frame.

        Returns
        -------
        ndarray
            (rows,), float32.
        """
        line = Window(0, 1, self.window.top, self.window.bottom)
        return stream.normal(line, self.shape[0])[0]

    @property
    def row_index(self) -> np.ndarray:
        """Row number in the full frame of each row of the window."""
        return np.arange(self.window.top, self.window.bottom)

    @property
    def column_index(self) -> np.ndarray:
        """Column number in the full frame of each column of the window."""
        return np.arange(self.window.left, self.window.right)

    @property
    def exposure_ratio(self) -> float:
        """Exposure over the reference exposure; 1 where either is unknown."""
        return self.point.exposure_over(self.reference)

    @property
    def gain_ratio(self) -> float:
        """Analogue gain over the reference gain; 1 where either is unknown."""
        return self.point.gain_over(self.reference)

    def thermal(self, ea_ev: float) -> float:
        """Return the Arrhenius growth from the reference temperature to here.

        Parameters
        ----------
        ea_ev : float
            Activation energy, eV.

        Returns
        -------
        float
            Factor; 1 where a temperature is unknown.
        """
        return arrhenius(self.point.temperature_c, self.reference.temperature_c, ea_ev)
