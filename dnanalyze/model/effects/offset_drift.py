"""The level of whole frames wanders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.evidence import bounded, curve, shows, typical_positive


@dataclass(frozen=True)
class OffsetDrift(Effect):
    """y += random walk + start transient of the frame number, or y (1 + that)."""

    name: ClassVar[str] = "offset_drift"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "The black level wanders from frame to frame, or settles at the start."
    physics: ClassVar[str] = (
        "The black level hangs on a reference voltage and on amplifiers that warm up. After "
        "power-on or a change of mode it settles over some frames, then wanders slowly, a random "
        "walk of a fraction of a DN a frame. Nothing within a frame changes, so no spectrum sees "
        "it: only the mean of frames does. It is independent of exposure and follows the analogue "
        "gain. A chip that warms up or cools from frame to frame moves the dark signal itself "
        "(`form`: scaled), and its pattern with it: that grows with exposure and temperature. "
        "Cure: wait, discard the first frames, subtract each frame's optically black level."
    )
    formula: ClassVar[str] = (
        "b_n = step sum_(k=1..n) N(0,1) + transient exp(-n / settling), n = 0, 1, ...; "
        "scaled: y (1 + b_n), step and transient as shares"
    )
    references: ClassVar[tuple[str, ...]] = ()
    fingerprint: ClassVar[tuple[str, ...]] = ("drift",)
    confused_with: ClassVar[dict[str, str]] = {
        "flicker_noise": "also uneven within a frame",
        "persistence": "decays from bright pixels, not everywhere alike",
        "dark_gradient": "a change of temperature scales with the dark current's own pattern",
    }

    step: float = parameter(0.2, "DN/sqrt(frame)", 1e-5, 1e3, "spread of the change a frame")
    transient: float = parameter(0.0, "DN", -1e4, 1e4, "excess of the first frame", "signed")
    settling: float = parameter(1.5, "frame", 0.1, 100.0, "time constant of the start")
    form: str = choice("added", "a level, or a share of the dark signal", "added", "scaled")

    def idle(self) -> tuple[str, ...]:
        """The time constant of a transient that is not there."""
        return ("transient", "settling") if self.transient == 0.0 else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the level of this frame; settings start anew."""
        frame = max(0, site.frame)
        walk = site.silicon.child("walk", repr(site.point)).generator().standard_normal(frame).sum()
        start = math.exp(-frame / self.value("settling", site.point))
        level = self.value("step", site.point) * walk + self.value("transient", site.point) * start
        if self.form == "scaled":
            signal *= np.float32(max(0.0, 1.0 + level))
        else:
            signal += np.float32(level * site.gain_ratio)
        return signal

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """The step from the spread of frame means, K frames of a walk having step^2 (K^2-1)/6K; a
        transient where the first frame stands apart in the same direction in most settings.
        """
        if not shows(clues, cls.fingerprint):
            return []
        spread2 = np.asarray(clues.measured("drift"), float) ** 2
        spread2 = spread2 - np.nan_to_num(np.asarray(clues.simulated("drift"), float)) ** 2
        means = [curve(clues, "frame_means", i) for i in range(len(clues.points))]
        frames = max([len(m) for m in means if m is not None], default=4)
        frames = max(frames, 2)
        step = math.sqrt(typical_positive(spread2) * 6.0 * frames / (frames**2 - 1.0))
        found: list[Effect] = [cls(bounded(cls, "step", step))]
        jumps = np.array([_jump(m) for m in means if m is not None and len(m) >= 4])
        if jumps.size and abs(np.sign(jumps).sum()) > 0.6 * jumps.size:
            small = bounded(cls, "step", 0.1 * step)
            found.insert(0, cls(small, bounded(cls, "transient", float(np.median(jumps)))))
        share = _share(np.asarray(clues.measured("mean"), float), means)
        if share is not None:
            step = bounded(cls, "step", 0.1 * abs(share))
            start = share / (1.0 - math.exp(-1.0 / cls.settling))
            found.append(cls(step, bounded(cls, "transient", start), form="scaled"))
        return found


def _share(level: np.ndarray, means: Sequence[np.ndarray | None]) -> float | None:
    """Share by which the first frame's dark signal exceeds the next's: the slope of their
    difference over the level; None where the level hardly moves or the slope is not seen.
    """
    jump = np.array([np.nan if m is None or len(m) < 2 else m[0] - m[1] for m in means])
    good = np.isfinite(level) & np.isfinite(jump)
    if good.sum() < 3 or np.ptp(level[good]) <= 0:
        return None
    x = level[good] - level[good].min()
    slope = float(x @ jump[good] / (x @ x))
    rest = jump[good] - slope * x
    error = math.sqrt(float(rest @ rest) / (good.sum() - 1) / float(x @ x))
    return slope if abs(slope) > 4.0 * error else None


def _jump(means: np.ndarray) -> float:
    """First frame mean less the others' where it is outside 3 times their range, else 0."""
    rest = means[1:]
    away = float(means[0] - np.median(rest))
    return away if abs(away) > 3.0 * float(np.ptp(rest)) / 2.0 else 0.0
