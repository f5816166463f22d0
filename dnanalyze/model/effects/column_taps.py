"""Offsets of the parallel outputs (taps) over which a frame is read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter


@dataclass(frozen=True)
class ColumnTaps(Effect):
    """y += o_t, t = j mod P or one of P equal vertical strips; the rms over the taps is exact."""

    name: ClassVar[str] = "column_taps"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "Odd and even columns, or whole strips, at different levels."
    physics: ClassVar[str] = (
        "Fast sensors read over several outputs at once. Interleaved outputs take every P-th "
        "column, often the odd ones at the top and the even ones at the bottom of the chip; others "
        "take a strip of the frame each. Each output has its own offset: a pattern of exact period "
        "P, with lines at u = n/P of the spectrum, or steps at the seams. It is the same in every "
        "frame, independent of exposure, follows the analog gain and drifts slowly with the "
        "temperature of the electronics. A sequencer that is not locked to the frame starts at "
        "another tap now and then, and the pattern moves by whole columns (`slip`). Remedy: "
        "subtract each tap's own black level, taken from its optically black pixels."
    )
    formula: ClassVar[str] = (
        "y_ij += o_((j + n slip) mod P), n the frame,  or  o_floor(j P / columns);  mean o = 0, "
        "mean o^2 = sigma^2"
    )
    references: ClassVar[tuple[str, ...]] = ("EMVA 1288 release 4.0 (horizontal spectrogram)",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "column_periodic_2", "column_periodic_4", "column_taps_2", "column_taps_4",
        "column_periodic_8", "column_taps_8", "column_periodic_3",
        "pattern_nyquist_10", "pattern_columns_0.3_0.5",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "column_fpn": "power at all frequencies of the v = 0 axis, no period",
        "cfa_mismatch": "also differs from row to row: a line at (1/2,1/2) or (0,1/2)",
        "periodic_pattern": "a single sine whose frequency is no exact fraction n/P",
        "dark_gradient": "smooth, grows with exposure; strips have sharp seams",
    }

    sigma: float = parameter(0.5, "DN", 1e-4, 1e3, "rms of the offsets over the taps")
    kind: str = choice("interleaved", "how columns belong to taps", "interleaved", "blocks")
    taps: int = choice(2, "number of taps P", 2, 3, 4, 8, 16)
    levels: tuple[float, ...] = choice(
        (), "levels of the taps in proportion, as measured; drawn at random where there are none"
    )
    slip: float = parameter(
        0.0, "column", 0.0, 15.0, "by which interleaved taps move from frame to frame", "held"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.levels and (len(self.levels) != self.taps or np.ptp(self.levels) == 0):
            raise InputError(
                f"column_taps.levels: {len(self.levels)} numbers for {self.taps} taps; "
                "give one a tap, not all alike, or none"
            )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offset of its tap to every column."""
        if self.levels:
            offsets = np.array(self.levels, np.float32)
        else:
            offsets = site.silicon.child("taps").normal(Window(0, 1, 0, self.taps), self.taps)[0]
        offsets = offsets - offsets.mean()
        offsets /= np.sqrt(np.mean(offsets**2))
        if self.kind == "interleaved":
            slip = round(self.value("slip", site.point))
            tap = (site.column_index + site.frame * slip) % self.taps
        else:
            tap = site.column_index * self.taps // site.shape[1]
        signal += np.float32(self.value("sigma", site.point) * site.gain_ratio) * offsets[tap]
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2."""
        return self.value("sigma", point) ** 2
