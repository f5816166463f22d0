"""Offsets of the parallel outputs (taps) over which a frame is read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.model.evidence import bounded, curve, shows, typical_positive
from dnanalyze.model.laws import Law, TableLaw, value_at
from dnanalyze.model.line_profile import line_profile, strip_profile

_PERIODS, _STRIPS = (2, 3, 4, 8), (2, 4, 8, 16)
_SEAMS = ("column_taps_2", "column_taps_4", "column_taps_8", "shading_1_0", "shading_2_0",
          "shading_3_0")  # fmt: skip
_PEAK = 14.0  # times the median: by chance in one of 1000 spectra of 1000 exponential modes
NEARLY = 0.8  # share of what any number of taps explains


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
        "temperature of the electronics. A sequencer that is not locked to the frame starts at "
        "another tap now and then, and the pattern moves by whole columns (`slip`). Cure: subtract "
        "each tap's own black level, taken from its optically black pixels."
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

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """For each kind, the least number of taps that explains nearly all that any number does."""
        found = [("interleaved", *_interleaved(clues)), ("blocks", _blocks(clues), 0.0)]
        return [
            cls(bounded(cls, "sigma", float(np.std(o))), kind, o.size, _told(o), slip)  # type: ignore[arg-type]
            for kind, o, slip in found
            if o.size and np.ptp(o) > 0
        ]


def _told(levels: np.ndarray) -> tuple[float, ...]:
    return tuple(round(float(v), 4) for v in (levels - levels.mean()) / np.std(levels))


def _interleaved(clues: Clues) -> tuple[np.ndarray, Law]:
    """Mean level of each tap, DN, beside a parabola over the fitted half (empty: no sign); slip."""
    names = [f"column_periodic_{p}" for p in _PERIODS]
    if not shows(clues, names):
        return np.empty(0), 0.0
    share = dict(zip(_PERIODS, (typical_positive(clues.measured(n)) for n in names), strict=True))
    taps = _fewest(share)
    slips = _slips(clues, taps)
    if slips == 0.0:
        places, means = (part[: clues.shape[1]] for part in line_profile(clues, "columns"))
        return _tap_levels(places, means, taps), 0.0
    each = []
    for i, point in enumerate(clues.points):
        places, means = (part[: clues.shape[1]] for part in clues.lines("columns", i))
        if value_at(slips, point) == 0.0:  # the mean over frames that slipped is none of theirs
            each.append(_tap_levels(places, means, taps))
    return _aligned([levels for levels in each if levels.size]), slips


def _tap_levels(places: np.ndarray, means: np.ndarray, taps: int) -> np.ndarray:
    """Mean level of each tap, DN, beside a parabola; empty where there are too few columns."""
    if means.size < 3 * taps:
        return np.empty(0)
    x = np.linspace(-1.0, 1.0, means.size)
    member = (places[:, None] % taps == np.arange(taps)).astype(float)
    terms = np.hstack([member, np.stack([x, x**2 - 1 / 3], axis=1)])
    return np.asarray(np.linalg.lstsq(terms, means, rcond=None)[0][:taps])


def _aligned(each: list[np.ndarray]) -> np.ndarray:
    """Mean of levels that start at different taps, each turned to agree with the strongest."""
    if not each:
        return np.empty(0)
    centred = [levels - levels.mean() for levels in each]
    best = max(centred, key=np.ptp)
    turns = range(best.size)
    return np.mean([max((np.roll(o, n) for n in turns), key=best.dot) for o in centred], axis=0)


def _slips(clues: Clues, taps: int) -> Law:
    """1 where the lines at n/P are new in a frame, 0 where they stand still, one a setting.

    At which tap a frame happened to start tells nothing of the sensor, so that the model may take
    it as it was.
    """
    rows = {}
    for i, point in enumerate(clues.points):
        power, at = (curve(clues, n, i) for n in ("temporal_column_spectrum", "column_spectrum_f"))
        if power is None or at is None or power.shape != at.shape or power.size < 8 * taps:
            continue
        away = np.abs(at * taps - np.rint(at * taps)) / taps
        line = (away < at[1] - at[0]) & (at > 0.5 / taps)
        rows[point] = float(power[line].max() > _PEAK * max(float(np.median(power)), 1e-30))
    return TableLaw(tuple(rows), tuple(rows.values())) if any(rows.values()) else 0.0


def _blocks(clues: Clues) -> np.ndarray:
    """Mean level of each strip of the whole field, DN; empty: no sign.

    Steps show in the columns, those of two wide taps as shading alone.
    """
    strips = strip_profile(clues)
    counts = [p for p in _STRIPS if strips.size >= 2 * p]
    if not counts or not shows(clues, _SEAMS, 0):
        return np.empty(0)
    levels, share = {}, {}
    for taps in counts:
        ends = np.linspace(0.0, taps, strips.size + 1)  # of the blocks, in taps
        tap = np.arange(taps)[None, :]
        within = np.minimum(ends[1:, None], tap + 1) - np.maximum(ends[:-1, None], tap)
        member = np.clip(within, 0.0, None) / np.diff(ends)[:, None]
        levels[taps] = np.linalg.lstsq(member, strips, rcond=None)[0]
        share[taps] = 1.0 - float(np.var(strips - member @ levels[taps]) / np.var(strips))
    return np.asarray(levels[_fewest(share)])


def _fewest(share: dict[int, float]) -> int:
    """The least number of taps that explains nearly as much as any."""
    best = max(share.values())
    return min(p for p in share if share[p] >= NEARLY * best)
