"""The level of whole frames drifts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter


@dataclass(frozen=True)
class OffsetDrift(Effect):
    """y += random walk + white offset + start transient of the frame number, or y (1 + that)."""

    name: ClassVar[str] = "offset_drift"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "The black level drifts from frame to frame, or settles at the start."
    physics: ClassVar[str] = (
        "The black level depends on a reference voltage and on amplifiers that warm up. After "
        "power-on or a change of mode it settles over some frames, then drifts slowly, a "
        "random walk of a fraction of a DN a frame. Nothing within a frame changes, so "
        "spectra do not show it; the frame means do. A clamp that takes the black level from "
        "few pixels leaves each frame an offset of its own, independent of the one before "
        "(`white`). Both are independent of exposure and follow the analog gain. A chip that "
        "warms up or cools from frame to frame moves the dark signal itself (`form`: scaled), "
        "and its pattern with it: that grows with exposure and temperature. Remedy: wait, "
        "discard the first frames, subtract each frame's optically black level."
    )
    formula: ClassVar[str] = (
        "b_n = step sum_(k=1..n) N(0,1) + transient exp(-n / settling) + white N(0,1), "
        "n = 0, 1, ...; scaled: y (1 + b_n), step, transient and white as shares"
    )
    references: ClassVar[tuple[str, ...]] = ()
    fingerprint: ClassVar[tuple[str, ...]] = ("drift",)
    confused_with: ClassVar[dict[str, str]] = {
        "flicker_noise": "also uneven within a frame",
        "persistence": "decays from bright pixels, not equally everywhere",
        "dark_gradient": "a change of temperature scales with the dark current's own pattern",
    }

    step: float = parameter(
        0.2, "DN/sqrt(frame)", 1e-5, 1e3, "standard deviation of the change per frame"
    )
    transient: float = parameter(0.0, "DN", -1e4, 1e4, "excess of the first frame", "signed")
    settling: float = parameter(1.5, "frame", 0.1, 100.0, "time constant of the start")
    white: float = parameter(
        0.0, "DN", 0.0, 1e3, "standard deviation of an offset that is new in each frame", "linear"
    )
    form: str = choice("added", "a level, or a share of the dark signal", "added", "scaled")

    def inactive_parameters(self) -> tuple[str, ...]:
        """The numbers of a transient and of a white offset that are not there."""
        still = ("transient", "settling") if self.transient == 0.0 else ()
        return (*still, "white") if self.white == 0.0 else still

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the level of this frame; settings start anew."""
        frame = max(0, site.frame)
        walk = (
            site.fixed_stream.child("walk", repr(site.point))
            .generator()
            .standard_normal(frame)
            .sum()
        )
        start = math.exp(-frame / self.value("settling", site.point))
        level = self.value("step", site.point) * walk + self.value("transient", site.point) * start
        white = self.value("white", site.point)
        if white:
            level += white * site.frame_stream.child("white").generator().standard_normal()
        if self.form == "scaled":
            signal *= np.float32(max(0.0, 1.0 + level))
        else:
            signal += np.float32(level * site.gain_ratio)
        return signal
