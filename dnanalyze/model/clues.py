"""What an effect may look at to guess its own strength."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.wave import Wave


class MeasuredLines(Protocol):
    """What statistics tell exactly, whatever the model."""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns that the statistics cover: counts are over these, lines this long."""

    def waves(self, part: str) -> Sequence[Wave]:
        """Lines of the "temporal" or "pattern" spectrum, of all settings, at the reference gain."""


class Clues(MeasuredLines, Protocol):
    """Measured and simulated statistics side by side, setting by setting (colour planes pooled).

    Values are in plain units; a statistic that a setting lacks is NaN there.
    """

    @property
    def points(self) -> Sequence[OperatingPoint]:
        """The settings, in the order of every array below."""

    @property
    def reference(self) -> OperatingPoint:
        """Where the model's numbers are stated."""

    @property
    def field(self) -> tuple[int, int]:
        """Full frame."""

    @property
    def area(self) -> Window:
        """The part of it that the curve "block_means" covers: of large sensors a window."""

    def measured(self, name: str) -> np.ndarray:
        """One value a setting."""

    def simulated(self, name: str) -> np.ndarray:
        """The present model's value, one a setting."""

    def z(self, name: str) -> np.ndarray:
        """(measured - simulated) / floor, one a setting."""

    def colours(self, name: str) -> np.ndarray:
        """Measured values and standard errors of the colours of a mosaic of 2 x 2, by row.

        (settings, 4, 2); (0, 4, 2) of frames that are analysed as a whole.
        """

    def lines(self, axis: str, setting: int) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the "columns" or "rows" in the full frame, and their mean in the pattern, DN.

        Over the whole field: lines of the part that the statistics cover come first.
        """

    def defects(self, axis: str) -> np.ndarray:
        """The "columns" or "rows" that stand out of the pattern, over all settings.

        (n, 4): number in the full frame, offset in DN at the reference gain, and along it the
        pixels where the offset begins, and after its end.
        """

    def curve(self, name: str, setting: int) -> np.ndarray:
        """A measured curve or map by name (histogram, line profile, block means, ...)."""

    def modelled_curve(self, name: str, setting: int) -> np.ndarray:
        """The same of a simulated sensor; empty where it has none."""
