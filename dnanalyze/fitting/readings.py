"""Statistics of a capture set as arrays over its operating points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.wave import Wave

MOSAIC = 2  # rows and columns of a block of colours
SHARED = ("", "rows", "columns")  # by a line, as in `analyzers.spectra.lines.Line.axis`
SINGLE = "frame"  # what a frame alone shows, of the names of statistics and curves
CHANCE = 0.1  # c/px; the frequency of a peak that chance made is told no better


@dataclass(frozen=True)
class Readings:
    """Values by name, one per setting; the colour planes of a setting are averaged.

    Parameters
    ----------
    statistics : Statistics
    """

    statistics: Statistics

    @cached_property
    def points(self) -> list[OperatingPoint]:
        """Operating points in order."""
        return list(dict.fromkeys(s.point for s in self.statistics.settings))

    @cached_property
    def planes(self) -> list[list[SettingStatistics]]:
        """The colour planes of each point."""
        return [[s for s in self.statistics.settings if s.point == p] for p in self.points]

    @cached_property
    def frames(self) -> np.ndarray:
        """Frames of each point."""
        return np.array([p[0].frames for p in self.planes])

    def value(self, name: str) -> np.ndarray:
        """A statistic over the points; NaN where a point lacks it."""
        return self._means(name, "value")

    def error(self, name: str) -> np.ndarray:
        """Its standard error over the points."""
        return self._means(name, "se")

    def _means(self, name: str, of: str) -> np.ndarray:
        seen = ([getattr(s.values[name], of) for s in p if name in s.values] for p in self.planes)
        return np.array([np.mean(values) if values else np.nan for values in seen])

    @property
    def noise(self) -> np.ndarray:
        """Noise of a pixel, DN: in time, or within a frame where a point has one alone.

        Steps and shading widen the distribution of a frame; its power at high frequency has none.
        """
        steady, core = self.value("temporal_noise_core"), self.value("frame_noise_core")
        within = np.fmin(core, np.sqrt(self.value("frame_psd_0.35_0.5")))
        return np.where(np.isfinite(steady), steady, within)

    def curve(self, name: str, setting: int) -> np.ndarray:
        """A curve of one point; empty where it lacks it (first colour plane)."""
        return self.planes[setting][0].curves.get(name, np.empty(0))

    def lines(self, axis: str, setting: int) -> np.ndarray:
        """Means of the "columns" or "rows" of one point; those of a mosaic are interleaved.

        Of each colour about its own mean. Empty where the point lacks them.
        """
        seen = [p.curves.get(f"{axis[:-1]}_mean", np.empty(0)) for p in self.planes[setting]]
        if len(seen) == 1:
            return seen[0]
        grid = np.array(seen).reshape(MOSAIC, MOSAIC, -1)  # row and column in the block
        return np.asarray(grid.mean(axis=0 if axis == "columns" else 1).T.ravel())

    def waves(self, part: str, setting: int) -> list[Wave]:
        """Significant lines of the "temporal" or "pattern" spectrum, DN as recorded.

        Of single frames alone those of the frame, which may be of either.
        A colour of a mosaic sees every second pixel: of the frequencies in the frame that look
        alike to it, the lowest.
        """
        planes = self.planes[setting]
        part = SINGLE if (self.frames == 1).all() else part
        scale = 1.0 if len(planes) == 1 else 1.0 / MOSAIC
        rows = [row for p in planes for row in p.curves.get(f"{part}_lines", np.empty((0, 7)))]
        return [_wave(row.tolist(), scale) for row in rows if row[2] <= CHANCE]

    def defects(self, axis: str, setting: int) -> np.ndarray:
        """The "columns" or "rows" of one point that deviate, (n, 4), as `line_defects` has them.

        Places are in the part of the frame that the statistics cover, also those of a mosaic.
        """
        found, planes = [np.empty((0, 4))], self.planes[setting]
        for number, plane in enumerate(planes):
            seen = plane.curves.get(f"{axis[:-1]}_defects", np.empty((0, 4))).copy()
            if len(planes) > 1:
                place = np.divmod(number, MOSAIC)[1 if axis == "columns" else 0]
                seen[:, 0] = MOSAIC * seen[:, 0] + place
                seen[:, 2:] *= MOSAIC
            found.append(seen)
        return np.concatenate(found)


def _wave(row: list[float], scale: float) -> Wave:
    """A line of a spectrum, its frequencies times ``scale``."""
    u, v, u_error, v_error = (scale * number for number in row[:4])
    return Wave(u, v, u_error, v_error, row[4], row[5], SHARED[int(row[6])])
