"""Random telegraph signal: pixels that switch between two levels."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.bounds import bounded, clip
from dnanalyze.model.effect import (
    HALF_THE_VARIANCE,
    Effect,
    Placing,
    Site,
    Stage,
    choice,
    parameter,
)
from dnanalyze.model.hot_signal import HotSignal
from dnanalyze.model.telegraph import Telegraph, add_telegraph

LEAST_CHANGED = 0.1  # share of the traps that change their state within a series, to be told
# Share of these that are up in more than one frame: with fewer, their numbers are those of hits,
# within a tenth
LEAST_RETURNED = LEAST_CHANGED
SEVERAL = 3  # frames from which one can be up in two and down in one


@dataclass(frozen=True)
class Rts(Effect):
    """A fraction of the pixels has an extra signal that switches on and off between frames."""

    name: ClassVar[str] = "rts"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "few pixels switch between two levels from frame to frame"
    physics: ClassVar[str] = (
        "A metastable defect that changes its configuration switches a pixel's dark current "
        "between two levels: a random telegraph signal. The amplitude follows the dark "
        "current (proportional to exposure, Arrhenius), and so do the switching rates. A "
        "single trap in the source follower's channel does the same at the readout, whatever "
        "the exposure (exposure: none, activation energy near 0); double sampling turns its "
        "two levels into three about zero, and pixels that share an amplifier share the trap "
        "(`shared` of `read_noise`), each in a state of its own, since they are read one after the "
        "other. Traps differ in energy, so the share of time in "
        "either level differs over pixels. Over the frames such a pixel is bimodal: its "
        "temporal variance is far above that of the others, in every part of the series. "
        "Averaging or dark subtraction does not remove it; a map of RTS pixels does. "
        "Switching within an exposure is averaged by it and is not modelled."
    )
    formula: ClassVar[str] = (
        "h += A_i s_i(n) for a fraction p of the pixels; s = 1 with probability o, 0 else; drawn "
        "anew in each frame with probability 1 - e^(-1/dwell); variance over time A^2 o (1 - o)"
    )
    references: ClassVar[tuple[str, ...]] = ("Belloir et al., IEEE TED (2017)",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "blink_repeat",
        "temporal_variance_q0.999",
        "temporal_variance_q0.99",
        "temporal_kurtosis",
        "temporal_q0.999",
        "noise_at_999",
        "noise_at_99",
        "transient_high",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "heavy_tailed_read_noise": ("heavy tails occur in all pixels; RTS in the same ones"),
        "read_noise": "where sigma differs from pixel to pixel, each pixel is Gaussian in time",
        "noisy_pixels": (
            "noisier pixels do not have two levels, and no correlation from frame to frame"
        ),
        "cosmic_rays": "a hit does not come back to the same pixel",
        "hot_pixels": "a hot pixel does not change between frames",
    }

    fraction: float = parameter(0.01, "1", 1e-6, 0.5, "fraction of pixels that switch")
    amplitude: float = parameter(
        10.0, "DN", 1e-2, 1e5, "mean step at the reference temperature, exposure and gain"
    )
    occupancy: float = parameter(0.5, "1", 0.02, 0.98, "share of time in the upper level", "linear")
    dwell_frames: float = parameter(
        0.5,
        "frame",
        0.05,
        1e4,
        ("correlation time of the state: correlation over n frames e^(-n/dwell)"),
    )
    ea_ev: float = parameter(0.6, "eV", 0.0, 1.6, "activation energy of the step", "linear")
    amplitudes: str = choice(
        "exponential", "distribution of the step over pixels", "exponential", "fixed"
    )
    exposure: str = choice("proportional", "step over exposure", "proportional", "none")
    polarity: str = choice(
        "up",
        "steps up from the usual level; half of the pixels down; two levels about the pixel's "
        "mean; or three levels -A, 0, A (double sampling)",
        "up", "both", "centred", "three",
    )  # fmt: skip
    occupancies: str = choice(
        "same",
        "occupancy the same in all RTS pixels, or uniform from 0 to 1",
        "same",
        "spread",
    )

    def inactive_parameters(self) -> tuple[str, ...]:
        """The common occupancy, where each pixel has its own."""
        return ("occupancy",) if self.occupancies == "spread" else ()

    def shows_in(self, frames: int, pixels: int) -> bool:
        """Whether these frames tell a trap from a hot pixel, and from a pixel that is hit once.

        A hot pixel does not change its state; at least `LEAST_CHANGED` of the traps must. A pixel
        that is hit is up in one frame; at least `LEAST_RETURNED` of the traps that change must not
        be, where there are frames enough for it. A two-state chain of occupancy o and correlation
        r = e^(-1/dwell) goes up with u = o (1 - r) and down with d = (1 - o) (1 - r) a step. It
        stays in its state over n steps with the probability o (1 - d)^n + (1 - o) (1 - u)^n, and is
        up in one of n + 1 frames, which is the first, the last or one between them, with
        o d (1 - u)^(n-1) + (1 - o) u (1 - u)^(n-1) + (n - 1) (1 - o) u d (1 - u)^(n-2). Of
        occupancies that differ from trap to trap the middle stands for all.
        """
        dwell, o = self.dwell_frames, self.occupancy if self.occupancies == "same" else 0.5
        if not (isinstance(dwell, (int, float)) and isinstance(o, (int, float))):
            return True
        n, r = frames - 1, math.exp(-1.0 / dwell)
        up, down = o * (1.0 - r), (1.0 - o) * (1.0 - r)
        changed = 1.0 - o * (1.0 - down) ** n - (1.0 - o) * (1.0 - up) ** n
        if changed < LEAST_CHANGED:
            return False
        if frames < SEVERAL or self.polarity != "up":
            return True
        ends = (o * down + (1.0 - o) * up) * (1.0 - up) ** (n - 1)
        once = ends + (n - 1) * (1.0 - o) * up * down * (1.0 - up) ** (n - 2)
        return changed - once >= LEAST_RETURNED * changed

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """A spread of sigma over pixels makes noisier pixels too."""
        return (HALF_THE_VARIANCE if name == "read_noise.spread" else 1.0), 0.0

    @classmethod
    def of_hot_signal(cls, hot: HotSignal) -> list[Effect]:
        """Traps in the upper level for half of the time, whose mean is the signal."""
        values = clip(cls, fraction=hot.fraction, amplitude=2.0 * hot.scale, ea_ev=hot.ea_ev)
        return [cls(**values)]  # type: ignore[arg-type]

    def relatives(self) -> list[Effect]:
        """The other law of the step that has the same second and fourth moment over pixels.

        p E[A^2] and p E[A^4] are 2 p a^2 and 24 p a^4 for exponential steps, p A^2 and p A^4 for
        equal ones.
        """
        numbers = self.amplitude, self.fraction
        if not all(isinstance(n, (int, float)) for n in numbers):
            return []
        factor = math.sqrt(12.0)
        if self.amplitudes == "fixed":
            factor = 1.0 / factor
        share = 6.0 if self.amplitudes == "fixed" else 1.0 / 6.0
        other = "exponential" if self.amplitudes == "fixed" else "fixed"
        return [
            replace(
                self,
                amplitude=bounded(type(self), "amplitude", factor * numbers[0]),
                fraction=bounded(type(self), "fraction", share * numbers[1]),
                amplitudes=other,
            )
        ]

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the step to the blinking pixels that are in their upper level."""
        at, index, step, occupancy = site.keep("steps", lambda: self._steps(site))
        renew = 1.0 - np.exp(-1.0 / self.value("dwell_frames", site.point))
        root = site.fixed_stream.child("telegraph", repr(site.point))
        names = ("state", "second") if self.polarity == "three" else ("state",)
        states = [Telegraph(root, n, site.frame, index, occupancy, renew) for n in names]
        below = occupancy if self.polarity == "centred" else None
        return add_telegraph(signal, at, step, states, below)

    def _occupancy(self, trap: np.ndarray, site: Site) -> np.ndarray:
        if self.occupancies == "spread":
            return site.fixed_stream.child("occupancy").uniform_at(trap)
        return np.full(trap.size, self.value("occupancy", site.point), np.float32)

    def _steps(self, site: Site) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Place in the window, index in the frame, step (DN), occupancy of the blinking pixels."""
        if self.exposure == "proportional":  # a defect of the photodiode, which no pixels share
            site = replace(site, shared=(1, 1))
        u = site.amplifiers("uniform", "where")
        p = np.float32(self.value("fraction", site.point))
        at = np.flatnonzero(u < p)
        rows, columns = np.divmod(at, site.window.shape[1])
        rows, columns = rows + site.window.top, columns + site.window.left
        index = rows * site.shape[1] + columns
        trap = site.amplifier_at(rows, columns)
        scale = self.value("amplitude", site.point) * site.gain_ratio
        scale *= site.thermal(self.value("ea_ev", site.point))
        if self.exposure == "proportional":
            scale *= site.exposure_ratio
        if self.amplitudes == "exponential":
            step = np.log(p / u.reshape(-1)[at])  # a larger fraction lets in small steps first
        else:
            step = np.ones(at.size, np.float32)
        if self.polarity in ("both", "centred"):
            down = site.fixed_stream.child("polarity").uniform_at(trap) < 0.5
            step = np.where(down, -step, step)
        step = (np.float32(scale) * step).astype(np.float32)
        return at, index, step, self._occupancy(trap, site)

    def variance(self, point: OperatingPoint) -> float:
        """Over pixels and time, DN^2, at the reference: of A s, A the step, s the level."""
        o = self.value("occupancy", point)
        mean, square = (0.5, 1 / 3) if self.occupancies == "spread" else (o, o**2)  # of o
        level = {"centred": mean - square, "three": 2 * (mean - square)}.get(self.polarity, mean)
        step2 = 2.0 if self.amplitudes == "exponential" else 1.0
        p = self.value("fraction", point)
        offset = p * mean if self.polarity == "up" else 0.0
        return self.value("amplitude", point) ** 2 * (p * step2 * level - offset**2)
