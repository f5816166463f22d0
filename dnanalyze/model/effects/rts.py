"""Random telegraph signal: pixels that blink between two levels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import hints
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.model.evidence import shows


@dataclass(frozen=True)
class Rts(Effect):
    """A fraction of the pixels has an extra signal that switches on and off between frames."""

    name: ClassVar[str] = "rts"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "temporal"
    summary: ClassVar[str] = "few pixels blink between two levels from frame to frame"
    physics: ClassVar[str] = (
        "A metastable defect that changes its configuration switches a pixel's dark current "
        "between two levels: a random telegraph signal. The amplitude follows the dark current "
        "(proportional to exposure, Arrhenius), and so do the switching rates. A single trap in "
        "the source follower's channel does the same at the readout, whatever the exposure "
        "(exposure: none, activation energy near 0). Over the frames such a pixel is bimodal: "
        "its temporal variance is far above the others' and stays so, in any frames. Averaging "
        "or dark subtraction does not remove it; a map of blinking pixels does. Switching within "
        "an exposure is averaged by it and is not modelled."
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
        "heavy_tailed_read_noise": (
            "heavy tails visit all pixels; blinking returns to the same ones"
        ),
        "read_noise": "a spread of sigma over pixels leaves each pixel Gaussian in time",
        "cosmic_rays": "a hit does not come back to the same pixel",
        "hot_pixels": "a hot pixel does not change between frames",
    }

    fraction: float = parameter(0.01, "1", 1e-6, 0.5, "fraction of pixels that blink")
    amplitude: float = parameter(
        10.0, "DN", 1e-2, 1e5, "mean step at the reference temperature, exposure and gain"
    )
    occupancy: float = parameter(0.5, "1", 0.02, 0.98, "share of time in the upper level", "linear")
    dwell_frames: float = parameter(
        0.5, "frame", 0.05, 1e4, "memory of the state: correlation over n frames e^(-n/dwell)"
    )
    ea_ev: float = parameter(0.6, "eV", 0.0, 1.6, "activation energy of the step", "linear")
    amplitudes: str = choice(
        "exponential", "distribution of the step over pixels", "exponential", "fixed"
    )
    exposure: str = choice("proportional", "step over exposure", "proportional", "none")
    polarity: str = choice(
        "up", "steps up from the usual level, or half of the pixels down", "up", "both"
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the step to the blinking pixels that are in their upper level."""
        at, index, step = site.keep("steps", lambda: self._steps(site))
        on = self._state(index, site)
        rows, columns = np.divmod(at[on], site.window.shape[1])
        signal[rows, columns] += step[on]
        return signal

    def _steps(self, site: Site) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Place in the window, index in the frame, and step (DN) of the blinking pixels."""
        u = site.fixed_uniform("where")
        p = np.float32(self.value("fraction", site.point))
        at = np.flatnonzero(u < p)
        rows, columns = np.divmod(at, site.window.shape[1])
        index = (rows + site.window.top) * site.shape[1] + columns + site.window.left
        scale = self.value("amplitude", site.point) * site.gain_ratio
        scale *= site.thermal(self.value("ea_ev", site.point))
        if self.exposure == "proportional":
            scale *= site.exposure_ratio
        if self.amplitudes == "exponential":
            step = np.log(p / u.reshape(-1)[at])  # a larger fraction lets in small steps first
        else:
            step = np.ones(at.size, np.float32)
        if self.polarity == "both":
            down = site.silicon.child("polarity").uniform_at(index) < 0.5
            step = np.where(down, -step, step)
        return at, index, (np.float32(scale) * step).astype(np.float32)

    def _state(self, index: np.ndarray, site: Site) -> np.ndarray:
        """Whether each pixel is in its upper level, as drawn at its latest renewal."""
        renew = 1.0 - np.exp(-1.0 / self.value("dwell_frames", site.point))
        occupancy = self.value("occupancy", site.point)
        on = np.zeros(index.size, bool)
        open_ = np.arange(index.size)
        root = site.silicon.child("telegraph", repr(site.point))
        for n in range(site.frame, -1, -1):
            if n > 0:
                new = root.child("renew", n).uniform_at(index[open_]) < renew
            else:
                new = np.ones(open_.size, bool)
            done = open_[new]
            on[done] = root.child("state", n).uniform_at(index[done]) < occupancy
            open_ = open_[~new]
            if open_.size == 0:
                break
        return on

    def variance(self, point: OperatingPoint) -> float:
        """Over pixels and time, DN^2, at the reference: p o E[A^2] - (p o E[A])^2, upward steps."""
        on = self.value("fraction", point) * self.value("occupancy", point)
        square = 2.0 if self.amplitudes == "exponential" else 1.0
        mean = 0.0 if self.polarity == "both" else on
        return self.value("amplitude", point) ** 2 * (on * square - mean**2)

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Step from the noisiest pixels' unexplained variance, fraction from the frame's."""
        if not shows(clues, cls.fingerprint[:6]):
            return []
        total = np.asarray(clues.measured("temporal_noise"), float) ** 2
        core = np.asarray(clues.measured("temporal_noise_core"), float) ** 2
        top = np.asarray(clues.measured("temporal_variance_q0.999"), float) * total
        usual = np.asarray(clues.simulated("temporal_variance_q0.999"), float)
        step2 = 4.0 * (top - usual * core)
        if not (np.isfinite(step2) & (step2 > 0)).any():
            return []
        lost = np.where(step2 > 0, 4.0 * (total - core) / step2, np.nan)
        lost = lost[np.isfinite(lost) & (lost > 0)]
        fraction = float(np.median(lost)) if lost.size else 0.01
        step = np.sqrt(np.where(step2 > 0, step2, np.nan))
        thermal = hints.thermal_fit(clues, step / hints.exposure_and_gain(clues), 0.6)
        fixed = float(np.nanmedian(step / hints.gains(clues)))
        kinds: list[tuple[float, float, str]] = [(fixed, 0.0, "none")]
        if thermal is not None and thermal[1] > 0.2:
            kinds.insert(0, (*thermal, "proportional"))
        # the noisiest pixels of few frames overstate the step; p E[A^2] o (1 - o) is kept
        shares = {"exponential": (0.35, 2.0), "fixed": (0.6, 1.0)}
        guesses: list[Effect] = []
        for size, ea, exposure in kinds:
            for law, (share, square) in shares.items():
                p = fraction / (share**2 * square)
                values = hints.clip(cls, fraction=p, amplitude=size * share, ea_ev=ea)
                guesses.append(cls.from_plain({**values, "amplitudes": law, "exposure": exposure}))
        return guesses
