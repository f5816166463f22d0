"""Offsets of the parallel outputs (taps) over which a frame is read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.model.evidence import LINE_BANDS, bounded, mean_power, named, shows, typical_positive
from dnanalyze.model.line_profile import line_profile, strip_profile

_KINDS = {"interleaved": ("column_periodic", (2, 3, 4, 8)), "blocks": ("column_taps", (2, 4, 8))}


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
        "frame, independent of exposure, follows the analogue gain and drifts slowly with the "
        "temperature of the electronics. Cure: subtract each tap's own black level, taken from its "
        "optically black pixels."
    )
    formula: ClassVar[str] = (
        "y_ij += o_(j mod P)  or  o_floor(j P / columns);  mean o = 0, mean o^2 = sigma^2"
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
            tap = site.column_index % self.taps
        else:
            tap = site.column_index * self.taps // site.shape[1]
        signal += np.float32(self.value("sigma", site.point) * site.gain_ratio) * offsets[tap]
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2."""
        return self.value("sigma", point) ** 2

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """For each kind, the least number of taps that explains nearly all that any number does."""
        names = named("pattern_columns", LINE_BANDS)
        power = np.stack([np.asarray(clues.measured(n), float) for n in names])
        variance = mean_power(power) / clues.shape[0]  # of the column means
        found: list[tuple[float, Effect]] = []
        for kind, (prefix, counts) in _KINDS.items():
            if not shows(clues, [f"{prefix}_{p}" for p in counts]):
                continue
            share = {p: typical_positive(clues.measured(f"{prefix}_{p}")) for p in counts}
            best = max(share.values())
            taps = min(p for p in counts if share[p] >= 0.8 * best)
            sigma = math.sqrt(max(best, 0.0) * typical_positive(variance))
            levels = _levels(clues, kind, taps)
            if levels.size and np.ptp(levels) > 0:
                levels, sigma = levels / np.std(levels), float(np.std(levels))
            told = tuple(round(float(v), 4) for v in levels)
            found.append((best, cls(bounded(cls, "sigma", sigma), kind, taps, told)))
        return [effect for _, effect in sorted(found, key=lambda item: -item[0])]


def _levels(clues: Clues, kind: str, taps: int) -> np.ndarray:
    """Mean level of each tap, DN, beside a parabola over the field; empty where not to be seen."""
    if kind == "blocks":
        strips = strip_profile(clues)
        if strips.size < 2 * taps:
            return np.empty(0)
        ends = np.linspace(0.0, taps, strips.size + 1)  # of the blocks, in taps
        tap = np.arange(taps)[None, :]
        share = np.minimum(ends[1:, None], tap + 1) - np.maximum(ends[:-1, None], tap)
        member, smooth = (
            np.clip(share, 0.0, None) / np.diff(ends)[:, None],
            np.empty((strips.size, 0)),
        )
    else:
        places, strips = line_profile(clues, "columns")
        places, strips = places[: clues.shape[1]], strips[: clues.shape[1]]  # of the fitted half
        if strips.size < 3 * taps:
            return np.empty(0)
        member = (places[:, None] % taps == np.arange(taps)).astype(float)
        x = np.linspace(-1.0, 1.0, strips.size)
        smooth = np.stack([x, x**2 - 1 / 3], axis=1)
    levels = np.linalg.lstsq(np.hstack([member, smooth]), strips, rcond=None)[0][:taps]
    return np.asarray(levels - levels.mean())
