"""Random telegraph signal: pixels that blink between two levels."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import hints
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.evidence import bounded, curve, shows
from dnanalyze.model.telegraph import Telegraph, add_telegraph

ALIKE = 3.0  # times: two fractions nearer than this are one guess
SLOW = 2.0  # frames: a pixel that hardly changes in the series shows in the pattern too


@dataclass(frozen=True)
class Rts(Effect):
    """A fraction of the pixels has an extra signal that switches on and off between frames."""

    name: ClassVar[str] = "rts"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "few pixels blink between two levels from frame to frame"
    physics: ClassVar[str] = (
        "A metastable defect that changes its configuration switches a pixel's dark current "
        "between two levels: a random telegraph signal. The amplitude follows the dark current "
        "(proportional to exposure, Arrhenius), and so do the switching rates. A single trap in "
        "the source follower's channel does the same at the readout, whatever the exposure "
        "(exposure: none, activation energy near 0); double sampling turns its two levels into "
        "three about zero. Traps differ in energy, so the share of time in either level spreads "
        "over pixels. Over the frames such a pixel is bimodal: its temporal variance is far above "
        "the others' and stays so, in any frames. Averaging or dark subtraction does not remove "
        "it; a map of blinking pixels does. Switching within an exposure is averaged by it and is "
        "not modelled."
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
        "up",
        "steps up from the usual level; half of the pixels down; two levels about the pixel's "
        "mean; or three levels -A, 0, A (double sampling)",
        "up", "both", "centred", "three",
    )  # fmt: skip
    occupancies: str = choice(
        "same",
        "occupancy the same in all blinking pixels, or uniform from 0 to 1",
        "same",
        "spread",
    )

    def idle(self) -> tuple[str, ...]:
        """The common occupancy, where each pixel has its own."""
        return ("occupancy",) if self.occupancies == "spread" else ()

    def bent(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """A spread of sigma over pixels makes noisier pixels too."""
        return (0.0 if name == "read_noise.spread" else 1.0), 0.0

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
        root = site.silicon.child("telegraph", repr(site.point))
        names = ("state", "second") if self.polarity == "three" else ("state",)
        states = [Telegraph(root, n, site.frame, index, occupancy, renew) for n in names]
        below = occupancy if self.polarity == "centred" else None
        return add_telegraph(signal, at, step, states, below)

    def _occupancy(self, index: np.ndarray, site: Site) -> np.ndarray:
        if self.occupancies == "spread":
            return site.silicon.child("occupancy").uniform_at(index)
        return np.full(index.size, self.value("occupancy", site.point), np.float32)

    def _steps(self, site: Site) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Place in the window, index in the frame, step (DN), occupancy of the blinking pixels."""
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
        if self.polarity in ("both", "centred"):
            down = site.silicon.child("polarity").uniform_at(index) < 0.5
            step = np.where(down, -step, step)
        step = (np.float32(scale) * step).astype(np.float32)
        return at, index, step, self._occupancy(index, site)

    def variance(self, point: OperatingPoint) -> float:
        """Over pixels and time, DN^2, at the reference: of A s, A the step, s the level."""
        o = self.value("occupancy", point)
        mean, square = (0.5, 1 / 3) if self.occupancies == "spread" else (o, o**2)  # of o
        level = {"centred": mean - square, "three": 2 * (mean - square)}.get(self.polarity, mean)
        step2 = 2.0 if self.amplitudes == "exponential" else 1.0
        p = self.value("fraction", point)
        offset = p * mean if self.polarity == "up" else 0.0
        return self.value("amplitude", point) ** 2 * (p * step2 * level - offset**2)

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Step from the noisiest pixels' variance beyond Gaussian noise, fraction from the frame's.

        And from how far down the pixels are noisier than Gaussian noise has them: the frame's
        variance tells few blinking pixels badly.
        """
        if not shows(clues, cls.fingerprint[:6]):
            return []
        total = np.asarray(clues.measured("temporal_noise"), float) ** 2
        core = np.asarray(clues.measured("temporal_noise_core"), float) ** 2
        top = np.asarray(clues.measured("temporal_variance_q0.999"), float) * total
        gaussian = _gaussian_quantile(clues, 0.999)
        usual = np.asarray(clues.simulated("temporal_variance_q0.999"), float)
        step2 = 4.0 * (top - np.minimum(usual, gaussian) * core)
        if not (np.isfinite(step2) & (step2 > 0)).any():
            return []
        lost = np.where(step2 > 0, 4.0 * (total - core) / step2, np.nan)
        lost = lost[np.isfinite(lost) & (lost > 0)]
        fractions = [float(np.median(lost)) if lost.size else 0.01]
        few = _noisier(clues)
        if not 1 / ALIKE < few / fractions[0] < ALIKE:
            fractions.append(few)
        step = np.sqrt(np.where(step2 > 0, step2, np.nan))
        thermal = hints.thermal_fit(clues, step / hints.exposure_and_gain(clues), 0.6)
        fixed = float(np.nanmedian(step / hints.gains(clues)))
        kinds: list[tuple[float, float, str]] = [(fixed, 0.0, "none")]
        if thermal is not None and thermal[1] > 0.2:
            kinds.insert(0, (*thermal, "proportional"))
        # the noisiest pixels of few frames overstate the step; p E[A^2] o (1 - o) is kept
        shares = {"exponential": (0.35, 2.0), "fixed": (0.6, 1.0)}
        guesses: list[Effect] = []
        centred = {"polarity": "centred", "occupancies": "spread"}
        shapes: list[dict[str, Any]] = [{}, {"dwell_frames": SLOW}, centred]
        for law, shape in itertools.product(shares, shapes):
            share, square = shares[law]
            for fraction, (size, ea, exposure) in itertools.product(fractions, kinds):
                p = fraction / (share**2 * square)
                values = hints.clip(cls, fraction=p, amplitude=size * share, ea_ev=ea)
                chosen = {**values, "amplitudes": law, "exposure": exposure, **shape}
                guesses.append(cls.from_plain(chosen))
        return guesses


def _gaussian_quantile(clues: Clues, level: float) -> float:
    """Quantile of the variances over pixels of equal Gaussian noise, over their mean."""
    from scipy.special import chdtri

    means = [curve(clues, "frame_means", i) for i in range(len(clues.points))]
    freedom = max((m.size for m in means if m is not None), default=8) - 1
    return float(chdtri(freedom, 1.0 - level)) / max(freedom, 1)


def _noisier(clues: Clues) -> float:
    """Share of the pixels that are noisier than the rest, from where their variance leaps.

    Over the quantile that Gaussian noise has, so that rounding, which widens all alike, is no leap;
    at the quietest setting, where shot noise differs least from pixel to pixel.
    """
    levels = (0.5, 0.9, 0.99, 0.999)
    core = np.asarray(clues.measured("temporal_noise_core"), float)
    quiet = int(np.nanargmin(core))
    seen = [
        np.asarray(clues.measured(f"temporal_variance_q{p:g}"), float)[quiet]
        / _gaussian_quantile(clues, p)
        for p in levels
    ]
    leaps = np.diff(np.log(np.nan_to_num(seen, nan=1.0)))
    return 3.0 * (1.0 - levels[1 + int(np.argmax(leaps))])
