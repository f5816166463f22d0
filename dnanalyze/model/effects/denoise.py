"""Smoothing within a frame, linear or edge-preserving."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.white_codes import noise_before

GAUSSIAN_RADIUS = 6
_BILATERAL_RADIUS = 2
WIDE = 2.0  # range over the noise from which a bilateral averages all that it meets
_MEDIAN_VARIANCE = 0.166  # of the median of 9 Gaussian values of variance 1, by simulation
PLAIN = (0.25, 0.5, 0.75)  # shares of a mixture
_PATTERN = 0.25  # of the noise, in fixed offsets


@dataclass(frozen=True)
class Denoise(Effect):
    """y += strength (filter(y) - y)."""

    name: ClassVar[str] = "denoise"
    stage: ClassVar[Stage] = Stage.SPATIAL_FILTER
    varies: ClassVar[str] = "digital"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "Spatial denoise: neighbours averaged before the file is written."
    physics: ClassVar[str] = (
        "Noise reduction averages neighbours, so the noise is no longer white: the power at high "
        "frequencies falls, extremes become rare. A Gaussian blurs everything, as crosstalk does. "
        "A median removes isolated pixels. Edge-preserving filters average only similar pixels: "
        "bilateral (pixels within range of each other), non-local means (pixels with like "
        "patches), wavelet shrinkage (coefficients are drawn towards 0 by range): 'wavelet' on all "
        "shifts of the grid, 'haar' and 'db2' (Haar's and Daubechies' second basis) on one, as "
        "packages do it, which leaves a lattice of 2, 4 and 8 pixels. They smooth the read "
        "noise of a cold frame and leave the large dark signal of a hot one alone, so high "
        "frequencies return with temperature. Strength below 1 mixes the filtered frame with the "
        "original. The measured read noise is then too low, and detail is lost. Remedy: "
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
        "Donoho, De-noising by soft-thresholding, IEEE Trans. Inf. Theory 41, 613 (1995)",
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
        "dpc": "changes outliers only: the core of the noise remains white",
        "temporal_denoise": "frames are correlated in time, the single frame remains white",
    }

    strength: float = parameter(1.0, "1", 0.0, 1.0, "share of the filtered frame", "linear")
    range: float = parameter(
        4.0,
        "DN",
        0.01,
        1e4,
        "difference up to which pixels are averaged (bilateral, nlm, wavelets)",
    )
    space: float = parameter(
        0.7, "pixel", 0.2, 2.0, "sigma of the weight over distance (gaussian, bilateral)"
    )
    kind: str = choice(
        "bilateral", "filter",
        "gaussian", "median", "bilateral", "nlm", "wavelet", "haar", "db2",
    )  # fmt: skip
    spacing: int = choice(1, "distance of neighbours: 2 within a colour of a mosaic", 1, 2)
    patch: int = choice(
        5, "pixels a side that are compared (nlm); even: a fast mode's", 2, 3, 4, 5, 6, 7
    )
    window: int = choice(11, "pixels a side that are searched (nlm)", 7, 9, 11, 13, 21)

    def inactive_parameters(self) -> tuple[str, ...]:
        """What the present kind does not use; a share in quarters is a maker's, and stays."""
        used = {
            "gaussian": ("space",),
            "median": (),
            "bilateral": ("range", "space"),
            "nlm": ("range", "patch", "window"),
        }.get(self.kind, ("range",))
        plain = ("strength",) if self.strength in PLAIN else ()
        return (*plain, *(n for n in ("range", "space", "patch", "window") if n not in used))

    def relatives(self) -> list[Effect]:
        """Quarters: mixed codes then fall on halves, which are rounded to even ones."""
        if not isinstance(self.strength, (int, float)) or self.strength in PLAIN:
            return []
        nearest = min(PLAIN, key=lambda q: abs(q - self.strength))
        return [replace(self, strength=nearest)] if abs(nearest - self.strength) < 0.1 else []

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """Noise of independent pixels is that much smaller, and the seed seems smooth by itself.

        What goes by the size of noise leaves some places of a field less of it than others, and may
        hide a fixed pattern: from none at all no derivative leads back.
        """
        if name == "convolved_lognormal.phi":
            return 0.0, 0.0
        if not all(isinstance(x, (int, float)) for x in (self.strength, self.range, self.space)):
            return 1.0, 0.0
        if self._linear(noise):
            kept = self._kept()
            factors = {
                "read_noise.sigma": kept**-0.5,
                "pixel_fpn.sigma": kept**-0.5,
                "dark_shot_noise.dn_per_e": 1.0 / kept,
            }
            return factors.get(name, 1.0), 0.0
        shares = {"read_noise.sigma": 1.0, "read_noise.spread": 0.0, "pixel_fpn.sigma": _PATTERN}
        if name not in shares or not 0 < noise < math.inf:
            return 1.0, 0.0
        return 0.0, shares[name] * noise_unfiltered(self, noise)

    def _linear(self, noise: float) -> bool:
        """Whether it treats small noise as large; a bilateral with a wide range does."""
        wide = self.range * np.sum(kernel_line(self.space) ** 2) > WIDE * noise
        return self.kind in ("gaussian", "median") or (self.kind == "bilateral" and bool(wide))

    def _kept(self) -> float:
        """Share of the variance of white noise, where large is treated as small."""
        if self.kind == "median":
            own, all_of_it = 1.0 / 9.0, _MEDIAN_VARIANCE
        else:
            line = kernel_line(self.space)
            own, all_of_it = float(line.max() ** 2), float(np.sum(line**2) ** 2)
        s = self.strength
        return (1.0 - s) ** 2 + 2.0 * s * (1.0 - s) * own + s**2 * all_of_it

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Mix the frame with its filtered copy; codes stay codes."""
        strength, range_dn, space = (
            self.value(name, site.point) for name in ("strength", "range", "space")
        )
        corner = site.window.top, site.window.left
        return self._mixed(signal, strength, range_dn, space, corner)

    def filtered(self, frame: np.ndarray) -> np.ndarray:
        """A frame, (rows, columns), after the filter, with numbers that hold at every setting."""
        return self._mixed(frame, self.strength, self.range, self.space, (0, 0))

    def margin(self) -> int:
        """As far as the filter of this kind looks, within its colour."""
        from dnanalyze.model import wavelets

        reaches = {
            "gaussian": GAUSSIAN_RADIUS,
            "median": 1,
            "bilateral": _BILATERAL_RADIUS,
            "nlm": self.patch // 2 + self.window // 2,
            "wavelet": wavelets.reach(wavelets.HAAR),
        }
        if self.kind in wavelets.BASES:
            return self.spacing * wavelets.reach(wavelets.BASES[self.kind])
        return self.spacing * reaches[self.kind]

    def _mixed(
        self,
        frame: np.ndarray,
        strength: float,
        range_dn: float,
        space: float,
        corner: tuple[int, int],
    ) -> np.ndarray:
        from dnanalyze.model import filters

        smooth = filters.planewise(
            lambda plane, begins: self._smooth(plane, range_dn, space, begins),
            frame,
            self.spacing,
            corner,
        )
        return filters.rounded_like(frame, frame + np.float32(strength) * (smooth - frame))

    def _smooth(
        self, plane: np.ndarray, range_dn: float, space: float, corner: tuple[int, int]
    ) -> np.ndarray:
        from dnanalyze.model import filters, wavelets

        if self.kind == "gaussian":
            return filters.gaussian(plane, space, GAUSSIAN_RADIUS)
        if self.kind == "median":
            return filters.median3(plane)
        if self.kind == "bilateral":
            return filters.bilateral(plane, range_dn, space, _BILATERAL_RADIUS)
        if self.kind == "nlm":
            return filters.nonlocal_means(plane, range_dn, self.patch, self.window // 2)
        if self.kind == "wavelet":
            return wavelets.over_all_shifts(plane, range_dn)
        return wavelets.on_grid(plane, range_dn, wavelets.BASES[self.kind], corner)


@lru_cache(maxsize=64)
def noise_unfiltered(effect: Denoise, noise: float) -> float:
    """Noise before the filter where ``noise`` is left behind it, DN."""
    return noise_before(effect.filtered, noise)


def kernel_line(space: float) -> np.ndarray:
    """The Gaussian kernel along one axis."""
    from dnanalyze.model import filters

    return filters.gaussian_kernel(space, GAUSSIAN_RADIUS)
