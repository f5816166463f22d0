"""Offsets of the parallel outputs (taps) over which a frame is read."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Site, Stage, choice, parameter
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect


@dataclass(frozen=True)
class ColumnTaps(ReadoutEffect):
    """y += o_t, t = j mod P or one strip of several; the rms over the taps is exact.

    Of columns j, or of rows. Strips are equal, or begin where `begins` says; the rms is then over
    the lines.
    """

    name: ClassVar[str] = "column_taps"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "Odd and even columns or rows, or whole strips, at different levels."
    physics: ClassVar[str] = (
        "Fast sensors read over several outputs at once. Interleaved outputs take every P-th "
        "column, often the odd ones at the top and the even ones at the bottom of the chip, or "
        "every second row (`axis`), as column converters that read two rows at a time do; others "
        "take a strip of the frame each. Each output has its own offset: a pattern of exact "
        "period P, with lines at u = n/P of the spectrum (v = n/P for rows), or steps at the "
        "seams. It is the same in every frame, independent of exposure, follows the analog gain "
        "and drifts slowly with the temperature of the electronics. A sequencer that is not "
        "locked to the frame sometimes starts at another tap, and the pattern shifts by whole "
        "columns (`slip`). The amplifiers of a CCD may read parts of unequal width (`begins`), "
        "and the level may settle exponentially beside an edge, as the video chain does after a "
        "step (`settle`). Remedy: subtract each tap's own black level, taken from its optically "
        "black pixels."
    )
    formula: ClassVar[str] = (
        "y_ij += o_((j + n slip) mod P), n the frame,  or  o_floor(j P / columns), or the same of "
        "rows i;  mean o = 0, mean o^2 = sigma^2;  or o_s, s the strip with begin_s <= j < "
        "begin_(s+1), mean and mean square over the lines, with "
        "s_e (o_(s-1) - o_s) e^(-(j - begin_s)/l) after an edge and "
        "s_e (o_(s+1) - o_s) e^(-(begin_(s+1) - 1 - j)/l) before one"
    )
    references: ClassVar[tuple[str, ...]] = ("EMVA 1288 release 4.0 (horizontal spectrogram)",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "column_periodic_2", "column_periodic_4", "column_taps_2", "column_taps_4",
        "column_periodic_8", "column_taps_8", "column_periodic_3", "row_periodic_2",
        "pattern_nyquist_10", "pattern_columns_0.3_0.5",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "column_fpn": "power at all frequencies of the v = 0 axis, no period",
        "cfa_mismatch": "also differs from row to row: a line at (1/2,1/2) or (0,1/2)",
        "periodic_pattern": "a single sine whose frequency is no exact fraction n/P",
        "dark_gradient": "smooth, grows with exposure; strips have sharp seams",
        "row_fpn": "every row has an offset of its own, not whole strips of rows",
    }

    sigma: float = parameter(0.5, "DN", 1e-4, 1e3, "rms of the offsets over the taps")
    kind: str = choice("interleaved", "how lines belong to taps", "interleaved", "blocks")
    taps: int = choice(2, "number of taps P", 2, 3, 4, 8, 16)
    levels: tuple[float, ...] = choice(
        (), "levels of the taps in proportion, as measured; drawn at random where there are none"
    )
    slip: float = parameter(
        0.0, "line", 0.0, 15.0, "shift of interleaved taps from frame to frame", "held"
    )
    begins: tuple[float, ...] = choice(
        (), "line at which each strip after the first begins, as measured; equal strips where none"
    )
    axis: str = choice("columns", "lines that belong to taps", "columns", "rows")
    settle: float = parameter(
        0.0, "1", -1.0, 1.0, "share s_e of the step left beside an edge of unequal strips", "linear"
    )
    length: float = parameter(8.0, "line", 0.3, 1e3, "lines l over which it settles by e")
    side: str = choice("after", "side of an edge that settles", "after", "before", "both")
    added: str = choice("before", ADDED, "before", "after")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.begins and (
            self.kind != "blocks" or self.begins[0] < 1 or not _rising(self.begins)
        ):
            raise InputError(
                f"column_taps.begins: {list(self.begins)} of kind {self.kind!r}; give rising "
                "numbers of lines from 1 on, and kind blocks"
            )
        strips = len(self.begins) + 1 if self.begins else self.taps
        if self.levels and (len(self.levels) != strips or np.ptp(self.levels) == 0):
            raise InputError(
                f"column_taps.levels: {len(self.levels)} numbers for {strips} taps; "
                "give one a tap, not all alike, or none"
            )

    def inactive_parameters(self) -> tuple[str, ...]:
        """The settling where there is none."""
        return () if self.begins and self.settle != 0.0 else ("settle", "length")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offset of its tap to every line."""
        size = np.float32(self.value("sigma", site.point) * self.amplified(site))
        along_rows = self.axis == "rows"
        lines, line = (
            (site.shape[0], site.row_index) if along_rows else (site.shape[1], site.column_index)
        )
        if self.begins:
            levels = self._levels(site, len(self.begins) + 1)
            offsets = self._strips(levels, lines, site.point)[line]
        else:
            offsets = self._equal(site, lines, line)
        signal += size * (offsets[:, None] if along_rows else offsets)
        return signal

    def black_shift(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> float:
        """Median offset of the lines, where their levels are stated: unequal strips have mean 0."""
        if not self.levels:
            return 0.0
        lines = shape[0 if self.axis == "rows" else 1]
        level = np.asarray(self.levels, float)
        if self.begins:
            offsets = self._strips(level, lines, point)
        else:
            offsets = _unit(level)
        size = self.value("sigma", point) * self.amplification(point, reference)
        return size * float(np.median(offsets))

    def _equal(self, site: Site, lines: int, line: np.ndarray) -> np.ndarray:
        """Offsets of some lines, of taps that take as many each; mean 0 and rms 1."""
        offsets = _unit(self._levels(site, self.taps))
        if self.kind == "interleaved":
            slip = round(self.value("slip", site.point))
            return np.asarray(offsets[(line + site.frame * slip) % self.taps])
        return np.asarray(offsets[line * self.taps // lines])

    def _levels(self, site: Site, count: int) -> np.ndarray:
        """Level of each tap as named, or drawn once a sensor."""
        if self.levels:
            return np.array(self.levels, np.float32)
        return site.fixed_stream.child("taps").normal(Window(0, 1, 0, count), count)[0]

    def _strips(self, levels: np.ndarray, lines: int, point: OperatingPoint) -> np.ndarray:
        """Offsets of all lines of the frame, float32; mean 0 and rms 1 before they settle."""
        begins = np.array([0, *self.begins], int)
        line = np.arange(lines)
        strip = np.searchsorted(begins, line, side="right") - 1
        level = levels.astype(float)
        level -= level[strip].mean()
        # a window of the sensor may lie within one strip, at the mean then
        level /= np.sqrt(np.mean(level[strip] ** 2)) or 1.0
        offsets = level[strip]
        share, length = self.value("settle", point), self.value("length", point)
        step = np.diff(level)
        if share and self.side != "before":
            after = strip > 0
            edge = strip[after] - 1
            fall = np.exp(-(line[after] - begins[strip[after]]) / length)
            offsets[after] -= share * step[edge] * fall
        if share and self.side != "after":
            before = strip < begins.size - 1
            edge = strip[before]
            fall = np.exp(-(begins[edge + 1] - 1 - line[before]) / length)
            offsets[before] += share * step[edge] * fall
        return offsets.astype(np.float32)

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2, before anything settles."""
        return self.value("sigma", point) ** 2


def _unit(levels: np.ndarray) -> np.ndarray:
    """Levels with mean 0 and rms 1."""
    away = levels - levels.mean()
    return np.asarray(away / np.sqrt(np.mean(away**2)))


def _rising(numbers: tuple[float, ...]) -> bool:
    return all(a < b for a, b in pairwise(numbers))
