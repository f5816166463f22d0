"""Smoothing within a frame, linear or edge-preserving."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.evidence import bounded, quietest, shows, typical
from dnanalyze.model.white_codes import left_of, likeness, noise_before, reached

_GAUSSIAN_RADIUS = 6
_BILATERAL_RADIUS = 2
WIDE = 2.0  # range over the noise from which a bilateral averages all that it meets
_MEDIAN_VARIANCE = 0.166  # of the median of 9 Gaussian values of variance 1, by simulation
_PLAIN = (0.25, 0.5, 0.75)  # shares of a mixture
_PATTERN = 0.25  # of the noise, in fixed offsets
_RANGES = 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0  # over the noise left
_BY_SIZE: tuple[dict[str, Any], ...] = (
    {"kind": "bilateral", "space": 1.5}, {"kind": "wavelet"}, {"kind": "nlm"},
    {"kind": "nlm", "patch": 2, "window": 7}, {"kind": "bilateral", "space": 0.8}, {"kind": "db2"},
    {"kind": "nlm", "patch": 4, "window": 13},
)  # fmt: skip


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
        "A median removes isolated pixels. Edge-preserving filters average only what is alike: "
        "bilateral (pixels within range of each other), non-local means (pixels with like "
        "patches), wavelet shrinkage (coefficients are drawn towards 0 by range): 'wavelet' on all "
        "shifts of the grid, 'haar' and 'db2' (Haar's and Daubechies' second basis) on one, as "
        "packages do it, which leaves a lattice of 2, 4 and 8 pixels. They smooth the read "
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
        "dpc": "touches outliers only: the core of the noise stays white",
        "temporal_denoise": "frames are correlated in time, the frame itself stays white",
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

    def idle(self) -> tuple[str, ...]:
        """What the present kind does not use; a share in quarters is a maker's, and stays."""
        used = {
            "gaussian": ("space",),
            "median": (),
            "bilateral": ("range", "space"),
            "nlm": ("range", "patch", "window"),
        }.get(self.kind, ("range",))
        plain = ("strength",) if self.strength in _PLAIN else ()
        return (*plain, *(n for n in ("range", "space", "patch", "window") if n not in used))

    def relatives(self) -> list[Effect]:
        """Quarters: mixed codes then fall on halves, which are rounded to even ones."""
        if not isinstance(self.strength, (int, float)) or self.strength in _PLAIN:
            return []
        nearest = min(_PLAIN, key=lambda q: abs(q - self.strength))
        return [replace(self, strength=nearest)] if abs(nearest - self.strength) < 0.1 else []

    def bent(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
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
        return 0.0, shares[name] * _before(self, noise)

    def _linear(self, noise: float) -> bool:
        """Whether it treats small noise as large; a bilateral with a wide range does."""
        wide = self.range * np.sum(_line(self.space) ** 2) > WIDE * noise
        return self.kind in ("gaussian", "median") or (self.kind == "bilateral" and bool(wide))

    def _kept(self) -> float:
        """Share of the variance of white noise, where large is treated as small."""
        if self.kind == "median":
            own, all_of_it = 1.0 / 9.0, _MEDIAN_VARIANCE
        else:
            line = _line(self.space)
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
            "gaussian": _GAUSSIAN_RADIUS,
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
            return filters.gaussian(plane, space, _GAUSSIAN_RADIUS)
        if self.kind == "median":
            return filters.median3(plane)
        if self.kind == "bilateral":
            return filters.bilateral(plane, range_dn, space, _BILATERAL_RADIUS)
        if self.kind == "nlm":
            return filters.nonlocal_means(plane, range_dn, self.patch, self.window // 2)
        if self.kind == "wavelet":
            return wavelets.over_all_shifts(plane, range_dn)
        return wavelets.on_grid(plane, range_dn, wavelets.BASES[self.kind], corner)

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Each kind, scaled to the noise; spacing 2 where pixels two apart are the more alike."""
        high = ("temporal_psd_0.35_0.5", "temporal_psd_0.5_0.71", "pattern_psd_0.5_0.71")
        near_by = ("temporal_corr_10", "temporal_corr_01", "temporal_corr_20", "temporal_corr_02")
        signs = (
            shows(clues, (*high, "temporal_pmax8", "frame_pmax8"), -1)
            or shows(clues, (*near_by, "local_variance_cv", "hh_kurtosis"))
        )  # fmt: skip
        if not signs:
            return []
        corr = {k: np.asarray(clues.measured(f"temporal_corr_{k}"), float) for k in ("10", "20")}
        near, far = (typical(corr[k]) for k in ("10", "20"))
        spacing = 2 if far > max(near, 0.0) + 0.02 else 1
        lag1 = max(near, far, 0.01)
        # what goes by the size of noise may see all of it where that is least, and none elsewhere
        noise, place = _least(clues)
        alike = max(float(np.nan_to_num(corr[f"{spacing}0"][place])), 0.01)
        wide = _space(alike)
        wide_range = bounded(cls, "range", 1.5 * WIDE * noise / np.sum(_line(wide) ** 2))
        sized = [_with_range(cls(**shape), noise, alike, spacing) for shape in _BY_SIZE]
        # like patches lie anywhere: a mean of many leaves neighbours no more alike than one of few
        wider = [replace(s, range=bounded(cls, "range", 2.0 * s.range)) for s in sized]
        return [
            *sized,
            *(e for e in wider if e.kind == "nlm"),
            cls(1.0, wide_range, wide, "bilateral", spacing),
            cls(min(1.0, 2.0 * lag1), kind="median", spacing=spacing),
            # codes mixed are rounded to codes: what is left of few changes by steps that stop a fit
            *(cls(share, kind="median", spacing=spacing) for share in (*_PLAIN, 1.0)),
            cls(space=_space(lag1), kind="gaussian", spacing=spacing),
        ]


def _with_range(shape: Denoise, noise: float, alike: float, spacing: int) -> Denoise:
    """The range with which neighbours of white noise are so much ``alike`` where ``noise`` is left.

    Found on a field of codes: what is left of few codes follows no formula.
    """

    def lag1(range_dn: float) -> float:
        tried = replace(shape, range=range_dn)
        return likeness(left_of(tried.filtered, _before(tried, noise)))

    tried = [bounded(Denoise, "range", noise * r) for r in _RANGES]
    return replace(shape, range=reached(alike, lag1, tried), spacing=spacing)


@lru_cache(maxsize=64)
def _before(effect: Denoise, noise: float) -> float:
    return noise_before(effect.filtered, noise)


def _line(space: float) -> np.ndarray:
    from dnanalyze.model import filters

    return filters.gaussian_kernel(space, _GAUSSIAN_RADIUS)


def _space(lag1: float) -> float:
    """Sigma of the kernel after which neighbours of white noise have this correlation."""
    tried = np.linspace(0.2, 2.0, 181)
    lines = [_line(float(s)) for s in tried]
    found = [float(np.sum(x[1:] * x[:-1]) / np.sum(x * x)) for x in lines]
    return float(np.interp(lag1, found, tried))


def _least(clues: Clues) -> tuple[float, int]:
    """Temporal noise of the quietest setting that tells it, DN, and which that is."""
    measured = np.asarray(clues.measured("temporal_noise"), float)
    place = quietest(measured)
    noise = measured[place] if measured[place] > 0 else 1.0
    return min(max(float(noise), 0.02), 5e3), place
