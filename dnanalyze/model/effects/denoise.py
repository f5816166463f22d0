"""Smoothing within a frame, linear or edge-preserving."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.model.evidence import bounded, known, shows, typical

_GAUSSIAN_RADIUS = 6
_BILATERAL_RADIUS = 2
WIDE = 2.0  # range over the noise from which a bilateral averages all that it meets
_NLM_PATCH, _NLM_DISTANCE = 2, 5
_MEDIAN_VARIANCE = 0.166  # of the median of 9 Gaussian values of variance 1, by simulation
_PLAIN = (0.25, 0.5, 0.75)  # shares of a mixture


@dataclass(frozen=True)
class Denoise(Effect):
    """y += strength (filter(y) - y)."""

    name: ClassVar[str] = "denoise"
    stage: ClassVar[Stage] = Stage.SPATIAL_FILTER
    varies: ClassVar[str] = "digital"
    even: ClassVar[bool] = True
    summary: ClassVar[str] = "Spatial denoise: neighbours averaged before the file is written."
    physics: ClassVar[str] = (
        "Noise reduction averages neighbours, so the noise is no longer white: the power at high "
        "frequencies falls, extremes become rare. A Gaussian blurs everything, as crosstalk does. "
        "A median removes isolated pixels. Edge-preserving filters average only what is alike: "
        "bilateral (pixels within range of each other), non-local means (pixels with like "
        "patches), wavelet shrinkage (coefficients below range are dropped); they smooth the read "
        "noise of a cold frame and leave the large dark signal of a hot one alone, so high "
        "frequencies return with temperature. Strength below 1 mixes the filtered frame with the "
        "original. Numbers such as the read noise are then too good, and detail is lost. Cure: "
        "switch it off; it cannot be undone."
    )
    formula: ClassVar[str] = (
        "y -> (1 - strength) y + strength filter(y);  bilateral weight exp(-d^2/2 space^2 - "
        "(dy)^2/2 range^2)"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Tomasi, Manduchi, Bilateral filtering for gray and color images, ICCV 1998",
        "Buades, Coll, Morel, A non-local algorithm for image denoising, CVPR 2005",
        "Coifman, Donoho, Translation-invariant de-noising, 1995",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_psd_0.35_0.5", "temporal_psd_0.5_0.71", "temporal_pmax8", "frame_pmax8",
        "temporal_corr_10", "temporal_corr_01", "temporal_corr_11", "local_variance_cv",
        "hh_kurtosis", "pattern_psd_0.5_0.71",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "crosstalk": "leaves the read noise white: high frequencies are lost in the hot pattern "
        "only, and every hot pixel has a halo of the same share. A Gaussian after readout smooths "
        "the noise too",
        "dpc": "touches outliers only: the core of the noise stays white",
        "temporal_denoise": "frames are correlated in time, the frame itself stays white",
    }
    reach: ClassVar[int] = 2 * max(_GAUSSIAN_RADIUS, 7, _NLM_PATCH + _NLM_DISTANCE)

    strength: float = parameter(1.0, "1", 0.0, 1.0, "share of the filtered frame", "linear")
    range: float = parameter(
        4.0, "DN", 0.01, 1e4, "difference up to which pixels are averaged (bilateral, nlm, wavelet)"
    )
    space: float = parameter(
        0.7, "pixel", 0.2, 2.0, "sigma of the weight over distance (gaussian, bilateral)"
    )
    kind: str = choice("bilateral", "filter", "gaussian", "median", "bilateral", "nlm", "wavelet")
    spacing: int = choice(1, "distance of neighbours: 2 within a colour of a mosaic", 1, 2)

    def idle(self) -> tuple[str, ...]:
        """What the present kind does not use; a share in quarters is a maker's, and stays."""
        used = {
            "gaussian": ("space",),
            "median": (),
            "bilateral": ("range", "space"),
            "nlm": ("range",),
            "wavelet": ("range",),
        }[self.kind]
        plain = ("strength",) if self.strength in _PLAIN else ()
        return (*plain, *(n for n in ("range", "space") if n not in used))

    def relatives(self) -> list[Effect]:
        """Quarters: mixed codes then fall on halves, which are rounded to even ones."""
        if not isinstance(self.strength, (int, float)) or self.strength in _PLAIN:
            return []
        nearest = min(_PLAIN, key=lambda q: abs(q - self.strength))
        return [replace(self, strength=nearest)] if abs(nearest - self.strength) < 0.1 else []

    def bent(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """Noise of independent pixels is that much smaller, and the seed seems smooth by itself."""
        if name == "convolved_lognormal.phi":
            return 0.0, 0.0
        kept = self._kept(noise)
        factors = {
            "read_noise.sigma": kept**-0.5,
            "pixel_fpn.sigma": kept**-0.5,
            "dark_shot_noise.dn_per_e": 1.0 / kept,
        }
        return factors.get(name, 1.0), 0.0

    def _kept(self, noise: float) -> float:
        """Share of the variance of white noise; 1 for filters that go by its size.

        ``noise`` is what was left of it. A bilateral with a wide range is a Gaussian.
        """
        if not all(isinstance(x, (int, float)) for x in (self.strength, self.range, self.space)):
            return 1.0
        line = _line(self.space)
        wide = self.kind == "bilateral" and self.range * np.sum(line**2) > WIDE * noise
        if self.kind == "gaussian" or wide:
            own, all_of_it = float(line.max() ** 2), float(np.sum(line**2) ** 2)
        elif self.kind == "median":
            own, all_of_it = 1.0 / 9.0, _MEDIAN_VARIANCE
        else:
            return 1.0
        s = self.strength
        return (1.0 - s) ** 2 + 2.0 * s * (1.0 - s) * own + s**2 * all_of_it

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Mix the frame with its filtered copy; codes stay codes."""
        from dnanalyze.model import filters

        strength = np.float32(self.value("strength", site.point))
        smooth = filters.planewise(lambda p: self._filtered(p, site), signal, self.spacing)
        return filters.rounded_like(signal, signal + strength * (smooth - signal))

    def _filtered(self, plane: np.ndarray, site: Site) -> np.ndarray:
        from dnanalyze.model import filters

        range_dn, space = self.value("range", site.point), self.value("space", site.point)
        if self.kind == "gaussian":
            return filters.gaussian(plane, space, _GAUSSIAN_RADIUS)
        if self.kind == "median":
            return filters.median3(plane)
        if self.kind == "bilateral":
            return filters.bilateral(plane, range_dn, space, _BILATERAL_RADIUS)
        if self.kind == "nlm":
            return filters.nonlocal_means(plane, range_dn, 0.0, _NLM_PATCH, _NLM_DISTANCE)
        return filters.wavelet(plane, range_dn)

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Each kind, scaled to the noise; spacing 2 where pixels two apart are the more alike."""
        high = ("temporal_psd_0.35_0.5", "temporal_psd_0.5_0.71", "pattern_psd_0.5_0.71")
        alike = ("temporal_corr_10", "temporal_corr_01", "temporal_corr_20", "temporal_corr_02")
        signs = (
            shows(clues, (*high, "temporal_pmax8", "frame_pmax8"), -1)
            or shows(clues, (*alike, "local_variance_cv", "hh_kurtosis"))
        )  # fmt: skip
        if not signs:
            return []
        noise = _noise(clues)
        corr = {k: clues.measured(f"temporal_corr_{k}") for k in ("10", "20")}
        near, far = (typical(corr[k]) for k in ("10", "20"))
        spacing = 2 if far > max(near, 0.0) + 0.02 else 1
        lag1 = max(near, far, 0.01)
        space = _space(lag1)
        # a bilateral may be wide for the noise where that is least, and narrow elsewhere
        wide = _space(known(corr["20" if spacing == 2 else "10"]).max(initial=0.01))
        quiet = min(known(clues.measured("temporal_noise_core")), default=0.0) or noise
        before = quiet / np.sum(_line(wide) ** 2)
        made = {
            "bilateral": cls(1.0, 1.5 * noise, 0.8, "bilateral", spacing),
            "wide": cls(
                1.0, bounded(cls, "range", 1.5 * WIDE * before), wide, "bilateral", spacing
            ),
            "median": cls(min(1.0, 2.0 * lag1), kind="median", spacing=spacing),
            "gaussian": cls(space=space, kind="gaussian", spacing=spacing),
            "wavelet": cls(1.0, noise, kind="wavelet", spacing=spacing),
            "nlm": cls(1.0, 1.2 * noise, kind="nlm", spacing=spacing),
        }
        return list(made.values())


def _line(space: float) -> np.ndarray:
    from dnanalyze.model import filters

    return filters.gaussian_kernel(space, _GAUSSIAN_RADIUS)


def _space(lag1: float) -> float:
    """Sigma of the kernel after which neighbours of white noise have this correlation."""
    tried = np.linspace(0.2, 2.0, 181)
    lines = [_line(float(s)) for s in tried]
    found = [float(np.sum(x[1:] * x[:-1]) / np.sum(x * x)) for x in lines]
    return float(np.interp(lag1, found, tried))


def _noise(clues: Clues) -> float:
    """Temporal noise where it is least, DN, within the bounds of ``range``."""
    noise = float(min(known(clues.simulated("temporal_noise_core")), default=1.0))
    return min(max(noise, 0.02), 5e3)
